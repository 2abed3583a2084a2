#include "analysis/score.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "analysis/moving_joint.hpp"
#include "support/refusal.hpp"

namespace vrda::score_test {

using analysis::Alignment;
using testing::ElementsAre;

constexpr double rounding = 1e-12;
// Of the rigid fit (rigid_alignment_test.cpp).
constexpr double exact = 1e-9;
constexpr int n = 40;

analysis::ScoreOptions options_of(Alignment align, Side side = Side::right)
{
  analysis::ScoreOptions options;
  options.convention = {side, {3, -8, 5}, analysis::Translations::rotation_centre};
  options.align = align;
  return options;
}

std::vector<analysis::Row> offset_rows(const analysis::Sequence& measured,
                                       const analysis::Coordinates& offset)
{
  std::vector<analysis::Row> rows = measured.rows;
  for (analysis::Row& row : rows) {
    for (std::size_t c = 0; c < analysis::n_scored; ++c) row.value[c] += offset[c];
  }
  return rows;
}

const analysis::Coordinates some_offset{0.01, -0.02, 0.03, 1.0, -2.0, 3.0};

TEST(Score, AConstantOffsetIsBiasAndAlignmentRemovesIt)
{
  const analysis::Sequence measured = test::moving_sequence(n);
  const std::vector<analysis::Row> found = offset_rows(measured, some_offset);
  const analysis::Score raw = analysis::score(found, measured, options_of(Alignment::none));
  const analysis::Score aligned = analysis::score(found, measured, options_of(Alignment::constant));
  for (std::size_t c = 0; c < analysis::n_scored; ++c) {
    SCOPED_TRACE(analysis::coordinate_names[c].name);
    const analysis::Statistics& s = raw.coordinates[c].statistics;
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
  const analysis::Sequence measured = test::moving_sequence(n);
  std::vector<analysis::Row> found = measured.rows;
  for (std::size_t k = 0; k < found.size(); ++k) found[k].value[3] += k < n / 2 ? 1.0 : 3.0;
  analysis::ScoreOptions options = options_of(Alignment::constant);
  options.fit = analysis::RowRange{0, n / 2};
  options.scored = {n / 2, n};
  const analysis::Score s = analysis::score(found, measured, options);
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
  analysis::Sequence measured = test::moving_sequence(n);
  for (std::size_t k = 0; k < measured.rows.size(); ++k) {
    measured.rows[k].value[3] = 2.0 * measured.rows[k].value[analysis::at_flexion];
    measured.rows[k].value[4] = 0.1 * measured.key[k];
  }
  analysis::ScoreOptions options = options_of(Alignment::none);
  const analysis::Score over_flexion = analysis::score(measured.rows, measured, options);
  options.line_over = analysis::LineOver::key;
  const analysis::Score over_key = analysis::score(measured.rows, measured, options);
  EXPECT_NEAR(over_flexion.coordinates[3].line_rms, 0.0, rounding);
  EXPECT_GT(over_flexion.coordinates[4].line_rms, 0.1);
  EXPECT_GT(over_key.coordinates[3].line_rms, 0.1);
  EXPECT_NEAR(over_key.coordinates[4].line_rms, 0.0, rounding);
}

/// The motion after a rigid transform of each body's frame.
std::vector<analysis::Row> transformed(const analysis::Sequence& motion,
                                       const analysis::Convention& convention)
{
  const Pose X_reference = test::rigid_transform(0.2, -0.1, 0.3, {20, -5, 9});
  const Pose X_moving = test::rigid_transform(-0.1, 0.25, 0.1, {-4, 11, 6});
  std::vector<analysis::Row> rows = motion.rows;
  for (analysis::Row& row : rows) {
    const Pose X = X_reference * analysis::right_sided_pose(row.value, convention) * X_moving;
    row.value = analysis::coordinates_of(X, analysis::right_sided(convention));
  }
  return rows;
}

TEST(Score, RigidAlignmentUndoesARigidTransform)
{
  const analysis::Sequence measured = test::moving_sequence(n);
  const analysis::ScoreOptions options = options_of(Alignment::rigid);
  const std::vector<analysis::Row> found = transformed(measured, options.convention);
  EXPECT_GT(analysis::score(found, measured, options_of(Alignment::constant)).coordinates[1].statistics.rms,
            0.01);
  const analysis::Score s = analysis::score(found, measured, options);
  ASSERT_TRUE(s.rigid.has_value());
  EXPECT_TRUE(s.rigid->is_converged);
  for (const analysis::CoordinateScore& c : s.coordinates) EXPECT_LT(c.statistics.rms, exact);
}

TEST(Score, RigidAlignmentFitsOnlyTheRowsToFit)
{
  const analysis::Sequence measured = test::moving_sequence(n);
  analysis::ScoreOptions options = options_of(Alignment::rigid);
  std::vector<analysis::Row> found = transformed(measured, options.convention);
  for (std::size_t k = n / 2; k < n; ++k) found[k].value[4] += 1.0;
  options.fit = analysis::RowRange{0, n / 2};
  options.scored = {n / 2, n};
  const analysis::Score s = analysis::score(found, measured, options);
  EXPECT_LT(s.rigid->rms_mm, exact);
  // a shift along the tibial axis by 1 mm, whatever the transform of the frames
  EXPECT_EQ(s.coordinates[4].statistics.n, static_cast<std::size_t>(n / 2));
  EXPECT_GT(s.coordinates[4].statistics.rms, 0.5);
}

TEST(Score, AMirroredJointHasEqualScores)
{
  // rows are free of the side; the transforms are those of the joint's own side
  const analysis::Sequence measured = test::moving_sequence(n);
  analysis::ScoreOptions right = options_of(Alignment::rigid), left = right;
  left.convention.side = Side::left;
  left.convention.rotation_centre_mm.z() *= -1;
  std::vector<analysis::Row> found = transformed(measured, right.convention);
  for (std::size_t k = 0; k < found.size(); ++k)
    found[k].value[3] += 0.3 * sine(0.9 * static_cast<double>(k));
  const analysis::Score a = analysis::score(found, measured, right),
                        b = analysis::score(found, measured, left);
  for (std::size_t c = 0; c < analysis::n_scored; ++c) {
    EXPECT_EQ(a.coordinates[c].statistics.rms, b.coordinates[c].statistics.rms);
    EXPECT_EQ(a.coordinates[c].statistics.bias, b.coordinates[c].statistics.bias);
    EXPECT_EQ(a.coordinates[c].statistics.correlation, b.coordinates[c].statistics.correlation);
  }
  EXPECT_EQ(analysis::reflected(b.rigid->X_reference).matrix(), a.rigid->X_reference.matrix());
  EXPECT_NE(b.rigid->X_reference.translation().z(), a.rigid->X_reference.translation().z());
}

TEST(Score, RowsWithoutAPoseAreNamedByReason)
{
  analysis::Sequence measured = test::moving_sequence(n);
  std::vector<analysis::Row> found = offset_rows(measured, some_offset);
  for (const std::size_t k : {3u, 7u}) {
    found[k].missing = "no_contact";
    found[k].value.fill(nan);
  }
  found[11].missing = analysis::outside_range;
  measured.rows[12].missing = "no_clearance";
  measured.rows[12].value.fill(nan);
  found[20].is_determined[analysis::at_internal] = false;
  found[20].value[analysis::at_internal] += 1.0;
  for (const Alignment align : {Alignment::none, Alignment::constant}) {
    const analysis::Score s = analysis::score(found, measured, options_of(align));
    EXPECT_EQ(s.n_scored_rows, static_cast<std::size_t>(n - 4));
    EXPECT_THAT(s.missing,
                testing::UnorderedElementsAre(testing::Pair("no_contact", ElementsAre(3, 7)),
                                              testing::Pair(analysis::outside_range, ElementsAre(11)),
                                              testing::Pair("measurement_no_clearance", ElementsAre(12))));
    EXPECT_THAT(s.coordinates[analysis::at_internal].undetermined, ElementsAre(20));
    EXPECT_EQ(s.coordinates[analysis::at_internal].statistics.n, static_cast<std::size_t>(n - 5));
    EXPECT_EQ(s.coordinates[analysis::at_flexion].statistics.n, static_cast<std::size_t>(n - 4));
    EXPECT_NEAR(s.coordinates[analysis::at_internal].statistics.shape, 0.0, rounding);
    EXPECT_TRUE(s.coordinates[analysis::at_flexion].undetermined.empty());
  }
}

TEST(Score, TheLargestDifferenceNamesItsRow)
{
  const analysis::Sequence measured = test::moving_sequence(n);
  std::vector<analysis::Row> found = measured.rows;
  found[2].missing = "no_contact";
  found[30].value[5] -= 0.25;
  const analysis::Score s = analysis::score(found, measured, options_of(Alignment::none));
  EXPECT_EQ(s.coordinates[5].largest_row, 30u);
  EXPECT_NEAR(s.coordinates[5].statistics.largest, 0.25, rounding);
}

TEST(Score, WholeTurnsDoNotCount)
{
  // a hip or a shoulder may pass half a turn; the files hold angles in (-180, 180]
  analysis::Sequence measured = test::moving_sequence(n);
  for (std::size_t k = 0; k < n; ++k)
    measured.rows[k].value[0] = std::remainder(2.9 + 0.02 * static_cast<double>(k), 2.0 * pi);
  std::vector<analysis::Row> found = measured.rows;
  for (analysis::Row& row : found) row.value[0] = std::remainder(row.value[0] - 0.1, 2.0 * pi);
  analysis::ScoreOptions options = options_of(Alignment::none);
  options.line_over = analysis::LineOver::key;
  const analysis::Score s = analysis::score(found, measured, options);
  EXPECT_NEAR(s.coordinates[0].statistics.bias, -0.1, rounding);
  EXPECT_NEAR(s.coordinates[0].statistics.shape, 0.0, rounding);
  EXPECT_NEAR(s.coordinates[0].line_rms, 0.0, rounding);
}

// Past gimbal lock the same pose has numbers half a turn away; a found pose on this side of it is near.
TEST(Score, TheOtherNumbersOfAPoseDoNotCount)
{
  analysis::Sequence measured = test::moving_sequence(n);
  std::vector<analysis::Row> found = measured.rows;
  for (int k = 0; k < n; ++k) {
    // Varus from 60 to 99 degrees: past 90 as clinical_coordinates() has it.
    analysis::Coordinates& m = measured.rows[static_cast<std::size_t>(k)].value;
    m = {0.2, rad_from_deg(60.0 + k), 0.1, 4.0, 0.0, 0.0};
    analysis::Coordinates& f = found[static_cast<std::size_t>(k)].value;
    f = m;
    f[analysis::at_varus] -= 0.01;
    for (analysis::Coordinates* row : {&m, &f}) {
      if ((*row)[analysis::at_varus] < pi / 2) continue;
      *row = {(*row)[0] - pi, pi - (*row)[1], (*row)[2] - pi, -(*row)[3], 0.0, 0.0};
    }
  }
  const analysis::Score of = analysis::score(found, measured, options_of(Alignment::none));
  const analysis::Coordinates wanted{0.0, 0.01, 0.0, 0.0, 0.0, 0.0};
  for (std::size_t c = 0; c < analysis::n_scored; ++c)
    EXPECT_NEAR(of.coordinates[c].statistics.largest, wanted[c], rounding) << c;
}

TEST(Score, NothingInCommonIsRefused)
{
  const analysis::Sequence measured = test::moving_sequence(4);
  std::vector<analysis::Row> found = measured.rows;
  for (analysis::Row& row : found) row.missing = analysis::outside_range;
  const auto score_all = [&] { analysis::score(found, measured, options_of(Alignment::none)); };
  EXPECT_THAT(
      test::input_error(score_all),
      test::refuses({.file = "measured.csv", .field = "rows to score", .found = {"4", "outside_range"}}));
  analysis::ScoreOptions options = options_of(Alignment::constant);
  options.fit = analysis::RowRange{4, 9};
  EXPECT_THAT(test::input_error([&] { analysis::score(measured.rows, measured, options); }),
              test::refuses({.file = "measured.csv", .field = "rows to fit"}));
}

}  // namespace vrda::score_test
