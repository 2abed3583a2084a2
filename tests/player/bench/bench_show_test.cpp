// Frames of the bench without devices: invalid key input, damaged recordings, no allocation.
#include "bench/bench_show.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <map>
#include <sstream>

#include "bench/bench_run.hpp"
#include "bench/recording.hpp"
#include "core/units.hpp"
#include "player/bench/bench_samples.hpp"
#include "player/bench/bench_texts.hpp"
#include "store/motion_model.hpp"
#include "support/allocation_count.hpp"
#include "support/input_error.hpp"
#include "support/models.hpp"
#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::bench_show_test {

using test::ms_in_ns;

constexpr std::int64_t picture_ns = 16 * ms_in_ns;
constexpr int n_pictures = 40;

std::vector<view::KeyPress> presses(int n, view::Key key, bool has_shift = false)
{
  return std::vector<view::KeyPress>(static_cast<std::size_t>(n), view::KeyPress{key, has_shift, false});
}

/// Selects the right eye's k1 from the first parameter, around the end of the list.
std::vector<view::KeyPress> to_right_k1()
{
  return presses(4, view::Key::up);
}

double right_k1(const bench::BenchState& state)
{
  return state.values().calibration.eyes.right.distortion.k1;
}

TEST(BenchView, AJointThatIsNotTheLegsIsAmber)
{
  test::SmallBench bench(test::two_bodies_text());
  store::MotionModel model = bench.model;
  Part& bone = model.reference.visual;
  bone.mesh.vertices_mm = Points::Identity(3, 3);
  bone.mesh.triangles.resize(1, 3);
  bone.mesh.triangles << 0, 1, 2;
  bone.component = {0};
  model.reference.components = {{"femur", "bone"}};
  bench::BenchView view(model, bench.motion, bench.bench, bench.calibration, {});
  ASSERT_FALSE(view.scene().drawables.empty());
  const Eigen::Vector3f own = view.scene().drawables.front().material.colour;
  const auto colour_at = [&](double flexion_deg, std::int64_t now_ns) {
    bench.take_leg(test::some_pose(1), {rad_from_deg(flexion_deg), 0.0, 0.0}, now_ns, now_ns);
    view.place(bench.state.frame(now_ns), bench.calibration);
    return view.scene().drawables.front().material.colour;
  };
  EXPECT_EQ(colour_at(60.0, ms_in_ns), own);
  EXPECT_NE(colour_at(120.0, 2 * ms_in_ns), own);
  EXPECT_EQ(colour_at(60.0, 3 * ms_in_ns), own);
}

TEST(BenchView, DrawsTheRequestedLayersAndRefusesOthers)
{
  const test::SmallBench bench(test::two_bodies_text());
  const auto shown = [&](const std::string& layers) {
    view::AppearanceOptions look;
    look.layers = layers;
    bench::BenchView view(bench.model, bench.motion, bench.bench, bench.calibration, look);
    bench::BenchFrame frame;
    frame.X_tracker_reference = test::some_pose(1);
    frame.pose = bench.motion.at({rad_from_deg(30.0), 0.0});
    view.place(frame, bench.calibration);
    std::vector<view::Drawable> found;
    for (const view::Drawable& drawable : view.scene().drawables) {
      if (drawable.layer == view::Layer::axes && drawable.is_shown) found.push_back(drawable);
    }
    return found;
  };
  EXPECT_TRUE(shown("none").empty());
  const std::vector<view::Drawable> axes = shown("axes");
  ASSERT_FALSE(axes.empty());
  // The flexion axis goes through the rotation centre of the tracked reference.
  const Eigen::Vector3d centre_mm = test::some_pose(1) * bench.model.rotation_centre_mm;
  EXPECT_LT((axes.front().X_world_mesh.translation() - centre_mm).norm(), 1e-9);
  EXPECT_EQ(test::input_error([&] { shown("banana"); }).file, "--layers");
  EXPECT_EQ(test::input_error([&] { shown("axes,labels"); }).file, "--layers");
}

TEST(BenchTake, EyesThatCannotBeDrawnForArePutBackToWhatTheyWereBefore)
{
  test::SmallBench bench(test::rigid_text());
  bench::PanelContent panel;
  bench::apply_input(bench.state, panel, to_right_k1(), {});
  ASSERT_EQ(bench::parameters()[bench.state.selected()].name, "right.k1");
  // The corner of 640 x 480 is at 1.25 units; folds there below k1 = -1 / (3 * 1.25^2) = -0.213.
  bench::apply_input(bench.state, panel, presses(20, view::Key::left, true), {});
  EXPECT_NEAR(right_k1(bench.state), -0.2, 1e-12);
  EXPECT_EQ(panel.message, "");
  bench::apply_input(bench.state, panel, presses(2, view::Key::left, true), {});
  EXPECT_NEAR(right_k1(bench.state), -0.2, 1e-12);
  EXPECT_THAT(panel.message, testing::HasSubstr("fold"));
  EXPECT_THAT(panel.message, testing::EndsWith(": restored"));
  bench::apply_input(bench.state, panel, presses(1, view::Key::right, true), {});
  EXPECT_NEAR(right_k1(bench.state), -0.19, 1e-12);
}

TEST(BenchTake, ThePotentiometerContinuesFromTheRestoredValue)
{
  test::SmallBench bench(test::rigid_text());
  bench::PanelContent panel;
  bench::apply_input(bench.state, panel, to_right_k1(), {});
  bench::apply_input(bench.state, panel, presses(20, view::Key::left, true), {});
  int k = 0;
  const auto turn = [&](int from, int to) {
    for (int n = 0; n <= 400; ++n, ++k) {
      const int count = n < 200 ? from + (to - from) * n / 200 : to;
      const bench::Sample sample = test::potentiometer_sample(count, k * 10 * ms_in_ns);
      bench::apply_input(bench.state, panel, {}, {&sample, 1});
    }
    return right_k1(bench.state);
  };
  turn(900, 900);
  // 80 steps of 0.001 down, of which 13 are usable; the value stops at the last one.
  EXPECT_NEAR(turn(900, 491), -0.213, 0.0015);
  EXPECT_THAT(panel.message, testing::EndsWith(": restored"));
  // 20 steps up from there; the rejected steps do not count.
  EXPECT_NEAR(turn(491, 593), -0.193, 0.0015);
}

class BenchReplay : public testing::Test {
 protected:
  BenchReplay()
  {
    store::MotionModel model = test::bench_model("right");
    test::add_bodies(model);
    store::write_motion_model(options_.file, model);
    const std::string text =
        test::bench_head("rigid") +
        "[display]\nwidth = 320\nheight = 256\nlayout = \"quarters\"\nrefresh_hz = 62.5\n" +
        test::tracker_table + "[body.leg]\ntool = \"leg\"\n";
    options_.bench = scratch_.write("bench.toml", text).string();
    options_.look.mode = view::DrawMode::smooth;
    options_.is_headless = options_.is_quiet = true;
    setup_.emplace(bench::read_bench_setup(options_));
  }

  std::string in_scratch(const std::string& name) const { return (scratch_.path() / name).string(); }

  static std::vector<view::KeyPress> keys_of(int picture)
  {
    if (picture == 2) return to_right_k1();
    if (picture == 5) return presses(15, view::Key::left, true);
    if (picture == 8) return presses(15, view::Key::left, true);  // a folding distortion is restored
    if (picture == 20) return presses(10, view::Key::right, true);
    return {};
  }

  /// The leg rotates and moves.
  static bench::Sample sample_of(int picture)
  {
    const bench::Screw a_second{{0.5, -0.8, 0.3}, {40.0, -20.0, 10.0}};
    const std::int64_t now_ns = picture * picture_ns;
    return test::place_sample(0, test::moved(Pose::Identity(), a_second, 0.016 * picture), now_ns + 1,
                              now_ns);
  }

  /// `pause_ns`: between the halves.
  void record(const std::string& log, std::int64_t pause_ns = 0) const
  {
    bench::Recorder recorder(log, setup_->facts);
    for (int k = 0; k < n_pictures; ++k) {
      const bench::Sample sample = sample_of(k);
      recorder.add(k * picture_ns + (2 * k < n_pictures ? 0 : pause_ns), keys_of(k), {&sample, 1});
    }
    recorder.close();
  }

  void replay(const std::string& log, const std::function<void(bench::BenchOptions&)>& change) const
  {
    bench::BenchOptions options = options_;
    options.bench.clear();
    options.replay = log;
    change(options);
    std::ostringstream data, messages;
    bench::replay_bench(options, {data, messages});
  }

  /// Number of frames of the video of a replay.
  std::string video_frames(const std::string& log, std::optional<double> speed) const
  {
    const std::string film = in_scratch("film.mp4");
    replay(log, [&](bench::BenchOptions& options) { options.video = film, options.speed = speed; });
    return test::run({"/usr/bin/ffprobe",
                      {"-v", "error", "-count_packets", "-show_entries", "stream=nb_read_packets", "-of",
                       "csv=p=0", film},
                      {},
                      {}})
        .out;
  }

  std::map<std::string, std::string> replayed(const std::string& log, const std::string& folder,
                                              double from_s, std::optional<double> speed) const
  {
    replay(log, [&](bench::BenchOptions& options) {
      options.pictures = in_scratch(folder);
      options.from_s = from_s;
      options.speed = speed;
    });
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(in_scratch(folder)))
      files[entry.path().filename()] = test::read_bytes(entry.path());
    return files;
  }

  test::Scratch scratch_;
  bench::BenchOptions options_ = [this] {
    bench::BenchOptions options;
    options.file = in_scratch("knee.h5");
    return options;
  }();
  std::optional<bench::BenchSetup> setup_;
};

TEST_F(BenchReplay, WhatCalibrationAloneTracksIsNotWaitedFor)
{
  EXPECT_EQ(setup_->bench.tracker->tools, (std::vector<std::string>{"leg"}));
  bench::BenchOptions options = options_;
  options.bench = scratch_.write("calibrated.toml", setup_->bench.text + "[calibration]\n").string();
  const bench::BenchSetup calibrated = bench::read_bench_setup(options);
  EXPECT_TRUE(calibrated.bench.calibration.is_present);
  EXPECT_EQ(calibrated.bench.tracker->tools, setup_->bench.tracker->tools);
}

TEST_F(BenchReplay, ACalibrationFileThatDoesNotExistIsRefusedUnlessItCanBeWritten)
{
  bench::BenchOptions options = options_;
  options.bench = scratch_.write("bench.toml", setup_->bench.text).string();
  options.calibration = (scratch_.path() / "mistyped.toml").string();
  EXPECT_EQ(test::input_error([&] { bench::read_bench_setup(options); }).file, options.calibration);
  EXPECT_TRUE(
      bench::read_bench_setup(options, bench::MissingCalibration::is_nominal).facts.calibration_text.empty());
}

TEST_F(BenchReplay, ADoubtfulPoseIsNamed)
{
  const auto doubt = [&] {
    bench::BenchState state(setup_->bench, setup_->calibration, setup_->motion, setup_->frame);
    bench::BenchOutput output(options_, *setup_);
    output.show(state, state.frame(0), 0, 0.0);
    return std::string(output.panel().doubt.data());
  };
  EXPECT_EQ(doubt(), "");
  store::GridB& plausibility = setup_->model.plausibility;
  plausibility = store::GridB::Constant(setup_->model.status.rows(), setup_->model.status.cols(),
                                        static_cast<std::int8_t>(Plausibility::dislocated));
  EXPECT_THAT(doubt(), testing::StartsWith("dislocated: "));
}

TEST_F(BenchReplay, FromWithinAndAtAnySpeedShowsThePicturesOfAWholeOne)
{
  const std::string log = in_scratch("a.log");
  record(log);
  const std::map<std::string, std::string> whole = replayed(log, "whole", 0.0, std::nullopt);
  ASSERT_EQ(whole.size(), static_cast<std::size_t>(n_pictures));
  EXPECT_EQ(replayed(log, "quick", 0.0, 100.0), whole);
  // Between the restored value and the next key, and after it.
  for (const int first : {15, 30}) {
    const std::string folder = "from " + std::to_string(first);
    const std::map<std::string, std::string> part =
        replayed(log, folder, 1e-9 * static_cast<double>(first * picture_ns), std::nullopt);
    ASSERT_EQ(part.size(), static_cast<std::size_t>(n_pictures - first));
    for (const auto& [name, bytes] : part) EXPECT_TRUE(whole.at(name) == bytes) << name;
  }
}

TEST_F(BenchReplay, AVideoTakesAsLongAsTheRecording)
{
  // 40 pictures in 39 x 16 ms; 63 frames a second: 0.624 s are 39.3 frames after the first.
  const std::string log = in_scratch("a.log"), paused = in_scratch("b.log");
  record(log);
  EXPECT_EQ(video_frames(log, std::nullopt), "40\n");
  EXPECT_EQ(video_frames(log, 2.0), "20\n");
  EXPECT_EQ(video_frames(log, 0.5), "79\n");
  record(paused, 1000 * ms_in_ns);
  EXPECT_EQ(video_frames(paused, std::nullopt), "103\n");
}

TEST_F(BenchReplay, ABenchFrameAllocatesNothingThoughTheCalibrationKeepsItsMarks)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  bench::CalibrationRecord& record = setup_->calibration.records[bench::CalibrationPart::viewport];
  record.date = "2026-11-22, a date too long for a short string";
  record.marks = {{"a task with a name that is long", {{1.0, 2.0}, {3.0, 4.0}}}};
  bench::BenchOutput show(options_, *setup_);
  bench::BenchState state(setup_->bench, setup_->calibration, setup_->motion, setup_->frame);
  const auto round = [&](int k) {
    const bench::Sample sample = sample_of(k);
    bench::apply_input(state, show.panel(), {}, {&sample, 1});
    show.show(state, state.frame(k * picture_ns), static_cast<std::uint64_t>(k), 0.016 * k);
  };
  for (int k = 1; k < 100; ++k) round(k);
  const long before = test::allocations_of_thread();
  for (int k = 100; k < 200; ++k) round(k);
  EXPECT_EQ(test::allocations_of_thread() - before, 0);
  const std::vector<int> counted(10);
  EXPECT_EQ(test::allocations_of_thread() - before, 1) << "the count counts";
}

}  // namespace vrda::bench_show_test
