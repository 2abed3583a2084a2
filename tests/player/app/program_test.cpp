// The program vrda-player: exit codes, standard output, standard error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "support/damaged_models.hpp"
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

/// A model with a valid seal that crashes HDF5 1.10.8: an object of its global heap has a huge length.
std::string deadly_for_hdf5(std::string bytes)
{
  bytes.resize(bytes.size() - store::seal_of("").size());
  bytes.replace(bytes.find("GCOL") + 24, 8, std::string(7, '\xff') + '\x7f');
  return bytes + store::seal_of(bytes);
}

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

TEST_F(Program, TakesNegativeAnglesAModeAndEveryBackground)
{
  for (const std::string background : {"studio", "night", "black"}) {
    const Outcome outcome =
        run("show '" + file_ + "' --offscreen '" + folder_ + "' --size 64x48 --varus -0.5 " +
            "--flexion -5:5:5 --mode wire --background " + background);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    EXPECT_THAT(outcome.messages, test::reports("--flexion", {"-5", "0", "30"}));
  }
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

TEST_F(Program, EndsWithTwoAndOneLineOnBadInput)
{
  const std::string text = scratch_.write("text.h5", "not HDF5 at all\n").string();
  const std::string whole = test::read_bytes(file_);
  const std::string cut = scratch_.write("cut.h5", whole.substr(0, whole.size() / 2)).string();
  const std::string huge = test::damaged_copy(file_, scratch_.path(), "gigabytes_of_vertices");
  const std::string endless = test::damaged_copy(file_, scratch_.path(), "contacts_beyond_an_index");
  const std::string empty = scratch_.write("empty.h5", "").string();
  const std::string deadly = scratch_.write("deadly.h5", deadly_for_hdf5(whole)).string();
  const std::string pictures = " --offscreen '" + folder_ + "'";
  const std::string kept = (scratch_.path() / "calibration.toml").string();
  struct Row {
    std::string arguments;
    test::Refusal refusal;
  };
  const std::string model = "show '" + file_ + "'";
  for (const Row& row :
       {Row{"", {"", "", {"show", "follow", "web", "bench", "calibrate", "body", "simulate", "devices"}}},
        Row{"show a.h5 --samples 3", {"", "", {"--samples", "3", "1", "2", "4"}}},
        Row{"dance", {"", "", "dance"}},
        Row{"show", {"", "", "FILE"}},
        Row{model, {"window", "display", "DISPLAY", "--offscreen"}},
        Row{"calibrate all --virtual --calibration '" + kept + "'",
            {"window", "display", "DISPLAY", "--headless"}},
        Row{"show --bogus", {"", "", "--bogus"}},
        Row{"bench --bogus 3", {"", "", "--bogus"}},
        Row{"devices --bogus", {"", "", "--bogus"}},
        Row{"calibrate foo --virtual --headless",
            {"calibrate",
             "STEP",
             "'foo'",
             {"all", "bench", "person", "tracking", "status", "solve", "viewport"}}},
        Row{model + " --varus front" + pictures, {"", "", {"--varus", "front"}}},
        Row{model + " --colour red" + pictures, {"", "", {"--colour", "red"}}},
        Row{model + " --background red" + pictures, {"--background", "", "'red'", "night"}},
        Row{model + " --frame half" + pictures, {"--frame", "", "'half'", {"all", "joint"}}},
        Row{model + " --mode wireframe" + pictures, {"--mode", "", "'wireframe'", {"flat", "wire"}}},
        Row{model + " --set degree_7" + pictures, {"sample.h5", "--set", "degree_7", {"degree_1", "raw"}}},
        Row{"show absent.h5" + pictures, {"absent.h5", "", "No such file"}},
        Row{"show '" + text + "'" + pictures, {text, "", {"16", "HDF5"}}},
        Row{"show '" + cut + "'" + pictures, {cut, "", "truncated"}},
        Row{"show '" + empty + "'" + pictures, {empty, "", {"0", "HDF5"}}},
        Row{"show '" + huge + "'" + pictures, {huge, "/bodies/reference/vertices"}},
        Row{"show '" + endless + "'" + pictures, {endless, "/contacts/contact"}},
        Row{"show '" + deadly + "'" + pictures, {.file = deadly}},
        Row{model + " --offscreen /proc/none", {"/proc/none", "--offscreen"}}}) {
    SCOPED_TRACE(row.arguments);
    const Outcome outcome = run(row.arguments);
    EXPECT_THAT((test::Ended{outcome.code, outcome.data, outcome.messages}), test::refuses(row.refusal));
    EXPECT_EQ(outcome.data, "");
    EXPECT_THAT(outcome.messages, StartsWith("vrda-player: "));
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
  }
  EXPECT_FALSE(std::filesystem::exists(kept));
}

}  // namespace vrda::program_test
