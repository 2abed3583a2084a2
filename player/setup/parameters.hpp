/// What can be adjusted while the bench runs (thesis 7.2): each with its unit, range and step.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "setup/calibration.hpp"

namespace vrda {

/// All that parameters change.
struct BenchValues {
  Calibration calibration;
  double flexion_deg = 0.0, varus_deg = 0.0;  ///< of a rigid leg
  double prediction_ms = 0.0;
};

struct Parameter {
  std::string name;  ///< "flexion", "left.k1", "tibia.shift_x"
  std::string unit;  ///< empty: a plain number
  double least = 0.0, most = 0.0, step = 0.0;
  bool is_kept = true;  ///< in the calibration file
};

/// In the order in which keys go through them. Never changes.
std::span<const Parameter> parameters();
std::optional<std::size_t> parameter_named(const std::string& name);

/// Whether it changes anything on that bench: a tracked leg has no flexion to set, a rigid one no femur's
/// body.
bool is_used(std::size_t parameter, const BenchFile& bench);

double value_of(const BenchValues& values, std::size_t parameter);
/// Within the parameter's range.
void set_value(BenchValues& values, std::size_t parameter, double value);

}  // namespace vrda
