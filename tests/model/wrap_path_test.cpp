#include "model/ligaments.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/units.hpp"

namespace vrda::wrap_path_test {

// The shortest way round an ellipsoid as a chain of points: slow, simple, and shares nothing with the
// product.
using Chain = std::vector<Eigen::Vector3d>;

/// The point outside or on the ellipsoid nearest to being on the straight line between two neighbours.
Eigen::Vector3d eased(const Eigen::Vector3d& before, const Eigen::Vector3d& after,
                      const Eigen::Vector3d& half_axes_mm)
{
  Eigen::Vector3d p = 0.5 * (before + after);
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d q = p.cwiseQuotient(half_axes_mm);
    const double outside = q.squaredNorm() - 1.0;
    if (outside >= 0.0 && i == 0) return p;
    const Eigen::Vector3d gradient = 2.0 * q.cwiseQuotient(half_axes_mm);
    p -= outside / gradient.squaredNorm() * gradient;
  }
  return p;
}

double length_of(const Chain& chain)
{
  double length_mm = 0.0;
  for (std::size_t i = 1; i < chain.size(); ++i) length_mm += (chain[i] - chain[i - 1]).norm();
  return length_mm;
}

/// Length of the way that starts from the given points, by halving the links down to `n_links`; an even
/// number of sweeps a level pulls it tight. Falls short by the arcs over the chords.
double chain_length_mm(Chain chain, const Eigen::Vector3d& half_axes_mm, std::size_t n_links)
{
  while (true) {
    for (int sweep = 0; sweep < 400; ++sweep) {
      for (std::size_t i = 1; i + 1 < chain.size(); ++i) {
        chain[i] = eased(chain[i - 1], chain[i + 1], half_axes_mm);
      }
    }
    if (chain.size() > n_links) return length_of(chain);
    Chain finer;
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
      finer.push_back(chain[i]);
      finer.push_back(eased(chain[i], chain[i + 1], half_axes_mm));
    }
    finer.push_back(chain.back());
    chain = finer;
  }
}

// The promise of ellipsoid_path: what its integration leaves.
constexpr double integration_mm = 1e-8;
constexpr double rounding_mm = 1e-11;  // of lengths of tens of mm

const Eigen::Vector3d half_axes_mm(30, 18, 12);  // of the jam-smith2019 knee's larger ellipsoid

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double from, double to)
  {
    return from + (to - from) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
  }
  Eigen::Vector3d direction()
  {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    while (p.norm() > 1.0 || p.norm() < 0.1) p = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    return p.normalized();
  }
  // Outside the ellipsoid, near its surface or up to 30 mm off.
  Eigen::Vector3d outside(const Eigen::Vector3d& axes_mm)
  {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    while (p.cwiseQuotient(axes_mm).squaredNorm() < 1.0) {
      p = uniform(1.0, 1.2) * direction().cwiseProduct(axes_mm) + uniform(0, 30) * direction();
    }
    return p;
  }

 private:
  std::mt19937_64 engine_;
};

struct Surface {
  const char* name;
  Eigen::Vector3d axes_mm;
  bool is_cylinder;

  model::WrapPath path(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const
  {
    return is_cylinder ? model::cylinder_path(a, b, axes_mm.x(), 1e6) : model::ellipsoid_path(a, b, axes_mm);
  }
};

const Surface ellipsoid{"ellipsoid", half_axes_mm, false};
const Surface slender{"slender", {25, 5.4, 5.3}, false};  // of the same knee
const Surface lens{"lens", {30, 30, 6}, false};           // as flat as a job may have
const Surface surfaces[] = {
    {"cylinder", {18, 18, 18}, true}, {"sphere", {18, 18, 18}, false}, ellipsoid, slender, lens};

struct Ends {
  Eigen::Vector3d a, b;
};

// Two points whose line the surface cuts.
Ends wrapped_ends(const Surface& surface, Random& random)
{
  Ends ends;
  do {
    ends = {random.outside(surface.axes_mm), random.outside(surface.axes_mm)};
  } while (!surface.path(ends.a, ends.b).is_wrapped);
  return ends;
}

// Tangent, arc, tangent in the plane through the centre; the arc is negative where the line is free.
struct Circular {
  double arc_rad, length_mm;
};

Circular round_circle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double r)
{
  const double between_rad = arc_cosine(a.dot(b) / (a.norm() * b.norm()));
  const double arc_rad = between_rad - arc_cosine(r / a.norm()) - arc_cosine(r / b.norm());
  return {arc_rad, std::sqrt(a.squaredNorm() - r * r) + r * arc_rad + std::sqrt(b.squaredNorm() - r * r)};
}

TEST(EllipsoidPath, WithEqualAxesIsAGreatCircle)
{
  Random random(5);
  const double r = 15.0;
  int n_wrapped = 0, n_free = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d a = random.outside({r, r, r}), b = random.outside({r, r, r});
    const model::WrapPath path = model::ellipsoid_path(a, b, {r, r, r});
    const Eigen::Vector3d x = a.normalized(), y = (b - b.dot(x) * x).normalized();
    const Circular expected = round_circle({a.norm(), 0}, {b.dot(x), b.dot(y)}, r);
    n_wrapped += path.is_wrapped;
    n_free += !path.is_wrapped;
    EXPECT_EQ(path.is_wrapped, expected.arc_rad > 0.0);
    EXPECT_NEAR(path.length_mm, path.is_wrapped ? expected.length_mm : 0.0, integration_mm);
  }
  EXPECT_GT(std::min(n_wrapped, n_free), 100);
}

// The shortest of chains pushed out to all sides.
double shortest_chain_mm(const Ends& ends, const Eigen::Vector3d& axes_mm, std::size_t n_links)
{
  const Eigen::Vector3d x = (ends.b - ends.a).unitOrthogonal();
  const Eigen::Vector3d y = (ends.b - ends.a).normalized().cross(x);
  double shortest_mm = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d side_mm = 60.0 * (cosine(k * pi / 4) * x + sine(k * pi / 4) * y);
    const Chain start = {ends.a, 0.5 * (ends.a + ends.b) + side_mm, ends.b};
    shortest_mm = std::min(shortest_mm, chain_length_mm(start, axes_mm, n_links));
  }
  return shortest_mm;
}

TEST(EllipsoidPath, AgreesWithADenseChain)
{
  Random random(6);
  const std::size_t n_links = 256;
  for (int i = 0; i < 20; ++i) {
    const Ends ends = wrapped_ends(ellipsoid, random);
    const double length_mm = ellipsoid.path(ends.a, ends.b).length_mm;
    // Chords of arcs: the sum of h^3 / 24 r^2 over links of h, the tightest bend r = 12^2 / 30 mm.
    const double h_mm = length_mm / n_links;
    const double chords_mm = n_links * h_mm * h_mm * h_mm / (24.0 * 4.8 * 4.8);
    EXPECT_NEAR(length_mm, shortest_chain_mm(ends, half_axes_mm, n_links), chords_mm) << i;
  }
}

TEST(EllipsoidPath, IsTheSameBackwards)
{
  Random random(7);
  for (const Surface& surface : {ellipsoid, slender}) {
    SCOPED_TRACE(surface.name);
    for (int i = 0; i < 1000; ++i) {
      const Ends ends = wrapped_ends(surface, random);
      EXPECT_NEAR(surface.path(ends.a, ends.b).length_mm, surface.path(ends.b, ends.a).length_mm,
                  integration_mm);
    }
  }
}

TEST(EllipsoidPath, TurnedHalfRoundAnAxisIsTheSame)
{
  Random random(8);
  const Eigen::Vector3d m(-1, 1, -1);
  for (int i = 0; i < 200; ++i) {
    const Ends ends = wrapped_ends(ellipsoid, random);
    const model::WrapPath path = ellipsoid.path(ends.a, ends.b);
    const model::WrapPath turned = ellipsoid.path(m.cwiseProduct(ends.a), m.cwiseProduct(ends.b));
    EXPECT_NEAR(path.length_mm, turned.length_mm, integration_mm);
    EXPECT_LT((path.end_direction - m.cwiseProduct(turned.end_direction)).norm(), 1e-8);
  }
}

TEST(EllipsoidPath, OfASlackFibreIsBoundedBelowTheSlackLength)
{
  Random random(11);
  int n_bounded = 0;
  for (int i = 0; i < 500; ++i) {
    const Ends ends = wrapped_ends(ellipsoid, random);
    const double length_mm = ellipsoid.path(ends.a, ends.b).length_mm;
    const double slack_mm = random.uniform(0.9, 1.2) * length_mm;
    const double bound_mm = model::ellipsoid_path(ends.a, ends.b, half_axes_mm, slack_mm).length_mm;
    n_bounded += bound_mm != length_mm;
    EXPECT_GE(bound_mm, length_mm - integration_mm);
    EXPECT_EQ(bound_mm < slack_mm, length_mm < slack_mm);
  }
  EXPECT_GT(n_bounded, 100);
}

TEST(EllipsoidPath, IsInactiveForAnAttachmentInside)
{
  EXPECT_FALSE(model::ellipsoid_path({0, 0, 11.9}, {0, 5, -40}, half_axes_mm).is_wrapped);
  EXPECT_FALSE(model::ellipsoid_path({0, 5, -40}, {0, 0, 11.9}, half_axes_mm).is_wrapped);
  EXPECT_TRUE(model::ellipsoid_path({0, 0, 12.1}, {0, 5, -40}, half_axes_mm).is_wrapped);
}

TEST(EllipsoidPath, ThroughTheCentreTakesTheShorterSide)
{
  // From pole to pole of the long axis: over the short axis, not the middle one.
  const model::WrapPath path = model::ellipsoid_path({-40, 0, 0}, {40, 0, 0}, half_axes_mm);
  const double r_sq = 30.0 * 30.0, touch = r_sq / 40.0;
  ASSERT_TRUE(path.is_wrapped);
  EXPECT_NEAR(std::abs(path.end_direction.z()) / path.end_direction.x(),
              12.0 * std::sqrt(1.0 - touch * touch / r_sq) / (40.0 - touch), 1e-8);
  EXPECT_NEAR(path.end_direction.y(), 0.0, 1e-8);
}

TEST(EllipsoidPath, OfAnAttachmentOnTheSurfaceStartsAlongIt)
{
  const double r = 10.0;
  const model::WrapPath path = model::ellipsoid_path({0, 0, r}, {20, 0, -5}, {r, r, r});
  ASSERT_TRUE(path.is_wrapped);
  EXPECT_NEAR(path.length_mm, round_circle({r, 0}, {-5, 20}, r).length_mm, integration_mm);
}

TEST(CylinderPath, IsAHelix)
{
  // A quarter of the circle of radius 10 between tangents of 5 and 7 mm, rising by 12 mm.
  const double r = 10.0, rise_mm = 12.0, across_mm = 5 + r * pi / 2 + 7;
  const model::WrapPath path = model::cylinder_path({r, -5, 0}, {-7, r, rise_mm}, r, 100);
  ASSERT_TRUE(path.is_wrapped);
  EXPECT_NEAR(path.length_mm, std::sqrt(across_mm * across_mm + rise_mm * rise_mm), rounding_mm);
  const Eigen::Vector3d expected = Eigen::Vector3d(-across_mm, 0, rise_mm).normalized();
  EXPECT_LT((path.end_direction - expected).norm(), 1e-12);
}

TEST(CylinderPath, StaysOnTheShorterSide)
{
  for (const double side : {1.0, -1.0}) {
    const model::WrapPath path = model::cylinder_path({-30, side, 0}, {30, side, 5}, 10, 100);
    ASSERT_TRUE(path.is_wrapped);
    EXPECT_LT(path.end_direction.y() * side, 0.0);  // comes down to the end from that side
  }
}

// A tangent of 8 mm to the cylinder of radius 6 through the end, then a third of its circle.
TEST(CylinderPath, ToAnEndInsideIsAroundTheCylinderThroughIt)
{
  const double r = 6.0, across_mm = 8.0 + r * pi / 3.0, rise_mm = 4.0;
  const Eigen::Vector3d start(r, -8, 0), end(r * 0.5, r * std::sqrt(0.75), rise_mm);
  const model::WrapPath path = model::cylinder_path(start, end, 9.5, 100);
  ASSERT_TRUE(path.is_wrapped);
  EXPECT_NEAR(path.length_mm, std::sqrt(across_mm * across_mm + rise_mm * rise_mm), rounding_mm);
  EXPECT_LT((model::cylinder_point_mm(path, path.arc_mm) - end).norm(), rounding_mm);
}

TEST(CylinderPath, IsContinuousWhereItsEndEntersTheSurface)
{
  const double h = 1e-7;
  const Eigen::Vector3d start(14, -5, 0), end(-7, 7, 3);
  const double r = end.head<2>().norm();
  const double inside_mm = model::cylinder_path(start, end, r + h, 100).length_mm;
  const double outside_mm = model::cylinder_path(start, end, r - h, 100).length_mm;
  EXPECT_NEAR(inside_mm, outside_mm, 10 * h);
  EXPECT_GT(outside_mm - (end - start).norm(), 1.0);  // a straight line would jump
}

TEST(CylinderPath, IsInactiveInsideAndBeyondAnEnd)
{
  EXPECT_FALSE(model::cylinder_path({30, 1, 0}, {-9, 0, 0}, 10, 100, model::EndInside::straight).is_wrapped);
  EXPECT_FALSE(model::cylinder_path({9, 0, 0}, {-30, 1, 0}, 10, 100).is_wrapped);
  EXPECT_TRUE(model::cylinder_path({30, 1, 19}, {-30, 1, 19}, 10, 20).is_wrapped);
  EXPECT_FALSE(model::cylinder_path({30, 1, 21}, {-30, 1, 21}, 10, 20).is_wrapped);
  EXPECT_FALSE(model::cylinder_path({30, 1, -21}, {-30, 1, -21}, 10, 20).is_wrapped);
}

struct Measured {
  model::WrapPath path;
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();
  Eigen::Matrix3d bending = Eigen::Matrix3d::Zero();
  bool is_smooth = false;  // wrapped all along, and not within 1 mm of the surface
};

Measured measured_derivatives(const Surface& surface, const Ends& ends)
{
  const double h = 1e-4;  // mm
  Measured out;
  out.path = surface.path(ends.a, ends.b);
  out.is_smooth = out.path.bending.norm() < 1.0;
  for (int k = 0; k < 3; ++k) {
    const model::WrapPath ahead = surface.path(ends.a, ends.b + h * Eigen::Vector3d::Unit(k));
    const model::WrapPath behind = surface.path(ends.a, ends.b - h * Eigen::Vector3d::Unit(k));
    out.slope[k] = (ahead.length_mm - behind.length_mm) / (2 * h);
    out.bending.col(k) = (ahead.end_direction - behind.end_direction) / (2 * h);
    out.is_smooth = out.is_smooth && ahead.is_wrapped && behind.is_wrapped;
  }
  return out;
}

TEST(WrapPath, DerivativesMatchDifferences)
{
  for (const Surface& surface : surfaces) {
    SCOPED_TRACE(surface.name);
    Random random(9);
    for (int i = 0; i < 100; ++i) {
      Measured measured;
      do {
        measured = measured_derivatives(surface, wrapped_ends(surface, random));
      } while (!measured.is_smooth);
      // Lengths to 1e-9 mm and directions to 1e-9 over steps of 1e-4 mm.
      EXPECT_LT((measured.slope - measured.path.end_direction).norm(), 3e-5) << i;
      EXPECT_LT((measured.bending - measured.path.bending).norm(), 1e-4) << i;
    }
  }
}

TEST(WrapPath, DerivativesMatchDifferencesWhereTheEndIsInsideACylinder)
{
  const Surface& cylinder = surfaces[0];
  Random random(10);
  for (int n = 0; n < 100;) {
    const Ends ends{random.outside(cylinder.axes_mm),
                    random.uniform(0.2, 0.95) * random.direction().cwiseProduct(cylinder.axes_mm)};
    const Measured measured = measured_derivatives(cylinder, ends);
    if (!measured.is_smooth) continue;
    EXPECT_LT((measured.slope - measured.path.end_direction).norm(), 3e-5) << n;
    EXPECT_LT((measured.bending - measured.path.bending).norm(), 1e-4) << n;
    ++n;
  }
}

TEST(WrapPath, LiftsOffSmoothly)
{
  // The end rises until the line is free: length and direction stay continuous at the last touch.
  for (const Surface& surface : surfaces) {
    SCOPED_TRACE(surface.name);
    const double top_mm = surface.axes_mm.y();
    const auto at = [&](double y_mm) {
      const Eigen::Vector3d a(-40, top_mm, 1), b(40, y_mm, -2);
      model::WrapPath path = surface.path(a, b);
      if (!path.is_wrapped) {
        path.length_mm = (b - a).norm();
        path.end_direction = (b - a).normalized();
      }
      return path;
    };
    double low_mm = top_mm - 5, high_mm = top_mm + 5;
    ASSERT_TRUE(at(low_mm).is_wrapped);
    ASSERT_FALSE(at(high_mm).is_wrapped);
    while (high_mm - low_mm > 1e-9) {
      const double middle_mm = 0.5 * (low_mm + high_mm);
      (at(middle_mm).is_wrapped ? low_mm : high_mm) = middle_mm;
    }
    EXPECT_NEAR(at(low_mm).length_mm, at(high_mm).length_mm, integration_mm);
    // Directions part by at most the root of the height, 1e-9 mm, over the bend, some mm.
    EXPECT_LT((at(low_mm).end_direction - at(high_mm).end_direction).norm(), 1e-4);
  }
}

TEST(WrapPath, IsLongerThanTheLine)
{
  Random random(10);
  for (const Surface& surface : surfaces) {
    SCOPED_TRACE(surface.name);
    for (int i = 0; i < 500; ++i) {
      const Ends ends = wrapped_ends(surface, random);
      EXPECT_GT(surface.path(ends.a, ends.b).length_mm, (ends.b - ends.a).norm() - integration_mm);
    }
  }
}

}  // namespace vrda::wrap_path_test
