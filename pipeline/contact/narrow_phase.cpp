#include "contact/narrow_phase.hpp"

#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include "contact/closest_points.hpp"

namespace vrda {

static_assert(sizeof(btScalar) == 8, "Bullet must be its double-precision build (pkg-config bullet-float64)");

namespace {

// Bullet's GJK stops at a squared distance of 1e-12 and was seen to miss by 1e-5 mm on nearly parallel faces.
// What it calls touching or nearer than this is decided and measured again in closed form.
constexpr double uncertain_mm = 1e-3;

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
  // The detector copies the margins when it is made, so the shapes must have lost theirs by then.
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

  TriangleDistance measure(const Corners& a, const Corners& b)
  {
    // Coordinates from a corner of the pair: far origins cost no digits.
    const Eigen::Vector3d& origin = a[0];
    for (std::size_t k = 0; k < 3; ++k) {
      reference.m_vertices1[k] = to_bullet(a[k] - origin);
      moving.m_vertices1[k] = to_bullet(b[k] - origin);
    }
    detector.setCachedSeparatingAxis(to_bullet(centre(b) - centre(a)));
    btPointCollector collector;
    detector.getClosestPoints(input, collector, nullptr);
    TriangleDistance result;
    result.is_overlapping = !collector.m_hasResult;
    if (result.is_overlapping) return result;
    const Eigen::Vector3d on_moving = from_bullet(collector.m_pointInWorld);
    const Eigen::Vector3d normal = from_bullet(collector.m_normalOnBInWorld);
    result.distance_mm = collector.m_distance;
    result.p_moving_mm = origin + on_moving;
    result.p_reference_mm = origin + (on_moving + normal * collector.m_distance);
    return result;
  }

  // A start for GJK; Bullet's own default (0, 1, 0) when both centres coincide.
  static Eigen::Vector3d centre(const Corners& t) { return (t[0] + t[1] + t[2]) / 3.0; }
};

NarrowPhase::NarrowPhase() : bullet_(std::make_unique<Bullet>()) {}
NarrowPhase::~NarrowPhase() = default;

TriangleDistance NarrowPhase::measure(const Corners& reference, const Corners& moving)
{
  ++n_measured_;
  const TriangleDistance found = bullet_->measure(reference, moving);
  if (!found.is_overlapping && found.distance_mm > uncertain_mm) return found;
  if (separation_mm(reference, moving) <= 0.0) return {true, 0.0, {}, {}};
  return closest_points(reference, moving);
}

bool is_surely_apart(const Corners& a, const Corners& b, double band_mm)
{
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Extent ea = extent(a, axis), eb = extent(b, axis);
    if (ea.least - eb.most > band_mm || eb.least - ea.most > band_mm) return true;
  }
  const auto keeps_apart = [band_mm](const Corners& face, const Corners& other) {
    const Eigen::Vector3d n = (face[1] - face[0]).cross(face[2] - face[0]);
    const double limit = band_mm * n.norm();
    const double d0 = n.dot(other[0] - face[0]), d1 = n.dot(other[1] - face[0]),
                 d2 = n.dot(other[2] - face[0]);
    // A hair beyond the limit: rounding must never hide a touching pair from the narrow phase.
    const double sure = limit + 1e-9 * (n.norm() + std::abs(d0));
    return (d0 > sure && d1 > sure && d2 > sure) || (d0 < -sure && d1 < -sure && d2 < -sure);
  };
  return keeps_apart(a, b) || keeps_apart(b, a);
}

}  // namespace vrda
