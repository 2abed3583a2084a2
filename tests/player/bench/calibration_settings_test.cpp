#include "bench/bench_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration_settings_test {

bench::BenchFile bench_with(const std::string& lines)
{
  return test::bench_of(test::bench_text() + lines);
}

TEST(CalibrationSettings, WithoutTheTableNoToolIsWanted)
{
  const bench::BenchFile bench = bench_with("");
  EXPECT_FALSE(bench.calibration.is_present);
  EXPECT_EQ(bench.tracker->tools, (std::vector<std::string>{"femur", "tibia"}));
}

TEST(CalibrationSettings, AnEmptyTableIsTheDefaults)
{
  const bench::BenchFile bench = bench_with("[calibration]\n");
  const bench::CalibrationSettings &c = bench.calibration, defaults;
  EXPECT_TRUE(c.is_present);
  const auto numbers = [](const bench::CalibrationSettings& s) {
    std::vector<double> all{s.screen_sd_mm, s.alignment_sd_rad, s.sight_sd_px, s.pupillometer_sd_mm,
                            s.eye_height_sd_mm};
    for (const int n : {s.edge_repeats, s.grid_columns, s.grid_rows, s.grid_repeats, s.rectangle_repeats,
                        s.rail_samples, s.pivot_samples, s.hold_samples, s.bullseyes, s.model_repeats})
      all.push_back(n);
    for (const bool flag : {s.is_grid_adjusted, s.has_pupillometer, s.is_model_adjusted}) all.push_back(flag);
    for (const bench::CalibrationRectangle& r : s.rectangles) all.insert(all.end(), {r.width_mm, r.depth_mm});
    return all;
  };
  EXPECT_EQ(numbers(c), numbers(defaults));
  EXPECT_EQ(c.probe + c.marker, defaults.probe + defaults.marker);
  EXPECT_EQ(bench.tracker->tools, (std::vector<std::string>{"femur", "tibia", "probe", "marker"}));
}

TEST(CalibrationSettings, AToolOfABodyIsNotListedTwice)
{
  EXPECT_EQ(bench_with("[calibration]\nprobe = \"wand\"\nmarker = \"wand\"\n").tracker->tools,
            (std::vector<std::string>{"femur", "tibia", "wand"}));
  EXPECT_EQ(bench_with("[calibration]\nmarker = \"tibia\"\n").tracker->tools,
            (std::vector<std::string>{"femur", "tibia", "probe"}));
}

TEST(CalibrationSettings, EveryKeyIsTaken)
{
  const bench::CalibrationSettings c =
      bench_with(
          "[calibration]\nedge_repeats = 5\nscreen_sd_mm = 0.2\ndistortion = \"adjust\"\ngrid = [9, 4]\n"
          "grid_repeats = 4\nrectangles = [[100, 0], [120, 80]]\nrectangle_repeats = 6\n"
          "alignment_sd_deg = 0.5\nsight_sd_px = 2\npupillometer = false\npupillometer_sd_mm = 0.3\n"
          "eye_height_sd_mm = 0.7\nprobe = \"wand\"\nmarker = \"dot\"\nrail_samples = 20\n"
          "pivot_samples = 21\nhold_samples = 22\nbullseyes = 7\nmodel = \"adjust\"\nmodel_repeats = 8\n"
          "[[calibration.point]]\nname = \"a\"\nmm = [1, 2, 3]\n[[calibration.point]]\nname = \"b\"\n"
          "mm = [4, 5, 6]\ntarget = true\n[[calibration.tibia_point]]\nname = \"a\"\nmm = [7, 8, 9]\n"
          "[[calibration.landmarks]]\nname = \"width\"\nmodel_mm = 81.5\n")
          .calibration;
  EXPECT_EQ(c.edge_repeats, 5);
  EXPECT_EQ(c.screen_sd_mm, 0.2);
  EXPECT_TRUE(c.is_grid_adjusted);
  EXPECT_EQ(c.grid_columns, 9);
  EXPECT_EQ(c.grid_rows, 4);
  EXPECT_EQ(c.grid_repeats, 4);
  ASSERT_EQ(c.rectangles.size(), 2u);
  EXPECT_EQ(c.rectangles[1].width_mm, 120.0);
  EXPECT_EQ(c.rectangles[1].depth_mm, 80.0);
  EXPECT_EQ(c.rectangle_repeats, 6);
  EXPECT_EQ(c.alignment_sd_rad, rad_from_deg(0.5));
  EXPECT_EQ(c.sight_sd_px, 2.0);
  EXPECT_FALSE(c.has_pupillometer);
  EXPECT_EQ(c.pupillometer_sd_mm, 0.3);
  EXPECT_EQ(c.eye_height_sd_mm, 0.7);
  EXPECT_EQ(c.probe, "wand");
  EXPECT_EQ(c.marker, "dot");
  EXPECT_EQ(c.rail_samples, 20);
  EXPECT_EQ(c.pivot_samples, 21);
  EXPECT_EQ(c.hold_samples, 22);
  EXPECT_EQ(c.bullseyes, 7);
  EXPECT_TRUE(c.is_model_adjusted);
  EXPECT_EQ(c.model_repeats, 8);
  ASSERT_EQ(c.points.size(), 2u);
  EXPECT_EQ(c.points[1].p_model_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(c.points[1].is_target);
  ASSERT_EQ(c.tibia_points.size(), 1u);
  EXPECT_EQ(c.tibia_points[0].p_model_mm, Eigen::Vector3d(7, 8, 9));
  ASSERT_EQ(c.landmarks.size(), 1u);
  EXPECT_EQ(c.landmarks[0].model_mm, 81.5);
}

TEST(CalibrationSettings, WhatIsWrongIsNamed)
{
  const std::string point = "[[calibration.point]]\nname = \"a\"\nmm = [1, 2, 3]\n";
  const std::string pair = "[[calibration.landmarks]]\nname = \"a\"\nmodel_mm = 1\n";
  struct Row {
    std::string lines, field, found;
  };
  for (const Row& row : {
           Row{"edges = 3\n", "edges", "an unknown key"},
           Row{"rectangles = [[100, 0], [0, 5]]\n", "rectangles.1.0", "0"},
           Row{"rectangles = [[100, 5], [120, 5]]\n", "rectangles", "5 mm"},
           Row{"rectangles = [[100, 5], [120, 5.5]]\n", "rectangles", "5 mm"},
           Row{"rectangles = [[100, 0], [120, 90]]\nrectangle_repeats = 1\n", "rectangle_repeats",
               "2 alignments of 2 rectangles"},
           Row{"grid = [3, 3]\n", "grid", "3 by 3 nodes"},
           Row{point + "targets = true\n", "point.0.targets", "an unknown key"},
           Row{point + point, "point.1.name", "'a'"},
           Row{pair + pair, "landmarks.1.name", "'a'"},
           Row{"[[calibration.landmarks]]\nname = \"a\"\nmodel_mm = 0\n", "landmarks.0.model_mm", "0"},
       }) {
    SCOPED_TRACE(row.lines);
    EXPECT_THAT(test::input_error([&] { bench_with("[calibration]\n" + row.lines); }),
                test::refuses({.field = "calibration." + row.field, .found = row.found}));
  }
}

}  // namespace vrda::calibration_settings_test
