/// Parameters that can be adjusted while the bench runs (thesis 7.2), with unit, range and step.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "bench/calibration.hpp"

namespace vrda::bench {

/// All values that parameters change.
struct BenchValues {
  Calibration calibration;
  double flexion_rad = 0.0, varus_rad = 0.0;  ///< only for a rigid leg
  double prediction_ms = 0.0;
};

struct Parameter {
  std::string name;  ///< "flexion", "left.k1", "tibia.shift_x"
  std::string unit;  ///< empty: dimensionless
  double minimum = 0.0, maximum = 0.0, step = 0.0;
  bool is_saved = true;  ///< saved in the calibration file
};

/// All parameters, in the order in which keys select them. Constant.
std::span<const Parameter> parameters();
std::optional<std::size_t> find_parameter(const std::string& name);

/// Whether the parameter has an effect on the bench, e.g. `flexion` only with a rigid leg.
bool is_used(std::size_t parameter, const BenchFile& bench);

double value_of(const BenchValues& values, std::size_t parameter);
/// Sets a parameter; the value is clamped to its range.
void set_value(BenchValues& values, std::size_t parameter, double value);

}  // namespace vrda::bench
