// The program `vrda-player follow`: messages, files and exit codes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <thread>

#include "core/units.hpp"
#include "player/view/screen.hpp"
#include "show/run_watch.hpp"
#include "store/journal.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"
#include "support/models.hpp"
#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::follow_test {

using test::comes_true;
namespace fs = std::filesystem;
using testing::EndsWith;

/// A run of 3 x 3 attitudes written by the test.
class Follow : public testing::Test {
 protected:
  Follow()
  {
    test::ModelPlan plan;
    plan.flexion_deg = {0, 10, 20};
    plan.varus_deg = {-1, 0, 1};
    model_ = test::model_of(plan);
    test::add_bodies(model_);
    store::write_motion_model(start_, store::with_pending_cells(model_));
  }

  void add_steps(int flexion)
  {
    store::OpenJournal journal = store::JournalWriter::open(store::journal_of(output_), std::string(64, 'a'));
    for (int j = 0; j < 3; ++j) {
      StepRecord r;
      r.key = {StepKind::row, flexion, j};
      r.status = j == 2 ? StepStatus::no_contact : StepStatus::stable;
      r.varus_rad = rad_from_deg(j - 1.0);
      journal.writer.append(r);
    }
  }
  void finish()
  {
    store::write_motion_model(output_, model_);
    fs::remove(store::journal_of(output_));
    fs::remove(start_);
  }
  test::Command command(std::vector<std::string> words, const std::string& start = "") const
  {
    words.insert(words.begin(), {"follow", start.empty() ? start_ : start});
    return {VRDA_PLAYER_PROGRAM, words, {}, scratch_.path()};
  }
  test::Ended follow(const std::vector<std::string>& words) const { return test::run(command(words)); }
  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }

  test::Scratch scratch_;
  store::MotionModel model_;
  std::string output_ = (scratch_.path() / "knee.h5").string();
  std::string start_ = store::start_file_of(output_);
};

TEST_F(Follow, OnceSaysWhatThereIs)
{
  EXPECT_EQ(follow({"--once", "--text"}).out, "waiting for the first step\n");
  add_steps(1);
  const test::Ended ended = follow({"--once", "--text"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_EQ(ended.out, "3/9 attitudes, flexion 10, varus 1\n");
  EXPECT_EQ(ended.err, "");
  EXPECT_EQ(follow({"--once", "--text", "--quiet"}).out, "");
}

TEST_F(Follow, WritesAPictureEachSoManySteps)
{
  add_steps(0);
  add_steps(1);
  const test::Ended ended =
      follow({"--once", "--offscreen", path("pictures"), "--each", "3", "--size", "160x120"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  // Four of the six are stable: an image for the third, and one for the last at the end.
  EXPECT_EQ(ended.out, path("pictures/step_000003.png") + "\n" + path("pictures/step_000004.png") + "\n");
  EXPECT_THAT(ended.err, test::reports("", "6/9"));
  EXPECT_TRUE(fs::exists(path("pictures/step_000003.png")));
}

TEST_F(Follow, EndsWithTheRunAndShowsItsResult)
{
  add_steps(0);
  test::Process program(command({"--offscreen", path("pictures"), "--every", "0.1", "--size", "160x120"}));
  ASSERT_TRUE(comes_true([&] { return fs::exists(path("pictures/step_000002.png")); })) << program.said();
  add_steps(2);
  ASSERT_TRUE(comes_true([&] { return fs::exists(path("pictures/step_000004.png")); })) << program.said();
  finish();
  const test::Ended ended = program.wait();
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.out, EndsWith(path("pictures/finished.png") + "\n"));
  EXPECT_THAT(ended.err, test::reports(output_, {"9/9", "finished"}));
  // Again, after the run has finished.
  const test::Ended again = follow({"--text"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_EQ(again.out, output_ + ": 9/9 attitudes, finished\n");
}

TEST_F(Follow, SaysWhatIsWrongWithTheResult)
{
  model_.plausibility = store::GridB::Constant(3, 3, static_cast<std::int8_t>(Plausibility::nothing_found));
  model_.plausibility(1, 1) = static_cast<std::int8_t>(Plausibility::dislocated);
  model_.job.warnings = {"the femur is coarse"};
  finish();
  const test::Ended ended = follow({"--text"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, testing::HasSubstr("warning: " + output_ + ": 1 of 9 poses: dislocated: further"));
  EXPECT_THAT(ended.err, EndsWith("warning: " + output_ + ": the femur is coarse\n"));
}

TEST_F(Follow, StopsWhenItIsInterrupted)
{
  add_steps(0);
  test::Process program(command({"--text"}));
  // It writes no file, so only the process itself shows that it runs.
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_TRUE(program.is_running());
  program.send(SIGINT);
  const test::Ended ended = program.wait();
  EXPECT_EQ(ended.exit_code, 4);
  EXPECT_THAT(ended.out, test::reports("", "3/9"));
  EXPECT_THAT(ended.out, test::reports("stopped"));
}

TEST_F(Follow, ReportsARestartOfTheRun)
{
  add_steps(0);
  test::Process program(command({"--offscreen", path("pictures"), "--every", "0.1", "--size", "160x120"}));
  ASSERT_TRUE(comes_true([&] { return fs::exists(path("pictures/step_000002.png")); })) << program.said();
  fs::remove(store::journal_of(output_));
  add_steps(1);
  EXPECT_TRUE(comes_true([&] { return program.said().find("restarted") != std::string::npos; }));
  program.send(SIGTERM);
  EXPECT_EQ(program.wait().exit_code, 4);
}

TEST_F(Follow, TakesEveryWayToNameViews)
{
  add_steps(0);
  const auto picture = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"--once", "--offscreen", path("pictures"), "--size", "320x240"};
    words.insert(words.end(), more.begin(), more.end());
    const test::Ended ended = follow(words);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return test::read_bytes(path("pictures/step_000002.png"));
  };
  const std::string front = picture({"--views", "front"});
  EXPECT_NE(picture({"--views", "front,top,back"}), front);
  EXPECT_NE(picture({"--orient", "0,90,0;10,-20,30"}), picture({"--orient", "0,90,0"}));
  EXPECT_NE(picture({"--orient", "0,0,0", "--shift", "5,0,0"}), picture({"--orient", "0,0,0"}));
  EXPECT_NE(picture({"--views", "front", "--mode", "wire"}), front);
  EXPECT_NE(picture({"--views", "front", "--layers", "axes"}), front);
  EXPECT_EQ(picture({"--views", "front"}), front) << "equal runs give equal images";
}

TEST_F(Follow, ShowsTheViewsOfTheJob)
{
  model_.job.resolved =
      "[player]\ndisplay_px = [320, 240]\nrender = \"wire\"\n\n[[player.view]]\nnumber = 0\nshift_mm = [0, "
      "0, 0]\n"
      "orientation_deg = [0, 90, 0]\n";
  store::write_motion_model(start_, store::with_pending_cells(model_));
  add_steps(0);
  const auto picture = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"--once", "--offscreen", path("pictures")};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(follow(words).exit_code, 0);
    return test::read_bytes(path("pictures/step_000002.png"));
  };
  const std::string of_job = picture({});
  EXPECT_EQ(of_job, picture({"--size", "320x240"}));
  EXPECT_NE(of_job, picture({"--mode", "smooth"}));
  EXPECT_NE(of_job, picture({"--views", "front,lateral"}));
}

TEST_F(Follow, RefusesWhatItCannotDo)
{
  struct Row {
    std::vector<std::string> words;
    test::Refusal refusal;
  };
  for (const Row& row : {
           Row{{"--once"}, {.file = "--once"}},
           Row{{"--text", "--offscreen", "x"}, {"--text", "", "--offscreen"}},
           Row{{"--text", "--every", "1"}, {"--offscreen", "", "", {"--every", "--each"}}},
           Row{{"--text", "--steps", "some"}, {"--steps", "", "\"some\"", {"stable", "contact", "all"}}},
           Row{{"--offscreen", "x", "--each", "-1"}, {"--each", "", "-1", "1"}},
           Row{{"--offscreen", "x", "--every", "-1"}, {"--every", "", "-1.000000"}},
           Row{{"--offscreen", "x", "--views", "nowhere"}, {"--views", "", "nowhere"}},
           Row{{"--offscreen", "x", "--orient", "1,2"}, {"--orient", "", "\"1,2\""}},
           Row{{"--offscreen", "x", "--shift", "1,2,3;1,nan,2"}, {"--shift", "", "\"1,nan,2\""}},
           Row{{"--offscreen", "x", "--views", "front", "--shift", "1,2,3"}, {"--views", "", "front"}},
           Row{{"--offscreen", "x", "--layers", "skin"}, {"--layers", "", "skin"}},
           Row{{"--offscreen", "x", "--size", "1x1"}, {"--size", "", "1x1"}},
       }) {
    SCOPED_TRACE(testing::PrintToString(row.words));
    EXPECT_THAT(follow(row.words), test::refuses(row.refusal));
  }
  const test::Ended no_start = test::run(command({"--text"}, output_));
  EXPECT_THAT(no_start, test::refuses({output_, "name", "", "OUTPUT.start.h5"}));
  EXPECT_EQ(test::run(command({"--text"}, path("none.start.h5"))).exit_code, 2);
  const test::Ended no_screen = test::run({VRDA_PLAYER_PROGRAM, {"follow", start_}, {{"DISPLAY", ""}}, {}});
  EXPECT_EQ(no_screen.exit_code, 2) << no_screen.err;
}

/// Pixels of a colour on a screen.
int count(const view::Image& image, const view::VertexColour& colour)
{
  int n = 0;
  for (std::size_t at = 0; at < image.rgba.size(); at += 4)
    n += std::equal(colour.begin(), colour.begin() + 3, image.rgba.begin() + static_cast<std::ptrdiff_t>(at));
  return n;
}

TEST_F(Follow, FillsInTheGridInAWindow)
{
  const test::Screen screen;
  add_steps(0);
  test::Process program(command({"--size", "640x480", "--views", "front"}));
  const auto n_stable = [&] { return count(screen.picture(640, 480), show::colour_of(StepStatus::stable)); };
  // The legend's swatch is smaller than a cell.
  ASSERT_TRUE(comes_true([&] { return n_stable() > 2000; })) << program.said();
  const int with_two = n_stable();
  add_steps(1);
  EXPECT_TRUE(comes_true([&] { return n_stable() > with_two + with_two / 2; }));
  finish();
  EXPECT_TRUE(comes_true([&] { return n_stable() > 3 * with_two; }));
  const view::Image before = screen.picture(640, 480);
  EXPECT_TRUE(comes_true([&] { return screen.picture(640, 480).rgba != before.rgba; })) << "the motion plays";
  EXPECT_EQ(test::run({"/usr/bin/xdotool", {"key", "q"}, {}, {}}).exit_code, 0);
  EXPECT_EQ(program.wait().exit_code, 0);
}

}  // namespace vrda::follow_test
