#include "bench/calibration_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <random>
#include <set>

#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::calibration_file_test {

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

std::string replaced(std::string text, const std::string& from, const std::string& to)
{
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
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

TEST(Calibration, WhatIsWrongIsNamed)
{
  const BenchFile bench = test::bench_of(test::bench_text());
  const std::string text = calibration_text(nominal_calibration(bench), bench);
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
           Row{"k1 = 0.0", "k1 = -5.0", "left.distortion", ""},
       }) {
    SCOPED_TRACE(row.to);
    EXPECT_THAT(
        test::input_error([&] { parse_calibration(replaced(text, row.from, row.to), "c.toml", bench); }),
        test::refuses({"c.toml", row.field, row.found}));
  }
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

TEST(CalibrationRecord, AFileWithoutRecordsStillReads)
{
  const BenchFile bench = test::bench_of(test::bench_text());
  std::string text = calibration_text(nominal_calibration(bench), bench);
  const std::size_t at = text.find("subject_scale");
  text.erase(at, text.find('\n', at) + 1 - at);
  const Calibration read = parse_calibration(text, "c.toml", bench);
  EXPECT_EQ(read.subject_scale, 1.0);
  EXPECT_TRUE(read.records.empty());
}

TEST(CalibrationRecord, WhatIsDamagedIsNamed)
{
  const BenchFile bench = test::bench_of(test::bench_text());
  const std::string whole = calibration_text(nominal_calibration(bench), bench);
  const std::string dated = "date = \"2026-11-22\"\n";
  const std::string place = "per_person.ipd", head = "[" + place + "]\n" + dated;
  const std::string result = head + "[" + place + ".result]\n";
  const std::string names = "names = [\"ipd\"]\nunits = [\"mm\"]\n", values = names + "values = [64]\n";
  const std::string mark = head + "[[" + place + ".mark]]\n", rest = "residuals = []\nresidual_rms = 0\n";
  const std::string covariance = values + "covariance = [[0.25]]\n";
  struct Row {
    std::string text, field, found;
  };
  for (const Row& row : {
           Row{"[per_bench.eyes]\n" + dated, "per_bench.eyes", "an unknown key"},
           Row{"[per_bench.ipd]\n" + dated, "per_bench.ipd", "an unknown key"},
           Row{"[per_person.rails]\n" + dated, "per_person.rails", "an unknown key"},
           Row{"[per_person]\nipd = 1\n", "per_person.ipd", "1"},
           Row{"[" + place + "]\n", place + ".date", "nothing"},
           Row{head + "marks = 1\n", place + ".marks", "an unknown key"},
           Row{mark, place + ".mark.0.task", "nothing"},
           Row{mark + "task = \"a\"\nrows = []\n[[" + place + ".mark]]\ntask = \"a\"\nrows = []\n",
               place + ".mark.1.task", "'a'"},
           Row{result + "names = [\"ipd\"]\nunits = []\nvalues = [64]\ndof = inf\n" + rest,
               place + ".result.units", "0 units"},
           Row{result + names + "values = [1, 2]\ndof = inf\n" + rest, place + ".result.values", "2 numbers"},
           Row{result + values + "dof = inf\n" + rest, place + ".result.covariance", "0 rows"},
           Row{result + values + "covariance = [[1], [2]]\ndof = inf\n" + rest, place + ".result.covariance",
               "2 rows"},
           Row{result + values + "covariance = [[1, 2]]\ndof = inf\n" + rest, place + ".result.covariance.0",
               "2 numbers"},
           Row{result + values + "covariance = [[-1]]\ndof = inf\n" + rest, place + ".result.covariance",
               "negative"},
           Row{result +
                   "names = [\"pd\"]\nunits = [\"mm\"]\nvalues = [64]\ncovariance = [[0.25]]\ndof = inf\n" +
                   rest,
               place + ".result.names", "no 'ipd'"},
       }) {
    SCOPED_TRACE(row.text);
    EXPECT_THAT(test::input_error([&] { parse_calibration(whole + row.text, "c.toml", bench); }),
                test::refuses({"c.toml", row.field, row.found}));
  }
  const Calibration read =
      parse_calibration(whole + result + covariance + "dof = inf\n" + rest, "c.toml", bench);
  EXPECT_EQ(read.records.at(CalibrationPart::ipd).estimate->values[0], 64.0);
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
  int n_kept = 0;
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    const Parameter& parameter = parameters()[k];
    SCOPED_TRACE(parameter.name);
    BenchValues values = nominal_values();
    set_value(values, k, value_of(values, k) + 2.0 * parameter.step);
    const std::string text = calibration_text(values.calibration, bench);
    BenchValues read;
    read.calibration = parse_calibration(text, "c.toml", bench);
    EXPECT_EQ(text != nominal, parameter.is_saved);
    // Values that are not in the file would be lost at the next start.
    EXPECT_EQ(read.calibration.eyes.left.distortion.pixel_aspect,
              values.calibration.eyes.left.distortion.pixel_aspect);
    EXPECT_EQ(read.calibration.eyes.right.distortion.pixel_aspect,
              values.calibration.eyes.right.distortion.pixel_aspect);
    for (std::size_t other = 3; other < parameters().size(); ++other)
      EXPECT_NEAR(value_of(read, other), value_of(values, other), degrees_rounding)
          << parameters()[other].name;
    n_kept += parameter.is_saved ? 1 : 0;
  }
  EXPECT_EQ(n_kept, static_cast<int>(parameters().size()) - 3);
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

}  // namespace vrda::calibration_file_test
