#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/text.hpp"
#include "geometry/envelopes.hpp"
#include "geometry/level_set.hpp"
#include "geometry/shapes.hpp"
#include "support/refusal.hpp"

namespace vrda::shapes_test {

double apart_mm(const geometry::Shape& shape)
{
  return test::smallest_height_mm(test::envelope(shape.reference.at(0).mesh, test::Facing::down),
                                  test::envelope(shape.moving.at(0).mesh, test::Facing::up));
}

TEST(Shapes, EveryShapeIsClosedOutwardAndApartByDefault)
{
  EXPECT_THAT(geometry::shape_names(),
              testing::ElementsAre("knee", "knee-template", "hip", "ankle", "ball-in-dish", "bar-on-pyramids",
                                   "cap-in-sink"));
  for (const std::string& name : geometry::shape_names()) {
    SCOPED_TRACE(name);
    EXPECT_FALSE(geometry::shape_summary(name).empty());
    const geometry::Shape shape = geometry::generate_shape({name, {}, {}});
    for (const auto& parts : {shape.reference, shape.moving}) {
      ASSERT_FALSE(parts.empty());
      for (const geometry::ShapePart& part : parts) {
        SCOPED_TRACE(part.name);
        EXPECT_EQ(edge_counts(part.mesh).boundary, 0);
        EXPECT_EQ(edge_counts(part.mesh).non_manifold, 0);
        EXPECT_GT(signed_volume_mm3(part.mesh), 0.0);
        EXPECT_EQ(part.mesh.normals.rows(), part.mesh.vertices_mm.rows());
      }
    }
    EXPECT_GT(apart_mm(shape), 0.0);
  }
}

TEST(Shapes, ParametersListTheirDefaultsAndRanges)
{
  for (const std::string& name : geometry::shape_names()) {
    for (const geometry::ShapeParameter& parameter : geometry::shape_parameters(name)) {
      SCOPED_TRACE(name + " " + parameter.name);
      EXPECT_FALSE(parameter.meaning.empty());
      EXPECT_TRUE(!parameter.choices.empty() || parameter.lowest < parameter.highest);
      EXPECT_GE(parameter.default_number, parameter.lowest);
      EXPECT_LE(parameter.default_number, parameter.highest);
    }
  }
}

TEST(Hip, HeadAndSocketAreBallsAboutOneCentre)
{
  const geometry::Shape shape = geometry::generate_shape({"hip", {{"radius", 20.0}, {"clearance", 1.0}}, {}});
  const Mesh& socket = shape.reference.at(0).mesh;
  const Mesh& head = shape.moving.at(0).mesh;
  EXPECT_EQ(shape.reference.at(0).name, "socket");
  EXPECT_EQ(shape.moving.at(0).name, "head");
  constexpr double on_surface_mm = 1e-8;  // Newton's last step
  EXPECT_GE(socket.vertices_mm.rowwise().norm().minCoeff(), 21.0 - on_surface_mm);
  EXPECT_NEAR(socket.vertices_mm.rowwise().norm().minCoeff(), 21.0, on_surface_mm);
  // The neck does not extend to the head's upper half.
  for (Eigen::Index v = 0; v < head.vertices_mm.rows(); ++v) {
    const double r = head.vertices_mm(v, 1) > 12.0 ? head.vertices_mm.row(v).norm() : 20.0;
    EXPECT_NEAR(r, 20.0, on_surface_mm);
  }
}

TEST(Hip, TheSocketOpensByInclinationAndThenAnteversion)
{
  const geometry::Shape plain = geometry::generate_shape({"hip", {{"depth", -4.0}}, {}});
  const geometry::Shape tilted =
      geometry::generate_shape({"hip", {{"depth", -4.0}, {"inclination", 45.0}, {"anteversion", 30.0}}, {}});
  // cos 30 = 0.866, cos 45 = sin 45 = 0.707
  const Eigen::Vector3d opening(0.5, -0.75 / std::sqrt(1.5), 0.75 / std::sqrt(1.5));
  const Eigen::VectorXd along = tilted.reference.at(0).mesh.vertices_mm * opening;
  EXPECT_NEAR(along.maxCoeff(), -plain.reference.at(0).mesh.vertices_mm.col(1).minCoeff(), 1e-12);
  EXPECT_NEAR(along.maxCoeff(), -4.0, 0.1);  // the rim, with its rounding
}

TEST(Ankle, BothSurfacesTurnAboutZ)
{
  const geometry::Shape shape = geometry::generate_shape({"ankle", {{"clearance", 0.75}}, {}});
  const auto profile_mm = [](double z_mm) { return 20.0 + 40.0 - std::sqrt(40.0 * 40.0 - z_mm * z_mm); };
  constexpr double on_surface_mm = 1e-8;  // Newton's last step
  const auto count_on = [&](const Mesh& mesh, double clearance_mm, double least_y_mm) {
    int n = 0;
    for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
      const Eigen::Vector3d p = mesh.vertices_mm.row(v);
      const double off_mm = p.head<2>().norm() - profile_mm(p.z()) - clearance_mm;
      n += p.y() > least_y_mm && std::abs(p.z()) < 11.0 && std::abs(off_mm) < on_surface_mm ? 1 : 0;
    }
    return n;
  };
  EXPECT_GT(count_on(shape.moving.at(0).mesh, 0.0, 0.0), 300);
  EXPECT_GT(count_on(shape.reference.at(0).mesh, 0.75, 12.0), 150);
  EXPECT_NEAR(apart_mm(shape), 0.75, 0.05);  // two facets of 2 mm: 2 * 2^2 / (8 * 20)
}

TEST(BallInDish, VerticesLieOnTheirBallsAndTheRestingPlaceIsTheOrigin)
{
  const geometry::Shape shape = geometry::generate_shape(
      {"ball-in-dish",
       {{"ball_radius", 8.0}, {"dish_radius", 28.0}, {"offset_x", 3.0}, {"offset_z", -2.0}},
       {}});
  const Mesh& dish = shape.reference.at(0).mesh;
  const Eigen::Vector3d centre(0.0, -28.0, 0.0);
  int n_front = 0;
  for (Eigen::Index v = 0; v < dish.vertices_mm.rows(); ++v) {
    const bool is_front = dish.vertices_mm(v, 1) <= 0.0;
    const double r = is_front ? (Eigen::Vector3d(dish.vertices_mm.row(v)) - centre).norm() : 28.0;
    EXPECT_NEAR(r, 28.0, 1e-12);
    n_front += is_front ? 1 : 0;
  }
  EXPECT_EQ(n_front, 49 * 49);
  const Box ball = bounding_box(shape.moving.at(0).mesh);
  EXPECT_DOUBLE_EQ(ball.max_mm.y(), ball.min_mm.y() + 16.0);
  // Straight below the bowl, `apart` below its corners: the top of the ball is lower than the lowest vertex.
  EXPECT_NEAR(bounding_box(dish).min_mm.y() - ball.max_mm.y(), 5.0, 1e-12);
  // Moved onto the axis and up by its depth, the ball touches the dish at the origin and nowhere else.
  geometry::Shape resting = shape;
  resting.moving.at(0).mesh.vertices_mm.rowwise() -= Eigen::RowVector3d(3.0, ball.max_mm.y(), -2.0);
  EXPECT_NEAR(apart_mm(resting), 0.0, 1e-12);
}

TEST(BallInDish, EverySectionFallsFromTheMiddleOutward)
{
  for (const std::string section : {"bowl", "cone", "wave"}) {
    SCOPED_TRACE(section);
    const Mesh dish =
        geometry::generate_shape({"ball-in-dish", {}, {{"section", section}}}).reference.at(0).mesh;
    const auto under = test::envelope(dish, test::Facing::down);
    constexpr std::size_t n = test::Envelope::n, middle = n / 2;
    for (std::size_t i = middle; i < middle + 35; ++i) {
      EXPECT_GT(under.y_mm[i * n + middle], under.y_mm[(i + 1) * n + middle]);
    }
    EXPECT_NEAR(under.y_mm[middle * n + middle], 0.0, 1e-12);
  }
}

TEST(BallInDish, ASmallBallFallsThroughTheHole)
{
  const geometry::Shape shape =
      geometry::generate_shape({"ball-in-dish", {{"hole", 12.0}, {"ball_radius", 5.0}}, {}});
  EXPECT_EQ(apart_mm(shape), std::numeric_limits<double>::infinity());
}

TEST(BallInDish, AnEllipsoidMayStartTurned)
{
  // A quarter turn about +Y maps the longer half axis from X to Z.
  const auto box = [](double turn_deg) {
    return bounding_box(geometry::generate_shape(
                            {"ball-in-dish",
                             {{"stretch_x", 1.5}, {"turn", turn_deg}, {"offset_x", 2.0}, {"offset_z", -3.0}},
                             {}})
                            .moving.at(0)
                            .mesh);
  };
  const Box straight = box(0.0), turned = box(90.0);
  EXPECT_NEAR(turned.max_mm.z() + 3.0, straight.max_mm.x() - 2.0, 1e-12);
  EXPECT_NEAR(turned.max_mm.x() - 2.0, straight.max_mm.z() + 3.0, 1e-12);
  EXPECT_EQ(turned.max_mm.y(), straight.max_mm.y());
}

TEST(BarOnPyramids, TheBarFitsBetweenThePyramidsWhenItLiesAlongThem)
{
  geometry::Shape straight = geometry::generate_shape({"bar-on-pyramids", {{"turn", 0.0}}, {}});
  const double top_mm = bounding_box(straight.moving.at(0).mesh).max_mm.y();
  EXPECT_NEAR(top_mm, -20.0, 1e-12);  // 15 mm of pyramid, 5 mm apart
  straight.moving.at(0).mesh.vertices_mm.col(1).array() -= top_mm;
  EXPECT_NEAR(apart_mm(straight), 0.0, 1e-12);
  // Rotated it touches the slopes before the floor.
  geometry::Shape turned = geometry::generate_shape({"bar-on-pyramids", {{"turn", 30.0}}, {}});
  turned.moving.at(0).mesh.vertices_mm.col(1).array() -= top_mm;
  EXPECT_LT(apart_mm(turned), -1.0);
}

TEST(CapInSink, CreasesAreExactAtAnyTessellation)
{
  for (const double edges : {1.0, 2.0, 5.0}) {
    const geometry::Shape shape =
        geometry::generate_shape({"cap-in-sink", {{"edges", edges}, {"turn", 0.0}}, {}});
    // A block of 26 mm minus a pyramid of 20 mm over a base of 40 mm.
    EXPECT_NEAR(signed_volume_mm3(shape.reference.at(0).mesh), 1600.0 * 26.0 - 1600.0 * 20.0 / 3.0, 1e-9);
    EXPECT_NEAR(signed_volume_mm3(shape.moving.at(0).mesh), 1296.0 * 6.0 + 1296.0 * 18.0 / 3.0, 1e-9);
  }
}

void expect_closed_and_outward(const Mesh& mesh)
{
  EXPECT_EQ(edge_counts(mesh).boundary, 0);
  EXPECT_EQ(edge_counts(mesh).non_manifold, 0);
  EXPECT_GT(signed_volume_mm3(mesh), 0.0);
}

TEST(LevelSet, BallIsExactAtItsVertices)
{
  const geometry::Field ball = [](const Eigen::Vector3d& p) { return p.norm() - 10.0; };
  for (const double cell_mm : {4.0, 2.0, 0.7}) {
    geometry::LevelSetOptions options;
    options.cell_mm = cell_mm;
    const Mesh mesh = geometry::level_set_mesh(ball, {{-11, -11, -11}, {11, 11, 11}}, options);
    expect_closed_and_outward(mesh);
    EXPECT_LT((mesh.vertices_mm.rowwise().norm().array() - 10.0).abs().maxCoeff(),
              1e-9);  // Newton's last step
    // Central differences over 1e-3 mm: error h^2 / (6 r^2) and rounding 1e-12.
    EXPECT_LT((mesh.normals - mesh.vertices_mm / 10.0).rowwise().norm().maxCoeff(), 1e-7);
    EXPECT_NEAR(mean_edge_length_mm(mesh) / cell_mm, 1.0, 0.25);
  }
}

TEST(LevelSet, ASurfaceThatLeavesItsBoxIsABrokenPromise)
{
  const geometry::Field ball = [](const Eigen::Vector3d& p) { return p.norm() - 20.0; };
  EXPECT_THROW(geometry::level_set_mesh(ball, {{-11, -11, -30}, {11, 11, 30}}, {}), InternalError);
}

TEST(LevelSet, SkippedEmptySpaceChangesNothing)
{
  const geometry::Field ball = [](const Eigen::Vector3d& p) { return p.norm() - 10.0; };
  geometry::LevelSetOptions skipping, careful;
  skipping.cell_mm = careful.cell_mm = 0.9;
  skipping.max_gradient = 1.0;
  careful.max_gradient = 1e9;
  const Box box{{-12, -12, -12}, {12, 12, 12}};
  EXPECT_EQ(geometry::level_set_mesh(ball, box, skipping).vertices_mm,
            geometry::level_set_mesh(ball, box, careful).vertices_mm);
}

TEST(LevelSet, ASurfaceAlongAnotherHasItsVerticesWhereBothAgree)
{
  // Two halves of one rod that overlap from y = -9 to 9; their ends are rounded over 2 mm.
  const auto rod = [](const Eigen::Vector3d& p) { return std::sqrt(p.x() * p.x() + p.z() * p.z()) - 8.0; };
  const auto half = [&](double low_mm, double high_mm) {
    const geometry::Field field = [=](const Eigen::Vector3d& p) {
      return geometry::smooth_max(geometry::smooth_max(rod(p), p.y() - high_mm, 2.0), low_mm - p.y(), 2.0);
    };
    return geometry::LevelSet{field, {{-10.3, low_mm - 2.1, -11}, {10, high_mm + 2.4, 11}}};
  };
  const geometry::LevelSet lower = half(-30.0, 9.0), upper = half(-9.0, 30.0);
  geometry::LevelSetOptions options;
  options.cell_mm = 1.7;
  const auto [first, second] = geometry::adjoining_level_set_meshes(lower, upper, options);
  EXPECT_EQ(first.vertices_mm, geometry::level_set_mesh(lower.field, lower.box_mm, options).vertices_mm);
  expect_closed_and_outward(second);
  EXPECT_GT(bounding_box(second).max_mm.y(), 29.0);
  int n_shared = 0, n_within = 0;
  for (Eigen::Index v = 0; v < second.vertices_mm.rows(); ++v) {
    constexpr double safely_shared_mm = 4.0;  // more than the ends' rounding and a cell
    const bool is_within = std::abs(second.vertices_mm(v, 1)) < safely_shared_mm &&
                           std::abs(rod(second.vertices_mm.row(v))) < 1e-6;
    const double nearest =
        (first.vertices_mm.rowwise() - second.vertices_mm.row(v)).rowwise().norm().minCoeff();
    n_within += is_within ? 1 : 0;
    n_shared += is_within && nearest == 0.0 ? 1 : 0;
  }
  EXPECT_GT(n_within, 100);
  EXPECT_EQ(n_shared, n_within);
}

TEST(Surface, EllipsoidHasTwentySquaresOfTrianglesOnTheSurface)
{
  for (const int n_edges : {1, 2, 7}) {
    const Mesh mesh = geometry::ellipsoid_mesh({3, 5, 4}, n_edges);
    expect_closed_and_outward(mesh);
    EXPECT_EQ(mesh.triangles.rows(), 20 * n_edges * n_edges);
    EXPECT_DOUBLE_EQ(bounding_box(mesh).max_mm.y(), 5.0);
    for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
      const Eigen::Vector3d p = mesh.vertices_mm.row(v);
      EXPECT_NEAR(p.cwiseQuotient(Eigen::Vector3d(3, 5, 4)).norm(), 1.0, 1e-14);
    }
  }
}

TEST(Surface, BlocksFacingEitherWayAreClosedAndHaveTheirVolume)
{
  for (const double back_y_mm : {-2.0, 3.0}) {
    geometry::ShapedBlock block;
    geometry::append_lines(block.x_mm, -2.0, 2.0, 4);
    geometry::append_lines(block.z_mm, -1.0, 2.0, 3);
    block.front_y_mm = [](double, double) { return 1.0; };
    block.back_y_mm = back_y_mm;
    expect_closed_and_outward(geometry::block_mesh(block));
    EXPECT_NEAR(signed_volume_mm3(geometry::block_mesh(block)), 12.0 * std::abs(back_y_mm - 1.0), 1e-12);
  }
}

TEST(Surface, AHoleGoesThroughTheBlock)
{
  geometry::ShapedBlock block;
  geometry::append_lines(block.x_mm, -4.0, 4.0, 8);
  block.z_mm = block.x_mm;
  block.front_y_mm = [](double, double) { return 0.0; };
  block.back_y_mm = 1.0;
  block.hole_half_mm = 2.0;
  expect_closed_and_outward(geometry::block_mesh(block));
  EXPECT_NEAR(signed_volume_mm3(geometry::block_mesh(block)), 64.0 - 16.0, 1e-12);
}

}  // namespace vrda::shapes_test
