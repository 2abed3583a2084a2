// Motion models and traces as HDF5 files, read as by the player. HDF5 itself crashes on some; that must give
// one message and is counted. Any other end of the reading process is a bug.
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <map>
#include <new>
#include <utility>

#include "fuzz/changed_content.hpp"
#include "fuzz/ending_cause.hpp"
#include "fuzz/outcome.hpp"
#include "fuzz/small_models.hpp"
#include "store/model_checks.hpp"
#include "store/read_separately.hpp"
#include "store/trace.hpp"

/// HDF5 passes sizes from the file to malloc and handles its failure.
extern "C" const char* __asan_default_options()
{
  return "symbolize=0:malloc_context_size=3:allocator_may_return_null=1:max_allocation_size_mb=2048:handle_"
         "abort=1:handle_sigfpe=1:"
         "handle_sigill=1";
}

namespace {

using namespace vrda;

/// Models per libFuzzer input. Forking this process takes as long as reading two.
constexpr std::size_t n_variants = 64;
/// Some files make HDF5 loop: time limit of one file in a batch, a hundred times the typical time.
constexpr long longest_us = 600'000;
/// The limit of a single file.
constexpr unsigned longest_alone_s = 2;

enum class Outcome : std::uint8_t { none, read, refused_seal, refused_by_hdf5, refused_by_us };
constexpr std::array<const char*, 5> outcome_names{"nothing", "read", "refused: seal", "rejected by HDF5",
                                                   "rejected by VRDA's checks"};

/// Progress of a child process, which may end at any file.
struct Progress {
  std::size_t n_done = 0;
  std::array<Outcome, n_variants> outcomes{};
  bool is_late = false;
};

Progress& progress()
{
  static auto* const shared =
      new (mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))
          Progress;
  return *shared;
}

std::map<std::string, long> counts;

void print_counts()
{
  long total = 0;
  for (const auto& [what, n] : counts) total += n;
  rusage usage = {};
  getrusage(RUSAGE_CHILDREN, &usage);
  std::fprintf(stderr, "files: %ld\npeak_kb_of_copies: %ld\n", total, usage.ru_maxrss);
  for (const auto& [what, n] : counts) std::fprintf(stderr, "outcome: %ld %s\n", n, what.c_str());
}

std::string file_name()
{
  static const pid_t own = getpid();  // of the first process, also in its children
  return "/dev/shm/vrda-fuzz-file-" + std::to_string(own);
}

void end()
{
  print_counts();
  std::remove(file_name().c_str());
}

Outcome refusal(const InputError::Facts& facts)
{
  if (facts.found.find("checksum does not match") != std::string::npos) return Outcome::refused_seal;
  const bool is_hdf5 = facts.found.find("HDF5 error") != std::string::npos;
  return is_hdf5 ? Outcome::refused_by_hdf5 : Outcome::refused_by_us;
}

void use(const store::Trace& trace)
{
  store::film_of(trace, "a.trace.h5", {});
}

/// Uses the poses of every model; one in eleven is also drawn, which takes ten times as long. The target
/// "values" draws every model.
void use(const store::MotionModel& model, std::size_t k)
{
  if (k % 11 == 0) {
    test::use_as_player(model);
  } else {
    test::use_motion(model);
  }
}

/// Both parts of read_motion_model, and the player's use of the model.
void read_and_use(bool is_trace, std::size_t k)
{
  if (is_trace) {
    use(store::trace_of(store::serialize(store::parse_trace(store::read_hdf5(file_name()))), "a.trace.h5"));
  } else {
    use(store::deserialize_motion_model(
            store::serialize(store::parse_motion_model(store::read_hdf5(file_name()))), "a.h5"),
        k);
  }
}

/// Calls `action`, which may throw InputError.
template <class Action>
Outcome outcome_of(Action action)
{
  Outcome outcome = Outcome::read;
  test::read_or_refuse([&] {
    try {
      action();
    } catch (const InputError& error) {
      outcome = refusal(error.facts());
      throw;
    } catch (const std::bad_alloc&) {
      outcome = Outcome::refused_by_us;
    }
  });
  return outcome;
}

/// Starts a time limit. Exceeding it ends the process with a report of the place, as a crash does.
void limit_processor_time()
{
  std::signal(SIGPROF, [](int) {
    progress().is_late = true;
    std::abort();
  });
  const itimerval once{{0, 0}, {0, longest_us}};
  setitimer(ITIMER_PROF, &once, nullptr);
}

bool write_file(const std::uint8_t* recipe, std::size_t size, std::size_t k)
{
  const test::ChangedFile file = test::changed_file(recipe, size, k);
  // A new name each time: HDF5 would reuse a file that it failed to close.
  std::remove(file_name().c_str());
  std::ofstream(file_name(), std::ios::binary) << file.bytes;
  return file.is_trace;
}

/// In the child: every file from the first that is not done.
std::string work(const std::uint8_t* recipe, std::size_t size)
{
  for (std::size_t k = progress().n_done; k < n_variants; progress().n_done = ++k) {
    limit_processor_time();
    const bool is_trace = write_file(recipe, size, k);
    progress().outcomes[k] = outcome_of([&] { read_and_use(is_trace, k); });
  }
  return {};
}

/// Reads one file in a separate process, as the player does; it may only return a message.
std::string outcome_alone(bool is_trace, std::size_t k)
{
  store::ProcessLimits limits;
  limits.processor_s = longest_alone_s;
  std::string ending;
  const Outcome outcome = outcome_of([&] {
    try {
      if (is_trace) {
        use(store::read_trace(file_name()));
      } else {
        use(store::SeparateModelRead(file_name(), limits).model(), k);
      }
    } catch (const InputError& error) {
      const std::size_t at = error.facts().found.find("it ended with ");
      if (at != std::string::npos) ending = error.facts().found.substr(at + 14);
      throw;
    }
  });
  const std::string report = test::take_reports();
  if (ending.empty()) return outcome_names[static_cast<std::size_t>(outcome)];
  // Both limits are equal there, so the kernel sends signal 9.
  if (ending.rfind("signal 9", 0) == 0 || ending.find("processor") != std::string::npos)
    return "HDF5 ended the process: limit of processor time";
  const std::string cause = test::cause_in(report);
  if (cause.rfind("VRDA", 0) != 0) return "HDF5 ended the process: " + cause;
  std::fprintf(stderr, "%s\n%s\n", ending.c_str(), report.c_str());
  test::require(false, "the reading process ended badly, and not in HDF5");
  return {};
}

/// The file at which the child ended. In HDF5: one in eight is read again alone, as by the player. Not in
/// HDF5: read alone, so that earlier memory corruption by HDF5 is excluded.
void count_end(const std::uint8_t* recipe, std::size_t size)
{
  static long n_ended_by_hdf5 = 0;
  const std::string cause = test::cause_in(test::take_reports());
  const std::size_t k = progress().n_done++;
  const bool is_late = std::exchange(progress().is_late, false);
  const std::string together = "HDF5 ended the process: " + (is_late ? "limit of processor time" : cause);
  if (cause.rfind("libhdf5", 0) == 0 && ++n_ended_by_hdf5 % 8 != 0) {
    ++counts[together];
    return;
  }
  const std::string alone = outcome_alone(write_file(recipe, size, k), k);
  const bool is_same = alone.rfind("HDF5 ended", 0) == 0;
  ++counts[is_same ? alone : "alone: " + alone + ", after others: " + cause];
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***)
{
  file_name();
  test::share_coverage();
  test::report_copies();
  test::changed_file(nullptr, 0, 0);  // creates the bases before any fork
  std::atexit(end);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  progress() = {};
  store::ProcessLimits limits;
  limits.processor_s = longest_alone_s * n_variants;
  while (progress().n_done < n_variants) {
    const store::ProcessResult answer =
        store::run_separately([&] { return work(data, size); }, "files", limits);
    if (!answer.is_complete) count_end(data, size);
  }
  test::take_reports();
  for (const Outcome outcome : progress().outcomes) {
    if (outcome != Outcome::none) ++counts[outcome_names[static_cast<std::size_t>(outcome)]];
  }
  return 0;
}
