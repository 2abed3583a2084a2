#include "geometry/shapes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/text.hpp"
#include "geometry/envelopes.hpp"
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

TEST(Shapes, WhatMakesNoShapeIsRefused)
{
  struct Row {
    geometry::ShapeRequest request;
    test::Refusal refusal;
  };
  for (const Row& row : {
           // Unknown names, with the nearest known one.
           Row{{"kne", {}, {}}, {"shape", "name", "\"kne\"", "knee"}},
           {{"knee", {{"resolutoin", 1.0}}, {}},
            {"shape knee", "parameters", "\"resolutoin\"", "resolution"}},
           {{"knee", {}, {{"sied", "left"}}}, {"shape knee", "parameters", "\"sied\"", "side"}},
           {{"knee", {}, {{"side", "lefd"}}}, {"shape knee", "side", "\"lefd\"", "left"}},
           // Numbers out of range, a number for a word, a word for a number.
           {{"knee", {{"resolution", 0.0}}, {}}, {"shape knee", "resolution", "0", {"0.5", "15"}}},
           {{"knee", {{"resolution", std::numeric_limits<double>::quiet_NaN()}}, {}},
            {"shape knee", "resolution", "nan"}},
           {{"hip", {{"radius", -3.0}}, {}}, {"shape hip", "radius", "-3", "mm"}},
           {{"cap-in-sink", {{"edges", 2.5}}, {}}, {"shape cap-in-sink", "edges", "2.5", {"whole", "1"}}},
           {{"knee", {{"side", 1.0}}, {}}, {"shape knee", "side", "1", {"right", "left"}}},
           {{"knee", {}, {{"resolution", "fine"}}}, {"shape knee", "resolution", "\"fine\"", "number"}},
           // A socket too deep for the head to enter, one too shallow to hold it; a hole as wide as the dish;
           // a bowl too small for its block.
           {{"hip", {{"clearance", 0.1}, {"depth", 10.0}}, {}}, {"shape hip", "depth", "10.000000"}},
           {{"hip", {{"radius", 10.0}, {"depth", -15.0}}, {}}, {"shape hip", "depth", "-15.000000"}},
           // Meshes and grids that would take gigabytes.
           {{"hip", {{"resolution", 12.0}}, {}}, {"shape", "resolution", "triangles", "2 million"}},
           {{"hip", {{"resolution", 12.0}, {"radius", 5.0}, {"wall", 50.0}, {"clearance", 20.0}}, {}},
            {"shape", "resolution", "triangles", "2 million"}},
           {{"ankle", {{"resolution", 12.0}, {"radius", 10.0}}, {}},
            {"shape", "resolution", "triangles", "2 million"}},
           {{"ball-in-dish", {{"dish_edges", 351.0}}, {}},
            {"shape ball-in-dish", "dish_edges", "351", "350"}},
           {{"ball-in-dish", {{"hole", 36.0}}, {}}, {"shape ball-in-dish", "hole", "36.000000"}},
           {{"ball-in-dish", {{"dish_width", 60.0}}, {}}, {"shape ball-in-dish", "dish_width", "60.000000"}},
       })
    EXPECT_THAT(test::input_error([&] { geometry::generate_shape(row.request); }),
                test::refuses(row.refusal));
  EXPECT_THROW(geometry::shape_parameters("elbow"), InputError);
  EXPECT_THROW(geometry::shape_summary("elbow"), InputError);
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

TEST(CapInSink, InLineTheTipsMeetAndTheSlopesLieOnEachOther)
{
  geometry::Shape shape = geometry::generate_shape({"cap-in-sink", {{"turn", 0.0}}, {}});
  Mesh& cap = shape.moving.at(0).mesh;
  cap.vertices_mm.col(1).array() -= bounding_box(cap).max_mm.y();
  EXPECT_NEAR(apart_mm(shape), 0.0, 1e-12);
}

}  // namespace vrda::shapes_test
