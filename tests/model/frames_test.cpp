// Clinical curves beyond the ranges of one pose's numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/mesh.hpp"
#include "support/meshes.hpp"

namespace vrda::frames_test {

constexpr double rounding = 1e-12;  // mm or rad, coordinates of hundreds of mm

SolverFrame far_frame(Side side, const Eigen::Vector3d& delta)
{
  return {side, {430.0, 510.0, side == Side::left ? -75.0 : 75.0}, delta};
}

TEST(Frames, shortest_rotation)
{
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  for (const Eigen::Vector3d& from :
       {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(1, 0, 0),
        Eigen::Vector3d(Eigen::Vector3d(1, -2, 0.5).normalized())}) {
    const Eigen::Matrix3d R = shortest_rotation(from, y);
    EXPECT_LT((R * from - y).norm(), rounding);
    EXPECT_NEAR(R.determinant(), 1.0, rounding);
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), rounding);
  }
}

TEST(Frames, stored_pose)
{
  // A moving vertex must have the same position relative to the reference in S and through the stored pose.
  const Attitude attitude{0.7, -0.1};
  const MovingPose pose{{1.5, -20.0, 2.5}, 0.2};
  for (const Side side : {Side::right, Side::left}) {
    for (const Eigen::Vector3d& delta :
         {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(Eigen::Vector3d(0.1, 1, -0.3).normalized())}) {
      const SolverFrame frame = far_frame(side, delta);
      Mesh stored = test::box({440, 500, 70}, {10, 20, 30});
      const Pose X = X_reference_moving(frame, attitude, pose);
      const Mesh seen = solver_mesh(transformed(stored, X), frame);
      const Mesh moving = solver_mesh(stored, frame);
      for (Eigen::Index v = 0; v < seen.vertices_mm.rows(); ++v) {
        const Eigen::Vector3d from_reference =
            reference_rotation(attitude) * Eigen::Vector3d(seen.vertices_mm.row(v));
        const Eigen::Vector3d from_moving = pose_of(pose) * Eigen::Vector3d(moving.vertices_mm.row(v));
        EXPECT_LT((from_reference - from_moving).norm(), 1e-11);
      }
    }
  }
}

Mesh soft(Mesh mesh, double overlap_mm)
{
  mesh.overlap_mm.assign(static_cast<std::size_t>(mesh.triangles.rows()), overlap_mm);
  return mesh;
}

// Every plane of a box moves by the overlap, and solver_mesh() does it for either side.
TEST(InwardLimit, of_a_box)
{
  const Mesh box = soft(test::box({440, 500, 70}, {10, 20, 30}), 1.0);
  const Eigen::MatrixXd expected = test::box({440, 500, 70}, {8, 18, 28}).vertices_mm;
  EXPECT_LT((inward_limit(box).vertices_mm - expected).cwiseAbs().maxCoeff(), 2e-5)
      << "the weight of the tie";
  for (const Side side : {Side::right, Side::left}) {
    const SolverFrame frame = far_frame(side, Eigen::Vector3d::UnitY());
    EXPECT_EQ(solver_mesh(box, frame).vertices_mm,
              solver_mesh(soft(inward_limit(box), 0.0), frame).vertices_mm);
  }
}

// At the edge of a disc thinner than the overlap triangles turn over and become points; the flat sides move
// by all of it, each to the other side.
TEST(InwardLimit, of_a_thin_disc)
{
  const Mesh disc = soft(test::box({0, 0, 0}, {40, 1, 40}), 0.8);
  const Mesh limit = inward_limit(disc);
  int n_points = 0;
  for (Eigen::Index t = 0; t < disc.triangles.rows(); ++t) {
    const Eigen::Vector3d n = face_normal(disc, t), after = face_normal(limit, t);
    n_points += after.isZero(0.0) ? 1 : 0;
    if (std::abs(n.y()) < 0.5) continue;
    EXPECT_GT(n.dot(after), 0.999);
    EXPECT_NEAR(corners(limit, t)[0].y(), n.y() * (0.5 - 0.8), 1e-5);
  }
  EXPECT_EQ(n_points, 8) << "the four narrow sides";
}

TEST(Frames, grood_suntay)
{
  const double f = 0.9, v = 0.12, theta = -0.3;
  const Pose X = X_reference_moving({}, {f, v}, {{0, 0, 0}, theta});
  EXPECT_LT((X.linear() - rotation_z(-f) * rotation_x(v) * rotation_y(theta)).norm(), rounding);
}

TEST(Frames, world_translation)
{
  for (const Side side : {Side::right, Side::left}) {
    const SolverFrame frame = far_frame(side, Eigen::Vector3d(0.2, 0.9, 0.1).normalized());
    const MovingPose pose{{1, 2, 3}, 0.0};
    EXPECT_LT((solver_translation_mm(frame, world_translation_mm(frame, pose)) - pose.translation_mm).norm(),
              rounding);
  }
}

TEST(Clinical, attitude_and_theta)
{
  for (const Side side : {Side::right, Side::left}) {
    const SolverFrame frame = far_frame(side, {0, 1, 0});
    const Pose X =
        X_reference_moving(frame, {rad_from_deg(75), rad_from_deg(-6)}, {{0, 0, 0}, rad_from_deg(11)});
    const ClinicalCoordinates clinical = clinical_coordinates(X, side, frame.rotation_centre_mm);
    EXPECT_NEAR(deg_from_rad(clinical.flexion_rad), 75, 1e-9);
    EXPECT_NEAR(deg_from_rad(clinical.varus_rad), -6, 1e-9);
    EXPECT_NEAR(deg_from_rad(clinical.internal_rotation_rad), 11, 1e-9);
    EXPECT_NEAR(clinical.anterior_mm, 0, 1e-9);
  }
}

TEST(Clinical, translations)
{
  Pose X = Pose::Identity();
  X.translation() << 1, 2, 3;
  const ClinicalCoordinates right = clinical_coordinates(X, Side::right, {0, 0, 0});
  EXPECT_NEAR(right.anterior_mm, 1, rounding);
  EXPECT_NEAR(right.proximal_mm, 2, rounding);
  EXPECT_NEAR(right.lateral_mm, 3, rounding);
  X.translation().z() = -3;
  EXPECT_NEAR(clinical_coordinates(X, Side::left, {0, 0, 0}).lateral_mm, 3, rounding);
}

TEST(Clinical, mirrored_pose)
{
  const MovingPose pose{{1.25, -3.5, 0.75}, 0.21};
  const Attitude attitude{1.1, 0.07};
  const SolverFrame right = far_frame(Side::right, {0, 1, 0});
  const SolverFrame left = far_frame(Side::left, {0, 1, 0});
  const ClinicalCoordinates r =
      clinical_coordinates(X_reference_moving(right, attitude, pose), Side::right, right.rotation_centre_mm);
  const ClinicalCoordinates l =
      clinical_coordinates(X_reference_moving(left, attitude, pose), Side::left, left.rotation_centre_mm);
  EXPECT_EQ(r.flexion_rad, l.flexion_rad);
  EXPECT_EQ(r.varus_rad, l.varus_rad);
  EXPECT_EQ(r.internal_rotation_rad, l.internal_rotation_rad);
  EXPECT_EQ(r.anterior_mm, l.anterior_mm);
  EXPECT_EQ(r.proximal_mm, l.proximal_mm);
  EXPECT_EQ(r.lateral_mm, l.lateral_mm);
}

constexpr double rounding_clinical = 1e-12;
// An angle whose sine is 1 within rounding_clinical is known to the root of it.
constexpr double near_lock = 1e-7;

TEST(Unwrapped, within_half_a_turn)
{
  const std::vector<double> turned = unwrapped({3.0, -3.0, nan, -2.5, 3.1});
  EXPECT_EQ(turned[0], 3.0);
  EXPECT_NEAR(turned[1], 2 * pi - 3.0, rounding_clinical);
  EXPECT_TRUE(std::isnan(turned[2]));
  EXPECT_NEAR(turned[3], 2 * pi - 2.5, rounding_clinical);
  EXPECT_NEAR(turned[4], 3.1, rounding_clinical);
  EXPECT_NEAR(unwrapped({179.0, -179.0}, 360.0)[1], 181.0, rounding_clinical);
  EXPECT_EQ(nearest_turn(0.2, 0.1), 0.2);  // the same bits
}

/// The pose of these numbers, of a right joint or of its mirror image.
Pose posed(double flexion_deg, double varus_deg, double internal_deg, Side side)
{
  const double other = side == Side::left ? -1.0 : 1.0;
  Pose X = Pose::Identity();
  X.linear() = rotation_z(-rad_from_deg(flexion_deg)) * rotation_x(other * rad_from_deg(varus_deg)) *
               rotation_y(other * rad_from_deg(internal_deg));
  X.translation() = Eigen::Vector3d(3.0, -2.0, other * 5.0);
  return X;
}

// Closed form: numbers that grow steadily come back, past half a turn, a whole one and gimbal lock.
TEST(ContinuousCoordinates, past_branches)
{
  struct Row {
    double first[3], step[3];  // flexion, varus, internal
    int n_locked;
  };
  for (const Row& row : {Row{{10, 1, 174.05}, {1, 0, 1}, 0}, Row{{-175, 2, -170}, {-3, 0, -30}, 0},
                         Row{{10, 85, 5}, {0, 1, 0}, 16}, Row{{10, -85, 5}, {1, -1, 1}, 16},
                         Row{{10, 1, 5}, {7, 0.1, 3}, 0}}) {
    for (const Side side : {Side::right, Side::left}) {
      SCOPED_TRACE(row.first[1]);
      ContinuousCoordinates along(side, Eigen::Vector3d::Zero());
      for (int k = 0; k <= 20; ++k) {
        const double f = row.first[0] + k * row.step[0], v = row.first[1] + k * row.step[1],
                     i = row.first[2] + k * row.step[2];
        const Pose X = posed(f, v, i, side);
        const ClinicalCoordinates c = along.next(X);
        EXPECT_NEAR(c.flexion_rad, rad_from_deg(f), near_lock) << k;
        EXPECT_NEAR(c.varus_rad, rad_from_deg(v), near_lock) << k;
        EXPECT_NEAR(c.internal_rotation_rad, rad_from_deg(i), near_lock) << k;
        // Along the floating axis (cos f, -sin f, 0), without a jump.
        EXPECT_NEAR(c.anterior_mm, 3.0 * std::cos(rad_from_deg(f)) + 2.0 * std::sin(rad_from_deg(f)), 1e-6);
      }
      EXPECT_EQ(along.n_locked(), row.n_locked);
    }
  }
}

TEST(ContinuousCoordinates, bits_of_one_pose)
{
  const Pose X = posed(30, 4, -10, Side::left);
  ContinuousCoordinates along(Side::left, {1, 2, 3});
  along.next(posed(20, 3, -8, Side::left));
  const ClinicalCoordinates found = along.next(X), one = clinical_coordinates(X, Side::left, {1, 2, 3});
  EXPECT_EQ(found.flexion_rad, one.flexion_rad);
  EXPECT_EQ(found.varus_rad, one.varus_rad);
  EXPECT_EQ(found.internal_rotation_rad, one.internal_rotation_rad);
  EXPECT_EQ(found.anterior_mm, one.anterior_mm);
}

// Rounding of products of rotations applied to coordinates of a few hundred mm.
constexpr double rounding_mm = 1e-12;
constexpr double unit_rounding = 1e-14;
constexpr double lever_mm = 150.0;  // largest distance between an axis and a query point

struct Screw {
  Eigen::Vector3d direction, point_mm;
  double rotation_rad = 0.0, translation_mm = 0.0;
};

Pose turned(const Screw& screw, double share)
{
  // By core's rotation about Z in the axis's frame, independent of the functions under test.
  const Eigen::Vector3d across = screw.direction.unitOrthogonal();
  Eigen::Matrix3d R_axis;
  R_axis << across, screw.direction.cross(across), screw.direction;
  Pose X = Pose::Identity();
  X.linear() = R_axis * rotation_z(share * screw.rotation_rad) * R_axis.transpose();
  X.translation() =
      screw.point_mm - X.linear() * screw.point_mm + share * screw.translation_mm * screw.direction;
  return X;
}

double distance_to_line_mm(const Eigen::Vector3d& p_mm, const Screw& line)
{
  return line.direction.cross(p_mm - line.point_mm).norm();
}

// Entries of products of rotations are accurate to `unit_rounding`. The direction of a rotation by a small
// angle is accurate to unit_rounding / angle; the resulting error of the translation across the axis, and the
// unit_rounding of coordinates, shift the axis by 1 / angle times as much.
void expect_found(const Screw& screw, const Pose& X_start, const Eigen::Vector3d& near_mm)
{
  const double widened = 1.0 + 1.0 / screw.rotation_rad;
  const double direction_tolerance = widened * unit_rounding;
  const double along_mm = rounding_mm + lever_mm * direction_tolerance;
  const double across_mm = widened * (rounding_mm + std::abs(screw.translation_mm) * direction_tolerance);
  const auto axis = helical_axis(X_start, turned(screw, 1.0) * X_start, near_mm);
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->rotation_rad, screw.rotation_rad, unit_rounding);
  EXPECT_NEAR(axis->translation_mm, screw.translation_mm, along_mm);
  EXPECT_LT((axis->direction - screw.direction).norm(), direction_tolerance);
  EXPECT_LT(distance_to_line_mm(axis->point_mm, screw), across_mm);
  // Nearest to the query point: the connection is perpendicular to the axis.
  EXPECT_NEAR((axis->point_mm - near_mm).dot(screw.direction), 0.0, along_mm);
}

Pose some_pose()
{
  Pose X = Pose::Identity();
  X.linear() = rotation_x(0.4) * rotation_z(-1.1) * rotation_y(0.2);
  X.translation() = Eigen::Vector3d(12.0, -35.0, 4.0);
  return X;
}

TEST(HelicalAxis, FindsScrewsOfAnyTurn)
{
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (const double angle_deg : {0.01, 0.5, 30.0, 89.0, 91.0, 150.0, 179.0}) {
    SCOPED_TRACE(angle_deg);
    for (int repeat = 0; repeat < 50; ++repeat) {
      const auto vector = [&] { return Eigen::Vector3d(number(random), number(random), number(random)); };
      const Screw screw{vector().normalized(), 50.0 * vector(), rad_from_deg(angle_deg),
                        6.0 * number(random)};
      expect_found(screw, some_pose(), 30.0 * vector());
    }
  }
}

TEST(HelicalAxis, HalfATurnIsFound)
{
  // The skew part is unit_rounding only; either sense of the axis describes the same rotation.
  const Screw screw{Eigen::Vector3d(0.6, 0.0, -0.8), {1.0, 2.0, 3.0}, pi, 2.5};
  const auto axis = helical_axis(Pose::Identity(), turned(screw, 1.0), Eigen::Vector3d::Zero());
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->rotation_rad, pi, unit_rounding);
  EXPECT_LT(axis->direction.cross(screw.direction).norm(), 2.0 * unit_rounding);
  EXPECT_NEAR(std::abs(axis->translation_mm), 2.5, rounding_mm);
  EXPECT_LT(distance_to_line_mm(axis->point_mm, screw), rounding_mm);
}

TEST(HelicalAxis, PureTranslationHasNone)
{
  Pose X_end = some_pose();
  X_end.translation() += Eigen::Vector3d(1.0, 2.0, 3.0);
  EXPECT_FALSE(helical_axis(some_pose(), X_end, Eigen::Vector3d::Zero()));
  EXPECT_FALSE(instant_centre_mm(some_pose(), X_end, Eigen::Vector3d::Zero()));
  EXPECT_EQ(midpoint_orientation(some_pose(), X_end), some_pose().linear());
}

TEST(HelicalAxis, MidwayIsHalfTheTurn)
{
  const Screw screw{Eigen::Vector3d(0.36, 0.48, 0.8), {1.0, 2.0, 3.0}, rad_from_deg(40.0), 2.0};
  const Eigen::Matrix3d expected = (turned(screw, 0.5) * some_pose()).linear();
  const Eigen::Matrix3d found = midpoint_orientation(some_pose(), turned(screw, 1.0) * some_pose());
  EXPECT_LT((found - expected).norm(), 10.0 * unit_rounding);
}

/// Intersection of the perpendicular bisectors of two points' displacements.
Eigen::Vector2d meeting_of_bisectors(const Pose& X_start, const Pose& X_end, const Eigen::Vector3d& a,
                                     const Eigen::Vector3d& b)
{
  Eigen::Matrix2d ways;
  Eigen::Vector2d levels;
  int row = 0;
  for (const Eigen::Vector3d& p : {a, b}) {
    const Eigen::Vector2d from = (X_start * p).head<2>(), to = (X_end * p).head<2>();
    ways.row(row) = (to - from).transpose();
    levels[row++] = (to - from).dot(0.5 * (from + to));
  }
  return ways.inverse() * levels;
}

TEST(InstantCentre, IsWhereTheBisectorsMeet)
{
  for (const double angle_deg : {-120.0, -5.0, 1.0, 60.0, 170.0}) {
    SCOPED_TRACE(angle_deg);
    Pose X_start = Pose::Identity();
    X_start.linear() = rotation_z(0.3);
    X_start.translation() = Eigen::Vector3d(4.0, -30.0, 7.0);
    Pose step = Pose::Identity();
    step.linear() = rotation_z(rad_from_deg(angle_deg));
    step.translation() = Eigen::Vector3d(2.0, -1.5, 0.0);
    const auto centre = instant_centre_mm(X_start, step * X_start, {5.0, 6.0, 7.0});
    ASSERT_TRUE(centre);
    const Eigen::Vector2d expected =
        meeting_of_bisectors(X_start, step * X_start, {0.0, -40.0, 1.0}, {25.0, 10.0, -3.0});
    EXPECT_LT((*centre - expected).norm(), 100.0 * rounding_mm);  // bisectors as little as 1 degree apart
  }
}

TEST(Mesh, box)
{
  const Mesh box = test::box({100, -50, 3}, {2, 4, 6});
  EXPECT_NEAR(signed_volume_mm3(box), 48.0, 1e-12);
  EXPECT_NEAR(area_mm2(box), 2 * (8 + 12 + 24), 1e-12);
  EXPECT_EQ(edge_counts(box).boundary, 0);
  EXPECT_EQ(edge_counts(box).non_manifold, 0);
  EXPECT_EQ(bounding_box(box).min_mm, Eigen::Vector3d(99, -52, 0));
  EXPECT_EQ(bounding_box(box).max_mm, Eigen::Vector3d(101, -48, 6));
}

TEST(Mesh, ball)
{
  const Mesh ball = test::ball(10, 64, 128);
  EXPECT_EQ(edge_counts(ball).boundary, 0);
  EXPECT_EQ(edge_counts(ball).non_manifold, 0);
  // Inscribed polyhedron: relative volume error below (pi / 64)^2.
  EXPECT_NEAR(signed_volume_mm3(ball) / (4.0 / 3.0 * pi * 1000), 1.0, 2.5e-3);
  const Points computed = vertex_normals(ball);
  for (Eigen::Index v = 0; v < computed.rows(); ++v) {
    EXPECT_GT(computed.row(v).dot(ball.normals.row(v)), 0.999);
  }
}

TEST(Mesh, sheet)
{
  Mesh sheet = test::sheet(10, 4);
  EXPECT_EQ(edge_counts(sheet).boundary, 16);
  EXPECT_EQ(edge_counts(sheet).non_manifold, 0);
  std::swap(sheet.triangles(10, 0), sheet.triangles(10, 1));
  EXPECT_GT(edge_counts(sheet).non_manifold, 0);
}

TEST(Mesh, mirrored)
{
  const Mesh ball = test::ball(7.3, 8, 12);
  const Mesh mirrored = mirrored_z(ball);
  EXPECT_NEAR(signed_volume_mm3(mirrored), signed_volume_mm3(ball), 1e-10);
  const Mesh twice = mirrored_z(mirrored);
  EXPECT_EQ(twice.vertices_mm, ball.vertices_mm);
  EXPECT_EQ(twice.triangles, ball.triangles);
}

TEST(Mesh, appended)
{
  Mesh two = test::box({0, 0, 0}, {1, 1, 1});
  append(two, test::box({5, 0, 0}, {2, 2, 2}));
  EXPECT_EQ(two.triangles.rows(), 24);
  EXPECT_NEAR(signed_volume_mm3(two), 9.0, 1e-12);
  EXPECT_EQ(two.normals.rows(), two.vertices_mm.rows());
}

constexpr double single_rounding = 1e-6;  // of a unit vector in single precision

std::vector<Eigen::Index> every_triangle(const Mesh& mesh)
{
  std::vector<Eigen::Index> all(static_cast<std::size_t>(mesh.triangles.rows()));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

Eigen::Vector3d as_vector(const std::array<float, 3>& v)
{
  return {v[0], v[1], v[2]};
}

TEST(DrawMesh, cube)
{
  const Mesh cube = test::box({0, 0, 0}, {2, 2, 2});
  const RenderMesh sharp = make_render_mesh(cube, every_triangle(cube), {0, 0, 0}, rad_from_deg(89));
  EXPECT_EQ(sharp.vertices.size(), 24U);  // three faces at each corner
  for (const RenderVertex& vertex : sharp.vertices) {
    const Eigen::Vector3d n = as_vector(vertex.normal);
    EXPECT_NEAR(n.cwiseAbs().maxCoeff(), 1.0, single_rounding);
    EXPECT_NEAR(n.dot(as_vector(vertex.position_mm)), 1.0, single_rounding);  // outward
  }
  const RenderMesh round = make_render_mesh(cube, every_triangle(cube), {0, 0, 0}, rad_from_deg(91));
  EXPECT_EQ(round.vertices.size(), 8U);
  for (const RenderVertex& vertex : round.vertices)
    EXPECT_GT(as_vector(vertex.normal).cwiseAbs().minCoeff(), 0.2);
}

TEST(DrawMesh, ball)
{
  const Mesh ball = test::ball(20, 32, 64);
  const RenderMesh drawn = make_render_mesh(ball, every_triangle(ball), {0, 0, 0});
  EXPECT_EQ(drawn.vertices.size(), static_cast<std::size_t>(ball.vertices_mm.rows()));
  EXPECT_EQ(drawn.triangles.size(), static_cast<std::size_t>(3 * ball.triangles.rows()));
  // A quarter of the angle between neighbouring rings: faces around a vertex deviate by half of it to either
  // side.
  constexpr double tolerance_rad = pi / 32 / 4;
  for (const RenderVertex& vertex : drawn.vertices) {
    EXPECT_LT((as_vector(vertex.normal) - as_vector(vertex.position_mm) / 20.0).norm(), tolerance_rad);
  }
}

TEST(DrawMesh, listed_triangles)
{
  Mesh cube = test::box({0, 0, 0}, {2, 2, 2});
  cube.triangles.row(1) << 3, 3, 4;
  const RenderMesh drawn = make_render_mesh(cube, {0, 1, 5}, {0, 0, 0});
  EXPECT_EQ(drawn.triangles.size(), 6U);
  EXPECT_LE(drawn.vertices.size(), 6U);
}

TEST(DrawMesh, far_from_origin)
{
  // At 600 mm single precision resolves 0.00006 mm; relative to the origin it is exact here.
  const Mesh cube = test::box({600, -300, 75}, {0.25, 0.25, 0.25});
  const RenderMesh drawn = make_render_mesh(cube, every_triangle(cube), {600, -300, 75});
  for (const RenderVertex& vertex : drawn.vertices) {
    for (const float x_mm : vertex.position_mm) EXPECT_EQ(std::abs(x_mm), 0.125F);
  }
}

}  // namespace vrda::frames_test
