#include "geometry/generic_knee.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "core/units.hpp"
#include "geometry/envelopes.hpp"

namespace vrda::knee_test {

geometry::Shape knee(double resolution, const std::string& side = "right")
{
  return geometry::generate_shape({"knee", {{"resolution", resolution}}, {{"side", side}}});
}

std::map<std::string, geometry::ShapePart> by_name(const geometry::Shape& shape)
{
  std::map<std::string, geometry::ShapePart> parts;
  for (const geometry::ShapePart& part : shape.reference) parts[part.name] = part;
  for (const geometry::ShapePart& part : shape.moving) parts[part.name] = part;
  return parts;
}

Mesh contact_mesh(const std::vector<geometry::ShapePart>& parts)
{
  Mesh mesh;
  for (const geometry::ShapePart& part : parts) {
    if (part.has_contact) append(mesh, part.mesh);
  }
  return mesh;
}

TEST(Knee, HasThePartsThatJobsName)
{
  const geometry::Shape shape = knee(1.0);
  std::vector<std::string> reference, moving;
  for (const geometry::ShapePart& part : shape.reference) {
    reference.push_back(part.name + (part.has_contact ? "" : " drawn") + ":" + part.material);
  }
  for (const geometry::ShapePart& part : shape.moving) {
    moving.push_back(part.name + (part.has_contact ? "" : " drawn") + ":" + part.material);
  }
  EXPECT_THAT(reference, testing::ElementsAre("femur:bone", "femur_shaft drawn:bone"));
  EXPECT_THAT(moving,
              testing::ElementsAre("tibia:bone", "meniscus_medial:meniscus", "meniscus_lateral:meniscus",
                                   "tibia_shaft drawn:bone", "fibula drawn:bone"));
}

TEST(Knee, EveryPartIsClosedManifoldAndOutwardAtAnyResolutionAndSide)
{
  for (const std::string side : {"right", "left"}) {
    for (const double resolution : {0.5, 0.77, 1.0, 1.9, 3.0}) {
      for (const auto& [name, part] : by_name(knee(resolution, side))) {
        SCOPED_TRACE(testing::Message() << name << " " << side << " " << resolution);
        EXPECT_EQ(edge_counts(part.mesh).boundary, 0);
        EXPECT_EQ(edge_counts(part.mesh).non_manifold, 0);
        EXPECT_GT(signed_volume_mm3(part.mesh), 0.0);
        ASSERT_EQ(part.mesh.normals.rows(), part.mesh.vertices_mm.rows());
        // Unit normals: rounding of a square root and three products.
        EXPECT_LT((part.mesh.normals.rowwise().norm().array() - 1.0).abs().maxCoeff(), 1e-12);
      }
    }
  }
}

TEST(Knee, TriangleCountsAreNearTheThesisTableAndGrowWithTheSquare)
{
  const std::map<std::string, double> thesis = {
      {"femur", 1516}, {"tibia", 1746}, {"meniscus_medial", 665}, {"meniscus_lateral", 742}};
  const auto coarse = by_name(knee(1.0));
  const auto fine = by_name(knee(2.5));
  for (const auto& [name, wanted] : thesis) {
    SCOPED_TRACE(name);
    const auto n_coarse = static_cast<double>(coarse.at(name).mesh.triangles.rows());
    const auto n_fine = static_cast<double>(fine.at(name).mesh.triangles.rows());
    EXPECT_NEAR(n_coarse / wanted, 1.0, 0.1);
    // Integer numbers of cells across thin parts: within a tenth of the square.
    EXPECT_NEAR(n_fine / n_coarse / 6.25, 1.0, 0.1);
  }
}

TEST(Knee, TrianglesAreWellShaped)
{
  for (const auto& [name, part] : by_name(knee(1.0))) {
    SCOPED_TRACE(name);
    Eigen::Index n_thin = 0;
    const double least_cosine = cosine(rad_from_deg(10.0));
    for (Eigen::Index t = 0; t < part.mesh.triangles.rows(); ++t) {
      const auto c = corners(part.mesh, t);
      double largest_cosine = -1.0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d u = (c[(k + 1) % 3] - c[k]).normalized(),
                              v = (c[(k + 2) % 3] - c[k]).normalized();
        largest_cosine = std::max(largest_cosine, u.dot(v));
      }
      n_thin += largest_cosine > least_cosine ? 1 : 0;
    }
    EXPECT_LE(n_thin, part.mesh.triangles.rows() / 100);
  }
}

TEST(Knee, LeftIsTheMirrorImageToTheLastBit)
{
  const auto right = by_name(knee(1.0, "right"));
  const auto left = by_name(knee(1.0, "left"));
  for (const auto& [name, part] : right) {
    SCOPED_TRACE(name);
    const Mesh mirrored = mirrored_z(part.mesh);
    EXPECT_EQ(left.at(name).mesh.vertices_mm, mirrored.vertices_mm);
    EXPECT_EQ(left.at(name).mesh.triangles, mirrored.triangles);
    EXPECT_EQ(left.at(name).mesh.normals, mirrored.normals);
  }
}

TEST(Knee, TheSameRequestGivesTheSameBits)
{
  const auto first = by_name(knee(1.3));
  const auto second = by_name(knee(1.3));
  for (const auto& [name, part] : first) {
    EXPECT_EQ(part.mesh.vertices_mm, second.at(name).mesh.vertices_mm) << name;
    EXPECT_EQ(part.mesh.triangles, second.at(name).mesh.triangles) << name;
  }
}

TEST(Knee, TheGeneratedPoseHasASmallGap)
{
  for (const double resolution : {0.77, 1.0, 2.0}) {
    SCOPED_TRACE(resolution);
    const geometry::Shape shape = knee(resolution);
    const auto femur = test::envelope(contact_mesh(shape.reference), test::Facing::down);
    const auto tibmen = test::envelope(contact_mesh(shape.moving), test::Facing::up);
    EXPECT_GT(test::smallest_height_mm(femur, tibmen), 0.0);
    EXPECT_LT(test::smallest_height_mm(femur, tibmen), 1.0);
  }
}

TEST(Knee, MenisciLieOnThePlateauWithoutCuttingIt)
{
  for (const double resolution : {1.0, 2.0}) {
    const auto parts = by_name(knee(resolution));
    const auto tibia = test::envelope(parts.at("tibia").mesh, test::Facing::up);
    for (const char* name : {"meniscus_medial", "meniscus_lateral"}) {
      SCOPED_TRACE(testing::Message() << name << " " << resolution);
      const auto meniscus = test::envelope(parts.at(name).mesh, test::Facing::down);
      EXPECT_GT(test::smallest_height_mm(meniscus, tibia), 0.0);
      EXPECT_LT(test::smallest_height_mm(meniscus, tibia), 0.5);
    }
  }
}

TEST(Knee, IsAsWideAndLongAsAKnee)
{
  const auto parts = by_name(knee(2.0));
  const Box femur = bounding_box(parts.at("femur").mesh);
  EXPECT_NEAR(femur.max_mm.z() - femur.min_mm.z(), 82.0, 4.0);  // epicondylar width of a man
  const Box shaft = bounding_box(parts.at("femur_shaft").mesh),
            tibia = bounding_box(parts.at("tibia_shaft").mesh);
  EXPECT_GT(shaft.max_mm.y() - tibia.min_mm.y(), 200.0);  // the thesis's model is twenty centimetres long
}

TEST(Knee, ShaftsLieOnTheBoneAndAreHiddenInsideTheContactParts)
{
  struct Row {
    const char* name;
    Mesh shaft;
    double (*field)(const Eigen::Vector3d&);
    double cut_mm, up;  // end of the contact part, and direction of the shaft from it
  };
  for (const double resolution : {1.0, 2.0, 3.0}) {
    for (const Row& row : {Row{"femur", geometry::femur_meshes(resolution, resolution).shaft,
                               geometry::femur_field, 16.0, 1.0},
                           Row{"tibia", geometry::tibia_meshes(resolution, resolution).shaft,
                               geometry::tibia_field, -50.0, -1.0}}) {
      SCOPED_TRACE(testing::Message() << row.name << " " << resolution);
      double furthest_out = -1.0, furthest_out_deep = -1.0;
      for (Eigen::Index v = 0; v < row.shaft.vertices_mm.rows(); ++v) {
        const Eigen::Vector3d p = row.shaft.vertices_mm.row(v);
        constexpr double hidden_mm = 11.0;  // past the rim, a triangle and the crossing
        const bool is_deep = row.up * (row.cut_mm - p.y()) > hidden_mm;
        furthest_out = std::max(furthest_out, row.field(p));
        furthest_out_deep = std::max(furthest_out_deep, is_deep ? row.field(p) : -1.0);
      }
      constexpr double steepest = 1.5;                               // of either field near its surface
      EXPECT_LT(furthest_out, steepest * 0.02 * 5.05 / resolution);  // a fiftieth of an edge
      EXPECT_LT(furthest_out_deep, 0.0);
      EXPECT_GT(furthest_out_deep, -1.0);
    }
  }
}

TEST(Knee, CompartmentsAreOnTheirSides)
{
  // On a right knee lateral is the subject's right, +Z; the fibula is lateral and behind.
  const auto parts = by_name(knee(1.0));
  EXPECT_LT(bounding_box(parts.at("meniscus_medial").mesh).max_mm.z(), 0.0);
  EXPECT_GT(bounding_box(parts.at("meniscus_lateral").mesh).min_mm.z(), 0.0);
  EXPECT_GT(bounding_box(parts.at("fibula").mesh).min_mm.z(), 0.0);
  EXPECT_LT(bounding_box(parts.at("fibula").mesh).max_mm.x(), 0.0);
}

TEST(Knee, MedialCondyleIsLarger)
{
  const geometry::Condyle medial = geometry::medial_condyle(), lateral = geometry::lateral_condyle();
  for (int flexion_deg = 0; flexion_deg <= 120; flexion_deg += 10) {
    EXPECT_GT(geometry::radius_mm(medial, rad_from_deg(flexion_deg)),
              geometry::radius_mm(lateral, rad_from_deg(flexion_deg)));
  }
  EXPECT_GT(medial.coronal_radius_mm, lateral.coronal_radius_mm);
}

TEST(Knee, PlateausAreHollowMediallyAndSlightlyConvexLaterally)
{
  const auto bend = [](const Eigen::Vector3d& rest) {
    constexpr double h_mm = 4.0;
    return geometry::plateau_height_mm(rest.x() + h_mm, rest.z()) +
           geometry::plateau_height_mm(rest.x() - h_mm, rest.z()) -
           2.0 * geometry::plateau_height_mm(rest.x(), rest.z());
  };
  EXPECT_GT(bend(geometry::medial_contact_point_mm()), 0.1);
  EXPECT_LT(bend(geometry::lateral_contact_point_mm()), 0.0);
  EXPECT_GT(bend(geometry::lateral_contact_point_mm()), -0.3);
  // Posterior slope: the front edge is higher than the rear one.
  EXPECT_GT(geometry::plateau_height_mm(25.0, -22.0), geometry::plateau_height_mm(-19.0, -22.0) + 1.0);
  EXPECT_GT(geometry::plateau_height_mm(20.0, 22.0), geometry::plateau_height_mm(-18.0, 22.0) + 1.0);
}

// With each condyle in contact at its lowest point, the tibia rotates with the line between the two lowest
// points, and the varus at which both touch follows the difference in their heights.
TEST(Knee, RollingCondylesTurnTheTibiaInwardAndKeepBothTouchingNearZeroVarus)
{
  const geometry::Condyle medial = geometry::medial_condyle(), lateral = geometry::lateral_condyle();
  const double apart_mm = lateral.z_mm - medial.z_mm;
  const auto turn_deg = [&](double flexion_deg) {
    const double a = rad_from_deg(flexion_deg);
    return deg_from_rad(arc_tangent2(
        geometry::support(medial, a).slope_mm - geometry::support(lateral, a).slope_mm, apart_mm));
  };
  const auto varus_deg = [&](double flexion_deg) {
    const double a = rad_from_deg(flexion_deg);
    return deg_from_rad(arc_tangent2(
        geometry::support(medial, a).value_mm - geometry::support(lateral, a).value_mm, apart_mm));
  };
  double previous_deg = turn_deg(0.0);
  for (int flexion_deg = 1; flexion_deg <= 90; ++flexion_deg) {
    EXPECT_GT(turn_deg(flexion_deg), previous_deg);
    previous_deg = turn_deg(flexion_deg);
    EXPECT_LT(std::abs(varus_deg(flexion_deg) - varus_deg(0.0)), 2.5);
  }
  EXPECT_GT(turn_deg(30.0) - turn_deg(0.0), 0.5 * (turn_deg(90.0) - turn_deg(0.0)));  // most of it early
  EXPECT_NEAR(turn_deg(90.0) - turn_deg(0.0), 12.5, 7.5);                             // 5 to 20 degrees
}

}  // namespace vrda::knee_test
