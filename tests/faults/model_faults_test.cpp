// Commands that read a motion model and extend it, write another file or print: after any fault the file is
// the old or the new one.
#include <gmock/gmock.h>

#include <fstream>
#include <iostream>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"
#include "support/messages.hpp"

namespace vrda::test::model_faults_test {

namespace fs = std::filesystem;
using testing::AnyOf;

/// A command and the file that it writes; empty if it prints.
struct Job {
  std::string name;
  std::vector<std::string> words;
  std::string output;
};

class ModelFaults : public FaultyRun {
 protected:
  ModelFaults() { begin_ = {{"a.h5", whole_run().after.at("a.h5")}, {"b.csv", "flexion,varus\n1,2\n"}}; }

  std::string written(const Job& job) const
  {
    return job.output.empty() ? "" : read_bytes(folder_ / job.output);
  }

  void expect_sound_end(const Fault& fault, const Ended& ended, const Ended& whole) const
  {
    // Only a kill ends it by a signal; errors of closing folders and of removing missing files are ignored.
    if (fault.what == "kill") {
      EXPECT_THAT(ended.exit_code, AnyOf(-1, 0, 2));
    } else {
      EXPECT_THAT(ended.exit_code, AnyOf(0, 2));
    }
    EXPECT_LE(n_lines(ended.err), n_lines(whole.err) + (ended.exit_code == 2 ? 1 : 0)) << ended.err;
    if (ended.exit_code == 2 && fault.what != "kill") {
      EXPECT_THAT(printed_facts(ended.err).file, testing::StartsWith(folder_.string()));
      EXPECT_THAT(
          ended,
          AnyOf(refuses({.field = printed_facts(ended.err).field, .found = "Input/output error"}),
                refuses({.field = printed_facts(ended.err).field, .found = "No space left on device"})));
    }
    if (ended.exit_code == 0) {
      EXPECT_EQ(ended.out, whole.out);
    }
  }

  Files begin_;
};

TEST_P(ModelFaults, TheFileIsTheOldOrTheNewOne)
{
  const std::string file = (folder_ / "a.h5").string();
  int n_disturbed = 0;
  for (const Job& job :
       {Job{"smooth", {"smooth", file, "--degree", "1", "--robust", "--quiet"}, "a.h5"},
        Job{"audit", {"audit", file, "--set", "degree_1", "--quiet"}, "a.h5"},
        Job{"reduce", {"reduce", file, "--set", "degree_1", "--quiet"}, "a.h5"},
        Job{"export",
            {"export", file, "--to", "csv", "-o", (folder_ / "b.csv").string(), "--quiet"},
            "b.csv"},
        Job{"compare", {"compare", file, "--degrees", "1", "--refine", "0", "--quiet"}, ""}}) {
    const Command command = vrda(job.words);
    put(begin_);
    const std::string old_bytes = written(job);
    const Ended whole = test::run(command);
    ASSERT_EQ(whole.exit_code, 0) << whole.err;
    const std::string new_bytes = written(job);
    const std::vector<std::string> whole_names = names();
    int n_refused = 0;
    for (const std::string call : {"any", "read"}) {
      put(begin_);
      // In a command that only prints, a separate process reads the model, with its own count of calls.
      const int n = job.output.empty()
                        ? 2
                        : n_calls_of(command, in_folder({"count", call}), scratch_.path() / "counts");
      int row = 0;
      for (const std::string what : {"kill", "eio", "enospc", "short"}) {
        ++row;
        for (int k = 1; k <= n; ++k) {
          if (!runs_full_set() && (k + row) % 4 != 0) continue;
          SCOPED_TRACE(job.name + " " + what + " " + call + " " + std::to_string(k));
          ++n_disturbed;
          put(begin_);
          const Fault fault{what, call, std::to_string(k)};
          const Ended ended = test::run(with_fault(command, in_folder(fault)));
          expect_sound_end(fault, ended, whole);
          n_refused += ended.exit_code == 2 ? 1 : 0;
          const std::string there = written(job);
          EXPECT_TRUE(there == new_bytes || (there == old_bytes && ended.exit_code != 0));
          EXPECT_EQ(test::run(command).exit_code, 0);
          EXPECT_TRUE(written(job) == new_bytes);
          EXPECT_EQ(names(), whole_names);
        }
      }
    }
    EXPECT_GT(n_refused, 0) << job.name;
  }
  std::cout << n_disturbed << " calls went wrong\n";
}

INSTANTIATE_TEST_SUITE_P(All, ModelFaults, testing::Values(equilibrium()), name_of);

}  // namespace vrda::test::model_faults_test
