/// `vrda plan`: the cases of a job or campaign, checked, with what they will take.
#pragma once

#include <string>
#include <vector>

#include "talk/talk.hpp"

namespace vrda {

struct PlanOptions {
  std::string job_file;  ///< or a campaign
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_shards = 1;
  bool as_json = false;
};

/// Solves nothing. Throws InputError for the first case that is wrong.
ExitCode plan_command(const PlanOptions& options);

}  // namespace vrda
