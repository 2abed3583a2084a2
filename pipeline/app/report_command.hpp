/// `vrda report`: motion models as one HTML page.
#pragma once

#include <string>
#include <vector>

#include "talk/talk.hpp"

namespace vrda {

struct ReportOptions {
  std::vector<std::string> files;    ///< motion models
  std::string folder;                ///< gets index.html
  std::vector<std::string> against;  ///< CSV files of curves
  std::string player;                ///< vrda-player; empty: the one beside this program
  bool is_quick = false;             ///< do not measure what each smoothing degree does to the meshes
  bool as_json = false;              ///< print the page's data instead of the page's path
};

/// Writes <folder>/index.html and prints its path. Nothing is written when any of the files cannot be read or
/// has no solved attitude.
ExitCode report_command(const ReportOptions& options);

}  // namespace vrda
