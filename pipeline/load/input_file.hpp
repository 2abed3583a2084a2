/// Files that a job names.
#pragma once

#include <string>

#include "load/job.hpp"

namespace vrda {

/// What a job names: under which key, and what is wanted there.
struct NamedFile {
  std::string key;   ///< "reference.component.0.file"
  std::string name;  ///< as the job writes it
  std::string what;  ///< "a mesh file"
};

struct InputFile {
  std::string path;
  std::string bytes;
};

/// Looks in the data folder first when there is one, then beside the job file.
/// Throws InputError naming the job, the key and the file that is not there or cannot be read.
InputFile input_file(const Job& job, const std::string& data_directory, const NamedFile& named);

}  // namespace vrda
