#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <random>
#include <set>

#include "bench/calibration_file.hpp"
#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::bench_files_test {

using namespace bench;
using test::bench_head, test::bench_of, test::bench_text, test::display_table, test::tracker_table,
    test::two_bodies;
using Names = std::vector<std::string>;

const std::string shared = display_table + tracker_table, quarters = "layout = \"quarters\"\n";
const std::string three_markers =
    "markers = [\"a\", \"b\", \"c\"]\nmarkers_mm = [0, 0, 0, 50, 0, 0, 0, 40, 0]\n";
const std::string aruco = bench_head() + "tracker = \"aruco\"\n" + display_table;

std::string display(const std::string& lines)
{
  return bench_head() + "[display]\nwidth = 1280\nheight = 1024\n" + lines + tracker_table + two_bodies;
}

Names tools(const std::string& text)
{
  return bench_of(text).tracker->tools;
}

TEST(BenchFile, Examples)
{
  const BenchFile desk = read_bench_file(VRDA_JOBS "/bench-desk.toml");
  EXPECT_EQ(desk.text, test::read_bytes(VRDA_JOBS "/bench-desk.toml"));
  EXPECT_EQ(desk.title, "Desk");
  EXPECT_EQ(desk.leg, LegKind::two_bodies);
  EXPECT_EQ(desk.head, HeadKind::stage);
  EXPECT_EQ(desk.tracker->tools, (Names{"femur", "tibia", "probe", "marker"}));
  EXPECT_TRUE(desk.board->has_stage && desk.board->has_potentiometer);
  EXPECT_TRUE(read_bench_file(VRDA_JOBS "/bench-webcam.toml").camera);
  EXPECT_EQ(read_bench_file(VRDA_JOBS "/plus/bench.toml").tracker->tools,
            (Names{"FemurToTracker", "TibiaToTracker", "ProbeToTracker"}));
  // The tools of the bench are those of the trackers' files for PlusServer.
  for (const std::string tracker : {"polaris", "optitrack", "vicon", "aruco"}) {
    const std::string text = test::read_bytes(VRDA_JOBS "/plus/" + tracker + ".xml");
    for (const std::string tool : {"Femur", "Tibia", "Probe"}) {
      EXPECT_THAT(text, testing::HasSubstr("<Transform Name=\"" + tool + "ToTracker\" />"));
      EXPECT_THAT(text, testing::HasSubstr("<DataSource Type=\"Tool\" Id=\"" + tool + "\""));
    }
    EXPECT_THAT(text, testing::HasSubstr("ListeningPort=\"18944\""));
    EXPECT_THAT(text, testing::HasSubstr("SendValidTransformsOnly=\"TRUE\""));
  }
}

TEST(BenchFile, Windows)
{
  struct Row {
    std::string lines;
    view::Viewport left, right;
  };
  for (const Row& row : {
           Row{quarters, {640, 16, 640, 480}, {640, 528, 640, 480}},
           Row{"layout = \"side-by-side\"\n", {0, 0, 640, 1024}, {640, 0, 640, 1024}},
           Row{"layout = \"top-bottom\"\n", {0, 0, 1280, 512}, {0, 512, 1280, 512}},
           Row{"layout = \"two-outputs\"\n", {0, 0, 640, 1024}, {640, 0, 640, 1024}},
           Row{"layout = \"side-by-side\"\nleft_window = [10, 20, 300, 400]\n",
               {10, 20, 300, 400},
               {640, 0, 640, 1024}},
           Row{"layout = \"top-bottom\"\nright_window = [0, 600, 1280, 424]\n",
               {0, 0, 1280, 512},
               {0, 600, 1280, 424}},
       }) {
    SCOPED_TRACE(row.lines);
    const DisplaySettings settings = bench_of(display(row.lines)).display;
    EXPECT_EQ(settings.windows.left, row.left);
    EXPECT_EQ(settings.windows.right, row.right);
  }
}

TEST(BenchFile, HalvedDisplay)
{
  const BenchFile bench = bench_of(
      display("layout = \"side-by-side\"\nmirror = true\nhalf_width = true\noutputs = [\"HDMI-1\"]\n"));
  EXPECT_EQ(bench.display.reflection, (view::Reflection{true, false}));
  EXPECT_EQ(bench.display.outputs, Names{"HDMI-1"});
  EXPECT_TRUE(bench_of(display(quarters + "flip = true\n")).display.reflection.is_flipped);
  EXPECT_EQ(bench_of(display(quarters + "at = [-1280, 24]\n")).display.at, (std::array<int, 2>{-1280, 24}));
  // A wide pixel: the same angles in half the columns.
  const view::Eye eye = nominal_calibration(bench).eyes.left;
  const view::Eye usual = nominal_calibration(bench_of(bench_text())).eyes.left;
  EXPECT_EQ(eye.distance_px, 0.5 * usual.distance_px);
  EXPECT_EQ(view::distance_y_px(eye), view::distance_y_px(usual));
  EXPECT_EQ(eye.distortion.pixel_aspect, eye.pixel_aspect);
}

TEST(BenchFile, Tools)
{
  EXPECT_EQ(tools(bench_head("rigid") + shared + "[body.leg]\ntool = \"thigh\"\n"), Names{"thigh"});
  // In role order, not in file order.
  EXPECT_EQ(tools(bench_head("two-bodies", "tracker") + shared + "[body.head]\ntool = \"h\"\n[body.tibia]\n" +
                  three_markers + "[body.femur]\ntool = \"f\"\n"),
            (Names{"f", "a", "b", "c", "h"}));
  EXPECT_EQ(tools(bench_text()), (Names{"femur", "tibia"}));
  EXPECT_EQ(tools(bench_text() + "[calibration]\n"), (Names{"femur", "tibia", "probe", "marker"}));
  EXPECT_EQ(tools(bench_text() + "[calibration]\nprobe = \"wand\"\nmarker = \"wand\"\n"),
            (Names{"femur", "tibia", "wand"}));
  EXPECT_EQ(tools(bench_text() + "[calibration]\nmarker = \"tibia\"\n"), (Names{"femur", "tibia", "probe"}));
}

TEST(BenchFile, Markers)
{
  const std::string rigid = bench_head("rigid") + shared + "[body.leg]\n";
  const BenchFile bench = bench_of(rigid + three_markers + "marker_interval_ms = 0.5\n");
  const BodySettings& leg = bench.bodies[0].value();
  ASSERT_EQ(leg.markers_body_mm.size(), 3u);
  EXPECT_EQ(leg.markers_body_mm[2], Eigen::Vector3d(0, 40, 0));
  EXPECT_EQ(leg.marker_interval_ms, 0.5);
  EXPECT_EQ(bench.simulation.firing_interval_ms, 0.5);
  EXPECT_FALSE(bench.bodies[1] || bench.bodies[2] || bench.bodies[3]);
  // Positions may be missing before they are measured.
  const std::string text = rigid + "markers = [\"a\", \"b\", \"c\"]\n";
  const BenchFile unmeasured = parse_bench_file(text, "bench.toml", MarkerPositions::optional);
  EXPECT_EQ(unmeasured.tracker->tools, (Names{"a", "b", "c"}));
  EXPECT_TRUE(unmeasured.bodies[0]->markers_body_mm.empty());
}

TEST(BenchFile, Webcam)
{
  const BenchFile bench = bench_of(aruco + two_bodies);
  EXPECT_EQ(bench.camera->device, "/dev/video0");
  EXPECT_EQ(bench.tracker->program, (Names{"vrda-webcam", "track", bench.path}));
  EXPECT_EQ(bench.tracker->tools, (Names{"femur", "tibia"}));
  EXPECT_EQ(bench.tracker->stale_after_ms, 200.0);
  const BenchFile other =
      bench_of(aruco + two_bodies + "[camera]\ndevice = \"a.mp4\"\nfold_deg = 100\nstale_after_ms = 500\n");
  EXPECT_EQ(other.camera->device, "a.mp4");
  EXPECT_EQ(other.camera->fold_rad, rad_from_deg(100.0));
  EXPECT_EQ(other.tracker->stale_after_ms, 500.0);
  EXPECT_FALSE(bench_of(bench_text()).camera);
}

/// Everything that a bench file sets, in a fixed order.
std::vector<double> numbers_of(const BenchFile& bench)
{
  const TrackerSettings& t = *bench.tracker;
  const BoardSettings& b = *bench.board;
  const SimulationScript& s = bench.simulation;
  const CalibrationSettings& c = bench.calibration;
  std::vector<double> all{bench.prediction_ms,
                          bench.display.refresh_hz,
                          double(t.port),
                          t.stale_after_ms,
                          t.tdata_interval_ms,
                          double(b.baud),
                          b.rate_hz,
                          bench.stage_mm_per_count,
                          double(bench.filter.is_on),
                          bench.filter.least_cutoff_hz,
                          bench.filter.slope,
                          double(s.seed),
                          double(s.side == Side::left),
                          s.rate_hz,
                          s.jitter_ms,
                          s.drop_rate,
                          s.noise_mm,
                          s.noise_rad,
                          double(s.is_looped),
                          s.potentiometer_noise_counts,
                          s.sway_mm,
                          s.sway_s,
                          s.clock.offset_s,
                          s.clock.drift_ppm,
                          double(c.edge_repeats),
                          c.screen_sd_mm,
                          double(c.is_grid_adjusted),
                          double(c.grid_columns),
                          double(c.grid_rows),
                          double(c.grid_repeats),
                          double(c.rectangle_repeats),
                          c.alignment_sd_rad,
                          c.sight_sd_px,
                          double(c.has_pupillometer),
                          c.pupillometer_sd_mm,
                          c.eye_height_sd_mm,
                          double(c.rail_samples),
                          double(c.pivot_samples),
                          double(c.hold_samples),
                          double(c.bullseyes),
                          double(c.is_model_adjusted),
                          double(c.model_repeats),
                          double(c.bends),
                          double(c.bend_samples),
                          c.functional.tracker_sd_mm,
                          c.functional.tracker_sd_rad,
                          c.functional.model_sd_mm,
                          c.functional.model_sd_rad};
  for (const LegKey& k : s.leg) all.insert(all.end(), {k.time_s, k.flexion_deg, k.varus_deg});
  for (const PathPoint& k : s.stage) all.insert(all.end(), {k.time_s, k.value});
  for (const PathPoint& k : s.potentiometer) all.insert(all.end(), {k.time_s, k.value});
  for (const Occlusion& o : s.occlusions) all.insert(all.end(), {o.from_s, o.to_s, o.every_s});
  for (const ClockStep& step : s.clock.steps) all.insert(all.end(), {step.at_s, step.by_ms});
  for (const CalibrationRectangle& r : c.rectangles) all.insert(all.end(), {r.width_mm, r.depth_mm});
  return all;
}

Names words_of(const BenchFile& bench)
{
  return {bench.tracker->host, bench.potentiometer, bench.simulation_address, bench.calibration.probe,
          bench.calibration.marker};
}

/// The defaults of the schema are those of the structs.
TEST(BenchFile, Defaults)
{
  const BenchFile bench = bench_of(bench_head() + display_table + "[tracker]\n" + two_bodies +
                                   "[board]\nport = \"p\"\n[calibration]\n");
  BenchFile defaults;
  defaults.tracker.emplace();
  defaults.board.emplace();
  EXPECT_EQ(numbers_of(bench), numbers_of(defaults));
  EXPECT_EQ(words_of(bench), words_of(defaults));
}

TEST(BenchFile, EveryKey)
{
  const BenchFile bench = bench_of(
      "prediction_ms = 33\n" + bench_head() + display_table +
      "refresh_hz = 75\n[tracker]\nhost = \"10.0.0.2\"\nport = 5000\nstale_after_ms = 40\n"
      "tdata_interval_ms = 10\n" +
      two_bodies +
      "[board]\nport = \"/dev/ttyUSB0\"\nbaud = 57600\nrate_hz = 50\nstage_mm_per_count = -0.01\n"
      "potentiometer = \"prediction\"\n[filter]\non = false\nleast_cutoff_hz = 3\nslope = 0.5\n"
      "[simulation]\naddress = \"0.0.0.0\"\nseed = 7\nside = \"left\"\nrate_hz = 60\njitter_ms = 1\n"
      "drop_rate = 0.25\nnoise_mm = 0.5\nnoise_deg = 2\nloop = false\nleg = [[0, 0, 0], [2, 80, 1]]\n"
      "stage = [[0, 0], [1, 5]]\npotentiometer = [[0, 0], [2, 1000]]\npotentiometer_noise_counts = 3\n"
      "femur = [1, 2, 3, 90, 0, 0]\nsway_mm = 4\nsway_s = 6\nclock_offset_s = 5\nclock_drift_ppm = -3\n"
      "[[simulation.occlusion]]\ntool = \"femur\"\nfrom_s = 1\nto_s = 2\nevery_s = 9\n"
      "[[simulation.clock_step]]\nat_s = 3\nby_ms = -20\n"
      "[calibration]\nedge_repeats = 5\nscreen_sd_mm = 0.2\ndistortion = \"adjust\"\ngrid = [9, 4]\n"
      "grid_repeats = 4\nrectangles = [[100, 0], [120, 80]]\nrectangle_repeats = 6\n"
      "alignment_sd_deg = 0.5\nsight_sd_px = 2\npupillometer = false\npupillometer_sd_mm = 0.3\n"
      "eye_height_sd_mm = 0.7\nprobe = \"wand\"\nmarker = \"dot\"\nrail_samples = 20\n"
      "pivot_samples = 21\nhold_samples = 22\nbullseyes = 7\nmodel = \"adjust\"\nmodel_repeats = 8\n"
      "bends = 3\nbend_samples = 99\ntracker_sd_mm = 0.4\ntracker_sd_deg = 0.6\nmodel_sd_mm = 2\n"
      "model_sd_deg = 3\n"
      "[[calibration.point]]\nname = \"a\"\nmm = [1, 2, 3]\n[[calibration.point]]\nname = \"b\"\n"
      "mm = [4, 5, 6]\ntarget = true\n[[calibration.tibia_point]]\nname = \"a\"\nmm = [7, 8, 9]\n"
      "[[calibration.landmarks]]\nname = \"width\"\nmodel_mm = 81.5\n");
  const double deg = rad_from_deg(1.0);
  EXPECT_EQ(
      numbers_of(bench),
      (std::vector<double>{
          33,  75,        5000, 40,      10,   57600, 50,      -0.01, 0,  3,         0.5 * deg_from_rad(1.0),
          7,   1,         60,   1,       0.25, 0.5,   2 * deg, 0,     3,  4,         6,
          5,   -3,        5,    0.2,     1,    9,     4,       4,     6,  0.5 * deg, 2,
          0,   0.3,       0.7,  20,      21,   22,    7,       1,     8,  3,         99,
          0.4, 0.6 * deg, 2,    3 * deg, 0,    0,     0,       2,     80, 1,         0,
          0,   1,         5,    0,       0,    2,     1000,    1,     2,  9,         3,
          -20, 100,       0,    120,     80}));
  EXPECT_EQ(words_of(bench), (Names{"10.0.0.2", "prediction", "0.0.0.0", "wand", "dot"}));
  EXPECT_EQ(bench.board->port, "/dev/ttyUSB0");
  EXPECT_EQ(bench.simulation.X_tracker_femur.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((bench.simulation.X_tracker_femur.linear().col(1) - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  const CalibrationSettings& c = bench.calibration;
  EXPECT_EQ(c.points.at(1).p_model_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(c.points[1].is_target);
  EXPECT_EQ(c.tibia_points.at(0).p_model_mm, Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(c.landmarks.at(0).model_mm, 81.5);
}

using namespace bench;

/// Of an angle converted to degrees and back, and of a pose of some metres.
constexpr double rounding = 1e-12;

PoseParameters random_six(std::mt19937_64& random)
{
  std::uniform_real_distribution<double> mm(-900.0, 900.0), any(-pi, pi), half(-0.499 * pi, 0.499 * pi);
  return {{mm(random), mm(random), mm(random)}, {any(random), half(random), any(random)}};
}

void expect_near(const PoseParameters& a, const PoseParameters& b)
{
  EXPECT_EQ(a.shift_mm, b.shift_mm);
  EXPECT_LT((a.turn_rad - b.turn_rad).norm(), rounding);
}

view::Eye random_eye(std::mt19937_64& random, const view::Viewport& window)
{
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  view::Eye eye;
  eye.window = window;
  eye.visible = {window.x + 20, window.y + 10, window.width - 50, window.height - 30};
  eye.distance_px = 900.0 + 100.0 * part(random);
  eye.pixel_aspect = 1.0 + 0.1 * part(random);
  eye.sight_px = {window.x + 300 + 9.0 * part(random), window.y + 200 + 9.0 * part(random)};
  eye.position_head_mm = {32.0 * part(random), part(random), part(random)};
  eye.distortion = {0.1 + 0.05 * part(random), 0.01 * part(random),
                    eye.sight_px + Eigen::Vector2d(3.25, -2.0), 320.0 + part(random), eye.pixel_aspect};
  return eye;
}

Calibration random_calibration(std::mt19937_64& random, const BenchFile& bench)
{
  Calibration c;
  c.eyes.left = random_eye(random, bench.display.windows.left);
  c.eyes.right = random_eye(random, bench.display.windows.right);
  c.image_distance_mm = 812.5;
  c.X_tracker_table = random_six(random);
  c.X_table_eyes = random_six(random);
  c.X_headbody_eyes = random_six(random);
  c.stage_direction_table = random_six(random).shift_mm.normalized();
  for (const std::size_t role : {0u, 1u, 2u}) c.X_body_model[role] = random_six(random);
  return c;
}

TEST(Calibration, ReadsBackWhatWasWritten)
{
  std::mt19937_64 random(82);
  const BenchFile bench = test::bench_of(test::bench_text());
  const test::Scratch scratch;
  for (int i = 0; i < 20; ++i) {
    const Calibration made = random_calibration(random, bench);
    const std::string file = scratch.write("c.toml", calibration_text(made, bench)).string();
    const Calibration read = read_calibration(file, bench);
    EXPECT_TRUE(read.eyes == made.eyes);
    EXPECT_EQ(read.image_distance_mm, made.image_distance_mm);
    EXPECT_EQ(read.stage_direction_table, made.stage_direction_table);
    expect_near(read.X_tracker_table, made.X_tracker_table);
    expect_near(read.X_table_eyes, made.X_table_eyes);
    expect_near(read.X_headbody_eyes, made.X_headbody_eyes);
    for (const std::size_t role : {0u, 1u, 2u}) expect_near(read.X_body_model[role], made.X_body_model[role]);
  }
}

TEST(CalibrationFile, WhatAnotherProgramWroteInTheMeantimeIsKept)
{
  std::mt19937_64 random(83);
  const BenchFile bench = test::bench_of(test::bench_text());
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "c.toml").string();
  CalibrationFile ours(bench, path, "");
  ours.write(random_calibration(random, bench));  // a new file
  ours.write(random_calibration(random, bench));
  const std::string before = test::read_bytes(path);
  CalibrationFile theirs(bench, path, before);
  theirs.write(random_calibration(random, bench));
  const std::string after = test::read_bytes(path);
  ASSERT_NE(after, before);
  EXPECT_THAT(test::input_error([&] { ours.write(random_calibration(random, bench)); }),
              test::refuses({.file = path, .found = "changed"}));
  EXPECT_EQ(test::read_bytes(path), after);
  std::filesystem::remove(path);
  EXPECT_NO_THROW(ours.write(random_calibration(random, bench)));  // nothing is lost
}

BenchFile bench_with(const std::string& layout)
{
  return test::bench_of(test::bench_head() + "[display]\nwidth = 1280\nheight = 1024\nlayout = \"" + layout +
                        "\"\n" + test::tracker_table + test::two_bodies);
}

TEST(Calibration, TheNominalOneIsUsableAndReadsBack)
{
  for (const std::string layout : {"quarters", "side-by-side", "top-bottom", "two-outputs"}) {
    const BenchFile bench = bench_with(layout);
    const Calibration nominal = nominal_calibration(bench);
    view::require_usable(nominal.eyes, "nominal");
    const Calibration read = parse_calibration(calibration_text(nominal, bench), "c.toml", bench);
    EXPECT_TRUE(read.eyes == nominal.eyes);
    EXPECT_EQ(read.X_table_eyes.shift_mm, Eigen::Vector3d(0, 0, 800));
    EXPECT_EQ(read.eyes.right.position_head_mm.x() - read.eyes.left.position_head_mm.x(), 64.0);
  }
}

TEST(Calibration, SixNumbersTurnAboutTheFixedAxesInOrder)
{
  const PoseParameters six{{1, 2, 3}, {0.5 * pi, 0.5 * pi, 0}};
  // About x: Y goes to Z; then about y: Z goes to X.
  EXPECT_LT((pose_of(six) * Eigen::Vector3d::UnitY() - Eigen::Vector3d(2, 2, 3)).norm(), rounding);
}

TEST(Calibration, SixNumbersAreThoseOfTheirPoseAlsoStraightUp)
{
  std::mt19937_64 random(84);
  for (int i = 0; i < 100; ++i) {
    PoseParameters six = random_six(random);
    for (const double y : {six.turn_rad.y(), 0.5 * pi, -0.5 * pi}) {
      six.turn_rad.y() = y;
      const Pose X = pose_of(six);
      EXPECT_LT((pose_of(pose_parameters_of(X)).matrix() - X.matrix()).norm(), rounding);
    }
  }
}

/// The new window contains the visible part, but the coefficients are relative to the window's width.
TEST(Calibration, OneOfAnotherWindowIsRefused)
{
  BenchFile bench = test::bench_of(test::bench_text());
  Calibration made = nominal_calibration(bench);
  view::Viewport& visible = made.eyes.right.visible;
  visible = {visible.x + 40, visible.y + 20, visible.width - 80, visible.height - 40};
  const std::string text = calibration_text(made, bench);
  const view::Viewport before = bench.display.windows.right;
  view::Viewport& window = bench.display.windows.right;
  window = {before.x + 20, before.y, before.width - 40, before.height};
  EXPECT_THAT(test::input_error([&] { parse_calibration(text, "c.toml", bench); }),
              test::refuses({"c.toml", "display.right_window", "[640.0, 528.0, 640.0, 480.0]",
                             "[660.0, 528.0, 600.0, 480.0]"}));
  // Older files have no windows.
  std::string silent = text;
  for (const char* name : {"left_window", "right_window"}) {
    const std::size_t at = silent.find(name);
    silent.erase(at, silent.find('\n', at) + 1 - at);
  }
  EXPECT_EQ(parse_calibration(silent, "c.toml", bench).eyes.right.visible.x, visible.x);
}

// Records: marks and estimates.

/// `named`: the first names.
Estimate random_estimate(std::mt19937_64& random, const std::vector<std::string>& named, Eigen::Index n_more)
{
  std::normal_distribution<double> any;
  Estimate estimate;
  const auto n_named = static_cast<Eigen::Index>(named.size());
  const Eigen::Index n = n_named + n_more;
  estimate.values.resize(n);
  const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return any(random); });
  estimate.covariance = A * A.transpose();
  for (Eigen::Index k = 0; k < n; ++k) {
    estimate.names.push_back(k < n_named ? named[static_cast<std::size_t>(k)]
                                         : "number \"" + std::to_string(k) + "\"");
    estimate.units.push_back(k % 2 == 0 ? "" : "mm");
    estimate.values[k] = any(random);
    estimate.residuals.push_back(any(random));
  }
  estimate.dof = n % 2 == 0 ? std::numeric_limits<double>::infinity() : 12.5;
  if (n > 0) estimate.residual_unit = "px";
  estimate.residual_rms = 0.25;
  if (n > 2) estimate.remarks = {"a line", "another"};
  return estimate;
}

CalibrationRecord random_record(std::mt19937_64& random, CalibrationPart part)
{
  const int number = static_cast<int>(part);
  std::normal_distribution<double> any;
  CalibrationRecord record;
  record.date = "2026-11-22";
  record.is_outdated = number % 3 == 1;
  for (int k = 0; k < number % 5; ++k) record.made_with.push_back(any(random));
  for (int mark = 0; mark < number % 4; ++mark) {
    CalibrationMark& made = record.marks.emplace_back();
    made.task = "task " + std::to_string(mark);
    // Row 0 is empty, as for a look.
    for (int row = 0; row <= mark; ++row) {
      made.rows.emplace_back();
      for (int k = 0; k < row; ++k) made.rows.back().push_back(any(random));
    }
  }
  if (number % 2 == 0) record.estimate = random_estimate(random, shared_estimate_names(part), number);
  return record;
}

TEST(CalibrationRecord, ReadsBackWhatWasWrittenToTheLastBit)
{
  std::mt19937_64 random(7);
  const BenchFile bench = test::bench_of(test::bench_text());
  Calibration made = nominal_calibration(bench);
  made.subject_scale = 1.0 / 3.0;
  for (std::size_t k = 0; k < n_calibration_parts; ++k) {
    const auto part = static_cast<CalibrationPart>(k);
    made.records[part] = random_record(random, part);
  }
  const std::string text = calibration_text(made, bench);
  const Calibration read = parse_calibration(text, "c.toml", bench);
  EXPECT_EQ(read.subject_scale, made.subject_scale);
  ASSERT_EQ(read.records.size(), n_calibration_parts);
  for (const auto& [part, record] : made.records) {
    SCOPED_TRACE(name_of(part));
    const CalibrationRecord& back = read.records.at(part);
    ASSERT_EQ(back.marks.size(), record.marks.size());
    for (std::size_t k = 0; k < back.marks.size(); ++k) EXPECT_EQ(back.marks[k].rows, record.marks[k].rows);
    ASSERT_EQ(back.estimate.has_value(), record.estimate.has_value());
    if (!record.estimate) continue;
    EXPECT_EQ(back.estimate->units, record.estimate->units);
    EXPECT_EQ(back.estimate->values, record.estimate->values);
    EXPECT_EQ(back.estimate->covariance, record.estimate->covariance);
  }
  // The text has every other field, with all digits of the numbers.
  EXPECT_EQ(calibration_text(read, bench), text);
}

// Parameters.

/// Of an angle converted to degrees and back.
constexpr double degrees_rounding = 1e-10;

BenchValues nominal_values()
{
  BenchValues values;
  values.calibration = nominal_calibration(test::bench_of(test::bench_text()));
  return values;
}

TEST(Parameters, HaveNamesUnitsRangesAndSteps)
{
  const std::set<std::string> units{"", "mm", "deg", "px", "ms"};
  std::set<std::string> names;
  for (const Parameter& parameter : parameters()) {
    SCOPED_TRACE(parameter.name);
    EXPECT_TRUE(names.insert(parameter.name).second);
    EXPECT_EQ(units.count(parameter.unit), 1u);
    EXPECT_LT(parameter.minimum, parameter.maximum);
    EXPECT_GT(parameter.step, 0.0);
    EXPECT_LT(parameter.step, parameter.maximum - parameter.minimum);
    EXPECT_EQ(find_parameter(parameter.name), names.size() - 1);
  }
  // Three of the bench, two common to both eyes, six poses of six numbers, ten of each eye.
  EXPECT_EQ(names.size(), 3u + 2u + 36u + 20u);
  EXPECT_FALSE(find_parameter("no.such").has_value());
}

TEST(Parameters, KeepWhatTheyAreSetToWithinTheirRange)
{
  BenchValues values = nominal_values();
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    const Parameter& parameter = parameters()[k];
    SCOPED_TRACE(parameter.name);
    const double range = parameter.maximum - parameter.minimum;
    for (const double wanted : {parameter.minimum, parameter.minimum + 0.375 * range, parameter.maximum}) {
      set_value(values, k, wanted);
      EXPECT_NEAR(value_of(values, k), wanted, degrees_rounding);
    }
    set_value(values, k, parameter.maximum + range);
    EXPECT_NEAR(value_of(values, k), parameter.maximum, degrees_rounding);
    set_value(values, k, parameter.minimum - range);
    EXPECT_NEAR(value_of(values, k), parameter.minimum, degrees_rounding);
  }
}

TEST(Parameters, KeptOnesSurviveTheFileAndTheOthersAreNotInIt)
{
  const BenchFile bench = test::bench_of(test::bench_text());
  const std::string nominal = calibration_text(nominal_calibration(bench), bench);
  constexpr std::size_t n_unsaved = 3;  // of the bench, not of its calibration
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    const Parameter& parameter = parameters()[k];
    SCOPED_TRACE(parameter.name);
    BenchValues values = nominal_values();
    set_value(values, k, value_of(values, k) + 2.0 * parameter.step);
    const std::string text = calibration_text(values.calibration, bench);
    BenchValues read;
    read.calibration = parse_calibration(text, "c.toml", bench);
    EXPECT_EQ(text != nominal, k >= n_unsaved);
    // Values that are not in the file would be lost at the next start.
    EXPECT_EQ(read.calibration.eyes.left.distortion.pixel_aspect,
              values.calibration.eyes.left.distortion.pixel_aspect);
    EXPECT_EQ(read.calibration.eyes.right.distortion.pixel_aspect,
              values.calibration.eyes.right.distortion.pixel_aspect);
    for (std::size_t other = n_unsaved; other < parameters().size(); ++other)
      EXPECT_NEAR(value_of(read, other), value_of(values, other), degrees_rounding)
          << parameters()[other].name;
  }
}

TEST(Parameters, ChangeNothingButThemselves)
{
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    SCOPED_TRACE(parameters()[k].name);
    const BenchValues before = nominal_values();
    BenchValues after = before;
    set_value(after, k, value_of(before, k) + parameters()[k].step);
    std::vector<std::string> changed;
    for (std::size_t other = 0; other < parameters().size(); ++other) {
      if (value_of(after, other) != value_of(before, other)) changed.push_back(parameters()[other].name);
    }
    EXPECT_EQ(changed, std::vector<std::string>{parameters()[k].name});
  }
}

TEST(Parameters, TheDistanceBetweenTheEyesKeepsTheirMiddle)
{
  BenchValues values = nominal_values();
  values.calibration.eyes.left.position_head_mm.x() = -30.0;
  values.calibration.eyes.right.position_head_mm.x() = 34.0;
  set_value(values, find_parameter("eyes.distance_apart").value(), 60.0);
  EXPECT_EQ(values.calibration.eyes.left.position_head_mm.x(), -28.0);
  EXPECT_EQ(values.calibration.eyes.right.position_head_mm.x(), 32.0);
}

}  // namespace vrda::bench_files_test
