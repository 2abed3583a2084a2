// Motion models and traces as HDF5 files, read as the player reads them. HDF5 itself crashes on some; that
// must end in one message here, and is counted. Whatever else ends the reading process is our mistake.
#include <dirent.h>
#include <hdf5.h>
#include <pthread.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <new>
#include <sstream>

#include "fuzz/changed_content.hpp"
#include "fuzz/outcome.hpp"
#include "fuzz/small_models.hpp"
#include "fuzz/use_model.hpp"
#include "motion/film.hpp"
#include "store/motion_model_file.hpp"
#include "store/plain_bytes.hpp"
#include "store/plain_stream.hpp"
#include "store/read_apart.hpp"
#include "store/separate_process.hpp"
#include "store/trace_file.hpp"

extern "C" void __sanitizer_set_report_path(const char* path);
extern "C" void __sanitizer_set_death_callback(void (*callback)());

/// Sizes from the file are asked of malloc by HDF5, which can take no for an answer.
extern "C" const char* __asan_default_options()
{
  return "symbolize=0:malloc_context_size=3:allocator_may_return_null=1:max_allocation_size_mb=2048:handle_"
         "abort=1:handle_sigfpe=1:"
         "handle_sigill=1";
}

namespace {

using namespace vrda;

/// Models that one input of libFuzzer's makes.
constexpr std::size_t n_variants = 8;

std::string report_path()
{
  return "/dev/shm/vrda-fuzz-report-" + std::to_string(getpid());
}

// ---- how the other process ended

/// What it died of: "libhdf5 SEGV", or "our own ...".
std::string cause_in(const std::string& report)
{
  std::istringstream lines(report);
  std::string line, kind = "no report";
  int n_frames = 0;
  while (std::getline(lines, line)) {
    const std::size_t at = line.find("AddressSanitizer: ");
    if (at != std::string::npos && kind == "no report")
      kind = line.substr(at + 18, line.find(' ', at + 18) - at - 18);
    if (line.find("runtime error") != std::string::npos) return "our own " + line;
    if (line.find("    #") != 0 || ++n_frames > 8) continue;
    // Above it stand an interceptor of the sanitizer, or the C library.
    if (line.find("libhdf5") != std::string::npos) return "libhdf5 " + kind;
    if (n_frames > 3 && line.find("fuzz_models") != std::string::npos) return "our own " + kind;
  }
  return "our own " + kind;
}

/// What the processes of ours reported, which goes with this: warnings of those that ended well, too.
std::string take_report()
{
  const std::string prefix = report_path().substr(report_path().rfind('/') + 1) + ".";
  std::string text;
  DIR* folder = opendir("/dev/shm");
  if (folder == nullptr) return text;
  while (const dirent* entry = readdir(folder)) {
    const std::string name = entry->d_name;
    if (name.rfind(prefix, 0) != 0) continue;
    std::ifstream stream("/dev/shm/" + name);
    text.append(std::istreambuf_iterator<char>(stream), {});
    std::remove(("/dev/shm/" + name).c_str());
  }
  closedir(folder);
  return text;
}

std::map<std::string, long> outcomes;

void print_outcomes()
{
  for (const auto& [what, n] : outcomes) std::fprintf(stderr, "outcome: %ld %s\n", n, what.c_str());
}

void count_refusal(const InputError::Facts& facts)
{
  const std::size_t ended = facts.found.find("it ended with ");
  if (ended == std::string::npos) {
    const bool is_hdf5 = facts.found.find("HDF5 error") != std::string::npos;
    const bool is_seal = facts.found.find("checksum does not match") != std::string::npos;
    ++outcomes[is_seal ? "refused: seal" : is_hdf5 ? "refused: HDF5 says why" : "refused: found by us"];
    return;
  }
  const std::string report = take_report();
  const std::string how = facts.found.substr(ended + 14);
  const bool is_limit = how.find("processor") != std::string::npos || how.find("signal 9") == 0;
  const std::string cause = is_limit ? "limit: " + how : cause_in(report);
  ++outcomes["HDF5 ended the process: " + cause];
  if (cause.rfind("our own", 0) != 0) return;
  std::fprintf(stderr, "%s\n%s\n", how.c_str(), report.c_str());
  test::require(false, "the reading process ended badly, and not in HDF5");
}

// ---- the files

std::string file_name(std::size_t k)
{
  static const pid_t own = getpid();  // of the first process, for the others too
  return "/dev/shm/vrda-fuzz-file-" + std::to_string(own) + "-" + std::to_string(k);
}

/// Some files send HDF5 round in circles.
ProcessLimits limits()
{
  ProcessLimits few;
  few.processor_s = 2;
  return few;
}

/// Counts what `action` does with one file, which it may refuse.
template <class Read>
void take(Read action)
{
  test::read_or_refuse([&] {
    try {
      action();
      ++outcomes["read"];
    } catch (const InputError& error) {
      count_refusal(error.facts());
      throw;
    }
  });
}

void use(const Trace& trace)
{
  film_of(trace, "a.trace.h5", {});
}

/// The poses of every model; one in eight goes all the way, which takes ten times as long. The target
/// "values" takes every one of its models there.
void use(const MotionModel& model)
{
  static long n = 0;
  if (++n % 8 == 0) {
    test::use_as_player(model);
  } else {
    test::use_motion(model);
  }
}

/// As the player, each file in a process of its own.
void read_alone(const std::string& path, bool is_trace)
{
  if (is_trace) {
    take([&] { use(read_trace_apart(path, limits())); });
  } else {
    take([&] { use(read_motion_model_apart(path, limits())); });
  }
}

/// What the process of many files answers for one.
std::string answer_for(const std::string& path, bool is_trace)
{
  try {
    return "+" + (is_trace ? plain_bytes(read_trace(path)) : plain_bytes(read_motion_model(path)));
  } catch (const InputError& error) {
    return "-" + error.facts().found;
  } catch (const std::bad_alloc&) {
    return "-more memory than there is";
  }
}

void use_answer(const std::string& answer, bool is_trace)
{
  const std::string text = answer.substr(1);
  take([&] {
    if (answer[0] != '+') throw InputError({"a.h5", "", text, "a motion model"});
    if (is_trace) {
      use(trace_of(text, "a.trace.h5"));
    } else {
      use(motion_model_of(text, "a.h5"));
    }
  });
}

/// A process costs more than a file, so one reads many; where it ends badly each is read alone.
void read_all(std::size_t n_files, bool is_trace)
{
  const SeparateAnswer answer = answer_apart(
      [&] {
        PlainWriter answers;
        for (std::size_t k = 0; k < n_files; ++k) answers.pass(answer_for(file_name(k), is_trace));
        return answers.take();
      },
      "files", limits());
  if (!answer.is_whole) {
    take_report();
    for (std::size_t k = 0; k < n_files; ++k) read_alone(file_name(k), is_trace);
    return;
  }
  const std::string file = "answers";
  PlainReader answers(answer.text, file);
  for (std::size_t k = 0; k < n_files; ++k) {
    std::string one;
    answers.pass(one);
    use_answer(one, is_trace);
  }
}

/// Offsets of the values of every dataset that lies in one piece.
herr_t add_offset(hid_t group, const char* name, const H5O_info_t* info, void* offsets)
{
  if (info->type != H5O_TYPE_DATASET) return 0;
  const hid_t dataset = H5Dopen2(group, name, H5P_DEFAULT);
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset != HADDR_UNDEF) static_cast<std::vector<std::size_t>*>(offsets)->push_back(offset);
  H5Dclose(dataset);
  return 0;
}

test::BaseContent base_of_file(const std::string& path)
{
  constexpr std::size_t seal_bytes = 16;
  std::ifstream stream(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(stream), {});
  bytes.resize(bytes.size() - seal_bytes);
  std::vector<std::size_t> offsets;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, add_offset, &offsets, H5O_INFO_BASIC);
  H5Fclose(file);
  return test::base_of_hdf5(bytes, offsets);
}

std::vector<test::BaseContent>& bases()
{
  static std::vector<test::BaseContent> made;
  return made;
}

void end()
{
  print_outcomes();
  for (std::size_t k = 0; k < n_variants; ++k) std::remove(file_name(k).c_str());
}

// In the other process: its report goes to a file, and it is no crash of this one.
std::string path_of_reports;
void in_the_other_process()
{
  __sanitizer_set_report_path(path_of_reports.c_str());
  __sanitizer_set_death_callback([] {});
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***)
{
  for (const MotionModel& model : test::small_models()) {
    write_motion_model(file_name(0), model);
    bases().push_back(base_of_file(file_name(0)));
  }
  write_trace(file_name(0), test::small_trace());
  bases().push_back(base_of_file(file_name(0)));
  path_of_reports = report_path();
  pthread_atfork(nullptr, nullptr, in_the_other_process);
  std::atexit(end);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  std::vector<std::uint8_t> recipe(data, data + size);
  for (std::size_t k = 0; k < n_variants; ++k) {
    std::ofstream(file_name(k), std::ios::binary) << test::changed(bases(), recipe.data(), size);
    // The next one differs in some of its places and values.
    for (std::size_t at = 2; at < size; ++at) {
      if ((at * 7 + k) % 3 == 0) recipe[at] = static_cast<std::uint8_t>(recipe[at] + 1 + 37 * k);
    }
  }
  const bool is_trace = size > 0 && data[0] % bases().size() == bases().size() - 1;
  read_all(n_variants, is_trace);
  return 0;
}
