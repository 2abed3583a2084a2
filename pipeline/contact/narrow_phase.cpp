#include "contact/narrow_phase.hpp"

#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vrda::contact {

static_assert(sizeof(btScalar) == 8, "Bullet must be its double-precision build (pkg-config bullet-float64)");

namespace {

// Bullet compares areas and squared lengths with constants, so that its errors depend on the unit: on pairs
// of 1 mm they reach 1e-6 mm where these are nearly parallel, on pairs of 200 units it may miss the closest
// points. In a unit in which the pair's extent is from 16 to 32 its distances are good to 1e-14 of the
// extent.
constexpr int extent_exponent = 4;
// Bullet's GJK stops at a squared distance of 1e-12 and misclassifies pairs within a micrometre of contact.
// Nearer pairs are measured with the moving triangle backed off by `backing_mm` and brought back.
constexpr double reliable_mm = 1e-3;
constexpr double backing_mm = 0.05;
// Below this distance Bullet's direction may be off by more than 1e-4 rad.
constexpr double directed_mm = 1e-7;
// Sine below which the direction no longer changes: the points are good to 5e-11 mm.
constexpr double same_direction = 1e-9;
// The points' distance is an upper bound, the separation along Bullet's direction a lower one. Between two
// vertices the direction converges slowly and the points are right from the first step on.
constexpr double settled_mm = 1e-9;
// One step for nearly all pairs.
constexpr int most_steps = 10;
// Bullet's GJK may end early, with points that are not the closest ones: by 6 mm for a corner 0.0008 mm from
// the middle of an edge (NarrowPhase.ACornerAtTheMiddleOfAnEdge). The separation along its direction, a lower
// bound, shows that; rounding and its end criterion are far below these.
constexpr double unproved_mm = 1e-5, unproved_share = 1e-5;

btVector3 to_bullet(const Eigen::Vector3d& p)
{
  return {p.x(), p.y(), p.z()};
}
Eigen::Vector3d from_bullet(const btVector3& p)
{
  return {p.x(), p.y(), p.z()};
}

}  // namespace

struct NarrowPhase::Bullet {
  // The detector copies the margins on construction, so the shapes' margins must be zero by then.
  struct BareTriangle : btTriangleShape {
    BareTriangle() : btTriangleShape({0, 0, 0}, {1, 0, 0}, {0, 0, 1}) { setMargin(0.0); }
  };
  btVoronoiSimplexSolver simplex;
  BareTriangle reference;
  BareTriangle moving;
  btGjkPairDetector detector{&reference, &moving, &simplex, nullptr};
  btGjkPairDetector::ClosestPointInput input;

  Bullet()
  {
    input.m_transformA.setIdentity();
    input.m_transformB.setIdentity();
  }

  struct Found {
    bool is_overlapping = true;
    double distance_mm = 0.0;
    Eigen::Vector3d p_reference_mm, p_moving_mm;
    Eigen::Vector3d away;  // unit direction from the reference to the moving triangle
  };

  // The moving triangle translated by `shift_mm`.
  Found closest(const geometry::Corners& a, const geometry::Corners& b, const Eigen::Vector3d& shift_mm)
  {
    // Coordinates relative to a corner of the pair: a distant origin loses no digits.
    const Eigen::Vector3d& origin = a[0];
    double extent_mm = 1e-3;  // smaller pairs are of no matter, and zero has no exponent
    for (std::size_t k = 0; k < 3; ++k) {
      extent_mm = std::max(extent_mm, (a[k] - origin).lpNorm<Eigen::Infinity>());
      extent_mm = std::max(extent_mm, (b[k] - origin + shift_mm).lpNorm<Eigen::Infinity>());
    }
    // A power of two is exact.
    const double scale = std::ldexp(1.0, extent_exponent - std::ilogb(extent_mm));
    for (std::size_t k = 0; k < 3; ++k) {
      reference.m_vertices1[k] = to_bullet(scale * (a[k] - origin));
      moving.m_vertices1[k] = to_bullet(scale * (b[k] - origin + shift_mm));
    }
    Found found = from_axis(centre(b) - centre(a) + shift_mm, origin, scale);
    if (is_proved(found, a, b, shift_mm)) return found;
    for (const Eigen::Vector3d& axis :
         {found.away, unit_normal(a), unit_normal(b), Eigen::Vector3d(Eigen::Vector3d::UnitX()),
          Eigen::Vector3d(Eigen::Vector3d::UnitY()), Eigen::Vector3d(Eigen::Vector3d::UnitZ())}) {
      for (const double sign : {1.0, -1.0}) {
        found = from_axis(sign * axis, origin, scale);
        if (is_proved(found, a, b, shift_mm)) return found;
      }
    }
    return {};
  }

  // GJK from an initial axis, with the triangles in the shapes.
  Found from_axis(const Eigen::Vector3d& axis, const Eigen::Vector3d& origin, double scale)
  {
    detector.setCachedSeparatingAxis(to_bullet(axis));
    btPointCollector collector;
    detector.getClosestPoints(input, collector, nullptr);
    if (!collector.m_hasResult) return {};
    const double distance_mm = collector.m_distance / scale;
    const Eigen::Vector3d on_moving = origin + from_bullet(collector.m_pointInWorld) / scale;
    const Eigen::Vector3d away = -from_bullet(collector.m_normalOnBInWorld);
    return {false, distance_mm, on_moving - away * distance_mm, on_moving, away};
  }

  // Whether the triangles are as far apart along the direction as the points are. An overlap is not judged.
  static bool is_proved(const Found& found, const geometry::Corners& a, const geometry::Corners& b,
                        const Eigen::Vector3d& shift_mm)
  {
    if (found.is_overlapping) return true;
    double last_of_a = found.away.dot(a[0]), first_of_b = found.away.dot(b[0]);
    for (std::size_t k = 1; k < 3; ++k) {
      last_of_a = std::max(last_of_a, found.away.dot(a[k]));
      first_of_b = std::min(first_of_b, found.away.dot(b[k]));
    }
    const double separation_mm = first_of_b - last_of_a + found.away.dot(shift_mm);
    return found.distance_mm - separation_mm <= unproved_mm + unproved_share * found.distance_mm;
  }

  // Initial axis for GJK; Bullet uses (0, 1, 0) when both centres coincide.
  static Eigen::Vector3d centre(const geometry::Corners& t) { return (t[0] + t[1] + t[2]) / 3.0; }
};

NarrowPhase::NarrowPhase() : bullet_(std::make_unique<Bullet>()) {}
NarrowPhase::~NarrowPhase() = default;

Eigen::Vector3d unit_normal(const geometry::Corners& t)
{
  return (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

TriangleDistance NarrowPhase::measured_backed_off(const geometry::Corners& reference,
                                                  const geometry::Corners& moving,
                                                  const Eigen::Vector3d& direction, Wanted wanted)
{
  TriangleDistance nearest;
  nearest.distance_mm = std::numeric_limits<double>::infinity();
  double separation_mm = -std::numeric_limits<double>::infinity();
  const Eigen::Vector3d from_reference = unit_normal(reference), from_moving = -unit_normal(moving);
  for (Eigen::Vector3d away : {direction, from_reference, from_moving, Eigen::Vector3d(-from_reference),
                               Eigen::Vector3d(-from_moving)}) {
    for (int step = 0; step < most_steps; ++step) {
      const Bullet::Found found = bullet_->closest(reference, moving, backing_mm * away);
      if (found.is_overlapping || found.distance_mm < reliable_mm) break;
      separation_mm = std::max(separation_mm, found.distance_mm - backing_mm * away.dot(found.away));
      const Eigen::Vector3d p_moving_mm = found.p_moving_mm - backing_mm * away;
      const double distance_mm = (p_moving_mm - found.p_reference_mm).norm();
      if (distance_mm < nearest.distance_mm)
        nearest = {false, distance_mm, found.p_reference_mm, p_moving_mm};
      if (separation_mm > 0.0 && wanted == Wanted::overlap) return nearest;
      if ((away - found.away).norm() < same_direction) break;
      away = found.away;
    }
    if (separation_mm > 0.0 && nearest.distance_mm - separation_mm < settled_mm) return nearest;
  }
  if (separation_mm > 0.0) return nearest;
  return {true, separation_mm, nearest.p_reference_mm, nearest.p_moving_mm};
}

TriangleDistance NarrowPhase::measured(const geometry::Corners& reference, const geometry::Corners& moving,
                                       Wanted wanted)
{
  ++n_measured_;
  const Bullet::Found found = bullet_->closest(reference, moving, Eigen::Vector3d::Zero());
  if (!found.is_overlapping && found.distance_mm > reliable_mm)
    return {false, found.distance_mm, found.p_reference_mm, found.p_moving_mm};
  const bool has_direction = !found.is_overlapping && found.distance_mm > directed_mm;
  return measured_backed_off(reference, moving, has_direction ? found.away : Eigen::Vector3d::UnitY(),
                             wanted);
}

TriangleDistance NarrowPhase::measure(const geometry::Corners& reference, const geometry::Corners& moving)
{
  return measured(reference, moving, Wanted::distance);
}

bool NarrowPhase::overlap(const geometry::Corners& reference, const geometry::Corners& moving,
                          double offset_mm)
{
  if (offset_mm > 0.0)
    return measured(reference, moving, Wanted::distance).distance_mm < offset_mm - rounded_touching_mm;
  return measured(reference, moving, Wanted::overlap).is_overlapping;
}

bool is_certainly_separated(const geometry::Corners& a, const geometry::Corners& b, double band_mm)
{
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const geometry::Extent ea = geometry::extent(a, axis), eb = geometry::extent(b, axis);
    if (ea.least - eb.most > band_mm || eb.least - ea.most > band_mm) return true;
  }
  struct Range {
    double least, most;
  };
  const auto range_along = [](const Eigen::Vector3d& n, const Eigen::Vector3d& p,
                              const geometry::Corners& other) {
    const double d0 = n.dot(other[0] - p), d1 = n.dot(other[1] - p), d2 = n.dot(other[2] - p);
    return Range{std::min({d0, d1, d2}), std::max({d0, d1, d2})};
  };
  // Whether distances along `n` from `least` to `most` are beyond the band. Margin for rounding: no touching
  // pair may be rejected. Most fail at the first comparison, without a square root.
  const auto is_beyond = [band_mm](const Eigen::Vector3d& n, double least, double most) {
    if (!(least > 0.0)) return false;
    const double length = n.norm();
    return least > band_mm * length + 1e-9 * (length + most);
  };
  // By the plane of a face on either side, or by the planes through its edges and across it.
  const auto separates = [&](const geometry::Corners& face, const geometry::Corners& other) {
    const Eigen::Vector3d n = (face[1] - face[0]).cross(face[2] - face[0]);
    const Range across = range_along(n, face[0], other);
    if (is_beyond(n, across.least, across.most) || is_beyond(n, -across.most, -across.least)) return true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d out = (face[(k + 1) % 3] - face[k]).cross(n);
      const Range beside = range_along(out, face[k], other);
      if (is_beyond(out, beside.least, beside.most)) return true;
    }
    return false;
  };
  return separates(a, b) || separates(b, a);
}

// Closest points of two triangles in closed form.

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
