#include "run/run_output.hpp"

#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "core/error.hpp"
#include "store/motion_model_file.hpp"
#include "talk/interrupt.hpp"
#include "talk/talk.hpp"

namespace vrda {

namespace fs = std::filesystem;

std::string output_of(const std::string& asked, const std::string& job_file)
{
  if (!asked.empty()) return asked;
  const std::string name = fs::path(job_file).stem().string();
  return (fs::path("results") / name / (name + ".h5")).string();
}

std::string run_record_of(const std::string& output)
{
  return output + ".run.json";
}

bool has_start_file(const std::string& output, const std::string& resolved_job)
{
  const std::string start = start_file_of(output);
  if (!fs::exists(start)) return false;
  try {
    return read_motion_model(start).job.resolved == resolved_job;
  } catch (const InputError&) {
    return false;
  }
}

void make_folder_of(const std::string& file)
{
  const fs::path folder = fs::path(file).parent_path();
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError({file, "folder", error.message(), "a folder that can be written"});
}

void require_replaceable(const std::string& output, const std::string& what)
{
  if (!fs::exists(output)) return;
  const std::string wanted = "a new name, or " + what + " to replace";
  if (!fs::is_regular_file(output)) throw InputError({output, "output", "something that is no file", wanted});
  std::array<char, 8> head{};
  std::ifstream(output, std::ios::binary).read(head.data(), head.size());
  constexpr std::array<char, 8> hdf5{'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  if (head != hdf5) throw InputError({output, "output", "a file that is not HDF5", wanted});
  if (access(output.c_str(), W_OK) != 0)
    throw InputError({output, "output", "a file without write permission", wanted});
}

std::optional<OutputLock> locked_output(const std::string& output, const std::string& command)
{
  const auto say_holder = [&](const std::string& holder) {
    say(output + ": waiting for " + holder + ", which writes it");
  };
  return OutputLock::take(output, command, {say_holder, is_interrupted});
}

void remove_needless(const std::vector<std::string>& files)
{
  for (const std::string& file : files) {
    std::error_code error;
    fs::remove(file, error);
    if (!error) continue;
    warn(file + ": found a file that cannot be removed (" + error.message() + "); it is not needed any more");
    return;
  }
}

}  // namespace vrda
