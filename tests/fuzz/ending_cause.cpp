#include "fuzz/ending_cause.hpp"

#include <dirent.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <vector>

#include "fuzz/outcome.hpp"

extern "C" void __sanitizer_set_report_path(const char* path);
extern "C" void __sanitizer_set_death_callback(void (*callback)());

// Bounds of the counters of -fsanitize=fuzzer-no-link, one byte per edge; symbols of the linker.
extern "C" std::uint8_t __start___sancov_cntrs[];
extern "C" std::uint8_t __stop___sancov_cntrs[];

namespace vrda::test {
namespace {

constexpr const char* folder_name = "/dev/shm/";

/// The sanitizer appends a dot and its process id.
const std::string& report_name()
{
  static const std::string name = "vrda-fuzz-report-" + std::to_string(getpid());
  return name;
}

void in_the_copy()
{
  static const std::string path = folder_name + report_name();
  __sanitizer_set_report_path(path.c_str());
  __sanitizer_set_death_callback([] {});
}

}  // namespace

void report_copies()
{
  report_name();  // with the id of this process
  pthread_atfork(nullptr, nullptr, in_the_copy);
}

std::string take_reports()
{
  std::string text;
  DIR* folder = opendir(folder_name);
  if (folder == nullptr) return text;
  while (const dirent* entry = readdir(folder)) {
    const std::string name = entry->d_name;
    if (name.rfind(report_name() + ".", 0) != 0) continue;
    std::ifstream stream(folder_name + name);
    text.append(std::istreambuf_iterator<char>(stream), {});
    std::remove((folder_name + name).c_str());
  }
  closedir(folder);
  return text;
}

std::string cause_in(const std::string& report)
{
  std::istringstream lines(report);
  std::string line, kind = "no report";
  int n_frames = 0;
  while (std::getline(lines, line)) {
    const std::size_t at = line.find("AddressSanitizer: ");
    if (at != std::string::npos && kind == "no report")
      kind = line.substr(at + 18, line.find(' ', at + 18) - at - 18);
    if (line.find("runtime error") != std::string::npos) return "VRDA " + line;
    if (line.find("    #") != 0 || ++n_frames > 8) continue;
    // Frames above are an interceptor of the sanitizer, or the C library.
    if (line.find("libhdf5") != std::string::npos) return "libhdf5 " + kind;
    if (n_frames > 3 && line.find("fuzz_models") != std::string::npos) return "VRDA " + kind;
  }
  return "VRDA " + kind;
}

void share_coverage()
{
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  // Whole pages only, since other variables precede and follow.
  const std::uintptr_t first =
      (reinterpret_cast<std::uintptr_t>(__start___sancov_cntrs) + page - 1) / page * page;
  const std::uintptr_t last = reinterpret_cast<std::uintptr_t>(__stop___sancov_cntrs) / page * page;
  require(first < last, "no counters to share");
  auto* counters = reinterpret_cast<std::uint8_t*>(first);
  const std::vector<std::uint8_t> counted(counters, counters + (last - first));
  void* shared =
      mmap(counters, last - first, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
  require(shared == counters, "no memory to share");
  for (std::size_t k = 0; k < counted.size(); ++k) counters[k] = counted[k];
}

}  // namespace vrda::test
