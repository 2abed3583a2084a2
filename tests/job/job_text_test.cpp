#include "job/thesis_files.hpp"

#include <gmock/gmock.h>

#include "core/text.hpp"
#include "job/component_loader.hpp"
#include "support/scratch.hpp"

namespace vrda::job_text_test {

using testing::HasSubstr;
using testing::Not;

const std::string models = "MODEL 0 femur\nMODEL 1 tibmen\n";

job::Job job_of(const std::string& text, const std::string& unit = "m")
{
  const test::Scratch scratch;
  const job::KeywordConfiguration configuration =
      job::parse_configuration({"k.cfg", text}, job::mm_per_unit(unit));
  const std::string toml = job::job_text(configuration, {"a \"title\"", "k.cfg", "../models", unit});
  return job::read_job(scratch.write("k.toml", toml).string());
}

TEST(JobText, settings)
{
  const job::Job job = job_of(models +
                              "INITIAL_POSITION 1 0.001 -0.02 0.003\nINITIAL_MOTION 1 0 0.004 0\n"
                              "CONTACT_RESOLUTION 0.0002\nMODELING_RESOLUTION 0.002\n"
                              "ORIENTATION_RESOLUTION 0.3\nORIENTATION_STEP 3\n"
                              "ANGLE_RANGE 0 0 90 2\nANGLE_RANGE 1 15 -15\n");
  EXPECT_EQ(job.title, "a \"title\"");
  EXPECT_EQ(job.side, Side::left);
  EXPECT_EQ(job.reference.components.front().file, "../models/femur.obj");
  EXPECT_EQ(job.moving.name, "tibmen");
  EXPECT_EQ(job.initial.translation_mm, Eigen::Vector3d(3, -20, -1));
  EXPECT_EQ(job.push.delta.value.row(0), Eigen::RowVector3d(0, 1, 0));
  EXPECT_EQ(job.search.approach_step_mm, 4.0);
  EXPECT_EQ(job.search.translation_step_mm, 2.0);
  EXPECT_EQ(job.search.translation_resolution_mm, 0.2);
  EXPECT_EQ(job.search.rotation_step_rad, rad_from_deg(3.0));
  EXPECT_EQ(job.search.rotation_resolution_rad, rad_from_deg(0.3));
  EXPECT_EQ(job.grid.flexion_deg.size(), 46u);
  EXPECT_EQ(job.grid.varus_deg.front(), 15.0);
  EXPECT_EQ(job.grid.varus_deg.size(), 31u);
  EXPECT_THAT(job.resolved_text, Not(HasSubstr("player")));
}

TEST(JobText, frame)
{
  // Native X to the subject's left, Y up, Z forward; canonical X anterior, Y proximal, Z right.
  for (const std::string unit : {"m", "cm", "mm"}) {
    const job::AxisMap map = job::axis_map(job_of(models, unit));
    EXPECT_EQ(map({1, 2, 3}), job::mm_per_unit(unit) * Eigen::Vector3d(3, 2, -1));
  }
}

TEST(JobText, directions)
{
  const job::Job left = job_of(models + "INITIAL_MOTION 1 0.002 0 0\nINITIAL_ORIENTATION 1 30 0 0\n");
  EXPECT_EQ(left.push.delta.value.row(0), Eigen::RowVector3d(0, 0, -1));
  EXPECT_EQ(left.initial.theta_rad, rad_from_deg(-30.0));
  const job::Job down = job_of(models + "INITIAL_MOTION 1 0 -0.002 0\nINITIAL_ORIENTATION 1 0 30 0\n");
  EXPECT_EQ(down.push.delta.value.row(0), Eigen::RowVector3d(0, -1, 0));
  EXPECT_EQ(down.initial.theta_rad, rad_from_deg(30.0));
}

TEST(JobText, several_models)
{
  const job::Job job = job_of("MODEL 0 Femur\nMODEL 1 Tibia\nMODEL 1 Medmen\nMODEL 1 Latmen\n");
  ASSERT_EQ(job.moving.components.size(), 3u);
  EXPECT_EQ(job.moving.name, "Tibia");
  EXPECT_EQ(job.moving.components[2].file, "../models/Latmen.obj");
}

TEST(JobText, views)
{
  const job::Job job = job_of(models +
                              "SHIFT_MODEL 2 -0.1 0 0.05\nORIENTATION_MODEL 2 0 90 0\n"
                              "ORIENTATION_MODEL 0 10 0 0\nDISPLAY 1280 1024\nZOOM 2.5\nRENDER wire\n");
  EXPECT_THAT(job.resolved_text,
              HasSubstr("[player]\ndisplay_px = [1280, 1024]\nzoom = 2.5\nrender = \"wire\"\n"));
  EXPECT_THAT(job.resolved_text,
              HasSubstr("number = 0\nshift_mm = [0, 0, 0]\norientation_deg = [10, 0, 0]\n"));
  EXPECT_THAT(job.resolved_text,
              HasSubstr("number = 2\nshift_mm = [-100, 0, 50]\norientation_deg = [0, 90, 0]\n"));
}

}  // namespace vrda::job_text_test
