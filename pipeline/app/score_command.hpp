/// `vrda score`: compares a motion model with a measured motion.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "analysis/score.hpp"
#include "core/console.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct ScoreCommandOptions {
  std::string model;    ///< motion model, or a table of a motion
  std::string against;  ///< the same
  std::string set = "raw";
  std::string match;  ///< key or flexion; empty: flexion for a grid, else key
  std::string align = "none";
  std::string rows, fit_rows;  ///< A:B, first-half or second-half; empty: all, and those scored
  std::string line;            ///< flexion or key; empty: what the rows are matched by
  std::string translations = "rotation-centre";
  std::string long_axis;             ///< push, or X,Y,Z; empty: the joint's own axes
  std::string side;                  ///< of two tables; empty: right
  std::string angles;                ///< of the tables: deg or rad; empty: as they state, else degrees
  std::vector<std::string> columns;  ///< COORDINATE=COLUMN of the tables
  std::vector<double> centre_mm;     ///< three numbers, canonical; empty: that of the model, else the origin
  bool bridges = false;
  bool as_json = false;

  /// Declares the options of the command.
  void add_to(CLI::App& command);
};

struct CommandOption {
  std::string command, name;  ///< for messages: "vrda score", "--rows"
};

/// Rows from 1 on the command line, from 0 inside: A:B, first-half, second-half, or all of `n` if empty.
analysis::RowRange rows_of(const CommandOption& option, const std::string& text, std::size_t n);

/// Prints a table or JSON. Throws InputError for files that are refused, for options that do not fit them,
/// and if no frame can be scored.
core::ExitCode score_command(const ScoreCommandOptions& options);

}  // namespace vrda::app
