#include "bench/bench_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/calibration_file.hpp"
#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::bench_file_test {

using test::bench_head, test::display_table, test::tracker_table, test::two_bodies, test::board_table;

const std::string three_markers =
    "markers = [\"a\", \"b\", \"c\"]\nmarkers_mm = [0, 0, 0, 50, 0, 0, 0, 40, 0]\n";

std::string display(const std::string& lines)
{
  return bench_head() + "[display]\nwidth = 1280\nheight = 1024\n" + lines + tracker_table + two_bodies;
}

void expect_window(const view::Viewport& window, const view::Viewport& wanted)
{
  EXPECT_EQ(window.x, wanted.x);
  EXPECT_EQ(window.y, wanted.y);
  EXPECT_EQ(window.width, wanted.width);
  EXPECT_EQ(window.height, wanted.height);
}

TEST(BenchFile, TheExampleIsADesk)
{
  const bench::BenchFile bench = bench::read_bench_file(VRDA_JOBS "/bench-desk.toml");
  EXPECT_EQ(bench.title, "Desk");
  EXPECT_EQ(bench.leg, bench::LegKind::two_bodies);
  EXPECT_EQ(bench.head, bench::HeadKind::stage);
  EXPECT_EQ(bench.display.layout, view::Layout::quarters);
  ASSERT_TRUE(bench.tracker.has_value());
  EXPECT_EQ(bench.tracker->host, "127.0.0.1");
  EXPECT_EQ(bench.tracker->port, 18944);
  EXPECT_EQ(bench.tracker->tools, (std::vector<std::string>{"femur", "tibia", "probe", "marker"}));
  EXPECT_TRUE(bench.calibration.is_present);
  ASSERT_TRUE(bench.board.has_value());
  EXPECT_EQ(bench.board->port, "/tmp/vrda-desk-board");
  EXPECT_TRUE(bench.board->has_stage);
  EXPECT_TRUE(bench.board->has_potentiometer);
  EXPECT_EQ(bench.potentiometer, "selected");
  EXPECT_EQ(bench.stage_mm_per_count, 0.005);
  EXPECT_EQ(bench.prediction_ms, 0.0);
  ASSERT_EQ(bench.simulation.leg.size(), 5u);
  EXPECT_EQ(bench.simulation.leg[2].flexion_deg, 90.0);
  ASSERT_EQ(bench.simulation.occlusions.size(), 1u);
  EXPECT_EQ(bench.simulation.occlusions[0].tool, "tibia");
  EXPECT_EQ(bench.simulation.occlusions[0].every_s, 16.0);
  EXPECT_EQ(bench.text, test::read_bytes(VRDA_JOBS "/bench-desk.toml"));
}

TEST(BenchFile, WindowsAreThoseOfTheLayoutOrTheFiles)
{
  struct Row {
    std::string lines;
    view::Viewport left, right;
  };
  for (const Row& row : {
           Row{"layout = \"quarters\"\n", {640, 16, 640, 480}, {640, 528, 640, 480}},
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
    const bench::BenchFile bench = test::bench_of(display(row.lines));
    expect_window(bench.display.windows.left, row.left);
    expect_window(bench.display.windows.right, row.right);
  }
}

TEST(BenchFile, TheDisplayMayHaveAPlaceOnTheDesktop)
{
  const std::string quarters = "layout = \"quarters\"\n";
  EXPECT_FALSE(test::bench_of(display(quarters)).display.at.has_value());
  EXPECT_EQ(test::bench_of(display(quarters + "at = [-1280, 24]\n")).display.at,
            (std::array<int, 2>{-1280, 24}));
}

TEST(BenchFile, TheDisplayMayBeReflectedHalvedAndOnNamedOutputs)
{
  const bench::DisplaySettings plain = test::bench_of(display("layout = \"quarters\"\n")).display;
  EXPECT_EQ(plain.reflection, view::Reflection{});
  EXPECT_FALSE(plain.is_half_width);
  const bench::BenchFile bench = test::bench_of(
      display("layout = \"side-by-side\"\nmirror = true\nhalf_width = true\noutputs = [\"HDMI-1\"]\n"));
  EXPECT_EQ(bench.display.reflection, (view::Reflection{true, false}));
  EXPECT_EQ(bench.display.outputs, std::vector<std::string>{"HDMI-1"});
  // A wide pixel: the same angles in half the columns.
  const view::Eye eye = bench::nominal_calibration(bench).eyes.left;
  const view::Eye usual = bench::nominal_calibration(test::bench_of(test::bench_text())).eyes.left;
  EXPECT_EQ(eye.distance_px, 0.5 * usual.distance_px);
  EXPECT_EQ(view::distance_y_px(eye), view::distance_y_px(usual));
  EXPECT_EQ(eye.distortion.pixel_aspect, eye.pixel_aspect);
  EXPECT_TRUE(test::bench_of(display("layout = \"quarters\"\nflip = true\n")).display.reflection.is_flipped);
}

TEST(BenchFile, BodiesAreThoseThatLegAndHeadWant)
{
  const auto tools = [](const std::string& text) { return test::bench_of(text).tracker->tools; };
  const std::string shared = display_table + tracker_table;
  EXPECT_EQ(tools(bench_head("rigid") + shared + "[body.leg]\ntool = \"thigh\"\n"),
            std::vector<std::string>{"thigh"});
  // In role order, not in file order.
  EXPECT_EQ(tools(bench_head("two-bodies", "tracker") + shared + "[body.head]\ntool = \"h\"\n[body.tibia]\n" +
                  three_markers + "[body.femur]\ntool = \"f\"\n"),
            (std::vector<std::string>{"f", "a", "b", "c", "h"}));
  const bench::BenchFile bench = test::bench_of(bench_head("rigid") + shared + "[body.leg]\n" +
                                                three_markers + "marker_interval_ms = 0.5\n");
  const bench::BodySettings& leg = bench.bodies[0].value();
  ASSERT_EQ(leg.markers_body_mm.size(), 3u);
  EXPECT_EQ(leg.markers_body_mm[2], Eigen::Vector3d(0, 40, 0));
  EXPECT_EQ(leg.marker_interval_ms, 0.5);
  EXPECT_EQ(bench.simulation.firing_interval_ms, 0.5);
  EXPECT_FALSE(bench.bodies[1] || bench.bodies[2] || bench.bodies[3]);
  EXPECT_FALSE(bench.board.has_value());
}

TEST(BenchFile, PlacesOfMarkersMayBeMissingBeforeTheyAreMeasured)
{
  const std::string text =
      bench_head("rigid") + display_table + tracker_table + "[body.leg]\nmarkers = [\"a\", \"b\", \"c\"]\n";
  const bench::BenchFile bench =
      bench::parse_bench_file(text, "bench.toml", bench::MarkerPositions::optional);
  EXPECT_EQ(bench.tracker->tools, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_TRUE(bench.bodies[0]->markers_body_mm.empty());
  EXPECT_THAT(test::input_error([&] { test::bench_of(text); }),
              test::refuses({.field = "body.leg.markers_mm", .found = "nothing"}));
}

TEST(BenchFile, EveryOtherKeyIsTaken)
{
  const bench::BenchFile bench = test::bench_of(
      "prediction_ms = 33\n" + bench_head() + display_table +
      "refresh_hz = 75\n[tracker]\nhost = \"10.0.0.2\"\nport = 5000\nstale_after_ms = 40\n"
      "tdata_interval_ms = 10\n" +
      two_bodies +
      "[board]\nport = \"/dev/ttyUSB0\"\nbaud = 57600\nrate_hz = 50\nstage_mm_per_count = -0.01\n"
      "potentiometer = \"prediction\"\n[filter]\non = false\nleast_cutoff_hz = 3\nslope = 0.5\n[simulation]\n"
      "address = \"0.0.0.0\"\nseed = 7\nside = \"left\"\nrate_hz = 60\njitter_ms = 1\ndrop_rate = "
      "0\nnoise_mm = 0\nnoise_deg = 0\n"
      "loop = false\nstage = [[0, 0], [1, 5]]\npotentiometer = [[0, 0], [2, 1000]]\n"
      "potentiometer_noise_counts = 0\nfemur = [1, 2, 3, 90, 0, 0]\nsway_mm = 0\nsway_s = 1\n"
      "clock_offset_s = 5\nclock_drift_ppm = -3\n[[simulation.clock_step]]\nat_s = 3\nby_ms = -20\n");
  EXPECT_EQ(bench.prediction_ms, 33.0);
  EXPECT_EQ(bench.display.refresh_hz, 75.0);
  EXPECT_EQ(bench.tracker->host, "10.0.0.2");
  EXPECT_EQ(bench.tracker->port, 5000);
  EXPECT_EQ(bench.tracker->stale_after_ms, 40.0);
  EXPECT_EQ(bench.tracker->tdata_interval_ms, 10.0);
  EXPECT_EQ(bench.board->baud, 57600);
  EXPECT_EQ(bench.board->rate_hz, 50.0);
  EXPECT_EQ(bench.stage_mm_per_count, -0.01);
  EXPECT_EQ(bench.potentiometer, "prediction");
  EXPECT_FALSE(bench.filter.is_on);
  EXPECT_EQ(bench.filter.least_cutoff_hz, 3.0);
  EXPECT_EQ(bench.filter.slope, 0.5 * deg_from_rad(1.0));
  const bench::SimulationScript& script = bench.simulation;
  EXPECT_EQ(bench.simulation_address, "0.0.0.0");
  EXPECT_EQ(test::bench_of(test::bench_text()).simulation_address, "127.0.0.1");
  EXPECT_EQ(script.seed, 7u);
  EXPECT_EQ(script.side, Side::left);
  EXPECT_EQ(script.rate_hz, 60.0);
  EXPECT_FALSE(script.is_looped);
  ASSERT_EQ(script.stage.size(), 2u);
  EXPECT_EQ(script.stage[1].value, 5.0);
  ASSERT_EQ(script.potentiometer.size(), 2u);
  EXPECT_EQ(script.potentiometer[1].value, 1000.0);
  EXPECT_EQ(script.X_tracker_femur.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((script.X_tracker_femur.linear() * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(),
            1e-15);
  ASSERT_EQ(script.clock.steps.size(), 1u);
  EXPECT_EQ(script.clock.steps[0].by_ms, -20.0);
  EXPECT_EQ(script.clock.offset_s, 5.0);
}

TEST(BenchFile, DefaultsOfTheSchemaAreThoseOfTheStructures)
{
  const bench::BenchFile bench =
      test::bench_of(bench_head() + display_table + "[tracker]\n" + two_bodies + "[board]\nport = \"p\"\n");
  const auto of_devices = [](const bench::TrackerSettings& t, const bench::BoardSettings& b,
                             const bench::FilterSettings& f) {
    return std::vector<double>{double(t.port), t.stale_after_ms, t.tdata_interval_ms, double(b.baud),
                               b.rate_hz,      double(f.is_on),  f.least_cutoff_hz,   f.slope};
  };
  EXPECT_EQ(of_devices(*bench.tracker, *bench.board, bench.filter), of_devices({}, {}, {}));
  EXPECT_EQ(bench.tracker->host, bench::TrackerSettings{}.host);
  EXPECT_EQ(bench.stage_mm_per_count, bench::BenchFile{}.stage_mm_per_count);
  EXPECT_EQ(bench.display.refresh_hz, bench::DisplaySettings{}.refresh_hz);
  const auto of_script = [](const bench::SimulationScript& s) {
    std::vector<double> all{double(s.seed),
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
                            double(s.clock.steps.size())};
    for (const bench::LegKey& k : s.leg) all.insert(all.end(), {k.time_s, k.flexion_deg, k.varus_deg});
    for (const bench::PathPoint& k : s.stage) all.insert(all.end(), {k.time_s, k.value});
    for (const bench::PathPoint& k : s.potentiometer) all.insert(all.end(), {k.time_s, k.value});
    for (const bench::Occlusion& o : s.occlusions) all.insert(all.end(), {o.from_s, o.to_s, o.every_s});
    return all;
  };
  EXPECT_EQ(of_script(bench.simulation), of_script({}));
}

TEST(BenchFile, WhatIsWrongIsNamed)
{
  const std::string whole = test::bench_text(), shared = display_table + tracker_table;
  const std::string quarters = "layout = \"quarters\"\n";
  const std::string beyond = "a rectangle that reaches beyond the frame buffer, or has no size";
  struct Row {
    std::string text, field, found;
  };
  const Row rows[] = {
      Row{"", "title", "nothing"},
      Row{"titel = \"x\"\n" + whole, "titel", "an unknown key"},
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
      Row{bench_head() + shared, "body", "nothing"},
      Row{bench_head() + shared + "[body.femur]\ntool = \"f\"\n", "body.tibia", "nothing"},
      Row{bench_head() + shared + "[body.femur]\n", "body.femur.tool", "neither tool nor markers"},
      Row{bench_head() + shared + "[body.femur]\ntool = \"f\"\n" + three_markers, "body.femur.tool",
          "tool and markers"},
      Row{bench_head() + shared + "[body.femur]\ntool = \"f\"\n[body.tibia]\ntool = \"f\"\n", "body.tibia",
          "'f'"},
      Row{bench_head() + shared + "[body.femur]\nmarkers = [\"a\", \"b\"]\nmarkers_mm = []\n",
          "body.femur.markers", "[\"a\", \"b\"]"},
      Row{bench_head() + shared + "[body.femur]\nmarkers = [\"a\", \"b\", \"c\"]\nmarkers_mm = [0, 0, 0]\n",
          "body.femur.markers_mm", "[0, 0, 0]"},
      Row{bench_head() + shared + "[body.knee]\n", "body.knee", "an unknown key"},
      Row{bench_head() + shared + two_bodies + "[board]\nport = \"p\"\npotentiometer = \"knee\"\n",
          "board.potentiometer", "\"knee\""},
      Row{bench_head() + shared + two_bodies + "[board]\nport = \"p\"\npotentiometer = \"flexion\"\n",
          "board.potentiometer", "\"flexion\""},
      Row{whole + "[simulation]\nspeed = 2\n", "simulation.speed", "an unknown key"},
      Row{whole + "[simulation]\naddress = \"desk\"\n", "simulation.address", "\"desk\""},
      Row{whole + "[simulation]\nleg = [[0, 0]]\n", "simulation.leg.0", "[0, 0]"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.text);
    EXPECT_THAT(test::input_error([&] { test::bench_of(row.text); }),
                test::refuses({"bench.toml", row.field, row.found}));
  }
  EXPECT_THAT(test::input_error([&] { test::bench_of("titel = 1"); }),
              test::refuses({.field = "line 1, titel", .wanted = "\"title\""}));
  EXPECT_THAT(test::input_error([] { bench::read_bench_file("/nowhere/b.toml"); }),
              test::refuses({.wanted = "bench.md"}));
}

TEST(BenchFile, NamesOfToolsAreAsLongAsMessagesHoldThem)
{
  const std::string fits(20, 'n'), cut(21, 'n'), shared = display_table + tracker_table;
  const auto text = [&](const std::string& tool, const std::string& marker, const std::string& probe) {
    return bench_head() + shared + "[body.femur]\ntool = \"" + tool +
           "\"\n[body.tibia]\nmarkers = [\"a\", \"" + marker +
           "\", \"c\"]\nmarkers_mm = [0, 0, 0, 50, 0, 0, 0, 40, 0]\n[calibration]\nprobe = \"" + probe +
           "\"\n";
  };
  const bench::BenchFile bench = test::bench_of(text(fits, "b", "probe"));
  EXPECT_EQ(bench.tracker->tools.front(), fits);
  struct Row {
    std::string text, field;
  };
  for (const Row& row :
       {Row{text(cut, "b", "p"), "body.femur.tool"}, Row{text("f", cut, "p"), "body.tibia.markers"},
        Row{text("f", "b", cut), "calibration.probe"},
        Row{text("f", "b", "p") + "marker = \"" + cut + "\"\n", "calibration.marker"}}) {
    EXPECT_THAT(test::input_error([&] { test::bench_of(row.text); }),
                test::refuses({.field = row.field, .found = {"'" + cut + "'", "21"}, .wanted = "20"}));
  }
}

TEST(BenchFile, AnOcclusionOfAnUnknownToolIsRefused)
{
  const InputError::Facts facts = test::input_error([] {
    test::bench_of(test::bench_text() +
                   "[[simulation.occlusion]]\ntool = \"patella\"\nfrom_s = 1\nto_s = 2\n");
  });
  EXPECT_EQ(facts.file, "bench.toml");
  EXPECT_NE((facts.field + facts.found).find("patella"), std::string::npos);
}

}  // namespace vrda::bench_file_test
