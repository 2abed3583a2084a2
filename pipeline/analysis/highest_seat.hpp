/// The seat of an object that is pressed along Delta and held in all rotations: the position across Delta,
/// within limits, where it rises highest. Lengths in mm, frame S (core/frames.hpp), rad.
#pragma once

#include "geometry/gap_query.hpp"

namespace vrda::analysis {

struct SeatTask {
  MovingPose centre;      ///< of the limits; its height is not used
  double limit_mm = 0.0;  ///< largest distance from the centre along X and along Z; may be infinite
  Eigen::Vector2d start_mm = Eigen::Vector2d::Zero();  ///< from the centre along X and Z, within the limit
};

struct Seat {
  MovingPose pose;  ///< in contact
  std::vector<geometry::GapFeature> contacts;
  bool is_found = false;      ///< false: nothing ahead of the start
  bool is_converged = false;  ///< to 1e-5 mm of height
};

/// A local maximum over the two translations across Delta of the height of first contact of an object that
/// approaches along Delta. At fixed rotations each feature of a contact limits the height by a plane, so each
/// step is the highest point below the planes found so far, in a trust region. Depends on the task only.
Seat highest_seat(geometry::GapQuery& query, const SeatTask& task);

}  // namespace vrda::analysis
