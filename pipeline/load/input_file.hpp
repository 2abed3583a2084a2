/// Input files named in a job.
#pragma once

#include <string>

#include "load/job.hpp"

namespace vrda::load {

/// A file name in a job with its key and the expected kind of file.
struct FileReference {
  std::string key;   ///< "reference.component.0.file"
  std::string name;  ///< as written in the job
  std::string what;  ///< "a mesh file"
};

struct InputFile {
  std::string path;
  std::string bytes;
};

/// Searches the data folder (if not empty), then the folder of the job file.
/// Throws InputError naming job, key and file if the file is missing or unreadable.
InputFile input_file(const Job& job, const std::string& data_directory, const FileReference& named);

}  // namespace vrda::load
