// The contacts of a motion model and the decisions of the search are Bullet's: a wrong pair detector shows.
#include <gmock/gmock.h>

#include "app/scenes.hpp"
#include "store/motion_model.hpp"

namespace vrda::test::wrong_bullet_test {

struct Solved {
  Ended ended;
  store::MotionModel model;
};

Solved solved(const Scratch& scratch, const std::string& method, const std::string& wrong)
{
  const std::filesystem::path output = scratch.path() / (method + wrong + ".h5");
  Command command = vrda({"run", small_knee_job(scratch, "right").string(), "--set",
                          "solver.method=" + method, "-o", output.string(), "--quiet"});
  if (!wrong.empty())
    command.environment = {{"LD_PRELOAD", VRDA_WRONG_BULLET},
                           {"VRDA_WRONG_BULLET", wrong},
                           // The address sanitizer's library must otherwise be loaded first.
                           {"ASAN_OPTIONS", "verify_asan_link_order=0"}};
  Solved result;
  result.ended = run(command);
  if (std::filesystem::exists(output)) result.model = store::read_motion_model(output.string());
  return result;
}

TEST(WrongBullet, ThatSeesOnlyOverlapsLeavesTheEquilibriumWithoutContacts)
{
  const Scratch scratch;
  const Solved right = solved(scratch, "equilibrium", ""), wrong = solved(scratch, "equilibrium", "overlap");
  EXPECT_GT(right.model.contacts.distance_mm.size(), 35U) << right.ended.err;
  EXPECT_TRUE(wrong.model.contacts.distance_mm.empty()) << wrong.ended.err;
}

TEST(WrongBullet, ThatDisplacesPointsDisplacesTheContacts)
{
  const Scratch scratch;
  const Solved right = solved(scratch, "equilibrium", ""),
               wrong = solved(scratch, "equilibrium", "displaced");
  ASSERT_GT(right.model.contacts.distance_mm.size(), 35U) << right.ended.err;
  const Points& expected = right.model.contacts.point_world_mm;
  const Points& found = wrong.model.contacts.point_world_mm;
  ASSERT_GT(found.rows(), 0) << wrong.ended.err;
  Eigen::Index n_displaced = 0;
  for (Eigen::Index k = 0; k < found.rows(); ++k)
    n_displaced += (expected.rowwise() - found.row(k)).rowwise().norm().minCoeff() > 0.01 ? 1 : 0;
  EXPECT_GT(n_displaced, found.rows() / 2);
}

// Where every pair overlaps the moving object stops too early and nothing tells it where to slide.
TEST(WrongBullet, ThatSeesOnlyOverlapsLeavesTheSearchWhereItStarts)
{
  const Scratch scratch;
  const Solved right = solved(scratch, "stability-search", ""),
               wrong = solved(scratch, "stability-search", "overlap");
  ASSERT_TRUE((right.model.status == 0).all()) << right.ended.err;
  EXPECT_TRUE(wrong.model.contacts.distance_mm.empty());
  EXPECT_GT((right.model.tx_mm - wrong.model.tx_mm).abs().maxCoeff(), 0.1) << wrong.ended.err;
}

}  // namespace vrda::test::wrong_bullet_test
