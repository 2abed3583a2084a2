#include <gmock/gmock.h>

#include <map>
#include <set>

#include "core/units.hpp"
#include "geometry/generic_knee.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "support/refusal.hpp"

namespace vrda::ligaments_test {

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

TEST(KneeLigaments, ATableHasTheirSourcesAndALineEach)
{
  const std::string table = geometry::fibre_table({"knee", {}, {}});
  EXPECT_EQ(table.front(), '#');
  EXPECT_THAT(table, HasSubstr("Lenhart et al. 2015"));
  const auto n_lines = static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n'));
  const auto n_comments = static_cast<std::size_t>(std::count(table.begin(), table.end(), '#'));
  EXPECT_EQ(n_lines, n_comments + 1 + fibres("right").size());
}

TEST(KneeLigamentErrors, AShapeWithoutLigamentsAndAnUnknownParameter)
{
  EXPECT_THAT(test::input_error([] {
                geometry::generate_fibres({"hip", {}, {}});
              }),
              test::refuses({.field = "name", .found = "\"hip\"", .wanted = "knee"}));
  EXPECT_THAT(test::input_error([] {
                geometry::generate_fibres({"knee", {}, {{"side", "up"}}});
              }),
              test::refuses({.field = "side"}));
}

}  // namespace vrda::ligaments_test
