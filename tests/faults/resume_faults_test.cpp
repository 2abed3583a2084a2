// Injects each fault into every call of a run that resumes an interrupted one: it reads the journal, cuts the
// torn record off and appends.
#include <gmock/gmock.h>

#include <fstream>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"
#include "support/messages.hpp"

namespace vrda::test::resume_faults_test {

constexpr int n_recorded = 4;

class ResumeFaults : public FaultyRun {
 protected:
  ResumeFaults()
  {
    // The first write is the header.
    run_from_empty({"torn", "write", std::to_string(n_recorded + 2), "a.h5.journal"});
    for (const std::string& name : names()) interrupted_[name] = read_bytes(folder_ / name);
  }

  void put_interrupted() const
  {
    clear();
    for (const auto& [name, bytes] : interrupted_) std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  std::map<std::string, std::string> interrupted_;  ///< name -> bytes
};

TEST_P(ResumeFaults, NoFaultLosesARecordedStep)
{
  int n_killed = 0, n_refused = 0;
  for (const std::string call : {"any", "read"}) {
    put_interrupted();
    const int n = n_calls_of(command(), in_folder({"count", call}), scratch_.path() / "counts");
    int row = 0;
    for (const std::string what : {"kill", "torn", "short", "eio", "enospc"}) {
      ++row;
      for (int k = 1; k <= n; ++k) {
        if (!runs_full_set() && (k + row) % 4 != 0) continue;
        SCOPED_TRACE(what + " " + call + " " + std::to_string(k));
        put_interrupted();
        const Ended ended = run({what, call, std::to_string(k)});
        n_killed += ended.exit_code == -1 ? 1 : 0;
        EXPECT_EQ(ended.exit_code == -1, what == "kill" || what == "torn");
        if (ended.exit_code == 2) {
          ++n_refused;
          EXPECT_NE(what, "short");
          EXPECT_TRUE(printed_facts(ended.err).file.starts_with(folder_.string() + "/a.")) << ended.err;
          EXPECT_LE(n_lines(ended.err), 3)
              << ended.err;  // after warnings of ligaments and of the torn record
        } else if (ended.exit_code != -1) {
          EXPECT_EQ(ended.exit_code, 0) << ended.err;
        }
        expect_no_incomplete_result();
        expect_finishes();
        EXPECT_GE(n_steps_recalled(), n_recorded);
      }
    }
  }
  EXPECT_GT(n_killed, 0);
  EXPECT_GT(n_refused, 0);
}

INSTANTIATE_TEST_SUITE_P(All, ResumeFaults, testing::ValuesIn(every_method()), name_of);

}  // namespace vrda::test::resume_faults_test
