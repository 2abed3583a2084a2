#include "job/input_file.hpp"

#include <filesystem>

#include "job/raw_mesh.hpp"

namespace vrda::job {

namespace {

namespace fs = std::filesystem;

fs::path path_of(const Job& job, const std::string& data_directory, const std::string& name)
{
  const fs::path in_data = fs::path(data_directory) / name;
  std::error_code ignored;
  if (!data_directory.empty() && fs::exists(in_data, ignored)) return in_data;
  return fs::path(job.file).parent_path() / name;
}

}  // namespace

std::uintmax_t mesh_bytes(const Job& job, const std::string& data_directory)
{
  std::uintmax_t n_bytes = 0;
  for (const BodyJob* body : {&job.reference, &job.moving}) {
    for (const ComponentJob& component : body->components) {
      if (component.generate) continue;
      std::error_code error;
      const std::uintmax_t size = fs::file_size(path_of(job, data_directory, component.file), error);
      if (!error) n_bytes += size;
    }
  }
  return n_bytes;
}

InputFile input_file(const Job& job, const std::string& data_directory, const FileReference& named)
{
  const std::string wanted = data_directory.empty() ? named.what + " in the folder of the job or of --data"
                                                    : named.what + " in \"" + data_directory +
                                                          "\" (--data) or in the folder of the job";
  const std::string path = path_of(job, data_directory, named.name).string();
  return {path,
          file_bytes(path, {job.document.source_of(named.key), named.key, "", wanted}, largest_mesh_bytes)};
}

}  // namespace vrda::job
