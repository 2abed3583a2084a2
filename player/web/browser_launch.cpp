// Opens the default browser without the token on its command line.
#include <spawn.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <string_view>

#include "web/server.hpp"

extern char** environ;

namespace vrda::web {

BrowserLaunch::BrowserLaunch(const std::string& address)
{
  constexpr std::string_view ending = ".html";
  std::error_code error;
  file_ = (std::filesystem::temp_directory_path(error) / "vrda-player-XXXXXX").string() + std::string(ending);
  const int descriptor = mkstemps(file_.data(), static_cast<int>(ending.size()));
  if (descriptor < 0) {
    file_.clear();
    return;
  }
  const std::string page =
      "<!DOCTYPE html><meta charset=\"utf-8\"><title>VRDA player</title>"
      "<meta http-equiv=\"refresh\" content=\"0; url=" +
      address + "\">\n";
  const bool is_written = write(descriptor, page.data(), page.size()) == static_cast<ssize_t>(page.size());
  if (close(descriptor) != 0 || !is_written) return;
  std::string program = "xdg-open";
  char* arguments[] = {program.data(), file_.data(), nullptr};
  pid_t pid = 0;
  has_begun_ = posix_spawnp(&pid, program.c_str(), nullptr, nullptr, arguments, environ) == 0;
}

BrowserLaunch::~BrowserLaunch()
{
  unlink(file_.c_str());
}

}  // namespace vrda::web
