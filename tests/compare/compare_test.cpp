#include "compare/compare.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "compare/noisy_joint.hpp"
#include "compare/perceptible.hpp"
#include "support/input_error.hpp"

namespace vrda::compare_test {

using test::input_error;
using test::noisy_model;

CompareOptions options_of(std::vector<int> degrees)
{
  CompareOptions options;
  options.name = "knee.h5";
  options.degrees = std::move(degrees);
  return options;
}

TEST(Compare, TellsWhatSmoothTells)
{
  const MotionModel model = noisy_model({.degree = 3, .noise_mm = 0.05});
  const Comparison comparison = compare(model, options_of({2, 4, 6}));
  ASSERT_EQ(comparison.rows.size(), 3u);
  const SmoothedSet set = smooth(smooth_input(model, "knee.h5"), 4);
  const DegreeRow& row = comparison.rows[1];
  EXPECT_EQ(row.set.degree, 4);
  ASSERT_EQ(row.surfaces.size(), 4u);
  double rms_sq = 0.0;
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_EQ(row.surfaces[s].name, set.surfaces[s].name);
    EXPECT_EQ(row.surfaces[s].n_cells, 21 * 13);
    EXPECT_EQ(row.surfaces[s].condition_number, set.surfaces[s].condition_number);
    EXPECT_EQ(row.surfaces[s].errors.rms, set.surfaces[s].rms);
    EXPECT_EQ(row.surfaces[s].errors.largest, set.surfaces[s].largest_residual);
    EXPECT_EQ(row.surfaces[s].errors.leave_one_out, set.surfaces[s].leave_one_out_rms);
    EXPECT_GT(row.surfaces[s].errors.roughness, 0.0);
    rms_sq += s < 3 ? set.surfaces[s].rms * set.surfaces[s].rms : 0.0;
  }
  EXPECT_NEAR(row.translation.rms, std::sqrt(rms_sq), 1e-15);
  EXPECT_GE(row.translation.largest, set.surfaces[0].largest_residual);
  EXPECT_FALSE(row.faults.has_value());
  EXPECT_TRUE(row.is_converged);
}

TEST(Compare, CountsPerceptibleAttitudes)
{
  // Zero surfaces but for a few cells: the constant fit is their mean, which 4 of 273 move by far too little.
  MotionModel model = noisy_model({.degree = 1});
  for (GridD* surface : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) surface->setZero();
  model.tx_mm(3, 3) = model.ty_mm(3, 3) = 0.8 * perceptible_mm;  // together 1.13
  model.tx_mm(4, 4) = model.ty_mm(4, 4) = 0.6 * perceptible_mm;  // together 0.85
  model.theta_deg(5, 5) = 1.1 * perceptible_deg;
  model.theta_deg(6, 6) = 1.1 * perceptible_deg;
  model.theta_determined(6, 6) = 0;
  const Comparison comparison = compare(model, options_of({0}));
  EXPECT_DOUBLE_EQ(comparison.rows[0].perceptible_share, 2.0 / 273.0);
}

TEST(Compare, CountsWhatRecontactMoves)
{
  MotionModel model = noisy_model({.degree = 2});
  CompareOptions options = options_of({2});
  EXPECT_EQ(compare(model, options).rows[0].perceptible_share, 0.0);
  options.recontact = [](const MotionModel& of, const SmoothedSet& set) {
    EXPECT_EQ(set.degree, 2);
    GridD travel_mm = GridD::Zero(of.status.rows(), of.status.cols());
    travel_mm.row(0).setConstant(-2.0 * perceptible_mm);
    travel_mm(1, 1) = std::numeric_limits<double>::quiet_NaN();
    return travel_mm;
  };
  const DegreeRow row = compare(model, options).rows[0];
  EXPECT_DOUBLE_EQ(row.perceptible_share, 13.0 / 273.0);
  EXPECT_TRUE(row.set.recontact_mm.has_value());
}

TEST(Compare, AuditsTheMotionOfEachDegree)
{
  MotionModel model = noisy_model({.degree = 2, .noise_mm = 0.01});
  model.smoothed = {smooth(smooth_input(model, "knee.h5"), 6)};
  std::vector<std::string> asked;
  CompareOptions options = options_of({1, 2});
  options.audit = [&](const MotionModel& of, const std::string& set) {
    asked.push_back(set);
    EXPECT_EQ(of.smoothed.size(), 1u);
    EXPECT_EQ(set.rfind("degree_" + std::to_string(of.smoothed.at(0).degree), 0), 0u);
    AuditSet audit;
    audit.refine = 1;
    audit.state = GridB::Constant(21, 13, static_cast<std::int8_t>(AuditState::overlapping));
    audit.penetration_mm = GridD::Constant(21, 13, 0.1 * of.smoothed.at(0).degree);
    audit.gap_mm = GridD::Constant(21, 13, std::numeric_limits<double>::quiet_NaN());
    return audit;
  };
  const Comparison comparison = compare(model, options);
  EXPECT_EQ(asked, (std::vector<std::string>{"degree_1", "degree_2"}));
  EXPECT_EQ(comparison.rows[1].faults.value().at_grid.largest_penetration_mm, 0.2);
  EXPECT_EQ(comparison.rows[1].faults.value().at_grid.n_overlapping, 273);
  asked.clear();
  options.recontact = [](const MotionModel& of, const SmoothedSet&) {
    return GridD::Zero(of.status.rows(), of.status.cols()).eval();
  };
  compare(model, options);
  EXPECT_EQ(asked, (std::vector<std::string>{"degree_1_recontacted", "degree_2_recontacted"}));
}

TEST(Compare, LeavesOutDegreesThatTheCellsCannotCarry)
{
  const MotionModel model = noisy_model({.degree = 2, .noise_mm = 0.01, .n_flexion = 20, .n_varus = 5});
  const Comparison comparison = compare(model, options_of({2, 4, 5, 9}));
  ASSERT_EQ(comparison.rows.size(), 2u);
  EXPECT_EQ(comparison.degrees_not_carried, (std::vector<int>{5, 9}));
  EXPECT_EQ(comparison.recommendation.degree, 2);
  const InputError::Facts facts = input_error([&] { compare(model, options_of({5, 6})); });
  EXPECT_EQ(facts.file, "knee.h5");
  EXPECT_EQ(facts.wanted, "enough for the 21 terms of degree 5; they carry degree 4");
}

TEST(Compare, RecommendsNothingWhereNoCellCanBeLeftOut)
{
  const MotionModel model = noisy_model({.degree = 1, .noise_mm = 0.01, .n_flexion = 3, .n_varus = 1});
  const Comparison comparison = compare(model, options_of({2}));
  EXPECT_EQ(comparison.recommendation.degree, -1);
  EXPECT_TRUE(std::isnan(comparison.rows[0].translation.leave_one_out));
}

TEST(Compare, JudgesThetaWhereEveryDegreeHasIt)
{
  // Degree 1 finds enough cells that determine theta; degree 3 has to take all of them.
  MotionModel model = noisy_model({.degree = 1, .noise_mm = 0.01});
  model.theta_determined.setZero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) model.theta_determined(5 * i, 4 * j) = 1;
  }
  const Comparison comparison = compare(model, options_of({1, 3}));
  EXPECT_EQ(comparison.rows[0].surfaces[3].n_cells, 9);
  EXPECT_EQ(comparison.rows[1].surfaces[3].n_cells, 273);
  EXPECT_EQ(comparison.recommendation.degree, 1);
}

TEST(Compare, VarusCountsAsAnAngleWhereItWasFree)
{
  MotionModel model = noisy_model({.degree = 1, .n_flexion = 31, .n_varus = 1});
  for (int i = 0; i < 31; ++i) model.varus_solved_deg(i, 0) = 1.0 + 0.02 * i * i;
  const Comparison comparison = compare(model, options_of({1, 2}));
  ASSERT_EQ(comparison.rows[0].surfaces.size(), 5u);
  EXPECT_EQ(comparison.rows[0].surfaces[4].name, "varus");
  EXPECT_GT(comparison.rows[0].perceptible_share, 0.5);
  EXPECT_EQ(comparison.rows[1].perceptible_share, 0.0);
  EXPECT_EQ(comparison.recommendation.degree, 2);
}

}  // namespace vrda::compare_test
