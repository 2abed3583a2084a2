/// What one motion step leaves behind: the rooms solve, sweep, journal and app pass it on.
/// Frame S and its units: core/frames.hpp.
#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/frames.hpp"
#include "core/step_status.hpp"

namespace vrda {

/// Which node of the seeding graph a step is (DESIGN.md 5.4). The values are those of the journal.
enum class StepKind : std::uint8_t {
  spine_probe = 0,  ///< solved while the spine looks for its cell; not in the motion model
  spine = 1,        ///< the spine's cell of a flexion
  row = 2,          ///< grown outward from the spine's cell
};

inline constexpr StepKind all_step_kinds[] = {StepKind::spine_probe, StepKind::spine, StepKind::row};

const char* name_of(StepKind kind);

/// Indices into the grid's axes. Ordered by kind, then flexion, then varus.
struct StepKey {
  StepKind kind = StepKind::row;
  std::int32_t flexion = 0;
  std::int32_t varus = 0;

  // clang-tidy 14 takes the generated comparison with 0 for a null pointer.
  auto operator<=>(const StepKey&) const = default;  // NOLINT(modernize-use-nullptr)
};

/// One contact of the final pose.
struct ContactRecord {
  Eigen::Vector3d point_solver_mm = Eigen::Vector3d::Zero();  ///< on the reference's surface
  Eigen::Vector3d normal_solver = Eigen::Vector3d::Zero();    ///< unit, reaction on the moving object
  double distance_mm = 0.0;
  std::int32_t triangle_reference = -1;  ///< row of the reference's contact triangles
  std::int32_t triangle_moving = -1;     ///< row of the moving object's contact triangles
  std::int8_t compartment = 0;           ///< 0 none, 1 medial, 2 lateral
};

struct StepRecord {
  StepKey key;
  MovingPose pose;  ///< in S; the best pose so far where `status` is not stable
  StepStatus status = StepStatus::pending;
  std::int32_t iterations = 0;
  std::int32_t queries = 0;                                       ///< collision and gap queries
  double residual_mm = std::numeric_limits<double>::quiet_NaN();  ///< last translation predicted
  /// Directional gap left in each compartment; NaN where nothing faces.
  double gap_medial_mm = std::numeric_limits<double>::quiet_NaN();
  double gap_lateral_mm = std::numeric_limits<double>::quiet_NaN();
  bool contact_medial = false;
  bool contact_lateral = false;
  bool theta_determined = false;
  std::vector<ContactRecord> contacts;
};

}  // namespace vrda
