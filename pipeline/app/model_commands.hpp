/// `vrda info` and `vrda validate`: what a motion model holds, and whether it keeps to its specification.
#pragma once

#include <string>

#include "talk/talk.hpp"

namespace vrda {

struct InfoOptions {
  std::string file;
  bool as_json = false;
};

/// Gaps and penetrations are measured again from the file's meshes and poses at every attitude.
ExitCode info_command(const InfoOptions& options);

ExitCode validate_command(const InfoOptions& options);

}  // namespace vrda
