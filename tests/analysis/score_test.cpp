#include "analysis/score.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "analysis/moving_joint.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::score_test {

using testing::ElementsAre;

constexpr double rounding = 1e-12;
// Of the rigid fit (rigid_alignment_test.cpp).
constexpr double exact = 1e-9;
constexpr int n = 40;

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
  const Sequence measured = test::moving_sequence(n);
  const std::vector<Row> found = offset_rows(measured, some_offset);
  const Score raw = score(found, measured, options_of(Alignment::none));
  const Score aligned = score(found, measured, options_of(Alignment::constant));
  for (std::size_t c = 0; c < n_scored; ++c) {
    SCOPED_TRACE(coordinate_names[c].name);
    const Statistics& s = raw.coordinates[c].statistics;
    EXPECT_EQ(s.n, static_cast<std::size_t>(n));
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
  const Sequence measured = test::moving_sequence(n);
  std::vector<Row> found = measured.rows;
  for (std::size_t k = 0; k < found.size(); ++k) found[k].value[3] += k < n / 2 ? 1.0 : 3.0;
  ScoreOptions options = options_of(Alignment::constant);
  options.fit = RowRange{0, n / 2};
  options.scored = {n / 2, n};
  const Score s = score(found, measured, options);
  EXPECT_EQ(s.n_fit_rows, static_cast<std::size_t>(n / 2));
  EXPECT_EQ(s.n_scored_rows, static_cast<std::size_t>(n / 2));
  EXPECT_NEAR(s.coordinates[3].offset, 1.0, rounding);
  EXPECT_NEAR(s.coordinates[3].statistics.rms, 2.0, rounding);
  EXPECT_NEAR(s.coordinates[3].statistics.bias, 2.0, rounding);
  EXPECT_NEAR(s.coordinates[3].statistics.shape, 0.0, rounding);
  // the baseline is the mean of the rows that were fitted, not of those that are scored
  double mean = 0.0, sum_sq = 0.0;
  for (std::size_t k = 0; k < n / 2; ++k) mean += measured.rows[k].value[3] / (n / 2);
  for (std::size_t k = n / 2; k < n; ++k)
    sum_sq += (measured.rows[k].value[3] - mean) * (measured.rows[k].value[3] - mean);
  EXPECT_NEAR(s.coordinates[3].constant_rms, std::sqrt(sum_sq / (n / 2)), rounding);
}

TEST(Score, TheLineIsOverFlexionOrTheKey)
{
  Sequence measured = test::moving_sequence(n);
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
  const Sequence measured = test::moving_sequence(n);
  ScoreOptions options = options_of(Alignment::rigid);
  std::vector<Row> found = transformed(measured, options.convention);
  for (std::size_t k = n / 2; k < n; ++k) found[k].value[4] += 1.0;
  options.fit = RowRange{0, n / 2};
  options.scored = {n / 2, n};
  const Score s = score(found, measured, options);
  EXPECT_LT(s.rigid->rms_mm, exact);
  // a shift along the tibial axis by 1 mm, whatever the transform of the frames
  EXPECT_EQ(s.coordinates[4].statistics.n, static_cast<std::size_t>(n / 2));
  EXPECT_GT(s.coordinates[4].statistics.rms, 0.5);
}

TEST(Score, RowsWithoutAPoseAreNamedByReason)
{
  Sequence measured = test::moving_sequence(n);
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
    EXPECT_EQ(s.n_scored_rows, static_cast<std::size_t>(n - 4));
    EXPECT_THAT(s.missing,
                testing::UnorderedElementsAre(testing::Pair("no_contact", ElementsAre(3, 7)),
                                              testing::Pair(outside_range, ElementsAre(11)),
                                              testing::Pair("measurement_no_clearance", ElementsAre(12))));
    EXPECT_THAT(s.coordinates[at_internal].undetermined, ElementsAre(20));
    EXPECT_EQ(s.coordinates[at_internal].statistics.n, static_cast<std::size_t>(n - 5));
    EXPECT_EQ(s.coordinates[at_flexion].statistics.n, static_cast<std::size_t>(n - 4));
    EXPECT_NEAR(s.coordinates[at_internal].statistics.shape, 0.0, rounding);
    EXPECT_TRUE(s.coordinates[at_flexion].undetermined.empty());
    EXPECT_EQ(s.coordinates[5].largest_row, 30u);
  }
}

TEST(Score, WholeTurnsDoNotCount)
{
  // a hip or a shoulder may pass half a turn; the files hold angles in (-180, 180]
  Sequence measured = test::moving_sequence(n);
  for (std::size_t k = 0; k < n; ++k)
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
  Sequence measured = test::moving_sequence(n);
  std::vector<Row> found = measured.rows;
  for (int k = 0; k < n; ++k) {
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

}  // namespace vrda::analysis::score_test
