/// `vrda smooth`: adds a smoothed set to a motion model.
#pragma once

#include <string>

#include "talk/talk.hpp"

namespace vrda {

struct SmoothCommandOptions {
  std::string file;
  int degree = 6;
  bool is_robust = false;
  bool is_recontacted = false;  ///< with travel into contact at every attitude
  int n_threads = 0;            ///< 0: as many as there are processors
  bool as_json = false;
};

/// Writes /smoothed/degree_N in place of the one of that degree. Audits of a set that changed are dropped.
ExitCode smooth_command(const SmoothCommandOptions& options);

}  // namespace vrda
