/// `vrda status`: how far the tasks of a submission are.
#pragma once

#include <string>

#include "talk/talk.hpp"

namespace vrda {

struct StatusOptions {
  std::string folder;
  std::string case_name;  ///< its tasks; empty: those of the only case, or a line a case of a campaign
  bool as_json = false;   ///< everything
};

ExitCode status_command(const StatusOptions& options);

}  // namespace vrda
