// Differences of two motions: statistics, baselines, alignment.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

#include "analysis/moving_joint.hpp"
#include "analysis/score.hpp"
#include "core/units.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::score_test {

using testing::ElementsAre;

constexpr double rounding = 1e-12;
// Points of some 100 mm with a rounding of 1e-14 each, through a fit with a condition number of some 1e3.
constexpr double exact = 1e-9;
constexpr int n_frames = 40;

ScoreOptions options_of(Alignment align, Side side = Side::right)
{
  ScoreOptions options;
  options.convention = {side, {3, -8, 5}, Translations::rotation_centre};
  options.align = align;
  return options;
}

std::vector<Row> offset_rows(const Sequence& measured, const Coordinates& offset)
{
  std::vector<Row> rows = measured.rows;
  for (Row& row : rows) {
    for (std::size_t c = 0; c < n_scored; ++c) row.value[c] += offset[c];
  }
  return rows;
}

const Coordinates some_offset{0.01, -0.02, 0.03, 1.0, -2.0, 3.0};

TEST(Score, AConstantOffsetIsBiasAndAlignmentRemovesIt)
{
  const Sequence measured = test::moving_sequence(n_frames);
  const std::vector<Row> found = offset_rows(measured, some_offset);
  const Score raw = score(found, measured, options_of(Alignment::none));
  const Score aligned = score(found, measured, options_of(Alignment::constant));
  for (std::size_t c = 0; c < n_scored; ++c) {
    SCOPED_TRACE(joint_coordinate_names[c]);
    const Statistics& s = raw.coordinates[c].statistics;
    EXPECT_EQ(s.n, static_cast<std::size_t>(n_frames));
    EXPECT_NEAR(s.rms, std::abs(some_offset[c]), rounding);
    EXPECT_NEAR(s.bias, some_offset[c], rounding);
    EXPECT_NEAR(s.shape, 0.0, rounding);
    EXPECT_EQ(raw.coordinates[c].offset, 0.0);
    EXPECT_NEAR(aligned.coordinates[c].offset, some_offset[c], rounding);
    EXPECT_NEAR(aligned.coordinates[c].statistics.rms, 0.0, rounding);
  }
  EXPECT_FALSE(raw.rigid.has_value());
}

TEST(Score, WhatIsFittedInTheFirstHalfIsScoredInTheSecond)
{
  // the found motion is 1 mm off in the first half and 3 mm in the second: 2 mm remain
  const Sequence measured = test::moving_sequence(n_frames);
  std::vector<Row> found = measured.rows;
  for (std::size_t k = 0; k < found.size(); ++k) found[k].value[3] += k < n_frames / 2 ? 1.0 : 3.0;
  ScoreOptions options = options_of(Alignment::constant);
  options.fit = RowRange{0, n_frames / 2};
  options.scored = {n_frames / 2, n_frames};
  const Score s = score(found, measured, options);
  EXPECT_EQ(s.n_fit_rows, static_cast<std::size_t>(n_frames / 2));
  EXPECT_EQ(s.n_scored_rows, static_cast<std::size_t>(n_frames / 2));
  EXPECT_NEAR(s.coordinates[3].offset, 1.0, rounding);
  EXPECT_NEAR(s.coordinates[3].statistics.rms, 2.0, rounding);
  EXPECT_NEAR(s.coordinates[3].statistics.bias, 2.0, rounding);
  EXPECT_NEAR(s.coordinates[3].statistics.shape, 0.0, rounding);
  // the baseline is the mean of the rows that were fitted, not of those that are scored
  double mean = 0.0, sum_sq = 0.0;
  for (std::size_t k = 0; k < n_frames / 2; ++k) mean += measured.rows[k].value[3] / (n_frames / 2);
  for (std::size_t k = n_frames / 2; k < n_frames; ++k)
    sum_sq += (measured.rows[k].value[3] - mean) * (measured.rows[k].value[3] - mean);
  EXPECT_NEAR(s.coordinates[3].constant_rms, std::sqrt(sum_sq / (n_frames / 2)), rounding);
}

TEST(Score, TheLineIsOverFlexionOrTheKey)
{
  Sequence measured = test::moving_sequence(n_frames);
  for (std::size_t k = 0; k < measured.rows.size(); ++k) {
    measured.rows[k].value[3] = 2.0 * measured.rows[k].value[at_flexion];
    measured.rows[k].value[4] = 0.1 * measured.key[k];
  }
  ScoreOptions options = options_of(Alignment::none);
  const Score over_flexion = score(measured.rows, measured, options);
  options.line_over = LineOver::key;
  const Score over_key = score(measured.rows, measured, options);
  EXPECT_NEAR(over_flexion.coordinates[3].line_rms, 0.0, rounding);
  EXPECT_GT(over_flexion.coordinates[4].line_rms, 0.1);
  EXPECT_GT(over_key.coordinates[3].line_rms, 0.1);
  EXPECT_NEAR(over_key.coordinates[4].line_rms, 0.0, rounding);
}

/// The motion after a rigid transform of each body's frame.
std::vector<Row> transformed(const Sequence& motion, const Convention& convention)
{
  const Pose X_reference = test::rigid_transform(0.2, -0.1, 0.3, {20, -5, 9});
  const Pose X_moving = test::rigid_transform(-0.1, 0.25, 0.1, {-4, 11, 6});
  std::vector<Row> rows = motion.rows;
  for (Row& row : rows) {
    const Pose X = X_reference * right_sided_pose(row.value, convention) * X_moving;
    row.value = coordinates_of(X, right_sided(convention));
  }
  return rows;
}

TEST(Score, RigidAlignmentFitsOnlyTheRowsToFit)
{
  const Sequence measured = test::moving_sequence(n_frames);
  ScoreOptions options = options_of(Alignment::rigid);
  std::vector<Row> found = transformed(measured, options.convention);
  for (std::size_t k = n_frames / 2; k < n_frames; ++k) found[k].value[4] += 1.0;
  options.fit = RowRange{0, n_frames / 2};
  options.scored = {n_frames / 2, n_frames};
  const Score s = score(found, measured, options);
  EXPECT_LT(s.rigid->rms_mm, exact);
  // a shift along the tibial axis by 1 mm, whatever the transform of the frames
  EXPECT_EQ(s.coordinates[4].statistics.n, static_cast<std::size_t>(n_frames / 2));
  EXPECT_GT(s.coordinates[4].statistics.rms, 0.5);
}

TEST(Score, RowsWithoutAPoseAreNamedByReason)
{
  Sequence measured = test::moving_sequence(n_frames);
  std::vector<Row> found = offset_rows(measured, some_offset);
  for (const std::size_t k : {3u, 7u}) {
    found[k].missing = "no_contact";
    found[k].value.fill(nan);
  }
  found[11].missing = outside_range;
  measured.rows[12].missing = "no_clearance";
  measured.rows[12].value.fill(nan);
  found[20].is_determined[at_internal] = false;
  found[20].value[at_internal] += 1.0;
  found[30].value[5] += 0.25;
  for (const Alignment align : {Alignment::none, Alignment::constant}) {
    const Score s = score(found, measured, options_of(align));
    EXPECT_EQ(s.n_scored_rows, static_cast<std::size_t>(n_frames - 4));
    EXPECT_THAT(s.missing,
                testing::UnorderedElementsAre(testing::Pair("no_contact", ElementsAre(3, 7)),
                                              testing::Pair(outside_range, ElementsAre(11)),
                                              testing::Pair("measurement_no_clearance", ElementsAre(12))));
    EXPECT_THAT(s.coordinates[at_internal].undetermined, ElementsAre(20));
    EXPECT_EQ(s.coordinates[at_internal].statistics.n, static_cast<std::size_t>(n_frames - 5));
    EXPECT_EQ(s.coordinates[at_flexion].statistics.n, static_cast<std::size_t>(n_frames - 4));
    EXPECT_NEAR(s.coordinates[at_internal].statistics.shape, 0.0, rounding);
    EXPECT_TRUE(s.coordinates[at_flexion].undetermined.empty());
    EXPECT_EQ(s.coordinates[5].largest_row, 30u);
  }
}

TEST(Score, WholeTurnsDoNotCount)
{
  // a hip or a shoulder may pass half a turn; the files hold angles in (-180, 180]
  Sequence measured = test::moving_sequence(n_frames);
  for (std::size_t k = 0; k < n_frames; ++k)
    measured.rows[k].value[0] = std::remainder(2.9 + 0.02 * static_cast<double>(k), 2.0 * pi);
  std::vector<Row> found = measured.rows;
  for (Row& row : found) row.value[0] = std::remainder(row.value[0] - 0.1, 2.0 * pi);
  ScoreOptions options = options_of(Alignment::none);
  options.line_over = LineOver::key;
  const Score s = score(found, measured, options);
  EXPECT_NEAR(s.coordinates[0].statistics.bias, -0.1, rounding);
  EXPECT_NEAR(s.coordinates[0].statistics.shape, 0.0, rounding);
  EXPECT_NEAR(s.coordinates[0].line_rms, 0.0, rounding);
}

// Past gimbal lock the same pose has numbers half a turn away; a found pose on this side of it is near.
TEST(Score, TheOtherNumbersOfAPoseDoNotCount)
{
  Sequence measured = test::moving_sequence(n_frames);
  std::vector<Row> found = measured.rows;
  for (int k = 0; k < n_frames; ++k) {
    // Varus from 60 to 99 degrees: past 90 as clinical_coordinates() has it.
    Coordinates& m = measured.rows[static_cast<std::size_t>(k)].value;
    m = {0.2, rad_from_deg(60.0 + k), 0.1, 4.0, 0.0, 0.0};
    Coordinates& f = found[static_cast<std::size_t>(k)].value;
    f = m;
    f[at_varus] -= 0.01;
    for (Coordinates* row : {&m, &f}) {
      if ((*row)[at_varus] < pi / 2) continue;
      *row = {(*row)[0] - pi, pi - (*row)[1], (*row)[2] - pi, -(*row)[3], 0.0, 0.0};
    }
  }
  const Score of = score(found, measured, options_of(Alignment::none));
  const Coordinates wanted{0.0, 0.01, 0.0, 0.0, 0.0, 0.0};
  for (std::size_t c = 0; c < n_scored; ++c)
    EXPECT_NEAR(of.coordinates[c].statistics.largest, wanted[c], rounding) << c;
}

TEST(Score, NothingInCommonIsRefused)
{
  const Sequence measured = test::moving_sequence(4);
  std::vector<Row> found = measured.rows;
  for (Row& row : found) row.missing = outside_range;
  const auto score_all = [&] { score(found, measured, options_of(Alignment::none)); };
  EXPECT_THAT(
      test::input_error(score_all),
      test::refuses({.file = "measured.csv", .field = "rows to score", .found = {"4", "outside_range"}}));
  ScoreOptions options = options_of(Alignment::constant);
  options.fit = RowRange{4, 9};
  EXPECT_THAT(test::input_error([&] { score(measured.rows, measured, options); }),
              test::refuses({.file = "measured.csv", .field = "rows to fit"}));
}

const Eigen::Vector3d centre_mm(3, -8, 5);

std::vector<Pose> moving_poses(int n)
{
  std::vector<Pose> poses;
  for (int k = 0; k < n; ++k) {
    poses.push_back(right_sided_pose(test::moving_coordinates(k, n),
                                     {Side::right, centre_mm, Translations::rotation_centre}));
  }
  return poses;
}

std::vector<Pose> transformed(const Pose& X_reference, const std::vector<Pose>& poses, const Pose& X_moving)
{
  std::vector<Pose> result;
  for (const Pose& X : poses) result.push_back(X_reference * X * X_moving);
  return result;
}

double largest_difference(const Pose& a, const Pose& b)
{
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(RigidAlignment, UndoesARigidTransformOfEachBody)
{
  const std::vector<Pose> found = moving_poses(40);
  struct Row {
    Pose X_reference, X_moving;
  };
  for (const Row& row : {Row{Pose::Identity(), Pose::Identity()},
                         Row{test::rigid_transform(0.02, -0.03, 0.01, {1, -2, 0.5}), Pose::Identity()},
                         Row{Pose::Identity(), test::rigid_transform(0.1, 0.2, -0.1, {-5, 1, 3})},
                         Row{test::rigid_transform(2.5, -1.0, 3.0, {400, -70, 20}),
                             test::rigid_transform(-1.7, 0.8, 1.2, {-30, 90, -250})}}) {
    const std::vector<Pose> measured = transformed(row.X_reference, found, row.X_moving);
    const RigidAlignment a = rigid_alignment(found, measured, centre_mm);
    EXPECT_TRUE(a.is_converged);
    EXPECT_EQ(a.n_determined, 12);
    EXPECT_LT(a.rms_mm, exact);
    EXPECT_LT(largest_difference(a.X_reference, row.X_reference), exact);
    EXPECT_LT(largest_difference(a.X_moving, row.X_moving), exact);
  }
}

TEST(RigidAlignment, OfAHingeLeavesItsAxisUndetermined)
{
  // the reference may turn about the hinge and slide along it if the moving object undoes both
  std::vector<Pose> found;
  for (int k = 0; k < 20; ++k) found.push_back(test::rigid_transform(0, 0, -0.05 * k, {0, 0, 0}));
  const Pose X_reference = test::rigid_transform(0.3, 0.1, 0.2, {4, 5, 6});
  const RigidAlignment a =
      rigid_alignment(found, transformed(X_reference, found, Pose::Identity()), centre_mm);
  EXPECT_TRUE(a.is_converged);
  EXPECT_EQ(a.n_determined, 10);
  EXPECT_LT(a.rms_mm, exact);
}

TEST(RigidAlignment, OfAShortNoisyMotionClaimsNoLargeRotation)
{
  // Seven degrees of flexion; varus and internal rotation are small and found with the wrong sign. Half a
  // turn of both frames about the axis of flexion mends the sign and leaves less, but only as much as the
  // noise.
  std::vector<Pose> found, measured;
  for (int k = 0; k < 30; ++k) {
    const double flexion_rad = 0.12 * sine(0.2 * k), small_rad = 0.01 * sine(1.3 * k);
    found.push_back(test::rigid_transform(small_rad, -small_rad, -flexion_rad, {0, 0, 0}));
    measured.push_back(test::rigid_transform(-small_rad, small_rad, -flexion_rad, {1, 0, 0}));
    measured.back().translation() += 0.5 * Eigen::Vector3d(sine(2.1 * k), sine(3.7 * k), sine(5.3 * k));
  }
  const RigidAlignment a = rigid_alignment(found, measured, {0, 0, 0});
  EXPECT_TRUE(a.is_converged);
  EXPECT_LT(a.n_determined, 12);
  EXPECT_GT(a.X_reference.linear().trace(), 2.9);  // below 20 degrees
  EXPECT_GT(a.X_moving.linear().trace(), 2.9);
  EXPECT_NEAR((a.X_reference * a.X_moving).translation().x(), 1.0, 0.2);
}

TEST(RigidAlignment, LeavesWhatNoTransformExplains)
{
  // noise of known size: the distance left is at most that without alignment, and no small change of either
  // transform brings the poses nearer
  const std::vector<Pose> found = moving_poses(40);
  std::vector<Pose> measured = found;
  for (std::size_t k = 0; k < measured.size(); ++k) measured[k].translation().x() += k % 2 == 0 ? 0.5 : -0.5;
  const RigidAlignment a = rigid_alignment(found, measured, centre_mm);
  EXPECT_TRUE(a.is_converged);
  EXPECT_GT(a.rms_mm, 0.4);
  EXPECT_LE(a.rms_mm, 0.5);
  const RigidAlignment again =
      rigid_alignment(transformed(a.X_reference, found, a.X_moving), measured, centre_mm);
  EXPECT_NEAR(again.rms_mm, a.rms_mm, exact);
  // Of a quadratic with a rounding of 1e-16: the minimum is known to its square root.
  EXPECT_LT(largest_difference(again.X_reference, Pose::Identity()), 1e-6);
  EXPECT_LT(largest_difference(again.X_moving, Pose::Identity()), 1e-6);
}

// Rounding of sums of some 400 numbers near 1.
constexpr double sum_rounding = 1e-13;

/// A sine over whole periods, `n` samples.
std::vector<double> sine_of(double phase_rad, double amplitude = 1.0, int n = 360)
{
  std::vector<double> values;
  for (int k = 0; k < n; ++k) values.push_back(amplitude * sine(2.0 * pi * k / n + phase_rad));
  return values;
}

TEST(ScoreStatistics, RmsSplitsIntoBiasAndShape)
{
  // differences 4 and 0: RMS sqrt(8), bias 2, shape 2
  const Statistics s = statistics({5, 3}, {1, 3});
  EXPECT_NEAR(s.rms, std::sqrt(8.0), sum_rounding);
  EXPECT_NEAR(s.bias, 2.0, sum_rounding);
  EXPECT_NEAR(s.shape, 2.0, sum_rounding);
  EXPECT_EQ(s.largest, 4.0);
  EXPECT_EQ(s.largest_at, 0u);
}

TEST(ScoreStatistics, AShiftedSineHasTheCosineOfItsShift)
{
  // over whole periods: correlation cos(p), RMS of the difference 2 sin(p / 2) / sqrt(2); amplitude does not
  // change the correlation, a sign does
  for (const double shift_rad : {0.0, 0.4, pi / 2, 2.0, pi}) {
    SCOPED_TRACE(shift_rad);
    const Statistics s = statistics(sine_of(shift_rad), sine_of(0.0));
    EXPECT_NEAR(s.correlation, cosine(shift_rad), sum_rounding);
    EXPECT_NEAR(s.rms, std::sqrt(2.0) * sine(shift_rad / 2), sum_rounding);
    EXPECT_NEAR(s.bias, 0.0, sum_rounding);
    EXPECT_NEAR(statistics(sine_of(shift_rad, 3.0), sine_of(0.0)).correlation, cosine(shift_rad),
                sum_rounding);
    EXPECT_NEAR(statistics(sine_of(shift_rad, -1.0), sine_of(0.0)).correlation, -cosine(shift_rad),
                sum_rounding);
  }
}

TEST(ScoreStatistics, AConstantHasNoCorrelation)
{
  // 0.1 added ten times has a mean that is not 0.1: rounding is no variation
  const std::vector<double> constant(10, 0.1), varying{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  EXPECT_TRUE(std::isnan(statistics(constant, varying).correlation));
  EXPECT_TRUE(std::isnan(statistics(varying, constant).correlation));
  EXPECT_NEAR(statistics(varying, varying).correlation, 1.0, sum_rounding);
}

TEST(ScoreStatistics, WithoutFramesNothingIsKnown)
{
  const Statistics s = statistics({}, {});
  EXPECT_EQ(s.n, 0u);
  for (const double value : {s.rms, s.bias, s.shape, s.correlation, s.largest})
    EXPECT_TRUE(std::isnan(value));
  EXPECT_TRUE(std::isnan(rms_of({}, {}, {})));
}

TEST(Baseline, OfAStraightLineIsZero)
{
  const std::vector<double> x{3, -1, 4, 10};
  std::vector<double> values;
  for (const double value : x) values.push_back(2.0 - 0.5 * value);
  EXPECT_NEAR(rms_of(straight_line(x, values), x, values), 0.0, sum_rounding);
  EXPECT_NEAR(straight_line(x, values).slope, -0.5, sum_rounding);
  const std::vector<double> same(3, 0.1);  // over a constant the line is the constant
  EXPECT_NEAR(straight_line(same, {1, 2, 6}).at(17.0), 3.0, sum_rounding);
  // the constant leaves the standard deviation: x has mean 4, squares of the deviations 1, 25, 0, 36
  EXPECT_NEAR(rms_of(constant(values), x, values), 0.5 * std::sqrt(62.0 / 4.0), sum_rounding);
}

TEST(Baseline, TheLineIsNeverWorseThanTheConstantWhereItIsFitted)
{
  const std::vector<double> x = sine_of(0.0), values = sine_of(1.1);
  // the line explains the square of the correlation: what is left is sin(1.1) / sqrt(2)
  EXPECT_NEAR(rms_of(straight_line(x, values), x, values), sine(1.1) / std::sqrt(2.0), sum_rounding);
  EXPECT_NEAR(rms_of(constant(values), x, values), 1.0 / std::sqrt(2.0), sum_rounding);
}

}  // namespace vrda::analysis::score_test
