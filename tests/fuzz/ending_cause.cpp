#include "fuzz/ending_cause.hpp"

#include <dirent.h>
#include <pthread.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <sstream>

extern "C" void __sanitizer_set_report_path(const char* path);
extern "C" void __sanitizer_set_death_callback(void (*callback)());

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

}  // namespace vrda::test
