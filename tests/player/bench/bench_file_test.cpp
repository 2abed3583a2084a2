#include "bench/bench_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/calibration_file.hpp"
#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::bench_file_test {

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

TEST(BenchFile, Refusals)
{
  const std::string whole = bench_text(), cut(21, 'n'), head = bench_head() + shared;
  const std::string femur = head + "[body.femur]\n", board = head + two_bodies + "[board]\nport = \"p\"\n";
  const std::string calibration = whole + "[calibration]\n", simulation = whole + "[simulation]\n";
  const std::string point = "[[calibration.point]]\nname = \"a\"\nmm = [1, 2, 3]\n";
  const std::string pair = "[[calibration.landmarks]]\nname = \"a\"\nmodel_mm = 1\n";
  const std::string beyond = "a rectangle that reaches beyond the frame buffer, or has no size";
  struct Row {
    std::string text, field, found, wanted = {};
  };
  for (const Row& row : {
           Row{"", "title", "nothing"},
           Row{"titel = \"x\"\n" + whole, "titel", "an unknown key", "\"title\""},
           Row{"title = \"x\"\n", "display", "nothing"},
           Row{bench_head("stiff") + shared + two_bodies, "leg", "\"stiff\""},
           Row{display(quarters + "left_window = [0, 0, 0, 9]\n"), "display.left_window", beyond},
           Row{display(quarters + "right_window = [1000, 0, 281, 9]\n"), "display.right_window", beyond},
           Row{display(quarters + "right_window = [640, 400, 640, 480]\n"), "display.right_window",
               "display.left_window"},
           Row{display(quarters + "half_width = true\n"), "display.half_width", "another layout"},
           Row{display(quarters + "outputs = [\"A\"]\nat = [0, 0]\n"), "display.outputs", "outputs and at"},
           Row{display(quarters + "outputs = [\"A\", \"B\"]\n"), "display.outputs", "2 names"},
           Row{display("layout = \"two-outputs\"\noutputs = [\"A\"]\n"), "display.outputs", "1 names"},
           Row{bench_head() + display_table + two_bodies, "tracker", "nothing"},
           Row{bench_head() + display_table + "[tracker]\nhosts = 1\n", "tracker.hosts", "an unknown key"},
           Row{bench_head() + "tracker = \"vicon\"\n" + display_table + two_bodies, "tracker", "vicon",
               "aruco"},
           Row{aruco + two_bodies + "[camera]\nfold_deg = 180\n", "camera.fold_deg", "180", "150"},
           Row{aruco + "[body.femur]\n" + three_markers + "[body.tibia]\ntool = \"t\"\n",
               "body.femur.markers", "single markers", "tool"},
           Row{head, "body", "nothing"},
           Row{femur + "tool = \"f\"\n", "body.tibia", "nothing"},
           Row{femur, "body.femur.tool", "neither tool nor markers"},
           Row{femur + "tool = \"f\"\n" + three_markers, "body.femur.tool", "tool and markers"},
           Row{femur + "tool = \"f\"\n[body.tibia]\ntool = \"f\"\n", "body.tibia", "'f'"},
           Row{femur + "markers = [\"a\", \"b\"]\nmarkers_mm = []\n", "body.femur.markers", "[\"a\", \"b\"]"},
           Row{femur + "markers = [\"a\", \"b\", \"c\"]\n", "body.femur.markers_mm", "nothing", "measure"},
           Row{femur + "markers = [\"a\", \"b\", \"c\"]\nmarkers_mm = [0, 0, 0]\n", "body.femur.markers_mm",
               "[0, 0, 0]"},
           Row{head + "[body.knee]\n", "body.knee", "an unknown key"},
           Row{femur + "tool = \"" + cut + "\"\n", "body.femur.tool", "'" + cut + "' of 21 bytes", "20"},
           Row{femur + "tool = \"f\"\n[body.tibia]\nmarkers = [\"a\", \"" + cut + "\", \"c\"]\n",
               "body.tibia.markers", cut, "20"},
           Row{board + "potentiometer = \"knee\"\n", "board.potentiometer", "\"knee\""},
           Row{board + "potentiometer = \"flexion\"\n", "board.potentiometer", "\"flexion\""},
           Row{simulation + "speed = 2\n", "simulation.speed", "an unknown key"},
           Row{simulation + "address = \"desk\"\n", "simulation.address", "\"desk\""},
           Row{simulation + "leg = [[0, 0]]\n", "simulation.leg.0", "[0, 0]"},
           Row{simulation + "[[simulation.occlusion]]\ntool = \"patella\"\nfrom_s = 1\nto_s = 2\n",
               "occlusion tool", "patella"},
           Row{calibration + "edges = 3\n", "calibration.edges", "an unknown key"},
           Row{calibration + "probe = \"" + cut + "\"\n", "calibration.probe", cut, "20"},
           Row{calibration + "marker = \"" + cut + "\"\n", "calibration.marker", cut, "20"},
           Row{calibration + "rectangles = [[100, 0], [0, 5]]\n", "calibration.rectangles.1.0", "0"},
           Row{calibration + "rectangles = [[100, 5], [120, 5.5]]\n", "calibration.rectangles", "5 mm"},
           Row{calibration + "rectangles = [[100, 0], [120, 90]]\nrectangle_repeats = 1\n",
               "calibration.rectangle_repeats", "2 alignments of 2 rectangles"},
           Row{calibration + "grid = [3, 3]\n", "calibration.grid", "3 by 3 nodes"},
           Row{calibration + point + "targets = true\n", "calibration.point.0.targets", "an unknown key"},
           Row{calibration + point + point, "calibration.point.1.name", "'a'"},
           Row{calibration + pair + pair, "calibration.landmarks.1.name", "'a'"},
           Row{calibration + "[[calibration.landmarks]]\nname = \"a\"\nmodel_mm = 0\n",
               "calibration.landmarks.0.model_mm", "0"},
       }) {
    SCOPED_TRACE(row.text);
    EXPECT_THAT(test::input_error([&] { bench_of(row.text); }),
                test::refuses({"bench.toml", row.field, row.found, row.wanted}));
  }
  EXPECT_EQ(tools(femur + "tool = \"" + cut.substr(1) + "\"\n[body.tibia]\ntool = \"t\"\n").front(),
            cut.substr(1));
  EXPECT_THAT(test::input_error([] { read_bench_file("/nowhere/b.toml"); }),
              test::refuses({.wanted = "bench.md"}));
}

}  // namespace vrda::bench_file_test
