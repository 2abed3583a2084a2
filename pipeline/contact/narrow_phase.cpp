#include "contact/narrow_phase.hpp"

#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

namespace vrda {

static_assert(sizeof(btScalar) == 8, "Bullet must be its double-precision build (pkg-config bullet-float64)");

namespace {

// Bullet's GJK stops at a squared distance of 1e-12, so at unit scale it may call triangles 1e-6 mm apart
// that cross by less. Below this distance the pair is measured again at a finer scale.
constexpr double uncertain_mm = 2e-6;
// A power of two loses no bits; 1024 brings the threshold to 1e-9 mm. Larger scales made it fail more often.
constexpr double fine_scale = 1024.0;

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

  TriangleDistance measure(const Corners& a, const Corners& b, double scale)
  {
    // Coordinates from a corner of the pair: far origins cost no digits.
    const Eigen::Vector3d& origin = a[0];
    for (std::size_t k = 0; k < 3; ++k) {
      reference.m_vertices1[k] = to_bullet(scale * (a[k] - origin));
      moving.m_vertices1[k] = to_bullet(scale * (b[k] - origin));
    }
    detector.setCachedSeparatingAxis(to_bullet(centre(b) - centre(a)));
    btPointCollector collector;
    detector.getClosestPoints(input, collector, nullptr);
    TriangleDistance result;
    result.is_overlapping = !collector.m_hasResult;
    if (result.is_overlapping) return result;
    const Eigen::Vector3d on_moving = from_bullet(collector.m_pointInWorld);
    const Eigen::Vector3d normal = from_bullet(collector.m_normalOnBInWorld);
    result.distance_mm = collector.m_distance / scale;
    result.p_moving_mm = origin + on_moving / scale;
    result.p_reference_mm = origin + (on_moving + normal * collector.m_distance) / scale;
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
  const TriangleDistance coarse = bullet_->measure(reference, moving, 1.0);
  if (coarse.is_overlapping || coarse.distance_mm > uncertain_mm) return coarse;
  return bullet_->measure(reference, moving, fine_scale);
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
