/// Distance of two triangles: Bullet's narrow phase in double precision, and closed forms where it is unsure.
#pragma once

#include <memory>

#include "proximity/placed.hpp"

namespace vrda {

struct TriangleDistance {
  bool is_overlapping = false;  ///< the triangles share a point; distance 0, points meaningless
  double distance_mm = 0.0;
  Eigen::Vector3d p_reference_mm = Eigen::Vector3d::Zero();  ///< closest point on the first triangle
  Eigen::Vector3d p_moving_mm = Eigen::Vector3d::Zero();     ///< closest point on the second triangle
};

/// Owns Bullet's solver state: one for each thread.
class NarrowPhase {
 public:
  NarrowPhase();
  ~NarrowPhase();
  NarrowPhase(const NarrowPhase&) = delete;
  NarrowPhase& operator=(const NarrowPhase&) = delete;

  /// Overlap is decided to rounding; distances are good to rounding below 1e-3 mm and to 1e-6 mm above, where
  /// they are Bullet's, margins zero (README.md says how).
  TriangleDistance measure(const Corners& reference, const Corners& moving);

  long long n_measured() const { return n_measured_; }

 private:
  struct Bullet;
  std::unique_ptr<Bullet> bullet_;
  long long n_measured_ = 0;
};

/// True when an axis or a plane of either triangle keeps them further apart than `band_mm`: a cheap and safe
/// "no" that spares the narrow phase.
bool is_surely_apart(const Corners& a, const Corners& b, double band_mm);

/// How far the best of the directions that can part two triangles (both normals, cross products of edges,
/// normals of edges within their planes) keeps them apart: positive when they share no point, negative when
/// each direction finds them overlapping by as much at least. Good to rounding.
double separation_mm(const Corners& a, const Corners& b);

/// The nearest of all corners, edges and faces of two triangles that share no point; good to rounding. Where
/// closest points are not unique (parallel edges or faces) it is the end of a common stretch.
TriangleDistance closest_points(const Corners& reference, const Corners& moving);

}  // namespace vrda
