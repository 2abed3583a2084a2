#include "faults/fault_plan.hpp"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace vrda::test {
namespace {

enum class Action { count, kill, torn, cut_short, full, enospc, eio, enolck, enosys, hold, clock };

constexpr const char* call_names[] = {"write", "fsync",  "rename", "truncate", "open",
                                      "close", "unlink", "read",   "list",     "lock"};
constexpr const char* action_names[] = {"count", "kill",   "torn",   "short", "full", "enospc",
                                        "eio",   "enolck", "enosys", "hold",  "clock"};

/// Then a held process kills itself, so that an aborted test leaves no process behind.
constexpr long longest_hold_s = 600;
constexpr long hold_poll_ms = 10;
constexpr int setting_exit_code = 125;

struct Plan {
  const char* file = nullptr;  ///< part of the path
  bool is_any_call = true;
  Call call = Call::write;
  long at = 1;
  bool is_repeated = false;  ///< every call from `at` on
  Action action = Action::count;
  long clock_from = 0;    ///< reading from which clocks jump; 0: never
  long clock_step_s = 0;  ///< added at each reading, over the real time
  const char* gate = nullptr;
  const char* once = nullptr;
  const char* count = nullptr;
};

[[noreturn]] void refuse(const char* name, const char* found)
{
  std::fprintf(stderr, "fault_shim: %s: found \"%s\"\n", name, found);
  _exit(setting_exit_code);
}

template <std::size_t n>
int index_of(const char* const (&words)[n], const char* name, const char* found)
{
  for (std::size_t i = 0; i < n; ++i) {
    if (std::strcmp(words[i], found) == 0) return static_cast<int>(i);
  }
  refuse(name, found);
}

const char* set_or_null(const char* name)
{
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0' ? value : nullptr;
}

/// A number from 1, followed by `ending`.
long number_of(const char* name, const char* found, const char* ending)
{
  char* end = nullptr;
  const long number = std::strtol(found, &end, 10);
  if (number < 1 || std::strcmp(end, ending) != 0) refuse(name, found);
  return number;
}

Plan read_plan()
{
  Plan plan;
  plan.file = set_or_null("VRDA_FAULT_FILE");
  plan.gate = set_or_null("VRDA_FAULT_GATE");
  plan.once = set_or_null("VRDA_FAULT_ONCE");
  plan.count = set_or_null("VRDA_FAULT_COUNT");
  if (const char* word = set_or_null("VRDA_FAULT_CALL"); word != nullptr && std::strcmp(word, "any") != 0) {
    plan.is_any_call = false;
    plan.call = static_cast<Call>(index_of(call_names, "VRDA_FAULT_CALL", word));
  }
  if (const char* word = set_or_null("VRDA_FAULT_DO"))
    plan.action = static_cast<Action>(index_of(action_names, "VRDA_FAULT_DO", word));
  if (const char* word = set_or_null("VRDA_FAULT_AT")) {
    plan.is_repeated = word[std::strlen(word) - 1] == '+';
    plan.at = number_of("VRDA_FAULT_AT", word, plan.is_repeated ? "+" : "");
  }
  if (const char* word = set_or_null("VRDA_FAULT_CLOCK"))
    plan.clock_step_s = number_of("VRDA_FAULT_CLOCK", word, "");
  if (plan.action == Action::clock) plan.clock_from = plan.at;
  plan.is_repeated = plan.is_repeated || plan.action == Action::full;
  if (plan.action == Action::hold && plan.gate == nullptr) refuse("VRDA_FAULT_GATE", "nothing to hold until");
  return plan;
}

const Plan& plan_of_process()
{
  static const Plan plan = read_plan();
  return plan;
}

std::atomic<long> n_calls = 0;
std::atomic<long> n_readings = 0;

// Opens the shim's own files without passing its interposed calls.
int open_directly(const char* path, int flags)
{
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags | O_CLOEXEC, 0666));
}

void append_number(const char* path, long number)
{
  const int descriptor = open_directly(path, O_WRONLY | O_CREAT | O_APPEND);
  if (descriptor < 0) refuse(path, std::strerror(errno));
  char line[32];
  const int n = std::snprintf(line, sizeof line, "%ld\n", number);
  const long n_written = syscall(SYS_write, descriptor, line, static_cast<std::size_t>(n));
  syscall(SYS_close, descriptor);
  if (n_written != n) refuse(path, std::strerror(errno));
}

/// Whether this process is the first to get the fault.
bool is_first(const Plan& plan)
{
  if (plan.once == nullptr) return true;
  const int descriptor = open_directly(plan.once, O_WRONLY | O_CREAT | O_EXCL);
  if (descriptor < 0) return false;
  syscall(SYS_close, descriptor);
  return true;
}

/// Signal handlers of the program run meanwhile; afterwards the held call continues.
void hold(const char* gate)
{
  if (access(gate, F_OK) == 0) return;
  char held[PATH_MAX];
  std::snprintf(held, sizeof held, "%s.held", gate);
  append_number(held, getpid());
  for (long waited_ms = 0; access(gate, F_OK) != 0; waited_ms += hold_poll_ms) {
    if (waited_ms > longest_hold_s * 1000) kill_self();
    const timespec pause{0, hold_poll_ms * 1'000'000};
    nanosleep(&pause, nullptr);
  }
}

CallDecision act(const Plan& plan, Call call, long k)
{
  switch (plan.action) {
    case Action::kill:
      kill_self();
    case Action::torn:
      if (call != Call::write) kill_self();
      return {CallOutcome::half_then_kill, 0};
    case Action::cut_short:
      return {CallOutcome::half, 0};
    case Action::full:
      if (call == Call::write && k == plan.at) return {CallOutcome::half, 0};
      return {CallOutcome::fail, ENOSPC};
    case Action::enospc:
      return {CallOutcome::fail, ENOSPC};
    case Action::eio:
      return {CallOutcome::fail, EIO};
    case Action::enolck:
      return {CallOutcome::fail, ENOLCK};
    case Action::enosys:
      return {CallOutcome::fail, ENOSYS};
    case Action::hold:
      hold(plan.gate);
      return {};
    case Action::count:
    case Action::clock:
      return {};
  }
  return {};
}

__attribute__((destructor)) void write_count()
{
  const Plan& plan = plan_of_process();
  if (plan.count != nullptr) append_number(plan.count, n_calls);
}

}  // namespace

bool is_watching()
{
  return plan_of_process().file != nullptr;
}

CallDecision decide_call(Call call, const char* path, const char* other_path)
{
  const Plan& plan = plan_of_process();
  const bool is_meant = plan.is_any_call ? call <= Call::unlink : call == plan.call;
  if (plan.file == nullptr || !is_meant) return {};
  if (std::strstr(path, plan.file) == nullptr && std::strstr(other_path, plan.file) == nullptr) return {};
  const long k = ++n_calls;
  if (k < plan.at || (k > plan.at && !plan.is_repeated) || !is_first(plan)) return {};
  return act(plan, call, k);
}

void kill_self()
{
  kill(getpid(), SIGKILL);
  for (;;) pause();
}

timespec with_clock_fault(timespec now)
{
  const Plan& plan = plan_of_process();
  if (plan.clock_from == 0 && plan.clock_step_s == 0) return now;
  const long k = ++n_readings;
  now.tv_sec += k * plan.clock_step_s;
  if (plan.clock_from == 0 || k < plan.clock_from) return now;
  // From 12 hours ago to 12 hours ahead, alternating: 7 and 25 have no common factor.
  now.tv_sec += (k * 7 % 25 - 12) * 3600;
  return now;
}

}  // namespace vrda::test
