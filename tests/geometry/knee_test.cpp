#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>

#include "core/units.hpp"
#include "geometry/envelopes.hpp"
#include "geometry/generic_knee.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "support/refusal.hpp"

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

TEST(Condyle, SupportSlopeAndRadiusMatchDifferences)
{
  constexpr double h_rad = 1e-4;
  constexpr double first_mm = 1e-6, second_mm = 1e-5;  // h^2 of the fourth derivative; rounding over h^2
  for (const geometry::Condyle& condyle : {geometry::medial_condyle(), geometry::lateral_condyle()}) {
    // Includes the spiral's end at 110 degrees.
    for (double angle_deg = -20.0; angle_deg <= 130.0; angle_deg += 7.3) {
      const double a = rad_from_deg(angle_deg);
      const double before = geometry::support(condyle, a - h_rad).value_mm,
                   after = geometry::support(condyle, a + h_rad).value_mm;
      const geometry::Support at = geometry::support(condyle, a);
      EXPECT_NEAR((after - before) / (2.0 * h_rad), at.slope_mm, first_mm);
      EXPECT_NEAR((after + before - 2.0 * at.value_mm) / (h_rad * h_rad) + at.value_mm,
                  geometry::radius_mm(condyle, a), second_mm);
    }
  }
}

TEST(CondyleSurface, DistanceMatchesAFineSearchOverTheOutline)
{
  std::mt19937 random(7);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random()) / 4294967296.0;
  };
  int n_inside = 0, n_outside = 0;
  for (const geometry::Condyle& condyle : {geometry::medial_condyle(), geometry::lateral_condyle()}) {
    const geometry::CondyleSurface surface(condyle);
    for (int trial = 0; trial < 400; ++trial) {
      const Eigen::Vector3d p(uniform(-32, 36), uniform(-34, 26), condyle.z_mm + uniform(-25, 25));
      double wanted = 1e9;
      constexpr int n_steps = 20000;  // 2 micrometres along the outline; the error is its square / 2 mm
      for (int k = 0; k <= n_steps; ++k) {
        const double a = condyle.first_rad + (condyle.last_rad - condyle.first_rad) * k / n_steps;
        wanted =
            std::min(wanted, (p - geometry::ball_centre_mm(condyle, a)).norm() - condyle.coronal_radius_mm);
      }
      const double found = surface.signed_distance_mm(p);
      const bool is_near = wanted < 12.0;
      EXPECT_NEAR(is_near ? found : wanted, wanted, 1e-5);
      EXPECT_LE(found, wanted + 1e-5);  // far away: a lower bound
      n_inside += wanted < 0.0 ? 1 : 0;
      n_outside += wanted > 0.0 && is_near ? 1 : 0;
    }
  }
  EXPECT_GT(n_inside, 100);
  EXPECT_GT(n_outside, 100);
}

using testing::HasSubstr;

std::vector<geometry::ShapeFibre> fibres(const std::string& side)
{
  return geometry::generate_fibres({"knee", {}, {{"side", side}}});
}

// The moving parts are generated below the design pose, to which the reference strains refer.
Eigen::Vector3d designed_mm(const geometry::ShapeFibre& fibre)
{
  return fibre.moving_mm + geometry::initial_clearance_mm() * Eigen::Vector3d::UnitY();
}

TEST(KneeLigaments, AreAttachedToTheBones)
{
  for (const geometry::ShapeFibre& fibre : fibres("right")) {
    SCOPED_TRACE(fibre.name);
    const auto moving_field = fibre.bundle == "LCL" ? geometry::fibula_field : geometry::tibia_field;
    // Newton's method converges to the rounding of fields of tens of mm.
    EXPECT_NEAR(geometry::femur_field(fibre.reference_mm), 0.0, 1e-9);
    EXPECT_NEAR(moving_field(designed_mm(fibre)), 0.0, 1e-9);
  }
}

TEST(KneeLigaments, HaveTheStiffnessAndReferenceStrainsOfTheirSource)
{
  // Lenhart et al. 2015, totals and means over each bundle, to the digits given.
  const std::map<std::string, std::pair<double, double>> source{
      {"ACLam", {4920, -0.112}}, {"ACLpl", {4920, -0.030}}, {"PCLal", {4500, -0.020}},
      {"PCLpm", {1500, -0.094}}, {"MCLs", {3000, 0.047}},   {"MCLd", {2500, 0.016}},
      {"MCLp", {2500, 0.030}},   {"LCL", {2400, 0.060}}};
  std::map<std::string, double> stiffness_n;
  std::set<std::string> names;
  for (const geometry::ShapeFibre& fibre : fibres("right")) {
    SCOPED_TRACE(fibre.name);
    const double length_mm = (designed_mm(fibre) - fibre.reference_mm).norm();
    EXPECT_NEAR(length_mm / fibre.slack_length_mm - 1.0, source.at(fibre.bundle).second, 1e-12);
    stiffness_n[fibre.bundle] += fibre.stiffness_n;
    EXPECT_TRUE(names.insert(fibre.name).second);
  }
  ASSERT_EQ(stiffness_n.size(), source.size());
  for (const char* bundle : model::divided_bundles) EXPECT_TRUE(stiffness_n.contains(bundle)) << bundle;
  for (const auto& [bundle, total_n] : stiffness_n) EXPECT_NEAR(total_n, source.at(bundle).first, 1e-9);
}

// Pose of the tibia with the contact points of extension below the condyles' lowest points.
Pose following_the_condyles(double flexion_rad)
{
  const auto lowest = [&](const geometry::Condyle& condyle, double angle_rad) {
    const geometry::Support p = geometry::support(condyle, angle_rad);
    return Eigen::Vector3d(-p.slope_mm, -p.value_mm, condyle.z_mm);
  };
  const Eigen::Vector3d medial = lowest(geometry::medial_condyle(), flexion_rad);
  const Eigen::Vector3d line = lowest(geometry::lateral_condyle(), flexion_rad) - medial;
  const Eigen::Vector3d first_line =
      geometry::lateral_contact_point_mm() - geometry::medial_contact_point_mm();
  Pose X = Pose::Identity();
  X.linear() = rotation_y(arc_tangent2(line.x(), line.z()) - arc_tangent2(first_line.x(), first_line.z()));
  X.translation() = medial - X.linear() * geometry::medial_contact_point_mm();
  return X;
}

TEST(KneeLigaments, FlexionTearsNone)
{
  // Ligaments fail at strains of 0.15 and above.
  for (int flexion_deg = 0; flexion_deg <= 90; flexion_deg += 10) {
    const double flexion_rad = rad_from_deg(flexion_deg);
    const Pose X_reference_moving = rotation_z(-flexion_rad) * following_the_condyles(flexion_rad);
    for (const geometry::ShapeFibre& fibre : fibres("right")) {
      const double length_mm = (X_reference_moving * designed_mm(fibre) - fibre.reference_mm).norm();
      EXPECT_LT(length_mm / fibre.slack_length_mm - 1.0, 0.15) << fibre.name << " at " << flexion_deg;
    }
  }
}

TEST(KneeLigaments, OfALeftKneeAreTheMirrorImageToTheLastBit)
{
  const std::vector<geometry::ShapeFibre> right = fibres("right"), left = fibres("left");
  ASSERT_EQ(right.size(), left.size());
  const Eigen::Vector3d m(1, 1, -1);
  for (std::size_t i = 0; i < right.size(); ++i) {
    EXPECT_EQ(left[i].reference_mm, Eigen::Vector3d(m.cwiseProduct(right[i].reference_mm)));
    EXPECT_EQ(left[i].moving_mm, Eigen::Vector3d(m.cwiseProduct(right[i].moving_mm)));
    EXPECT_EQ(left[i].slack_length_mm, right[i].slack_length_mm);
  }
}

}  // namespace vrda::knee_test
