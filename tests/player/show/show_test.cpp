// Images and videos of a motion model and of a trace.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <sstream>

#include "core/text.hpp"
#include "show/show.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"
#include "support/input_error.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "support/traces.hpp"

namespace vrda::show::show_test {

using testing::ElementsAre;
using testing::HasSubstr;

class Show : public testing::Test {
 protected:
  Show() { store::write_motion_model(file_, test::small_model()); }

  ShowOptions options() const
  {
    ShowOptions options;
    options.file = file_;
    options.folder = folder_;
    options.size = "64x48";
    options.views = "front";
    return options;
  }
  ShowSummary run(const ShowOptions& options) { return show(options, {data_, messages_}); }

  /// Names of the files written, sorted, which must be the paths on standard output.
  std::vector<std::string> stills() const
  {
    std::vector<std::string> names, reported;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      names.push_back(entry.path().filename());
    std::istringstream lines(data_.str());
    for (std::string line; std::getline(lines, line);)
      reported.push_back(std::filesystem::path(line).filename());
    std::ranges::sort(names);
    std::ranges::sort(reported);
    EXPECT_EQ(names, reported);
    return names;
  }

  test::Scratch scratch_;
  std::string file_ = (scratch_.path() / "sample.h5").string();
  std::string folder_ = (scratch_.path() / "pictures").string();
  std::ostringstream data_, messages_;
};

TEST_F(Show, Images)
{
  ShowOptions given = options();
  given.views = "front,top";
  given.flexion = "0:30:15";
  const ShowSummary summary = run(given);
  EXPECT_EQ(summary.n_images, 6);
  EXPECT_EQ(summary.n_unsolved, 0);
  EXPECT_THAT(stills(), ElementsAre("front_flexion_000.png", "front_flexion_015.png", "front_flexion_030.png",
                                    "top_flexion_000.png", "top_flexion_015.png", "top_flexion_030.png"));
  EXPECT_THAT(messages_.str(), HasSubstr("set degree_1, 3 attitudes, 6 "));
}

// Draws beyond the range at its end once and says so.
TEST_F(Show, BeyondTheRange)
{
  ShowOptions given = options();
  given.flexion = "20:50:10";
  given.varus_deg = 3.0;
  EXPECT_EQ(run(given).n_images, 2);
  EXPECT_THAT(stills(), ElementsAre("front_flexion_020.png", "front_flexion_030.png"));
  EXPECT_THAT(messages_.str(), HasSubstr("--flexion: found 40, wanted 0 to 30 degrees"));
  const std::string varus = "--varus: found 3, wanted -1 to 1 degrees: drawn at 1";
  EXPECT_THAT(messages_.str(), HasSubstr(varus));
  EXPECT_EQ(messages_.str().find(varus), messages_.str().rfind(varus));  // once
}

TEST_F(Show, FreeVarus)
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30};
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return 0.5 - 0.1 * flexion_deg; };
  plan.turning_delta = [](double flexion_deg) {
    return Eigen::Vector3d(0.001 * flexion_deg, 1.0, 0.0).normalized();
  };
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  store::write_motion_model(file_, model);
  ShowOptions given = options();
  given.flexion = "0:30:10";
  EXPECT_EQ(run(given).n_images, 4);
  EXPECT_EQ(messages_.str().find("varus"), std::string::npos);
  given.varus_deg = 1.0;
  EXPECT_EQ(run(given).n_images, 4);
  const std::string reported = "--varus: found 1,";
  EXPECT_THAT(messages_.str(), HasSubstr(reported));
  EXPECT_EQ(messages_.str().find(reported), messages_.str().rfind(reported));  // once
}

// Leaves out attitudes without an answer and names them.
TEST_F(Show, UnsolvedAttitude)
{
  ShowOptions given = options();
  given.set = "raw";
  given.flexion = "0:30:10";
  given.varus_deg = 0.5;
  const ShowSummary summary = run(given);
  EXPECT_EQ(summary.n_images, 3);
  EXPECT_EQ(summary.n_unsolved, 1);
  EXPECT_THAT(stills(),
              ElementsAre("front_flexion_000.png", "front_flexion_020.png", "front_flexion_030.png"));
  EXPECT_THAT(messages_.str(), HasSubstr("flexion 10, varus 0.5:"));
  EXPECT_THAT(messages_.str(), HasSubstr("unsolved_cell"));
}

// Without any solved cell there is nothing to draw.
TEST_F(Show, NothingSolved)
{
  const store::MotionModel pending = store::with_pending_cells(test::small_model());
  store::write_motion_model(file_, pending);
  const ShowSummary summary = run(options());
  EXPECT_EQ(summary.n_images, 0);
  EXPECT_EQ(summary.n_unsolved, 7);
  EXPECT_THAT(messages_.str(), HasSubstr(": varus 0 "));
  EXPECT_FALSE(std::filesystem::exists(folder_));
}

// A film has a frame for each angle or plays at a speed.
TEST_F(Show, VideoFrames)
{
  struct Row {
    std::optional<std::string> flexion;
    std::optional<double> speed_deg_s;
    bool is_to_and_fro;
    const char* reported;
  };
  const std::string film = (scratch_.path() / "film.gif").string();
  for (const Row& row :
       {Row{"0:30:10", {}, false, "film.gif: 4 frames, 10 "}, Row{"0:30:10", {}, true, "film.gif: 6 frames"},
        Row{"0:30:10", 50.0, false, "film.gif: 7 frames"}, Row{{}, {}, false, "film.gif: 11 frames"},
        Row{"20", {}, true, "film.gif: 1 frame,"}}) {
    SCOPED_TRACE(row.reported);
    ShowOptions given = options();
    given.folder.clear();
    given.video = film;
    given.views = "front,top";
    given.frames_per_s = 10;
    given.flexion = row.flexion;
    given.speed_deg_s = row.speed_deg_s;
    given.is_to_and_fro = row.is_to_and_fro;
    data_.str("");
    messages_.str("");
    EXPECT_EQ(run(given).n_images, 0);
    EXPECT_EQ(data_.str(), film + "\n");
    EXPECT_THAT(messages_.str(), HasSubstr(row.reported));
    EXPECT_TRUE(std::filesystem::remove(film));
  }
}

TEST_F(Show, VideoWithoutPose)
{
  store::MotionModel model = test::small_model();
  test::unsolve(model, 1, 1);
  store::write_motion_model(file_, model);
  ShowOptions given = options();
  given.folder.clear();
  given.set = "raw";
  given.varus_deg = 0.0;
  given.flexion = "0:30:30";  // both image angles are solved
  given.speed_deg_s = 25.0;
  given.frames_per_s = 10;
  given.video = (scratch_.path() / "film.gif").string();
  EXPECT_EQ(run(given).n_unsolved, 1);
  EXPECT_THAT(messages_.str(), HasSubstr("flexion 2.5 to 17.5: neighbouring cells are unsolved, the video "
                                         "shows only the fixed object"));
  EXPECT_THAT(messages_.str(), HasSubstr("film.gif: 13 frames"));
}

class ShowFrames : public Show {
 protected:
  ShowFrames() { store::write_motion_model(file_, test::small_sequence()); }
};

TEST_F(ShowFrames, DrawsFramesByTheirKeys)
{
  EXPECT_EQ(run(options()).n_images, 4);
  EXPECT_THAT(stills(), ElementsAre("front_frame_000.0.png", "front_frame_000.5.png", "front_frame_001.0.png",
                                    "front_frame_002.0.png"));
  EXPECT_EQ(messages_.str().find("flexion"), std::string::npos);
}

TEST_F(ShowFrames, ChosenKeys)
{
  ShowOptions given = options();
  given.frame = "0.25:3:1.25";
  EXPECT_EQ(run(given).n_images, 3);
  EXPECT_THAT(stills(),
              ElementsAre("front_frame_000.25.png", "front_frame_001.50.png", "front_frame_002.00.png"));
  EXPECT_THAT(messages_.str(), HasSubstr("--key: found 2.75, wanted 0 to 2"));
}

// Views size and mode of the job hold unless options are given.
TEST_F(Show, JobDefaults)
{
  store::MotionModel model = test::small_model();
  model.job.resolved =
      "[player]\ndisplay_px = [80, 60]\nzoom = 2\nrender = \"wire\"\n"
      "[[player.view]]\nnumber = 2\norientation_deg = [0, 90, 0]\n[[player.view]]\nnumber = 5\n";
  store::write_motion_model(file_, model);
  ShowOptions given = options();
  given.size = given.views = "";
  given.flexion = "0";
  EXPECT_EQ(run(given).n_images, 2);
  EXPECT_THAT(stills(), ElementsAre("view_2_flexion_000.png", "view_5_flexion_000.png"));
  const ResolvedPictures look = resolved_pictures(given, model);
  EXPECT_EQ(look.size.width, 80);
  EXPECT_EQ(look.size.height, 60);
  EXPECT_EQ(look.zoom, 2.0);
  EXPECT_EQ(look.appearance.mode, view::DrawMode::wire);
  given.has_mode = true;
  given.views = "top";
  given.size = "64x48";
  const ResolvedPictures own = resolved_pictures(given, model);
  EXPECT_EQ(own.size.width, 64);
  EXPECT_EQ(own.zoom, 1.0);
  ASSERT_EQ(own.views.size(), 1u);
  EXPECT_EQ(own.views[0].name, "top");
  EXPECT_EQ(own.appearance.mode, given.appearance.mode);
}

class ShowTrace : public testing::Test {
 protected:
  ShowTrace()
  {
    test::ModelPlan plan;
    plan.flexion_deg = {0, 10};
    plan.varus_deg = {-1, 0, 1};
    store::MotionModel model = test::model_of(plan);
    test::add_bodies(model);
    store::write_motion_model(options_.file, model);
    store::write_trace(options_.trace, test::trace_beside(model));
    options_.size = "64x48";
    options_.views = "front";
  }

  int run(const ShowOptions& options)
  {
    data_.str("");
    return show(options, {data_, messages_}).n_images;
  }

  std::vector<std::string> names() const
  {
    std::vector<std::string> names;
    std::istringstream lines(data_.str());
    for (std::string line; std::getline(lines, line);) {
      EXPECT_TRUE(std::filesystem::exists(line));
      names.push_back(std::filesystem::path(line).filename());
    }
    return names;
  }

  std::string still(const std::string& name) const { return test::read_bytes(options_.folder + "/" + name); }

  test::Scratch scratch_;
  std::ostringstream data_, messages_;
  ShowOptions options_ = [this] {
    ShowOptions options;
    options.file = (scratch_.path() / "knee.h5").string();
    options.trace = (scratch_.path() / "knee.trace.h5").string();
    options.folder = (scratch_.path() / "film").string();
    return options;
  }();
};

TEST_F(ShowTrace, EveryMove)
{
  EXPECT_EQ(run(options_), 1 + test::n_moves_of_a_cell);
  const std::vector<std::string> frames = names();
  EXPECT_EQ(frames.front(), "front_frame_0000.png");
  EXPECT_EQ(frames.back(), "front_frame_0008.png");
  EXPECT_TRUE(std::is_sorted(frames.begin(), frames.end()));
  EXPECT_THAT(messages_.str(), HasSubstr("flexion 0, varus 0, 9 frames, 9 "));
  // The last free trial and the step that ends there have the same pose; seed and end differ.
  EXPECT_EQ(still("front_frame_0004.png"), still("front_frame_0005.png"));
  EXPECT_NE(still("front_frame_0000.png"), still("front_frame_0008.png"));
}

TEST_F(ShowTrace, ContactOnly)
{
  options_.contact_only = true;
  options_.views = "front,top";
  options_.flexion = "10";
  options_.varus_deg = 1.0;
  EXPECT_EQ(run(options_), 2 * test::n_touches_of_a_cell);
  EXPECT_THAT(names(), ElementsAre("front_frame_0000.png", "front_frame_0001.png", "front_frame_0002.png",
                                   "top_frame_0000.png", "top_frame_0001.png", "top_frame_0002.png"));
}

}  // namespace vrda::show::show_test
