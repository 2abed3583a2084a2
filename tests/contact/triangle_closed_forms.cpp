#include "contact/triangle_closed_forms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vrda::test {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Sine below which two edges are parallel: the square root of the rounding unit, where the error of their
// cross product's direction equals the error of omitting it.
constexpr double parallel_sine = 1e-8;

Eigen::Vector3d edge(const geometry::Corners& t, std::size_t k)
{
  return t[(k + 1) % 3] - t[k];
}
Eigen::Vector3d normal_of(const geometry::Corners& t)
{
  return edge(t, 0).cross(edge(t, 1));
}

// Keeps the largest separation of two triangles over the tested axes.
class MaxSeparation {
 public:
  MaxSeparation(const geometry::Corners& a, const geometry::Corners& b)
  {
    // Relative to a corner of the pair: a distant origin loses no digits.
    for (std::size_t k = 0; k < 3; ++k) {
      a_[k] = a[k] - a[0];
      b_[k] = b[k] - a[0];
    }
  }

  // Directions shorter than `shortest` are rounding errors.
  void test_axis(const Eigen::Vector3d& direction, double shortest)
  {
    const double length = direction.norm();
    if (!(length > shortest)) return;
    const double a0 = direction.dot(a_[0]), a1 = direction.dot(a_[1]), a2 = direction.dot(a_[2]);
    const double b0 = direction.dot(b_[0]), b1 = direction.dot(b_[1]), b2 = direction.dot(b_[2]);
    const double above = std::min({b0, b1, b2}) - std::max({a0, a1, a2});
    const double below = std::min({a0, a1, a2}) - std::max({b0, b1, b2});
    max_mm_ = std::max(max_mm_, std::max(above, below) / length);
  }

  const geometry::Corners& a() const { return a_; }
  const geometry::Corners& b() const { return b_; }
  double max_mm() const { return max_mm_; }

 private:
  geometry::Corners a_, b_;
  double max_mm_ = -infinity;
};

// Keeps the nearest of the offered pairs of points.
class Nearest {
 public:
  void offer(const Eigen::Vector3d& on_reference, const Eigen::Vector3d& on_moving)
  {
    const double distance_sq_mm2 = (on_moving - on_reference).squaredNorm();
    if (!(distance_sq_mm2 < distance_sq_mm2_)) return;
    distance_sq_mm2_ = distance_sq_mm2;
    on_reference_ = on_reference;
    on_moving_ = on_moving;
  }

  ClosestPoints answer() const { return {std::sqrt(distance_sq_mm2_), on_reference_, on_moving_}; }

 private:
  double distance_sq_mm2_ = infinity;
  Eigen::Vector3d on_reference_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d on_moving_ = Eigen::Vector3d::Zero();
};

// Candidate closest points to `p` on the corners, edges and face of a triangle, passed to `offer`.
template <typename Offer>
void offer_point(const Eigen::Vector3d& p, const geometry::Corners& t, const Eigen::Vector3d& normal,
                 const Offer& offer)
{
  bool is_over = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d along = edge(t, k), from = p - t[k];
    offer(t[k]);
    const double share = along.dot(from) / along.squaredNorm();
    if (share > 0.0 && share < 1.0) offer(t[k] + share * along);
    is_over = is_over && normal.dot(along.cross(from)) >= 0.0;
  }
  if (is_over) offer(p - (normal.dot(p - t[0]) / normal.squaredNorm()) * normal);
}

// Feet of the common perpendicular of two edges.
void offer_edges(const geometry::Corners& reference, std::size_t i, const geometry::Corners& moving,
                 std::size_t k, Nearest& nearest)
{
  const Eigen::Vector3d d = edge(reference, i), e = edge(moving, k), w = moving[k] - reference[i];
  const Eigen::Vector3d across = d.cross(e);
  const double across_sq = across.squaredNorm();
  if (!(across_sq > parallel_sine * parallel_sine * d.squaredNorm() * e.squaredNorm())) return;
  const double s = across.dot(w.cross(e)) / across_sq, t = across.dot(w.cross(d)) / across_sq;
  if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) nearest.offer(reference[i] + s * d, moving[k] + t * e);
}

}  // namespace

double separation_mm(const geometry::Corners& a, const geometry::Corners& b)
{
  MaxSeparation separation(a, b);
  const Eigen::Vector3d normal_a = normal_of(separation.a()), normal_b = normal_of(separation.b());
  separation.test_axis(normal_a, 0.0);
  separation.test_axis(normal_b, 0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = edge(separation.a(), i);
    separation.test_axis(normal_a.cross(d), 0.0);
    separation.test_axis(normal_b.cross(edge(separation.b(), i)), 0.0);
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = edge(separation.b(), k);
      separation.test_axis(d.cross(e), parallel_sine * d.norm() * e.norm());
    }
  }
  return separation.max_mm();
}

ClosestPoints closest_points(const geometry::Corners& reference, const geometry::Corners& moving)
{
  Nearest nearest;
  const Eigen::Vector3d normal_r = normal_of(reference), normal_m = normal_of(moving);
  for (std::size_t i = 0; i < 3; ++i) {
    offer_point(reference[i], moving, normal_m,
                [&](const Eigen::Vector3d& on_moving) { nearest.offer(reference[i], on_moving); });
    offer_point(moving[i], reference, normal_r,
                [&](const Eigen::Vector3d& on_reference) { nearest.offer(on_reference, moving[i]); });
    for (std::size_t k = 0; k < 3; ++k) offer_edges(reference, i, moving, k, nearest);
  }
  return nearest.answer();
}

}  // namespace vrda::test
