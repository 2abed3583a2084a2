#include "run/output_file.hpp"

#include <filesystem>
#include <fstream>

#include "core/error.hpp"

namespace vrda {

namespace fs = std::filesystem;

void write_file(const std::string& path, const std::string& bytes)
{
  std::ofstream file(path, std::ios::binary);
  const bool is_open = file.is_open();
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file.fail()) return;
  // A part of a file is worse than none; a device is not ours to remove.
  std::error_code ignored;
  if (is_open && fs::is_regular_file(path, ignored)) fs::remove(path, ignored);
  throw InputError({path, "", "a file that cannot be written", "room and permission to write"});
}

void make_folder(const std::string& folder)
{
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError({folder, "folder", error.message(), "a folder that can be written"});
}

}  // namespace vrda
