// Tests of the shim with dd, which makes one write call per block.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

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

TEST_F(Shim, KillsBeforeTheCallAndTearsWithinIt)
{
  for (int k = 1; k <= 4; ++k) {
    SCOPED_TRACE(k);
    const auto before = static_cast<std::uintmax_t>(100 * (k - 1));
    EXPECT_EQ(run_with({"kill", "write", std::to_string(k), "/blocks"}).exit_code, -1);
    EXPECT_EQ(size(), before);
    EXPECT_EQ(run_with({"torn", "write", std::to_string(k), "/blocks"}).exit_code, -1);
    EXPECT_EQ(size(), before + 50);
  }
}

TEST_F(Shim, MakesWritesReallyShort)
{
  const fs::path counts = scratch_.path() / "counts";
  Command command = with_fault(blocks(), {"short", "write", "2", "/blocks"});
  command.environment["VRDA_FAULT_COUNT"] = counts.string();
  EXPECT_EQ(run(command).exit_code, 0);  // dd writes the rest by another call
  EXPECT_EQ(size(), 400u);
  EXPECT_EQ(read_bytes(counts), "5\n");
}

TEST_F(Shim, FailsOnceOrFromThereOn)
{
  const Ended full = run_with({"full", "write", "3", "/blocks"});
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_NE(full.err.find("No space left on device"), std::string::npos) << full.err;
  EXPECT_EQ(size(), 250u);
  const Ended broken = run_with({"eio", "write", "2", "/blocks"});
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_NE(broken.err.find("Input/output error"), std::string::npos) << broken.err;
  EXPECT_EQ(size(), 100u);
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

TEST_F(Shim, HoldsUntilTheGateExists)
{
  const fs::path gate = scratch_.path() / "gate", held = scratch_.path() / "gate.held";
  Command command = with_fault(blocks(), {"hold", "write", "3", "/blocks"});
  command.environment["VRDA_FAULT_GATE"] = gate;
  Process process(command);
  while (process.is_running() && !fs::exists(held)) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_TRUE(process.is_running());
  EXPECT_EQ(size(), 200u);
  scratch_.write("gate", "");
  EXPECT_EQ(process.wait().exit_code, 0);
  EXPECT_EQ(size(), 400u);
  EXPECT_EQ(run(command).exit_code, 0);  // an existing gate holds no process
}

TEST_F(Shim, AHeldProcessStillHandlesSignals)
{
  Command command = with_fault(blocks(), {"hold", "write", "3", "/blocks"});
  command.environment["VRDA_FAULT_GATE"] = scratch_.path() / "gate";
  Process process(command);
  while (process.is_running() && !fs::exists(scratch_.path() / "gate.held"))
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  process.send(SIGTERM);
  EXPECT_EQ(process.wait().exit_code, -1);
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
