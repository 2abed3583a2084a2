// `vrda repair`: a measured motion with overlap and gaps, on both sides.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "analysis/repair.hpp"
#include "app/scenes.hpp"
#include "core/text.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::repair_command_test {

using nlohmann::json;

class RepairCommand : public test::CommandTest {
 protected:
  /// Solved poses of the two-ball knee, pushed together by 1.2 mm in the middle and apart by 0.8 mm at the
  /// end.
  std::string measured_walk(const std::string& side)
  {
    const std::string job = test::small_knee_job(scratch_, side).string(), grid_file = path("grid.h5");
    succeed({"run", job, "-o", grid_file, "--progress", "none", "--replace"});
    const store::MotionModel grid = store::read_motion_model(grid_file);
    std::string text = "time,T11,T12,T13,T14,T21,T22,T23,T24,T31,T32,T33,T34\n";
    int frame = 0;
    for (const std::size_t i : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 5u}) {
      Pose X = store::pose_in(grid.X_reference_moving, 5 * i + 2);
      X.translation().y() += frame == 7 ? -0.8 : frame >= 3 && frame <= 5 ? 1.2 : 0.0;
      text += shortest_decimal(0.25 * frame++);
      for (Eigen::Index k = 0; k < 12; ++k) text += "," + shortest_decimal(X.matrix()(k / 4, k % 4));
      text += "\n";
    }
    const std::string table = scratch_.write("walk.csv", text).string(), file = path("measured.h5");
    const test::Ended imported =
        succeed({"import", job, "--motion", table, "-o", file, "--unit", "mm", "--direction",
                 "moving-in-reference", "--axes", "canonical", "--side", side, "--replace"});
    EXPECT_THAT(imported.err, testing::HasSubstr("of 8 frames, by at most 1.2 mm at time_s"));
    return file;
  }

  std::vector<std::string> repair_words(const std::string& file, const std::string& output) const
  {
    return {"repair", file, "-o", output, "--noise-mm", "0.5", "--noise-deg", "1,1,0.5", "--gap-mm", "0"};
  }
};

TEST_F(RepairCommand, NothingOverlapsAndTheMeasuredPosesAreKept)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    const std::string file = measured_walk(side), output = path("repaired_" + side + ".h5");
    std::vector<std::string> words = repair_words(file, output);
    words.emplace_back("--json");
    const json found = json::parse(succeed(words).out);
    EXPECT_GE(found["before"]["overlapping"], 3);
    EXPECT_GT(found["before"]["largest_penetration_mm"], 1.0);
    EXPECT_GT(found["before"]["largest_gap_mm"], 0.5);
    EXPECT_LE(found["after"]["largest_penetration_mm"], analysis::repair_tolerance_mm);
    EXPECT_LE(found["after"]["largest_gap_mm"], analysis::repair_tolerance_mm + 0.1);
    EXPECT_EQ(found["statuses"]["not_converged"], 0);
    EXPECT_EQ(found["frames"].size(), 8u);
    succeed({"validate", output});
    const store::MotionModel measured = store::read_motion_model(file),
                             model = store::read_motion_model(output);
    ASSERT_TRUE(model.repair);
    EXPECT_EQ(model.repair->X_measured, measured.X_reference_moving);
    EXPECT_NE(model.X_reference_moving, measured.X_reference_moving);
    EXPECT_EQ(model.frames->key, measured.frames->key);
    EXPECT_EQ(model.repair->noise_deg[2], 0.5);
    // Measured again from the file's meshes and poses.
    const json info = json::parse(succeed({"audit", output, "--json"}).out);
    EXPECT_TRUE(info[0]["largest_penetration"].is_null() ||
                info[0]["largest_penetration"]["mm"] <= analysis::repair_tolerance_mm);
    // A repair of a repair starts from the measurement.
    const std::string again = path("again_" + side + ".h5");
    succeed(repair_words(output, again));
    EXPECT_EQ(store::read_motion_model(again).X_reference_moving, model.X_reference_moving);
  }
}

TEST_F(RepairCommand, AnOutputIsReplacedOnRequest)
{
  const std::string file = measured_walk("right"), output = path("out.h5");
  succeed(repair_words(file, output));
  test::expect_refused(repair_words(file, output), {.file = output, .wanted = "--replace"});
  std::vector<std::string> words = repair_words(file, output);
  words.emplace_back("--replace");
  succeed(words);
}

}  // namespace vrda::repair_command_test
