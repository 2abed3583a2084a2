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
#include "show/run_panel.hpp"
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

  /// Two stable cells and one without contact; `n_contacts`: of each.
  void add_steps(int flexion, int n_contacts = 0)
  {
    store::OpenJournal journal = store::JournalWriter::open(store::journal_of(output_), std::string(64, 'a'));
    for (int j = 0; j < 3; ++j) {
      StepRecord r;
      r.key = {StepKind::row, flexion, j};
      r.status = j == 2 ? StepStatus::no_contact : StepStatus::stable;
      r.varus_rad = rad_from_deg(j - 1.0);
      for (int k = 0; k < n_contacts; ++k)
        r.contacts.push_back({{0.1 * k, 0.0, 0.0}, {0, -1, 0}, 0.0, 0, 0, 0});
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

TEST_F(Follow, ChosenSteps)
{
  add_steps(1, 1);
  core::FrameWriter moves =
      store::create_trace_journal(store::trace_journal_of(output_), std::string(64, 'a'));
  SearchTrace search;
  search.key = {StepKind::row, 1, 1};
  search.status = StepStatus::stable;
  search.moves.resize(4);
  search.moves[1].in_contact = search.moves[3].in_contact = true;
  moves.append(core::bytes_of_value(search));
  const auto n_pictures = [&](const std::string& steps) {
    const std::string out =
        follow({"--once", "--offscreen", path(steps), "--each", "1", "--size", "64x48", "--steps", steps})
            .out;
    return std::ranges::count(out, '\n');
  };
  EXPECT_EQ(n_pictures("stable"), 2);
  EXPECT_EQ(n_pictures("contact"), 2 + 2);
  EXPECT_EQ(n_pictures("all"), 3 + 4);
}

TEST_F(Follow, Contacts)
{
  const auto picture = [&](int n_contacts) {
    fs::remove(store::journal_of(output_));
    add_steps(0, n_contacts);
    EXPECT_EQ(follow({"--once", "--offscreen", path("pictures"), "--size", "160x120"}).exit_code, 0);
    return test::read_bytes(path("pictures/step_000002.png"));
  };
  const std::string one = picture(1);
  EXPECT_TRUE(one != picture(0));
  EXPECT_TRUE(one != picture(200)) << "more than there is room for at first";
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
