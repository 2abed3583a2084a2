#include "show/show.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <sstream>

#include "store/motion_model.hpp"
#include "support/input_error.hpp"
#include "support/models.hpp"
#include "support/scratch.hpp"

namespace vrda::show::show_test {

using testing::ElementsAre;
using testing::HasSubstr;

/// Flexion 0 to 30 by 10, varus -1 to 1; the cell at 10 degrees, varus 1 is unsolved.
store::MotionModel small_model()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30};
  plan.varus_deg = {-1, 0, 1};
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  test::unsolve(model, 1, 2);
  test::add_smoothed(model, 1, [](int i, int) { return store::PoseCoordinates{0.0, 0.0, 0.0, 2.0 * i}; });
  return model;
}

class Show : public testing::Test {
 protected:
  Show() { store::write_motion_model(file_, small_model()); }

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
  const store::MotionModel pending = store::with_pending_cells(small_model());
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
  store::MotionModel model = small_model();
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

TEST_F(Show, Refusals)
{
  using O = ShowOptions;
  struct Row {
    std::string file_ends_with, field, found, wanted;
    void (*change)(O&);
  };
  const std::string with_video = "--video FILE with it";
  for (const Row& row : {
           Row{"window", "display", "no DISPLAY", "--offscreen",
               [](O& o) { o.folder.clear(), unsetenv("DISPLAY"), unsetenv("WAYLAND_DISPLAY"); }},
           Row{"--trace", "", "no --offscreen", "either of them",
               [](O& o) { o.folder.clear(), o.trace = "a.trace.h5"; }},
           Row{"--views", "", "front,lateral", "one view",
               [](O& o) { o.folder.clear(), o.views = "front,lateral"; }},
           Row{"--speed", "", "no --video", with_video, [](O& o) { o.speed_deg_s = 20.0; }},
           Row{"--to-and-fro", "", "no --video", with_video, [](O& o) { o.is_to_and_fro = true; }},
           Row{"--fps", "", "no --video", with_video, [](O& o) { o.frames_per_s = 25; }},
           Row{"--video", "", "a.avi", ".mp4, .webm or .gif", [](O& o) { o.video = "a.avi"; }},
           Row{"--fps", "", "0", "1 to 120", [](O& o) { o.video = "a.mp4", o.frames_per_s = 0; }},
           Row{"--speed", "", "-1", "0.1 to 3600", [](O& o) { o.video = "a.mp4", o.speed_deg_s = -1.0; }},
           Row{"--varus", "", "nan", "-360 to 360", [](O& o) { o.varus_deg = std::nan(""); }},
           Row{"sample.h5", "--set", "degree_9", "degree_1, raw", [](O& o) { o.set = "degree_9"; }},
           Row{"--views", "", "below", "oblique", [](O& o) { o.views = "front,below"; }},
           Row{"--layers", "", "gapes", "gaps, ligaments", [](O& o) { o.appearance.layers = "gapes"; }},
           Row{"sample.h5", "--layers", "ligaments", "layer",
               [](O& o) { o.appearance.layers = "axes,ligaments"; }},
           Row{"--see-through", "", "all", "both", [](O& o) { o.appearance.see_through = "all"; }},
           Row{"--hide", "", "both", "femur or tibia", [](O& o) { o.appearance.hidden = "both"; }},
           Row{"absent.toml", "", "file", "schemas/lights.md",
               [](O& o) { o.appearance.lights = "absent.toml"; }},
           Row{"--size", "", "0x0", "16 to 4096", [](O& o) { o.size = "0x0"; }},
           Row{"--flexion", "", "90:0:5", "A at most B", [](O& o) { o.flexion = "90:0:5"; }},
           Row{"absent.h5", "", "No such file", "motion model", [](O& o) { o.file = "absent.h5"; }},
           Row{"sample.h5", "--offscreen", "", "folder", [](O& o) { o.folder = o.file; }},
       }) {
    SCOPED_TRACE(row.file_ends_with + row.field + row.found);
    ShowOptions given = options();
    row.change(given);
    const InputError::Facts facts = test::input_error([&] { run(given); });
    EXPECT_THAT(facts.file, testing::EndsWith(row.file_ends_with));
    EXPECT_EQ(facts.field, row.field);
    EXPECT_THAT(facts.found, HasSubstr(row.found));
    EXPECT_THAT(facts.wanted, HasSubstr(row.wanted));
    EXPECT_FALSE(std::filesystem::is_directory(folder_));
  }
}

/// Flexion 20, 0, 30, 10 at 0, 0.5, 1 and 2 s.
store::MotionModel walk()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30};
  plan.varus_deg = {0};
  store::MotionModel model = test::frames_of(test::model_of(plan), {2, 0, 3, 1}, {0.0, 0.5, 1.0, 2.0});
  test::add_bodies(model);
  return model;
}

class ShowFrames : public Show {
 protected:
  ShowFrames() { store::write_motion_model(file_, walk()); }
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

TEST_F(ShowFrames, ChoosesByKeysOnly)
{
  for (const auto& set : std::vector<std::function<void(ShowOptions&)>>{
           [](auto& o) { o.flexion = "0:30:10"; }, [](auto& o) { o.varus_deg = 1.0; }}) {
    ShowOptions given = options();
    set(given);
    EXPECT_THAT(test::input_error([&] { run(given); }).wanted, HasSubstr("--key"));
  }
  store::write_motion_model(file_, small_model());
  ShowOptions given = options();
  given.frame = "1";
  EXPECT_EQ(test::input_error([&] { run(given); }).field, "--key");
}

// Views size and mode of the job hold unless options are given.
TEST_F(Show, JobDefaults)
{
  store::MotionModel model = small_model();
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

}  // namespace vrda::show::show_test
