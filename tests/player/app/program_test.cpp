// The program vrda-player: exit codes, standard output, standard error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "store/motion_model.hpp"
#include "support/messages.hpp"
#include "support/models.hpp"
#include "support/scratch.hpp"

namespace vrda::program_test {

using testing::HasSubstr;
using testing::StartsWith;

struct Outcome {
  int code = -1;
  std::string data, messages;
};

class Program : public testing::Test {
 protected:
  /// Flexion 0 to 30 by 10, varus -1 to 1; the cell at 10 degrees, varus 1 is unsolved.
  Program()
  {
    test::ModelPlan plan;
    plan.flexion_deg = {0, 10, 20, 30};
    plan.varus_deg = {-1, 0, 1};
    store::MotionModel model = test::model_of(plan);
    test::add_bodies(model);
    test::unsolve(model, 1, 2);
    test::add_smoothed(model, 1, [](int, int) { return store::PoseCoordinates{}; });
    store::write_motion_model(file_, model);
  }

  Outcome run(const std::string& arguments) const
  {
    const std::string data = (scratch_.path() / "out").string(),
                      messages = (scratch_.path() / "err").string();
    const std::string command =
        "'" VRDA_PLAYER_PROGRAM "' " + arguments + " >'" + data + "' 2>'" + messages + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, test::read_bytes(data), test::read_bytes(messages)};
  }

  test::Scratch scratch_;
  std::string file_ = (scratch_.path() / "sample.h5").string();
  std::string folder_ = (scratch_.path() / "pictures").string();
};

TEST_F(Program, HelpShowsAnExampleAndVersionIsTheProjects)
{
  const Outcome help = run("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.data, HasSubstr("Example:"));
  EXPECT_EQ(help.messages, "");
  const Outcome show_help = run("show --help");
  EXPECT_EQ(show_help.code, 0);
  EXPECT_THAT(show_help.data, HasSubstr("vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15"));
  EXPECT_THAT(show_help.data, HasSubstr("Space         play or pause"));
  EXPECT_THAT(show_help.data, HasSubstr("Left drag     turn"));
  const Outcome version = run("--version");
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.data, "vrda-player " VRDA_VERSION "\n");
}

TEST_F(Program, WritesPathsToStandardOutputAndMessagesToStandardError)
{
  const Outcome outcome = run("show '" + file_ + "' --offscreen '" + folder_ +
                              "' --flexion 0:30:30 --views lateral --size 64x48");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.data, folder_ + "/lateral_flexion_000.png\n" + folder_ + "/lateral_flexion_030.png\n");
  EXPECT_THAT(outcome.messages, test::reports("", {"2 attitudes", "2"}));
  const Outcome quiet =
      run("show '" + file_ + "' --offscreen '" + folder_ + "' --flexion 0 --size 64x48 --quiet");
  EXPECT_EQ(quiet.code, 0);
  EXPECT_EQ(quiet.messages, "");
}

TEST_F(Program, FramesTheJointOrAllOfIt)
{
  const auto still = [&](const std::string& frame) {
    const Outcome outcome = run("show '" + file_ + "' --offscreen '" + folder_ +
                                "' --size 64x48 --flexion 0 --views inverted" + frame);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return test::read_bytes(folder_ + "/inverted_flexion_000.png");
  };
  const std::string by_default = still(""), joint = still(" --frame joint"), all = still(" --frame all");
  EXPECT_EQ(by_default, joint);
  EXPECT_NE(all, joint);
}

TEST_F(Program, EndsWithThreeWhenAnAttitudeHasNoAnswer)
{
  const Outcome outcome = run("show '" + file_ + "' --offscreen '" + folder_ +
                              "' --set raw --varus 0.5 --flexion 0:10:10 --size 64x48 --quiet");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.messages, test::reports("", {"10", "0.5"}));
}

}  // namespace vrda::program_test
