#include "app/own_program.hpp"

#include <cerrno>
#include <filesystem>

namespace vrda {

namespace fs = std::filesystem;

std::string program_to_start(const std::string& executable, const std::string& called_by)
{
  const bool is_loader = fs::path(executable).filename().string().starts_with("ld-linux");
  return is_loader ? called_by : executable;
}

std::string own_program()
{
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  return error ? "" : program_to_start(executable.string(), program_invocation_name);
}

}  // namespace vrda
