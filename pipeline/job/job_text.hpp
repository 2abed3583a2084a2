/// Writes a job file from a configuration.
#pragma once

#include <string>

#include "job/configuration.hpp"

namespace vrda::job {

struct JobTextOptions {
  std::string title;
  std::string source;         ///< name of the configuration, for the first comment
  std::string models_folder;  ///< folder of the models' .obj files, relative to the job file
  std::string unit = "m";     ///< of the mesh files: m, cm or mm
};

/// TOML with comments. Frame: thesis 5.2 in the OpenGL view: X to the subject's left, Y up, Z
/// forward, left knee.
std::string job_text(const KeywordConfiguration& configuration, const JobTextOptions& places);

}  // namespace vrda::job
