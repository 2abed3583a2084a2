/// Input files named in a job, whole files with a size limit, and SHA-256.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "job/job.hpp"

namespace vrda::job {

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

/// Size of all mesh files of the job in bytes; a missing file counts as none.
std::uintmax_t mesh_bytes(const Job& job, const std::string& data_directory);

/// The content of `file`. Throws InputError for a missing file, a folder, an unreadable file and one larger
/// than `largest_bytes`; `facts` supplies file, field and wanted of the message.
std::string file_bytes(const std::string& file, const InputError::Facts& facts, std::uintmax_t largest_bytes);

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string sha256_of(std::string_view bytes);

}  // namespace vrda::job
