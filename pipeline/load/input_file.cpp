#include "load/input_file.hpp"

#include <filesystem>

#include "load/raw_mesh.hpp"

namespace vrda::load {

InputFile input_file(const Job& job, const std::string& data_directory, const FileReference& named)
{
  namespace fs = std::filesystem;
  const fs::path next_to_job = fs::path(job.file).parent_path() / named.name;
  const fs::path in_data = fs::path(data_directory) / named.name;
  std::error_code ignored;
  const bool is_in_data = !data_directory.empty() && fs::exists(in_data, ignored);
  const std::string wanted = data_directory.empty() ? named.what + " in the folder of the job or of --data"
                                                    : named.what + " in \"" + data_directory +
                                                          "\" (--data) or in the folder of the job";
  const std::string path = (is_in_data ? in_data : next_to_job).string();
  return {path,
          file_bytes(path, {job.document.source_of(named.key), named.key, "", wanted}, largest_mesh_bytes)};
}

}  // namespace vrda::load
