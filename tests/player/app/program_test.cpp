// The program vrda-player: exit codes, standard output, standard error.
#include "player/app/player_programs.hpp"

namespace vrda::program_test {

using testing::HasSubstr;

class Program : public test::PlayerPrograms {
 protected:
  /// Pictures of 64 x 48 pixels of the model.
  test::Ended show(std::vector<std::string> more) const
  {
    more.insert(more.begin(), {"show", model_, "--offscreen", folder_, "--size", "64x48"});
    return run(std::move(more));
  }

  std::string folder_ = path("pictures");
};

TEST_F(Program, Help)
{
  const test::Ended help = run({"--help"}), show_help = run({"show", "--help"}), version = run({"--version"});
  for (const test::Ended& ended : {help, show_help, version}) {
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_EQ(ended.err, "");
  }
  EXPECT_THAT(help.out, HasSubstr("Example:"));
  EXPECT_THAT(show_help.out, HasSubstr("vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15"));
  EXPECT_THAT(show_help.out, HasSubstr("Space         play or pause"));
  EXPECT_THAT(show_help.out, HasSubstr("Left drag     turn"));
  EXPECT_EQ(version.out, "vrda-player " VRDA_VERSION "\n");
}

TEST_F(Program, PathsAndMessages)
{
  const test::Ended ended = show({"--flexion", "0:30:30", "--views", "lateral"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_EQ(ended.out, folder_ + "/lateral_flexion_000.png\n" + folder_ + "/lateral_flexion_030.png\n");
  EXPECT_THAT(ended.err, test::reports("", {"2 attitudes", "2"}));
  EXPECT_EQ(show({"--flexion", "0", "--quiet"}).err, "");
}

TEST_F(Program, Frame)
{
  const auto still = [&](const std::vector<std::string>& frame) {
    std::vector<std::string> words{"--flexion", "0", "--views", "inverted", "--quiet"};
    words.insert(words.end(), frame.begin(), frame.end());
    const test::Ended ended = show(words);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return test::read_bytes(folder_ + "/inverted_flexion_000.png");
  };
  const std::string by_default = still({}), joint = still({"--frame", "joint"}),
                    all = still({"--frame", "all"});
  EXPECT_TRUE(by_default == joint);
  EXPECT_FALSE(all == joint);
}

TEST_F(Program, UnsolvedAttitude)
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10};
  plan.varus_deg = {0, 1};
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  test::unsolve(model, 1, 1);
  store::write_motion_model(model_, model);
  const test::Ended ended = show({"--set", "raw", "--varus", "0.5", "--flexion", "0:10:10", "--quiet"});
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.err, test::reports("", {"10", "0.5"}));
}

}  // namespace vrda::program_test
