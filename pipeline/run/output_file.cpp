#include "run/output_file.hpp"

#include <filesystem>

#include "core/error.hpp"

namespace vrda {

namespace fs = std::filesystem;

void make_folder(const std::string& folder)
{
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError({folder, "folder", error.message(), "a folder that can be written"});
}

}  // namespace vrda
