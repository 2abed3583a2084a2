/// Values of options that are texts: numbers, ranges of angles, ranges of rows.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/score.hpp"

namespace vrda::app {

/// For messages: "vrda score", "--rows".
struct CommandOption {
  std::string command, name;
};

/// A finite number that is the whole text.
std::optional<double> finite_number(const std::string& text);

/// The angles of "FROM:TO:STEP", degrees, ascending, TO included if steps reach it. Throws InputError unless
/// FROM is at most TO, STEP above 0, and the angles at most 100,000.
std::vector<double> angle_range(const CommandOption& option, const std::string& range);

/// Rows from 1 on the command line, from 0 inside: A:B, first-half, second-half, or all of `n` if empty.
analysis::RowRange rows_of(const CommandOption& option, const std::string& text, std::size_t n);

}  // namespace vrda::app
