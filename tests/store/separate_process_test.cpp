#include "store/read_separately.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <iostream>
#include <memory>
#include <new>
#include <vector>

#include "support/refusal.hpp"

namespace vrda::separate_process_test {

using ::testing::HasSubstr;

TEST(SeparateProcess, AnswersWithWhateverBytes)
{
  for (const std::size_t size : {0u, 1u, 5'000'000u}) {
    std::string text(size, '\0');
    for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i % 251);
    const store::ProcessResult answer = store::run_separately([&] { return text; }, "x");
    EXPECT_TRUE(answer.is_complete);
    EXPECT_EQ(answer.text, text);
  }
}

TEST(SeparateProcess, LeavesThisOneAlone)
{
  int changed = 0;
  const store::ProcessResult answer = store::run_separately(
      [&] {
        changed = 1;
        std::cout << "not to be seen" << std::flush;
        return std::to_string(getpid());
      },
      "x");
  EXPECT_EQ(changed, 0);
  EXPECT_NE(answer.text, std::to_string(getpid()));
}

TEST(SeparateProcess, GoesOnWhileThisOneDoes)
{
  void* const memory =
      mmap(nullptr, sizeof(std::atomic<char>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  auto& byte = *new (memory) std::atomic<char>('\0');
  store::SeparateProcess work(
      [&] {
        while (byte == '\0') usleep(1000);
        return std::string(1, byte);
      },
      "x");
  // The child waits for this; if it had run synchronously, the test would block.
  byte = 'y';
  EXPECT_EQ(work.wait_for_result().text, "y");
  munmap(memory, sizeof(std::atomic<char>));
}

TEST(SeparateProcess, IsEndedIfItsResultIsNotCollected)
{
  {
    const store::SeparateProcess endless(
        []() -> std::string {
          for (;;) pause();
        },
        "x");
  }
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(SeparateProcess, ThatEndsBadlySaysHow)
{
  struct Row {
    std::function<std::string()> work;
    const char* how;
  };
  for (const Row& row : {Row{[]() -> std::string {
                               std::raise(SIGKILL);
                               return "x";
                             },
                             "signal 9"},
                         Row{[]() -> std::string { std::abort(); }, "signal 6"},
                         Row{[]() -> std::string { _exit(3); }, "exit code 3"}}) {
    const store::ProcessResult answer = store::run_separately(row.work, "x");
    EXPECT_FALSE(answer.is_complete);
    EXPECT_EQ(answer.text, row.how);
  }
}

TEST(SeparateProcess, HasNoneOfTheOpenFiles)
{
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const store::ProcessResult answer = store::run_separately(
      [&] { return std::string(write(ends[1], "x", 1) < 0 && errno == EBADF ? "none" : "open"); }, "x");
  EXPECT_EQ(answer.text, "none");
  close(ends[0]);
  close(ends[1]);
}

// Each of these succeeds before the confinement and fails after it.
TEST(Confinement, OpensNoFileAndNoSocketStartsNoProgramAndRunsNoNewCode)
{
  if (store::is_sanitized) GTEST_SKIP() << "sanitizers open files for their reports";
  const auto tried = [] {
    std::string done;
    const auto note = [&](const char* what, bool is_done) { done += is_done ? what : ""; };
    note("open ", open("/dev/null", O_RDONLY) >= 0);
    note("socket ", socket(AF_UNIX, SOCK_STREAM, 0) >= 0);
    const pid_t child = fork();
    if (child == 0) _exit(execl("/bin/true", "true", nullptr));
    int status = -1;
    note("exec ", child > 0 && waitpid(child, &status, 0) == child && status == 0);
    note("code ",
         mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED);
    note("memory ", std::make_unique<char[]>(std::size_t{8} << 20) != nullptr);
    return done;
  };
  const store::ProcessResult answer = store::run_separately(
      [&] {
        const std::string before =
            "no_new_privs=" + std::to_string(prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0)) + " " + tried();
        const std::string why = store::confine_this_process();
        return before + "then " + why + tried();
      },
      "x");
  EXPECT_EQ(answer.text, "no_new_privs=1 open socket exec code memory then memory ");
}

TEST(SeparateProcess, HasLimits)
{
  store::ProcessLimits limits;
  limits.processor_s = 1;
  limits.result_bytes = 1000;
  volatile bool goes_on = true;
  const store::ProcessResult endless = store::run_separately(
      [&] {
        while (goes_on) {
        }
        return std::string();
      },
      "x", limits);
  EXPECT_FALSE(endless.is_complete);
  EXPECT_TRUE(endless.text == "signal 9" || endless.text == "more than 1 s of processor time")
      << endless.text;
  const store::ProcessResult long_answer =
      store::run_separately([] { return std::string(2000, 'x'); }, "x", limits);
  EXPECT_FALSE(long_answer.is_complete);
  EXPECT_TRUE(test::names_value(long_answer.text, "1000 bytes")) << long_answer.text;
}

TEST(SeparateProcess, HasNoMoreMemoryThanAllowed)
{
  if (store::is_sanitized) GTEST_SKIP() << "sanitizers need memory of their own";
  store::ProcessLimits limits;
  limits.memory_bytes = std::uint64_t{64} << 20;
  const store::ProcessResult answer = store::run_separately(
      [] {
        try {
          const std::vector<char> large(std::size_t{128} << 20, 1);
          return std::to_string(large.size());
        } catch (const std::bad_alloc&) {
          return std::string("refused");
        }
      },
      "x", limits);
  EXPECT_EQ(answer.text, "refused");
}

}  // namespace vrda::separate_process_test
