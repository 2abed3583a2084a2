/// Distances between landmarks of the model and of a subject: schemas/scaling.md.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model/scaling.hpp"

namespace vrda::job {

struct LandmarkPair {
  std::string name;
  Eigen::Vector3d a_native{0.0, 0.0, 0.0};  ///< in the mesh files' coordinates and unit
  Eigen::Vector3d b_native{0.0, 0.0, 0.0};
  double subject_mm = 0.0;  ///< distance in the subject, above 0
};

/// The pairs of a table, in order. `file` is its name in messages. Throws InputError with file, line and
/// column for rows that violate schemas/landmarks.schema.json, duplicate columns or names, coincident points,
/// and no pairs.
std::vector<LandmarkPair> read_landmarks(const std::string& file, std::string_view text);

/// Least-squares fit of one factor s: minimises sum((subject - s model)^2). `unit_mm` is the length unit of
/// the files. The standard error assumes equal uncertainty of all distances: sqrt(sum(residual^2) / (n - 1) /
/// sum(model^2)). Requires at least one pair.
Scaling fit_scaling(const std::vector<LandmarkPair>& pairs, double unit_mm);

}  // namespace vrda::job
