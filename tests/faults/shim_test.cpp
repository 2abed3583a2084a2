// Tests of the shim with dd, which makes one write call per block.
#include <gtest/gtest.h>

#include <csignal>

#include "faults/faulty_run.hpp"

namespace vrda::test::shim_test {

namespace fs = std::filesystem;

class Shim : public testing::Test {
 protected:
  /// Four blocks of 100 bytes into out/blocks.
  Command blocks() const
  {
    return {"/bin/dd", {"if=/dev/zero", "of=" + file_.string(), "bs=100", "count=4", "status=none"}, {}, {}};
  }
  Ended run_with(const Fault& fault) const
  {
    fs::remove(file_);
    return run(with_fault(blocks(), fault));
  }
  std::uintmax_t size() const { return fs::file_size(file_); }

  Scratch scratch_;
  fs::path file_ = scratch_.path() / "blocks";
};

TEST_F(Shim, CountsTheCallsOfOneFile)
{
  const fs::path counts = scratch_.path() / "counts";
  EXPECT_EQ(n_calls_of(blocks(), {"count", "write", "1", "/blocks"}, counts), 4);
  EXPECT_EQ(n_calls_of(blocks(), {"count", "read", "1", "/dev/zero"}, counts), 4);
  EXPECT_EQ(n_calls_of(blocks(), {"count", "open", "1", "/blocks"}, counts), 1);
  Command synced = blocks();
  synced.arguments.emplace_back("conv=fsync");
  EXPECT_EQ(n_calls_of(synced, {"count", "fsync", "1", "/blocks"}, counts), 1);
  Command moved{"/bin/mv", {file_.string(), file_.string() + ".moved"}, {}, {}};
  fs::remove(counts);
  moved = with_fault(moved, {"count", "write", "1", "/blocks"});
  moved.environment["VRDA_FAULT_COUNT"] = counts.string();
  EXPECT_EQ(run(moved).exit_code, 0);
  EXPECT_EQ(read_bytes(counts), "0\n");
}

TEST_F(Shim, DisturbsTheCallAndThoseAfterIt)
{
  struct Row {
    Fault fault;
    int exit_code;
    std::uintmax_t n_bytes;
    const char* said;
  };
  for (const Row& row : {Row{{"kill", "write", "1", "/blocks"}, -1, 0, ""},
                         Row{{"kill", "write", "4", "/blocks"}, -1, 300, ""},
                         Row{{"torn", "write", "1", "/blocks"}, -1, 50, ""},
                         Row{{"torn", "write", "3", "/blocks"}, -1, 250, ""},
                         // dd writes the rest by another call
                         Row{{"short", "write", "2", "/blocks"}, 0, 400, ""},
                         Row{{"full", "write", "3", "/blocks"}, 1, 250, "No space left on device"},
                         Row{{"eio", "write", "2", "/blocks"}, 1, 100, "Input/output error"}}) {
    SCOPED_TRACE(row.fault.what + " " + row.fault.at);
    const Ended ended = run_with(row.fault);
    EXPECT_EQ(ended.exit_code, row.exit_code);
    EXPECT_EQ(size(), row.n_bytes);
    EXPECT_NE(ended.err.find(row.said), std::string::npos) << ended.err;
  }
  EXPECT_EQ(run_with({"enospc", "open", "1+", "/blocks"}).exit_code, 1);
  EXPECT_FALSE(fs::exists(file_));
}

TEST_F(Shim, LeavesEntriesOutOfListingsAndRefusesLocks)
{
  scratch_.write("blocks", "");
  scratch_.write("other", "");
  const std::string folder = scratch_.path().string();
  const Ended listed = run(with_fault({"/bin/ls", {folder}, {}, {}}, {"eio", "list", "1+", "/blocks"}));
  EXPECT_EQ(listed.out, "other\n");
  const Command lock{"/usr/bin/flock", {"--nonblock", file_.string(), "/bin/true"}, {}, {}};
  const Ended locked = run(with_fault(lock, {"enolck", "lock", "1+", "/blocks"}));
  EXPECT_NE(locked.exit_code, 0);
  EXPECT_NE(locked.err.find("No locks available"), std::string::npos) << locked.err;
  EXPECT_EQ(run(with_fault(lock, {"enolck", "lock", "1+", "/other"})).exit_code, 0);
}

TEST_F(Shim, OnlyTheFirstProcessGetsAFaultOnce)
{
  Command command = with_fault(blocks(), {"kill", "write", "2", "/blocks"});
  command.environment["VRDA_FAULT_ONCE"] = scratch_.path() / "done";
  EXPECT_EQ(run(command).exit_code, -1);
  EXPECT_EQ(run(command).exit_code, 0);
  EXPECT_EQ(size(), 400u);
}

TEST_F(Shim, HoldsUntilTheGateExistsOrASignal)
{
  const Fault fault{"hold", "write", "3", "/blocks"};
  HeldProcess process(scratch_, blocks(), fault);
  EXPECT_EQ(size(), 200u);
  EXPECT_EQ(process.release().exit_code, 0);
  EXPECT_EQ(size(), 400u);
  HeldProcess signalled(scratch_, blocks(), fault);
  signalled.send(SIGTERM);
  EXPECT_EQ(signalled.release().exit_code, -1);
}

TEST_F(Shim, UnknownValuesAreRefused)
{
  for (const auto& [name, value] :
       {std::pair{"VRDA_FAULT_DO", "explode"}, std::pair{"VRDA_FAULT_CALL", "writes"},
        std::pair{"VRDA_FAULT_AT", "0"}, std::pair{"VRDA_FAULT_AT", "3x"}}) {
    Command command = with_fault(blocks(), {"eio", "write", "9", "/blocks"});
    command.environment[name] = value;
    const Ended ended = run(command);
    EXPECT_EQ(ended.exit_code, 125);
    EXPECT_EQ(ended.err, "fault_shim: " + std::string(name) + ": found \"" + value + "\"\n");
  }
}

}  // namespace vrda::test::shim_test
