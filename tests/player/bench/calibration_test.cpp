#include "bench/calibration_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <random>

#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::calibration_test {

/// Of an angle converted to degrees and back, and of a pose of some metres.
constexpr double rounding = 1e-12;

bench::PoseParameters random_six(std::mt19937_64& random)
{
  std::uniform_real_distribution<double> mm(-900.0, 900.0), any(-pi, pi), half(-0.499 * pi, 0.499 * pi);
  return {{mm(random), mm(random), mm(random)}, {any(random), half(random), any(random)}};
}

void expect_near(const bench::PoseParameters& a, const bench::PoseParameters& b)
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

bench::Calibration random_calibration(std::mt19937_64& random, const bench::BenchFile& bench)
{
  bench::Calibration c;
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
  const bench::BenchFile bench = test::bench_of(test::bench_text());
  const test::Scratch scratch;
  for (int i = 0; i < 20; ++i) {
    const bench::Calibration made = random_calibration(random, bench);
    const std::string file = scratch.write("c.toml", bench::calibration_text(made, bench)).string();
    const bench::Calibration read = bench::read_calibration(file, bench);
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
  const bench::BenchFile bench = test::bench_of(test::bench_text());
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "c.toml").string();
  bench::CalibrationFile ours(bench, path, "");
  ours.write(random_calibration(random, bench));  // a new file
  ours.write(random_calibration(random, bench));
  const std::string before = test::read_bytes(path);
  bench::CalibrationFile theirs(bench, path, before);
  theirs.write(random_calibration(random, bench));
  const std::string after = test::read_bytes(path);
  ASSERT_NE(after, before);
  EXPECT_THAT(test::input_error([&] { ours.write(random_calibration(random, bench)); }),
              test::refuses({.file = path, .found = "changed"}));
  EXPECT_EQ(test::read_bytes(path), after);
  std::filesystem::remove(path);
  EXPECT_NO_THROW(ours.write(random_calibration(random, bench)));  // nothing is lost
}

bench::BenchFile bench_with(const std::string& layout)
{
  return test::bench_of(test::bench_head() + "[display]\nwidth = 1280\nheight = 1024\nlayout = \"" + layout +
                        "\"\n" + test::tracker_table + test::two_bodies);
}

TEST(Calibration, TheNominalOneIsUsableAndReadsBack)
{
  for (const std::string layout : {"quarters", "side-by-side", "top-bottom", "two-outputs"}) {
    const bench::BenchFile bench = bench_with(layout);
    const bench::Calibration nominal = bench::nominal_calibration(bench);
    view::require_usable(nominal.eyes, "nominal");
    const bench::Calibration read =
        bench::parse_calibration(bench::calibration_text(nominal, bench), "c.toml", bench);
    EXPECT_TRUE(read.eyes == nominal.eyes);
    EXPECT_EQ(read.X_table_eyes.shift_mm, Eigen::Vector3d(0, 0, 800));
    EXPECT_EQ(read.eyes.right.position_head_mm.x() - read.eyes.left.position_head_mm.x(), 64.0);
  }
}

TEST(Calibration, SixNumbersAreThoseOfTheirPose)
{
  std::mt19937_64 random(83);
  for (int i = 0; i < 500; ++i) {
    const bench::PoseParameters made = random_six(random);
    // Near the singularity rounding errors are divided by the cosine, at least 0.003.
    const bench::PoseParameters read = bench::pose_parameters_of(bench::pose_of(made));
    EXPECT_EQ(read.shift_mm, made.shift_mm);
    EXPECT_LT((read.turn_rad - made.turn_rad).norm(), 1e-12);
  }
}

TEST(Calibration, SixNumbersTurnAboutTheFixedAxesInOrder)
{
  const bench::PoseParameters six{{1, 2, 3}, {0.5 * pi, 0.5 * pi, 0}};
  // About x: Y goes to Z; then about y: Z goes to X.
  EXPECT_LT((bench::pose_of(six) * Eigen::Vector3d::UnitY() - Eigen::Vector3d(2, 2, 3)).norm(), rounding);
}

TEST(Calibration, StraightUpThePoseIsStillTheSame)
{
  std::mt19937_64 random(84);
  for (int i = 0; i < 100; ++i) {
    for (const double y : {0.5 * pi, -0.5 * pi}) {
      bench::PoseParameters six = random_six(random);
      six.turn_rad.y() = y;
      const Pose X = bench::pose_of(six);
      EXPECT_LT((bench::pose_of(bench::pose_parameters_of(X)).matrix() - X.matrix()).norm(), rounding);
    }
  }
}

std::string replaced(std::string text, const std::string& from, const std::string& to)
{
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// The new window contains the visible part, but the coefficients are relative to the window's width.
TEST(Calibration, OneOfAnotherWindowIsRefused)
{
  bench::BenchFile bench = test::bench_of(test::bench_text());
  bench::Calibration made = bench::nominal_calibration(bench);
  view::Viewport& visible = made.eyes.right.visible;
  visible = {visible.x + 40, visible.y + 20, visible.width - 80, visible.height - 40};
  const std::string text = bench::calibration_text(made, bench);
  const view::Viewport before = bench.display.windows.right;
  view::Viewport& window = bench.display.windows.right;
  window = {before.x + 20, before.y, before.width - 40, before.height};
  const auto list = [](const view::Viewport& v) {
    const std::array<int, 4> numbers{v.x, v.y, v.width, v.height};
    std::string words;
    for (const int n : numbers) words += (words.empty() ? "[" : ", ") + std::to_string(n) + ".0";
    return words + "]";
  };
  const InputError::Facts facts = test::input_error([&] { bench::parse_calibration(text, "c.toml", bench); });
  EXPECT_EQ(facts.file, "c.toml");
  EXPECT_EQ(facts.field, "display.right_window");
  EXPECT_THAT(facts.found, testing::HasSubstr(list(before)));
  EXPECT_THAT(facts.wanted, testing::HasSubstr(list(window)));
  // Older files have no windows.
  std::string silent = text;
  for (const char* name : {"left_window", "right_window"}) {
    const std::size_t at = silent.find(name);
    silent.erase(at, silent.find('\n', at) + 1 - at);
  }
  EXPECT_EQ(bench::parse_calibration(silent, "c.toml", bench).eyes.right.visible.x, visible.x);
}

TEST(Calibration, WhatIsWrongIsNamed)
{
  const bench::BenchFile bench = test::bench_of(test::bench_text());
  const std::string text = bench::calibration_text(bench::nominal_calibration(bench), bench);
  struct Row {
    std::string from, to, field, found;
  };
  for (const Row& row : {
           Row{"version = 1", "version = 2", "version", "2"},
           Row{"bench = \"Desk\"", "bench = \"Lab\"", "bench", "'Lab'"},
           Row{"width = 1280", "width = 1024", "display", "a calibration of 1024 x 1024, quarters"},
           Row{"\"quarters\"", "\"top-bottom\"", "display", "a calibration of 1280 x 1024, top-bottom"},
           Row{"stage_direction = [1.0,", "stage_direction = [0.5,", "stage_direction", "length is not 1"},
           Row{"[left]", "[lefft]", "lefft", "an unknown key"},
           Row{"visible = [640, 16, 640, 480]", "visible = [640, 16, 641, 480]", "left.visible",
               "641x480 at 640, 16"},
           Row{"shift_mm = [0.0, 0.0, 800.0]", "shift_mm = [0.0, 0.0]", "eyes.shift_mm", "[0, 0]"},
       }) {
    SCOPED_TRACE(row.to);
    EXPECT_THAT(test::input_error(
                    [&] { bench::parse_calibration(replaced(text, row.from, row.to), "c.toml", bench); }),
                test::refuses({"c.toml", row.field, row.found}));
  }
  EXPECT_THAT(test::input_error([&] {
                bench::parse_calibration(replaced(text, "k1 = 0.0", "k1 = -5.0"), "c.toml", bench);
              }),
              test::refuses({.field = "left.distortion"}));
}

}  // namespace vrda::calibration_test
