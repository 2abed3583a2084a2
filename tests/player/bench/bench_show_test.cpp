// Frames of the bench without devices: invalid key input, damaged recordings, no allocation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include "bench/bench_show.hpp"
#include "bench/joint_stream.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"
#include "player/bench/bench_samples.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/allocation_count.hpp"
#include "support/input_error.hpp"
#include "support/models.hpp"
#include "support/process.hpp"
#include "support/refusal.hpp"
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

TEST(BenchView, ADevicesLineHasItsRateOrItsError)
{
  bench::DeviceReport report;
  report.peer = "/dev/ttyUSB0";
  report.link = bench::LinkState::up;
  report.rate_hz = 99.5;
  EXPECT_EQ(bench::device_text("board", report), "board /dev/ttyUSB0: up, 99.5 a second");
  report.link = bench::LinkState::closed;
  report.error_message = "not there";
  EXPECT_EQ(bench::device_text("board", report), "board /dev/ttyUSB0: closed, not there");
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

using testing::HasSubstr;

const std::vector<view::Monitor> two_monitors{{"DP-1", {0, 0, 1280, 1024}, 60},
                                              {"HDMI-1", {1280, 0, 1920, 1080}, 60}};

bench::BenchFile bench_with(const std::string& display)
{
  return test::bench_of(test::bench_head() + "[display]\n" + display + test::tracker_table +
                        test::two_bodies + test::board_table);
}

/// What is found of a window, or nothing.
std::string found(const bench::BenchFile& bench, const view::WindowGeometry& place,
                  const std::vector<view::Monitor>& monitors = two_monitors)
{
  const std::optional<InputError::Facts> facts = bench::window_mismatch(bench, place, monitors);
  return facts ? facts->found : "";
}

TEST(WindowCheck, NamesSizePlaceAndWhatNoScreenShows)
{
  const bench::BenchFile bench =
      bench_with("width = 1280\nheight = 1024\nlayout = \"quarters\"\nat = [0, 0]\n");
  EXPECT_EQ(found(bench, {0, 0, 1280, 1024}), "");
  EXPECT_EQ(found(bench, {0, 0, 1280, 996}), "a frame buffer of 1280 x 996");
  EXPECT_EQ(found(bench, {10, 37, 1280, 1024}), "a window at 10, 37");
  bench::BenchFile elsewhere = bench;
  elsewhere.display.at = {5000, 0};
  EXPECT_EQ(found(elsewhere, {5000, 0, 1280, 1024}), "a window off every screen (1280 x 1024 at 5000, 0)");
  elsewhere.display.at = {-640, 0};
  EXPECT_THAT(found(elsewhere, {-640, 0, 1280, 1024}), HasSubstr("partly off the screens"));
  elsewhere.display.at = {640, 0};
  EXPECT_EQ(found(elsewhere, {640, 0, 1280, 1024}), "") << "across two monitors";
  elsewhere.display.at.reset();
  EXPECT_THAT(found(elsewhere, {0, 2000, 1280, 1024}), HasSubstr("off every screen"))
      << "without a wanted place";
  EXPECT_EQ(found(elsewhere, {0, 2000, 1280, 1024}, {}), "") << "no monitor is known";
}

TEST(WindowCheck, OfMonitorsThatShowTheSameOneCounts)
{
  const bench::BenchFile bench = bench_with("width = 1280\nheight = 1024\nlayout = \"quarters\"\n");
  const std::vector<view::Monitor> copies{{"A", {0, 0, 1280, 1024}, 60}, {"B", {0, 0, 1280, 1024}, 60}};
  EXPECT_THAT(found(bench, {640, 0, 1280, 1024}, copies), HasSubstr("partly"));
}

TEST(Outputs, AreMonitorsByName)
{
  const bench::BenchFile one =
      bench_with("width = 1920\nheight = 1080\nlayout = \"side-by-side\"\noutputs = [\"HDMI-1\"]\n");
  EXPECT_EQ(bench::window_position(one, two_monitors), (std::array{1280, 0}));
  EXPECT_EQ(found(one, {1280, 0, 1920, 1080}), "");
  EXPECT_EQ(found(one, {0, 0, 1920, 1080}), "a window at 0, 0");
  EXPECT_EQ(found(one, {1280, 0, 1920, 1080}, {}), "\"HDMI-1\"") << "unplugged";
  const bench::BenchFile both =
      bench_with("width = 2560\nheight = 1024\nlayout = \"two-outputs\"\noutputs = [\"DP-1\", \"HDMI-1\"]\n");
  EXPECT_EQ(bench::window_position(both, two_monitors), (std::array{0, 0}));
  bench::BenchFile exchanged = both;
  std::swap(exchanged.display.outputs[0], exchanged.display.outputs[1]);
  const InputError::Facts facts = test::input_error([&] { bench::window_position(exchanged, two_monitors); });
  EXPECT_EQ(facts.field, "display.outputs");
  EXPECT_EQ(facts.found, "\"DP-1\" at 0, 0");
  EXPECT_THAT(facts.wanted, HasSubstr("at 2560, 0"));
  exchanged.display.outputs[0] = "VGA-9";
  EXPECT_THAT(test::input_error([&] { bench::window_position(exchanged, two_monitors); }).wanted,
              "one of DP-1, HDMI-1");
}

bench::Sample probe_sample(std::size_t tool, bench::ToolVisibility state, std::int64_t arrival_ns)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::tool_pose;
  sample.source = static_cast<std::uint16_t>(tool);
  sample.state = static_cast<std::uint8_t>(state);
  sample.arrival_ns = arrival_ns;
  sample.tool_pose = bench::place_of(test::some_pose(1));
  return sample;
}

TEST(JointStream, AProbeThatIsNoLongerSeenIsMarked)
{
  test::SmallBench bench(test::two_bodies_text() + "[calibration]\n");
  const std::vector<std::string>& tools = bench.bench.tracker->tools;
  const auto tool = static_cast<std::size_t>(std::ranges::find(tools, "probe") - tools.begin());
  ASSERT_LT(tool, tools.size());
  bench::ProbeTool probe(bench.bench, bench.calibration);
  const auto marks_at = [&](std::int64_t now_ns) {
    bench::StreamedFrame streamed;
    streamed.X_tracker_probe = probe.X_tracker_probe();
    streamed.probe = probe.status(now_ns);
    return bench::angles_text(streamed, Side::right, Eigen::Vector3d::Zero());
  };
  const auto names_probe = testing::HasSubstr("probe");
  EXPECT_THAT(marks_at(0), testing::Not(names_probe)) << "not used yet";
  probe.take(probe_sample(tool, bench::ToolVisibility::seen, ms_in_ns));
  EXPECT_TRUE(probe.X_tracker_probe());
  EXPECT_THAT(marks_at(ms_in_ns), testing::Not(names_probe));
  probe.take(probe_sample(tool, bench::ToolVisibility::missing, 2 * ms_in_ns));
  EXPECT_FALSE(probe.X_tracker_probe());
  EXPECT_THAT(marks_at(2001 * ms_in_ns), testing::HasSubstr("probe hidden for 2 s"));
  probe.take(probe_sample(tool, bench::ToolVisibility::seen, 2001 * ms_in_ns));
  EXPECT_THAT(marks_at(2001 * ms_in_ns), testing::Not(names_probe));
}

constexpr std::size_t n_frames = 8600;  // 143 s, longer than the run-up
constexpr std::size_t hidden_from = 600, turned_at = 300;

/// A moving femur with arrival jitter; a tibia that is hidden early and stays so; a potentiometer and keys
/// that change parameters at the beginning only; a lost and found board.
std::string recorded(const test::SmallBench& bench)
{
  std::vector<bench::RecordedFrame> frames;
  for (std::size_t k = 0; k < n_frames; ++k) {
    const auto now_ns = static_cast<std::int64_t>(k + 1) * 16'666'667;
    const std::int64_t arrival_ns = now_ns - static_cast<std::int64_t>(1 + k * 7919 % 5) * ms_in_ns;
    const std::int64_t device_ns = now_ns - 8 * ms_in_ns + 3'600'000 * ms_in_ns;
    const double flexion_rad = 0.7 + 0.3 * std::sin(0.01 * static_cast<double>(k));
    const Pose X_thigh = test::moved(test::some_pose(2), {{0.02, 0.01, 0.0}, {5.0, 0.0, 1.0}},
                                     1e-9 * 1.0 * static_cast<double>(now_ns));
    bench::RecordedFrame& frame = frames.emplace_back();
    frame.now_ns = now_ns;
    std::vector<bench::Sample>& samples = frame.samples;
    samples.push_back(test::place_sample(0, X_thigh, device_ns, arrival_ns));
    samples.push_back(k < hidden_from
                          ? test::place_sample(1, bench.X_tracker_shank(X_thigh, {flexion_rad, 0.02, 0.1}),
                                               device_ns, arrival_ns)
                          : test::hidden_sample(1, arrival_ns));
    if (k < 2 * turned_at)
      samples.push_back(test::potentiometer_sample(k < turned_at ? 300 : 700, arrival_ns));
    if (k == 100 || k == 400)
      samples.push_back(test::link_sample(
          bench::DeviceId::board, k == 100 ? bench::LinkState::closed : bench::LinkState::up, arrival_ns));
    if (k == 50) frame.keys.assign(3, {view::Key::right});
  }
  return test::recording_bytes({}, frames);
}

TEST(ReplayState, AJumpShowsTheFrameOfTheSession)
{
  const test::SmallBench small(test::two_bodies_text());
  const bench::BenchSetup setup{small.model, small.motion, small.frame, small.bench, small.calibration, {}};
  const std::string bytes = recorded(small);
  bench::RecordingReader reader = test::reader_of(bytes);
  bench::ReplayState played(setup, reader);
  for (std::size_t k = 0; k + 200 < n_frames; ++k) played.at(k);
  bench::ReplayState jumped(setup, reader);
  jumped.at(10);
  for (const std::size_t k : {n_frames - 200, n_frames - 1, n_frames - 2}) {
    SCOPED_TRACE(k);
    const bench::BenchFrame a = played.at(k), b = jumped.at(k);
    EXPECT_EQ(a.X_tracker_reference.matrix(), b.X_tracker_reference.matrix());
    EXPECT_EQ(a.X_tracker_moving.matrix(), b.X_tracker_moving.matrix());
    EXPECT_EQ(a.X_tracker_eyes.matrix(), b.X_tracker_eyes.matrix());
    EXPECT_EQ(a.pose.attitude.flexion_rad, b.pose.attitude.flexion_rad);
    for (std::size_t role = 0; role < a.bodies.size(); ++role) {
      EXPECT_EQ(a.bodies[role].is_live, b.bodies[role].is_live);
      EXPECT_EQ(a.bodies[role].was_seen, b.bodies[role].was_seen);
      EXPECT_NEAR(a.bodies[role].age_s, b.bodies[role].age_s, 0.02);
    }
    EXPECT_EQ(a.potentiometer.is_live, b.potentiometer.is_live);
    for (std::size_t p = 0; p < bench::parameters().size(); ++p)
      EXPECT_EQ(bench::value_of(played.state().values(), p), bench::value_of(jumped.state().values(), p));
  }
}

/// Two samples per picture, with a delay of 3 ms.
TEST(MotionCollector, GivesEveryPoseAtItsTime)
{
  const bench::Screw a_second{{0.5, -0.8, 0.3}, {200.0, -100.0, 50.0}};
  const Pose start = test::some_pose(3);
  bench::MotionCollector collector(test::SmallBench(test::rigid_text()).bench);
  for (int k = 0; k < 100; ++k) {
    bench::RecordedFrame picture;
    for (const int ms : {20 * k, 20 * k + 10})
      picture.samples.push_back(test::place_sample(0, test::moved(start, a_second, 0.001 * ms),
                                                   (5000 + ms) * ms_in_ns, (ms + 3) * ms_in_ns));
    collector.take(picture);
  }
  const std::vector<bench::TimedPose>& motion = collector.motion(bench::BodyRole::leg);
  ASSERT_EQ(motion.size(), 200u);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    EXPECT_NEAR(motion[k].time_s, 0.01 * static_cast<double>(k) + 0.003, 1e-9);
    EXPECT_LT(test::distance_of(motion[k].X, test::moved(start, a_second, 0.01 * static_cast<double>(k))),
              1e-9);
  }
  EXPECT_TRUE(collector.motion(bench::BodyRole::tibia).empty());
  // A constant twist is predicted exactly; the held pose has the error of the motion during the horizon.
  const std::vector<bench::BodyPrediction> predictions = bench::predictions_of(collector);
  ASSERT_EQ(predictions.size(), 3u);
  EXPECT_EQ(predictions[1].horizon_ms, 33.0);
  EXPECT_LT(predictions[1].error.shift_mm.predicted.percentile_95, 1e-6);
  EXPECT_GT(predictions[1].error.shift_mm.held.rms, 1.0);
}

}  // namespace vrda::bench_show_test
