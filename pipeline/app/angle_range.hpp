/// Ranges of angles on the command line.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace vrda::app {

/// A finite number that is the whole text.
std::optional<double> finite_number(const std::string& text);

/// An option and its text "FROM:TO:STEP", degrees.
struct AngleRangeOption {
  std::string command, option, text;
};

/// The angles, ascending, TO included if steps reach it. Throws InputError unless FROM is at most TO, STEP
/// above 0, and the angles at most 100,000.
std::vector<double> angle_range(const AngleRangeOption& option);

}  // namespace vrda::app
