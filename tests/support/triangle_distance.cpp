#include "support/triangle_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace vrda::test {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<Vector3d, 3>;

// Ericson, Real-Time Collision Detection (2005), 5.1.9.
double segment_distance(const Vector3d& p1, const Vector3d& q1, const Vector3d& p2, const Vector3d& q2)
{
  const Vector3d d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const double a = d1.dot(d1), e = d2.dot(d2), f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
  const double denominator = a * e - b * b;
  double s = denominator > 1e-14 * a * e ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
  double t = (b * s + f) / e;
  if (t < 0.0) {
    t = 0.0;
    s = std::clamp(-c / a, 0.0, 1.0);
  } else if (t > 1.0) {
    t = 1.0;
    s = std::clamp((b - c) / a, 0.0, 1.0);
  }
  return (p1 + s * d1 - p2 - t * d2).norm();
}

bool is_over(const Triangle& t, const Vector3d& n, const Vector3d& p)
{
  for (std::size_t k = 0; k < 3; ++k) {
    if (n.cross(t[(k + 1) % 3] - t[k]).dot(p - t[k]) < 0.0) return false;
  }
  return true;
}

double face_distance(const Vector3d& p, const Triangle& t)
{
  const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
  return is_over(t, n, p) ? std::abs(n.normalized().dot(p - t[0])) : std::numeric_limits<double>::infinity();
}

bool pierces(const Vector3d& p, const Vector3d& q, const Triangle& t)
{
  const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double a = n.dot(p - t[0]), b = n.dot(q - t[0]);
  if ((a > 0.0) == (b > 0.0) && a != 0.0 && b != 0.0) return false;
  if (a == b) return false;
  return is_over(t, n, p + (q - p) * (a / (a - b)));
}

}  // namespace

double triangle_distance_mm(const Triangle& a, const Triangle& b)
{
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    if (pierces(a[i], a[(i + 1) % 3], b) || pierces(b[i], b[(i + 1) % 3], a)) return 0.0;
    least = std::min({least, face_distance(a[i], b), face_distance(b[i], a)});
    for (std::size_t k = 0; k < 3; ++k) {
      least = std::min(least, segment_distance(a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3]));
    }
  }
  return least;
}

}  // namespace vrda::test
