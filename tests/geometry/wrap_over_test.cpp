// Fibres beside a bone: depth inside it, and the wrap that keeps a fibre outside.
#include <gmock/gmock.h>

#include <array>

#include "core/units.hpp"
#include "geometry/wrap_over.hpp"
#include "support/meshes.hpp"

namespace vrda::wrap_over_test {

using Eigen::Vector3d;
using geometry::BonesOfJoint, geometry::NearestSurface;

constexpr double fitted_mm = 0.25;  // depth that a fit may leave

std::vector<NearestSurface> bone_of(Mesh mesh)
{
  std::vector<NearestSurface> bone;
  bone.emplace_back(std::move(mesh));
  return bone;
}

// About Z; every vertex is on the cylinder.
Mesh tube(double radius_mm, double half_length_mm)
{
  constexpr int n = 96, n_rings = 41;
  Mesh mesh;
  mesh.vertices_mm.resize(n * n_rings, 3);
  mesh.triangles.resize(2 * n * (n_rings - 1), 3);
  for (int r = 0; r < n_rings; ++r) {
    for (int k = 0; k < n; ++k) {
      const SinCos turn = sin_cos(2.0 * pi * k / n);
      mesh.vertices_mm.row(r * n + k) << radius_mm * turn.cos, radius_mm * turn.sin,
          half_length_mm * (2.0 * r / (n_rings - 1) - 1.0);
    }
  }
  for (int r = 0; r + 1 < n_rings; ++r) {
    for (int k = 0; k < n; ++k) {
      const int a = r * n + k, b = r * n + (k + 1) % n;
      mesh.triangles.row(2 * a) << a, b, b + n;
      mesh.triangles.row(2 * a + 1) << a, b + n, a + n;
    }
  }
  return mesh;
}

double sagitta_mm(double radius_mm, int n)
{
  return radius_mm * (1.0 - cosine(pi / n));
}

double length_mm(const model::Wrap& wrap, const Vector3d& start_mm, const Vector3d& end_mm)
{
  const Pose X = wrap.X_body_wrap.inverse();
  const model::WrapPath path =
      model::cylinder_path(X * start_mm, X * end_mm, wrap.radii_mm.x(), wrap.radii_mm.z());
  return path.is_wrapped ? path.length_mm : (end_mm - start_mm).norm();
}

// A fibre between a reference and a point of the other bone at some poses of it.
struct Span {
  model::Fibre fibre;
  std::vector<Pose> poses;

  Span(const Vector3d& start_mm, const std::vector<Vector3d>& ends_mm)
  {
    fibre.reference_mm = start_mm;
    fibre.moving_mm = Vector3d::Zero();
    for (const Vector3d& end_mm : ends_mm) poses.emplace_back(Eigen::Translation3d(end_mm));
  }

  std::optional<model::Wrap> fitted(const BonesOfJoint& bones, BodyIndex body = BodyIndex::reference) const
  {
    return geometry::wrap_over(bones, body, fibre, poses);
  }

  double left_mm(const BonesOfJoint& bones, const std::vector<model::Wrap>& wraps) const
  {
    model::Fibre over = fibre;
    over.wrap = wraps.empty() ? -1 : 0;
    return geometry::deepest_crossing(bones, over, wraps, poses).depth_mm;
  }
};

// An attachment low on the side of a cylinder; the other bone moves over it.
Span over_cylinder(double radius_mm)
{
  return {
      Vector3d(-radius_mm - 0.5, -8.0, 3.0),
      {{8, radius_mm + 12, 6}, {14, radius_mm + 12, 6}, {20, radius_mm + 12, 6}, {26, radius_mm + 12, 6}}};
}

TEST(InnerPoints, chord_of_a_ball)
{
  const std::vector<NearestSurface> bone = bone_of(test::ball(20.0, 48, 96));
  const auto deepest_mm = [&](double y_mm, double half_mm) {
    double most_mm = 0.0;
    const std::array line{Vector3d(-half_mm, y_mm, 0), Vector3d(half_mm, y_mm, 0)};
    for (const geometry::InnerPoint& point : geometry::inner_points(bone, line)) {
      most_mm = std::max(most_mm, point.depth_mm);
      EXPECT_GT(point.outward.dot(point.surface_mm.normalized()), 0.99);
    }
    return most_mm;
  };
  const double tolerance_mm = sagitta_mm(20.0, 48) + 0.01;  // the sampled point next to the middle
  EXPECT_NEAR(deepest_mm(14.0, 60.0), 6.0, tolerance_mm);
  EXPECT_NEAR(deepest_mm(18.0, 60.0), 2.0, tolerance_mm);
  EXPECT_EQ(deepest_mm(20.5, 60.0), 0.0);
  // Within 3 mm of the ends.
  EXPECT_EQ(deepest_mm(14.0, 2.9), 0.0);
}

TEST(InnerPoints, beyond_the_rim_of_a_sheet)
{
  const std::vector<NearestSurface> bone = bone_of(test::sheet(20.0, 8));
  const auto n_inner = [&](double x_mm, double y_mm) {
    const std::array line{Vector3d(x_mm, y_mm, -30), Vector3d(x_mm, y_mm, 30)};
    return geometry::inner_points(bone, line).size();
  };
  // 20 mm less a triangle of 2.5 mm at each rim; one point per mm.
  EXPECT_NEAR(static_cast<double>(n_inner(0.0, -2.0)), 15.0, 1.0);
  EXPECT_EQ(n_inner(0.0, 2.0), 0U);
  EXPECT_EQ(n_inner(14.0, -2.0), 0U);
}

TEST(WrapOver, cylinder_in_closed_form)
{
  constexpr double radius_mm = 20.0;
  const BonesOfJoint bones{bone_of(tube(radius_mm, 60.0)), {}};
  const Span span = over_cylinder(radius_mm);
  const std::optional<model::Wrap> wrap = span.fitted(bones);
  ASSERT_TRUE(wrap);
  const Vector3d& start_mm = span.fibre.reference_mm;
  for (const Pose& X : span.poses) {
    const Vector3d end_mm = X.translation();
    const double exact_mm = model::cylinder_path(start_mm, end_mm, radius_mm, 60.0).length_mm;
    ASSERT_GT(exact_mm, (end_mm - start_mm).norm() + 1.0);
    // A path raised by d over an arc of some 1.5 rad is longer by at most 1.5 d.
    EXPECT_NEAR(length_mm(*wrap, start_mm, end_mm), exact_mm, 1.5 * (fitted_mm + sagitta_mm(radius_mm, 96)));
  }
}

// Half-axes of 24, 16 and 20 mm.
Mesh ellipsoid()
{
  Mesh mesh = test::ball(20.0, 48, 96);
  mesh.vertices_mm.col(0) *= 1.2;
  mesh.vertices_mm.col(1) *= 0.8;
  return mesh;
}

TEST(WrapOver, ellipsoid_in_closed_form)
{
  const BonesOfJoint bones{bone_of(ellipsoid()), {}};
  const Span span({-24.4, -3.0, 1.0}, {{10, 25, 2}, {16, 25, 2}, {20, 23, 2}});
  const std::optional<model::Wrap> wrap = span.fitted(bones);
  ASSERT_TRUE(wrap);
  for (const Pose& X : span.poses) {
    const double exact_mm =
        model::ellipsoid_path(span.fibre.reference_mm, X.translation(), {24.0, 16.0, 20.0}).length_mm;
    EXPECT_NEAR(length_mm(*wrap, span.fibre.reference_mm, X.translation()), exact_mm, 1.5 * fitted_mm + 0.1);
  }
}

TEST(WrapOver, outside_every_pose)
{
  const BonesOfJoint bones{bone_of(test::ball(20.0, 48, 96)), {}};
  const Span span({-20.3, -4.0, 0}, {{12, 28, -8}, {12, 28, -4}, {12, 28, 0}, {12, 28, 4}, {12, 28, 8}});
  const std::optional<model::Wrap> wrap = span.fitted(bones);
  ASSERT_TRUE(wrap);
  EXPECT_GT(span.left_mm(bones, {}), 2.0);
  EXPECT_LT(span.left_mm(bones, {*wrap}), fitted_mm + 0.05);  // points of the polyline differ a little
}

// A solved pose differs from those of the fit: the fibre stays over the bone where its line sinks by 2 mm
// more.
TEST(WrapOver, on_one_side_beyond_the_poses)
{
  constexpr double radius_mm = 5.0;
  const BonesOfJoint bones{bone_of(tube(radius_mm, 60.0)), {}};
  Span span({-30, 0.5, 3}, {{30, 0.5, 3}, {30, 1.5, 3}});
  const std::optional<model::Wrap> wrap = span.fitted(bones);
  ASSERT_TRUE(wrap);
  EXPECT_LT(span.left_mm(bones, {*wrap}), fitted_mm + 0.05);
  span.fibre.wrap = 0;
  std::array<Vector3d, 25> line_mm;
  model::sample_fibre_path(span.fibre, {*wrap},
                           {Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(), {30, -3.5, 3}},
                           line_mm);
  EXPECT_GT(line_mm[12].y(), radius_mm - fitted_mm);
}

TEST(WrapOver, over_both_bones)
{
  // Two balls beside each other; the second one moves with the fibre's end.
  const Mesh other = transformed(test::ball(12.0, 48, 96), Pose(Eigen::Translation3d(-18.0, -6.0, 0.0)));
  const BonesOfJoint bones{bone_of(test::ball(15.0, 48, 96)), bone_of(other)};
  const Span span({-15.3, -2.0, 0}, {{45, 8, 0}, {45, 9, 2}});
  ASSERT_GT(span.left_mm(bones, {}), 8.0);
  for (const BodyIndex body : all_bodies) {
    const std::optional<model::Wrap> wrap = span.fitted(bones, body);
    ASSERT_TRUE(wrap);
    EXPECT_EQ(wrap->body, body);
    EXPECT_LT(span.left_mm(bones, {*wrap}), 1.0);  // what prepare allows: no circle fits two balls exactly
  }
}

TEST(WrapOver, none_for_a_free_fibre)
{
  const BonesOfJoint bones{bone_of(test::ball(20.0, 48, 96)), {}};
  EXPECT_FALSE(Span({-20.3, 0, 0}, {{-21, 40, 0}}).fitted(bones));
  EXPECT_FALSE(over_cylinder(20.0).fitted({}));
}

TEST(WrapOver, mirrored)
{
  const Span span({-24.4, -3.0, 2.0}, {{10, 25, 1}, {16, 25, 5}});
  Span other = span;
  other.fibre.reference_mm.z() *= -1.0;
  for (Pose& X : other.poses) X.translation().z() *= -1.0;
  const std::optional<model::Wrap> wrap = span.fitted({bone_of(ellipsoid()), {}});
  const std::optional<model::Wrap> mirror = other.fitted({bone_of(mirrored_z(ellipsoid())), {}});
  ASSERT_TRUE(wrap && mirror);
  for (std::size_t i = 0; i < span.poses.size(); ++i)
    EXPECT_NEAR(length_mm(*wrap, span.fibre.reference_mm, span.poses[i].translation()),
                length_mm(*mirror, other.fibre.reference_mm, other.poses[i].translation()), 1e-9);
}

}  // namespace vrda::wrap_over_test
