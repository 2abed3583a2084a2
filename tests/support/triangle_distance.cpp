#include "support/triangle_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace vrda::test {
namespace {

template <typename Real>
using Vector = Eigen::Matrix<Real, 3, 1>;
template <typename Real>
using Triangle = std::array<Vector<Real>, 3>;

// Ericson, Real-Time Collision Detection (2005), 5.1.9.
template <typename Real>
Real segment_distance(const Vector<Real>& p1, const Vector<Real>& q1, const Vector<Real>& p2,
                      const Vector<Real>& q2)
{
  const Vector<Real> d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const Real zero = 0, one = 1;
  const Real a = d1.dot(d1), e = d2.dot(d2), f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
  const Real denominator = a * e - b * b;
  Real s = denominator > Real(1e-14) * a * e ? std::clamp((b * f - c * e) / denominator, zero, one) : zero;
  Real t = (b * s + f) / e;
  if (t < zero) {
    t = zero;
    s = std::clamp(-c / a, zero, one);
  } else if (t > one) {
    t = one;
    s = std::clamp((b - c) / a, zero, one);
  }
  return (p1 + s * d1 - p2 - t * d2).norm();
}

template <typename Real>
bool is_over(const Triangle<Real>& t, const Vector<Real>& n, const Vector<Real>& p)
{
  for (std::size_t k = 0; k < 3; ++k) {
    if (n.cross(t[(k + 1) % 3] - t[k]).dot(p - t[k]) < 0) return false;
  }
  return true;
}

template <typename Real>
Real face_distance(const Vector<Real>& p, const Triangle<Real>& t)
{
  const Vector<Real> n = (t[1] - t[0]).cross(t[2] - t[0]);
  return is_over<Real>(t, n, p) ? std::abs(n.normalized().dot(p - t[0]))
                                : std::numeric_limits<Real>::infinity();
}

template <typename Real>
bool pierces(const Vector<Real>& p, const Vector<Real>& q, const Triangle<Real>& t)
{
  const Vector<Real> n = (t[1] - t[0]).cross(t[2] - t[0]);
  const Real a = n.dot(p - t[0]), b = n.dot(q - t[0]);
  if ((a > 0) == (b > 0) && a != 0 && b != 0) return false;
  if (a == b) return false;
  return is_over<Real>(t, n, p + (q - p) * (a / (a - b)));
}

template <typename Real>
Real distance(const Triangle<Real>& a, const Triangle<Real>& b)
{
  Real least = std::numeric_limits<Real>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    if (pierces<Real>(a[i], a[(i + 1) % 3], b) || pierces<Real>(b[i], b[(i + 1) % 3], a)) return 0;
    least = std::min({least, face_distance<Real>(a[i], b), face_distance<Real>(b[i], a)});
    for (std::size_t k = 0; k < 3; ++k) {
      least = std::min(least, segment_distance<Real>(a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3]));
    }
  }
  return least;
}

Triangle<long double> fine(const Triangle<double>& t)
{
  return {t[0].cast<long double>(), t[1].cast<long double>(), t[2].cast<long double>()};
}

// Length of the translation along `n` that separates the two triangles.
long double overlap_along(const Vector<long double>& n, const Triangle<long double>& a,
                          const Triangle<long double>& b)
{
  const auto [a_low, a_high] = std::minmax({n.dot(a[0]), n.dot(a[1]), n.dot(a[2])});
  const auto [b_low, b_high] = std::minmax({n.dot(b[0]), n.dot(b[1]), n.dot(b[2])});
  return std::min(a_high - b_low, b_high - a_low);
}

}  // namespace

double triangle_distance_mm(const Triangle<double>& a, const Triangle<double>& b)
{
  return distance<double>(a, b);
}

long double fine_triangle_distance_mm(const Triangle<double>& a, const Triangle<double>& b)
{
  return distance<long double>(fine(a), fine(b));
}

long double fine_triangle_depth_mm(const Triangle<double>& a_given, const Triangle<double>& b_given)
{
  using Direction = Vector<long double>;
  const Triangle<long double> a = fine(a_given), b = fine(b_given);
  const Direction na = (a[1] - a[0]).cross(a[2] - a[0]), nb = (b[1] - b[0]).cross(b[2] - b[0]);
  std::vector<Direction> directions{na, nb};
  for (std::size_t i = 0; i < 3; ++i) {
    const Direction d = a[(i + 1) % 3] - a[i];
    directions.insert(directions.end(), {na.cross(d), nb.cross(b[(i + 1) % 3] - b[i])});
    for (std::size_t k = 0; k < 3; ++k) {
      const Direction e = b[(k + 1) % 3] - b[k];
      // Cross products near the rounding unit (1e-19) have no reliable direction.
      if (d.cross(e).norm() > 1e-15L * d.norm() * e.norm()) directions.push_back(d.cross(e));
    }
  }
  long double least = std::numeric_limits<long double>::infinity();
  for (const Direction& n : directions) {
    if (n.norm() > 0) least = std::min(least, overlap_along(n.normalized(), a, b));
  }
  return least;
}

}  // namespace vrda::test
