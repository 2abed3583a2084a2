/// `vrda audit`: gap and penetration of the motions in a motion model.
#pragma once

#include <string>

#include "talk/talk.hpp"

namespace vrda {

struct AuditOptions {
  std::string file;
  std::string set = "all";  ///< one of set_names of motion/poses.hpp, or all of them
  int refine = 1;           ///< parts each cell of the grid is cut into, along each axis
  int n_threads = 0;        ///< 0: as many as there are processors
  bool as_json = false;
};

/// Writes /audit/SET into the file, in place of the one of that name.
ExitCode audit_command(const AuditOptions& options);

}  // namespace vrda
