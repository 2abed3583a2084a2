#include "prepare/template_joint.hpp"

#include <gmock/gmock.h>

#include "core/units.hpp"
#include "support/meshes.hpp"

namespace vrda::slack_lengths_test {

using prepare::SettledPose, prepare::settled_pose, prepare::set_slack_lengths;

TEST(SettledPose, displaced_knee)
{
  job::Case knee = prepare::generic_template().joint;
  const SettledPose own = settled_pose(knee);
  ASSERT_TRUE(own.has_contact);
  // Adducted by 3 degrees about the rotation centre and lowered by 4 mm.
  Pose X = Pose::Identity();
  X.linear() = rotation_x(rad_from_deg(-3.0));
  knee.moving.contact.mesh = transformed(knee.moving.contact.mesh, X);
  knee.moving.contact.mesh.vertices_mm.col(1).array() -= 4.0;
  const SettledPose settled = settled_pose(knee);
  ASSERT_TRUE(settled.has_contact);
  // The point of contact moves on the plateau as the tibia turns: some hundredths of a millimetre.
  EXPECT_NEAR(deg_from_rad(settled.attitude.varus_rad - own.attitude.varus_rad), 3.0, 0.3);
  EXPECT_NEAR(settled.pose.translation_mm.y() - own.pose.translation_mm.y(), 4.0, 0.2);
}

TEST(SettledPose, one_compartment)
{
  job::Case knee = prepare::generic_template().joint;
  knee.reference.contact.mesh.vertices_mm.col(2).array() += 200.0;
  EXPECT_FALSE(settled_pose(knee).has_contact);
}

TEST(SlackLengths, onto_itself)
{
  const job::Case knee = prepare::generic_template().joint;
  job::Case subject = knee;
  for (model::Fibre& fibre : subject.ligaments.fibres) fibre.slack_length_mm = 1.0;
  const prepare::SlackResult result = set_slack_lengths(subject, knee, 2);
  for (std::size_t i = 0; i < knee.ligaments.fibres.size(); ++i) {
    EXPECT_NEAR(subject.ligaments.fibres[i].slack_length_mm, knee.ligaments.fibres[i].slack_length_mm, 1e-9);
    EXPECT_NEAR(result.loads.largest_strain[i], result.template_strain[i], 1e-9);
  }
  EXPECT_EQ(result.loads.n_solved, result.loads.n_flexions);
  EXPECT_THAT(result.lengthenings, testing::ElementsAre(0));
}

TEST(SlackLengths, strained_fibre)
{
  job::Case knee = prepare::generic_template().joint;
  job::Case subject = knee;
  // Attached anterior of the flexion axis, it tightens in flexion.
  for (model::Fibre& fibre : subject.ligaments.fibres) {
    if (fibre.bundle == "MCLs") fibre.reference_mm.x() += 20.0;
  }
  const prepare::SlackResult result = set_slack_lengths(subject, knee, 2);
  ASSERT_GT(result.lengthenings.front(), 0);
  for (std::size_t i = 0; i < result.template_strain.size(); ++i)
    EXPECT_LT(result.loads.largest_strain[i], std::max(result.template_strain[i], 0.0) + 0.06);
}

TEST(ScannedGap, two_compartments)
{
  geometry::KneeFit fit;
  geometry::KneeSurfaces knee;
  knee.femur.bone = test::box({0, 10, 0}, {60, 10, 80});
  knee.tibia.bone = test::box({0, -10, -20}, {60, 26, 30});        // 2 mm below
  append(knee.tibia.bone, test::box({0, -11, 20}, {60, 24, 30}));  // 4 mm below
  EXPECT_NEAR(prepare::scanned_gap_mm(fit, knee), 3.0, 1e-9);
  knee.tibia.bone.vertices_mm.col(2).array() += 300.0;
  EXPECT_TRUE(std::isnan(prepare::scanned_gap_mm(fit, knee)));
  EXPECT_DOUBLE_EQ(prepare::cartilage_in_gap_mm(3.2), 3.2);
  EXPECT_DOUBLE_EQ(prepare::cartilage_in_gap_mm(0.4), 1.5);
  EXPECT_DOUBLE_EQ(prepare::cartilage_in_gap_mm(9.0), 5.0);
}

}  // namespace vrda::slack_lengths_test
