/// Distances between landmarks, of the model and of a subject: schemas/scaling.md.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/scaling.hpp"

namespace vrda {

struct LandmarkPair {
  std::string name;
  Eigen::Vector3d a_native{0.0, 0.0, 0.0};  ///< in the mesh files' coordinates and unit
  Eigen::Vector3d b_native{0.0, 0.0, 0.0};
  double subject_mm = 0.0;  ///< distance in the subject, above 0
};

/// The pairs of a table, in its order. `file` is its name in messages. Throws InputError naming the file,
/// line and column: what schemas/landmarks.schema.json does not take of a row, double columns, points that
/// coincide, a name twice, no pair at all.
std::vector<LandmarkPair> read_landmarks(const std::string& file, std::string_view text);

/// The even factor s that makes sum((subject - s model)^2) least, with what it leaves; `unit_mm` is the
/// length of the files' unit. Its standard error takes all distances to be equally uncertain:
/// sqrt(sum(residual^2) / (n - 1) / sum(model^2)). Expects at least one pair.
Scaling fitted_scaling(const std::vector<LandmarkPair>& pairs, double unit_mm);

}  // namespace vrda
