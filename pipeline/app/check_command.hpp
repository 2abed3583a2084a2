/// `vrda check`: what was understood of a job, the plan, and the warnings that matter.
#pragma once

#include <string>
#include <vector>

#include "talk/talk.hpp"

namespace vrda {

struct CheckOptions {
  std::string job_file;
  std::string data_directory;
  std::vector<std::string> overrides;
  std::string picture;  ///< PNG file to draw what was understood into; empty: none
  bool as_json = false;
};

ExitCode check_command(const CheckOptions& options);

}  // namespace vrda
