// Closest points of two triangles in closed form.
#include "contact/narrow_phase.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vrda::contact {
namespace {

// A separation above it is not due to rounding: coordinates of 100 mm, edges up to 100 mm.
constexpr double proven_mm = 1e-9;

using geometry::Corners;

struct Nearest {
  double distance_sq_mm2 = std::numeric_limits<double>::infinity();
  Eigen::Vector3d on_reference = Eigen::Vector3d::Zero(), on_moving = Eigen::Vector3d::Zero();

  void offer(const Eigen::Vector3d& r, const Eigen::Vector3d& m)
  {
    const double sq = (m - r).squaredNorm();
    if (!(sq < distance_sq_mm2)) return;
    distance_sq_mm2 = sq;
    on_reference = r;
    on_moving = m;
  }
};

struct Plane {
  Eigen::Vector3d normal;  // not of unit length
  std::array<Eigen::Vector3d, 3> inward;
};

Plane plane_of(const Corners& t)
{
  const Eigen::Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
  return {n, {n.cross(t[1] - t[0]), n.cross(t[2] - t[1]), n.cross(t[0] - t[2])}};
}

// Calls `offer(foot, p)` for each corner p of `others` over the face.
template <typename Offer>
void offer_corners(const Corners& face, const Plane& plane, const Corners& others, const Offer& offer)
{
  for (const Eigen::Vector3d& p : others) {
    const bool is_over = plane.inward[0].dot(p - face[0]) >= 0.0 && plane.inward[1].dot(p - face[1]) >= 0.0 &&
                         plane.inward[2].dot(p - face[2]) >= 0.0;
    if (!is_over) continue;
    const double height = plane.normal.dot(p - face[0]) / plane.normal.squaredNorm();
    offer(p - height * plane.normal, p);
  }
}

// Edges in closed form (Ericson 2005, 5.1.9): the nearest point on each line, clamped to the edges.
void offer_edges(const Eigen::Vector3d& r, const Eigen::Vector3d& d, const Eigen::Vector3d& m,
                 const Eigen::Vector3d& e, Nearest& nearest)
{
  const Eigen::Vector3d w = r - m;
  const double dd = d.squaredNorm(), ee = e.squaredNorm(), de = d.dot(e), dw = d.dot(w), ew = e.dot(w);
  const double across = dd * ee - de * de;
  double s = across > 0.0 ? std::clamp((de * ew - dw * ee) / across, 0.0, 1.0) : 0.0;
  double t = (de * s + ew) / ee;
  if (t < 0.0 || t > 1.0) {
    t = std::clamp(t, 0.0, 1.0);
    s = std::clamp((t * de - dw) / dd, 0.0, 1.0);
  }
  nearest.offer(r + s * d, m + t * e);
}

}  // namespace

std::optional<TriangleDistance> closest_points(const Corners& reference, const Corners& moving)
{
  Nearest nearest;
  offer_corners(reference, plane_of(reference), moving,
                [&](const Eigen::Vector3d& foot, const Eigen::Vector3d& p) { nearest.offer(foot, p); });
  offer_corners(moving, plane_of(moving), reference,
                [&](const Eigen::Vector3d& foot, const Eigen::Vector3d& p) { nearest.offer(p, foot); });
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = reference[(i + 1) % 3] - reference[i];
    for (std::size_t k = 0; k < 3; ++k)
      offer_edges(reference[i], d, moving[k], moving[(k + 1) % 3] - moving[k], nearest);
  }
  const double distance_mm = std::sqrt(nearest.distance_sq_mm2);
  const Eigen::Vector3d away = nearest.on_moving - nearest.on_reference;
  double most = -std::numeric_limits<double>::infinity(), least = -most;
  for (std::size_t k = 0; k < 3; ++k) {
    most = std::max(most, away.dot(reference[k] - nearest.on_reference));
    least = std::min(least, away.dot(moving[k] - nearest.on_reference));
  }
  if (!(least - most > proven_mm * distance_mm)) return std::nullopt;
  return TriangleDistance{false, distance_mm, nearest.on_reference, nearest.on_moving};
}

}  // namespace vrda::contact
