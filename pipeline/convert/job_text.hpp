/// A job file from a configuration.
#pragma once

#include <string>

#include "convert/configuration.hpp"

namespace vrda {

struct JobPlaces {
  std::string title;
  std::string source;         ///< the configuration's name, for the first comment
  std::string models_folder;  ///< as the job file sees it, where the models' .obj files are
  std::string unit = "m";     ///< of the mesh files: m, cm or mm
};

/// TOML with comments. The frame is the one of thesis 5.2 in OpenGL's view (DESIGN.md 3): X to the subject's
/// left, Y up, Z forward, a left knee.
std::string job_text(const Configuration& configuration, const JobPlaces& places);

}  // namespace vrda
