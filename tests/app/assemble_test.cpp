#include "solve/case_solver.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "app/scenes.hpp"
#include "run/run_output.hpp"

namespace vrda::assemble_test {

TEST(Assemble, EveryCellOfTheStartFileIsPending)
{
  const test::Scratch scratch;
  const job::Case job_case = job::load_case(test::small_knee_job(scratch, "right").string());
  const store::MotionModel model = solve::pending_model_of(job_case);
  EXPECT_EQ(run::cells_by_status(model), (std::map<std::string, int>{{"pending", 35}}));
  EXPECT_EQ(run::unsolved_fraction(model), 1.0);
  EXPECT_TRUE(model.tx_mm.isNaN().all());
  EXPECT_EQ(model.contacts.row_start.size(), 36u);
  EXPECT_EQ(model.reference.contact.mesh.triangles.rows(), 2 * 648 + 2 * 4 * 18);
}

TEST(Assemble, OnlyStableCellsHoldNumbers)
{
  const test::Scratch scratch;
  const job::Case job_case = job::load_case(test::small_knee_job(scratch, "left").string());
  solve::SweepResult result;
  result.cells.resize(35);
  result.spine_column.assign(7, 2);
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 5; ++j) {
      StepRecord& r = result.cells[static_cast<std::size_t>(5 * i + j)];
      r.key = {StepKind::row, i, j};
      r.status = j == 4 ? StepStatus::no_contact : StepStatus::stable;
      r.varus_rad = rad_from_deg(j - 2.0);
      r.pose = {{1.0 * i, 2.0 * j, 3.0}, 0.1};
      if (j != 4) r.contacts.push_back({{1, 2, 3}, {0, -1, 0}, 0.01, 4, 5, 1});
    }
  }
  const store::MotionModel model = solve::motion_model_of(job_case, result);
  EXPECT_EQ(run::status_line(model), "35 attitudes: 7 no_contact, 28 stable");
  EXPECT_NEAR(run::unsolved_fraction(model), 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(model.theta_deg(3, 4)));
  EXPECT_EQ(model.tz_mm(3, 3), -3.0) << "a left knee is reflected back to its own side";
  EXPECT_EQ(model.contacts.point_world_mm(0, 2), -3.0);
  EXPECT_EQ(model.contacts.row_start.back(), 28);
  EXPECT_EQ(model.is_spine.cast<int>().sum(), 7);
  // The decomposition of the stored pose returns the grid attitudes.
  EXPECT_NEAR(model.clinical.flexion_deg(3, 1), 6.0, 1e-9);
  EXPECT_NEAR(model.clinical.varus_deg(3, 1), -1.0, 1e-9);
}

TEST(Assemble, TheFingerprintFollowsTheJobAndItsMeshes)
{
  const test::Scratch scratch;
  const std::filesystem::path job = test::small_job(scratch);
  const std::string before = solve::fingerprint_of(job::load_case(job.string()));
  EXPECT_EQ(solve::fingerprint_of(job::load_case(job.string())), before);
  EXPECT_NE(solve::fingerprint_of(job::load_case(job.string(), {"", {"solver.search.rotation_step_deg=2"}})),
            before);
  std::string mesh = test::text_of(scratch.path() / "ball.stl");
  mesh[84 + 12] = static_cast<char>(mesh[84 + 12] ^ 1);
  scratch.write("ball.stl", mesh);
  EXPECT_NE(solve::fingerprint_of(job::load_case(job.string())), before);
}

}  // namespace vrda::assemble_test
