#include "prepare/job_files.hpp"

#include <gmock/gmock.h>

#include "core/units.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"

namespace vrda::job_files_test {

TEST(JobText, IsAJobWithItsComponents)
{
  prepare::JobDescription description;
  description.title = "Anna \"A\"";
  description.side = Side::left;
  description.reference = {{"femur", "bone", true, -1.25}};
  description.moving = {{"tibia", "bone"}, {"meniscus_1", "meniscus", false}};
  description.has_wraps = true;
  description.scanned = ClinicalCoordinates{};
  description.scanned->flexion_rad = rad_from_deg(19.04);
  EXPECT_THAT(job_text(description), testing::HasSubstr("# In the scan: flexion 19, varus 0,"));
  const job::Job job = job::parse_job("knee.toml", job_text(description));
  EXPECT_EQ(job.title, "Anna \"A\"");
  EXPECT_EQ(job.side, Side::left);
  EXPECT_EQ(job.reference.components[0].file, "femur.stl");
  EXPECT_DOUBLE_EQ(job.reference.components[0].inset_mm, -1.25);
  EXPECT_FALSE(job.moving.components[1].has_contact);
  EXPECT_TRUE(job.is_varus_free);
  EXPECT_EQ(job.grid.flexion_deg.size(), 19U);
  EXPECT_EQ(job.ligaments->wraps_file, "wraps.json");
  description.has_ligaments = false;
  EXPECT_FALSE(job::parse_job("knee.toml", job_text(description)).ligaments.has_value());
}

TEST(LigamentFiles, AreReadBackAsTheyWere)
{
  model::Ligaments ligaments;
  model::Wrap ellipsoid{"e", model::WrapShape::ellipsoid, BodyIndex::moving};
  ellipsoid.radii_mm = {30, 18, 12};
  ellipsoid.X_body_wrap.linear() = rotation_x(0.3) * rotation_y(-0.7) * rotation_z(2.0);
  ellipsoid.X_body_wrap.translation() = Eigen::Vector3d(1, -34.6, 5);
  model::Wrap cylinder{"c", model::WrapShape::cylinder, BodyIndex::reference};
  cylinder.radii_mm = {18, 18, 250};
  ligaments.wraps = {ellipsoid, cylinder};
  ligaments.fibres = {{"MCL1", "MCL", {1, 2, 3}, {4, 5, 6}, 500, 30.75, 0},
                      {"A", "ACL", {-1, 0.1, 3}, {4, 5, -6}, 1640, 31, -1}};
  const std::vector<job::FibreJob> fibres =
      job::read_ligament_table("l.csv", prepare::ligament_table(ligaments, "a comment"));
  ASSERT_EQ(fibres.size(), 2U);
  EXPECT_EQ(fibres[1].moving_native_mm, ligaments.fibres[1].moving_mm);
  EXPECT_EQ(fibres[0].bundle, "MCL");
  EXPECT_EQ(fibres[0].wrap, "e");
  EXPECT_EQ(fibres[1].wrap, "");
  EXPECT_DOUBLE_EQ(*fibres[0].slack_length_mm, 30.75);
  const std::vector<model::Wrap> wraps =
      job::read_wraps("w.json", prepare::wraps_text(ligaments), {"femur", "tibia"});
  ASSERT_EQ(wraps.size(), 2U);
  EXPECT_TRUE(wraps[0].X_body_wrap.isApprox(ellipsoid.X_body_wrap, 1e-12));
  EXPECT_EQ(wraps[0].body, BodyIndex::moving);
  EXPECT_TRUE(wraps[0].radii_mm.isApprox(ellipsoid.radii_mm));
  EXPECT_TRUE(wraps[1].radii_mm.isApprox(cylinder.radii_mm));
}

}  // namespace vrda::job_files_test
