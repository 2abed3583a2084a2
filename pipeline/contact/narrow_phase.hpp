/// Distance of two triangles by Bullet's narrow phase in double precision.
#pragma once

#include <memory>
#include <optional>

#include "geometry/placement.hpp"

namespace vrda::contact {

struct TriangleDistance {
  bool is_overlapping = false;  ///< the triangles intersect
  /// Negative where they overlap: the shortest translation that separates them, -infinity beyond 0.05 mm,
  /// where the points are undefined.
  double distance_mm = 0.0;
  Eigen::Vector3d p_reference_mm = Eigen::Vector3d::Zero();  ///< closest point on the first triangle
  Eigen::Vector3d p_moving_mm = Eigen::Vector3d::Zero();     ///< closest point on the second triangle
};

/// By the order of the corners, counterclockwise seen from outside; zero for a triangle without area.
Eigen::Vector3d unit_normal(const geometry::Corners& t);

/// Overlap of rounded triangles up to which they count as touching: the accuracy of Bullet's distance of the
/// bare triangles, which are apart by the offset.
constexpr double rounded_touching_mm = 1e-6;

/// Owns Bullet's solver state; use one object per thread.
class NarrowPhase {
 public:
  NarrowPhase();
  ~NarrowPhase();
  NarrowPhase(const NarrowPhase&) = delete;
  NarrowPhase& operator=(const NarrowPhase&) = delete;

  /// Overlap and distance are accurate to 1e-9 mm within 1e-3 mm of contact, where the moving triangle is
  /// backed off by 0.05 mm, measured and brought back; to 1e-6 mm above (README.md).
  TriangleDistance measure(const geometry::Corners& reference, const geometry::Corners& moving);

  /// Whether the triangles intersect, with the same accuracy in less time. With an offset: whether they are
  /// nearer than it by more than `rounded_touching_mm`.
  bool overlap(const geometry::Corners& reference, const geometry::Corners& moving, double offset_mm = 0.0);

  long long n_measured() const { return n_measured_; }

 private:
  struct Bullet;
  enum class Wanted { overlap, distance };
  TriangleDistance measured(const geometry::Corners& reference, const geometry::Corners& moving, Wanted);
  TriangleDistance measured_backed_off(const geometry::Corners& reference, const geometry::Corners& moving,
                                       const Eigen::Vector3d& direction, Wanted);
  std::unique_ptr<Bullet> bullet_;
  long long n_measured_ = 0;
};

/// True when an axis or a face plane separates the triangles by more than `band_mm`. Conservative and cheap:
/// rejects pairs before the narrow phase.
bool is_certainly_separated(const geometry::Corners& a, const geometry::Corners& b, double band_mm);

/// In closed form: distance and closest points of the bare triangles, by the pairs of their features. Empty
/// where the line between the points does not prove the triangles apart by more than rounding: they overlap,
/// are nearer than about 1e-8 mm or degenerate, and only the narrow phase decides.
std::optional<TriangleDistance> closest_points(const geometry::Corners& reference,
                                               const geometry::Corners& moving);

}  // namespace vrda::contact
