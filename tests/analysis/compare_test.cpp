#include "analysis/compare.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "analysis/noisy_joint.hpp"
#include "analysis/smooth.hpp"
#include "analysis/smooth_inputs.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::compare_test {

using test::input_error;
using test::noisy_model;

CompareOptions options_of(std::vector<int> degrees)
{
  CompareOptions options;
  options.name = "knee.h5";
  options.degrees = std::move(degrees);
  return options;
}

TEST(Compare, ReportsTheSameResidualsAsSmooth)
{
  const store::MotionModel model = noisy_model({.degree = 3, .noise_mm = 0.05});
  const Comparison comparison = compare(model, options_of({2, 4, 6}));
  ASSERT_EQ(comparison.rows.size(), 3u);
  const store::SmoothedSet set = smooth(smooth_input(model, "knee.h5"), 4);
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
  EXPECT_FALSE(row.audit_totals.has_value());
  EXPECT_TRUE(row.is_converged);
}

TEST(Compare, CountsPerceptibleAttitudes)
{
  // Zero surfaces except a few cells: the constant fit is the mean, which 4 of 273 cells hardly change.
  store::MotionModel model = noisy_model({.degree = 1});
  for (store::GridD* surface : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg})
    surface->setZero();
  model.tx_mm(3, 3) = model.ty_mm(3, 3) = 0.8 * perceptible_mm;  // together 1.13
  model.tx_mm(4, 4) = model.ty_mm(4, 4) = 0.6 * perceptible_mm;  // together 0.85
  model.theta_deg(5, 5) = 1.1 * deg_from_rad(perceptible_rad);
  model.theta_deg(6, 6) = 1.1 * deg_from_rad(perceptible_rad);
  model.theta_determined(6, 6) = 0;
  const Comparison comparison = compare(model, options_of({0}));
  EXPECT_DOUBLE_EQ(comparison.rows[0].perceptible_share, 2.0 / 273.0);
}

TEST(Compare, CountsWhatRecontactMoves)
{
  store::MotionModel model = noisy_model({.degree = 2});
  CompareOptions options = options_of({2});
  EXPECT_EQ(compare(model, options).rows[0].perceptible_share, 0.0);
  options.recontact = [](const store::MotionModel& of, store::SmoothedSet& set) {
    EXPECT_EQ(set.degree, 2);
    set.recontact_mm = store::GridD::Zero(of.status.rows(), of.status.cols());
    set.recontact_mm->row(0).setConstant(-2.0 * perceptible_mm);
    (*set.recontact_mm)(1, 1) = std::numeric_limits<double>::quiet_NaN();
  };
  const DegreeRow row = compare(model, options).rows[0];
  EXPECT_DOUBLE_EQ(row.perceptible_share, 13.0 / 273.0);
  EXPECT_TRUE(row.set.recontact_mm.has_value());
}

TEST(Compare, AuditsTheMotionOfEachDegree)
{
  store::MotionModel model = noisy_model({.degree = 2, .noise_mm = 0.01});
  model.smoothed = {smooth(smooth_input(model, "knee.h5"), 6)};
  std::vector<std::string> requested;
  CompareOptions options = options_of({1, 2});
  options.audit = [&](const store::MotionModel& of, const std::string& set) {
    requested.push_back(set);
    EXPECT_EQ(of.smoothed.size(), 1u);
    EXPECT_EQ(set.rfind("degree_" + std::to_string(of.smoothed.at(0).degree), 0), 0u);
    store::AuditSet audit;
    audit.refine = 1;
    audit.state = store::GridB::Constant(21, 13, static_cast<std::int8_t>(store::AuditState::overlapping));
    audit.penetration_mm = store::GridD::Constant(21, 13, 0.1 * of.smoothed.at(0).degree);
    audit.gap_mm = store::GridD::Constant(21, 13, std::numeric_limits<double>::quiet_NaN());
    return audit;
  };
  const Comparison comparison = compare(model, options);
  EXPECT_EQ(requested, (std::vector<std::string>{"degree_1", "degree_2"}));
  EXPECT_EQ(comparison.rows[1].audit_totals.value().at_grid.largest_penetration_mm, 0.2);
  EXPECT_EQ(comparison.rows[1].audit_totals.value().at_grid.n_overlapping, 273);
  requested.clear();
  options.recontact = [](const store::MotionModel& of, store::SmoothedSet& set) {
    set.recontact_mm = store::GridD::Zero(of.status.rows(), of.status.cols());
  };
  compare(model, options);
  EXPECT_EQ(requested, (std::vector<std::string>{"degree_1_recontacted", "degree_2_recontacted"}));
}

TEST(Compare, LeavesOutDegreesThatTheCellsCannotCarry)
{
  const store::MotionModel model =
      noisy_model({.degree = 2, .noise_mm = 0.01, .n_flexion = 20, .n_varus = 5});
  const Comparison comparison = compare(model, options_of({2, 4, 5, 9}));
  ASSERT_EQ(comparison.rows.size(), 2u);
  EXPECT_EQ(comparison.undetermined_degrees, (std::vector<int>{5, 9}));
  EXPECT_EQ(comparison.recommendation.degree, 2);
  EXPECT_THAT(input_error([&] {
                compare(model, options_of({5, 6}));
              }),
              test::refuses({"knee.h5", "smooth.degrees", "", {"21", "5", "4"}}));
}

TEST(Compare, JudgesThetaWhereEveryDegreeHasIt)
{
  // Degree 1 has enough cells that determine theta; degree 3 must use all cells.
  store::MotionModel model = noisy_model({.degree = 1, .noise_mm = 0.01});
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
  store::MotionModel model = noisy_model({.degree = 1, .n_flexion = 31, .n_varus = 1});
  for (int i = 0; i < 31; ++i) model.varus_solved_deg(i, 0) = 1.0 + 0.02 * i * i;
  const Comparison comparison = compare(model, options_of({1, 2}));
  ASSERT_EQ(comparison.rows[0].surfaces.size(), 5u);
  EXPECT_EQ(comparison.rows[0].surfaces[4].name, "varus");
  EXPECT_GT(comparison.rows[0].perceptible_share, 0.5);
  EXPECT_EQ(comparison.rows[1].perceptible_share, 0.0);
  EXPECT_EQ(comparison.recommendation.degree, 2);
}

store::MotionModel solved_model(int n_flexion, int n_varus)
{
  store::MotionModel model;
  model.status = store::GridB::Zero(n_flexion, n_varus);
  return model;
}

/// Free everywhere, without a gap.
store::AuditSet touching(const store::MotionModel& model, int refine)
{
  store::AuditSet audit;
  audit.refine = refine;
  const Eigen::Index rows = (model.status.rows() - 1) * refine + 1;
  const Eigen::Index columns = (model.status.cols() - 1) * refine + 1;
  audit.state = store::GridB::Zero(rows, columns);
  audit.gap_mm = audit.penetration_mm = store::GridD::Zero(rows, columns);
  return audit;
}

void overlap(store::AuditSet& audit, int i, int j, double depth_mm)
{
  audit.state(i, j) = static_cast<std::int8_t>(store::AuditState::overlapping);
  audit.gap_mm(i, j) = nan;
  audit.penetration_mm(i, j) = depth_mm;
}

TEST(Faults, AreSortedByFlexionAndVarus)
{
  const store::MotionModel model = solved_model(3, 2);
  store::AuditSet audit = touching(model, 3);
  overlap(audit, 3, 0, 0.25);
  overlap(audit, 4, 0, 0.75);
  audit.gap_mm(6, 3) = 0.5;
  audit.gap_mm(6, 2) = 0.125;
  audit.state(0, 3) = audit.state(0, 1) = static_cast<std::int8_t>(store::AuditState::nothing_ahead);
  audit.gap_mm(0, 3) = audit.gap_mm(0, 1) = nan;
  const MotionAuditTotals faults = motion_audit_totals(model, audit);
  EXPECT_EQ(faults.at_grid.n_attitudes, 6);
  EXPECT_EQ(faults.between.n_attitudes, 7 * 4 - 6);
  EXPECT_EQ(faults.at_grid.n_overlapping, 1);
  EXPECT_EQ(faults.between.n_overlapping, 1);
  EXPECT_EQ(faults.at_grid.n_nothing_ahead, 1);
  EXPECT_EQ(faults.between.n_nothing_ahead, 1);
  EXPECT_EQ(faults.at_grid.largest_penetration_mm, 0.25);
  EXPECT_EQ(faults.between.largest_penetration_mm, 0.75);
  EXPECT_EQ(faults.at_grid.largest_gap_mm, 0.5);
  EXPECT_EQ(faults.between.largest_gap_mm, 0.125);
}

TEST(Faults, BesideAFailedCellDoNotCount)
{
  store::MotionModel model = solved_model(3, 3);
  model.status(0, 0) = static_cast<std::int8_t>(StepStatus::no_contact);
  store::AuditSet audit = touching(model, 2);
  // Inside the patches of the cell and on its own edges, but not on their far edges.
  for (const auto& [i, j] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}}) overlap(audit, i, j, 9.0);
  MotionAuditTotals faults = motion_audit_totals(model, audit);
  EXPECT_EQ(faults.at_grid.n_attitudes, 8);
  EXPECT_EQ(faults.between.n_attitudes, 16 - 3);
  EXPECT_EQ(faults.between.largest_penetration_mm, 0.0);
  overlap(audit, 1, 2, 0.5);
  faults = motion_audit_totals(model, audit);
  EXPECT_EQ(faults.between.largest_penetration_mm, 0.5);
}

/// Rounding of sums of some hundred products of numbers near 1.
constexpr double rounding = 1e-11;

struct Fitted {
  store::SmoothedSet set;
  store::AxisRanges ranges;
};

/// tx is value(flexion, varus) over 0 to 90 and -10 to 10 degrees, which the degree reproduces.
template <typename Value>
Fitted fitted(int degree, const Value& value)
{
  SmoothInput input = test::blank(test::axis(31, 0, 3), test::axis(11, -10, 2));
  test::fill(input, value);
  return {smooth(input, degree), store::axis_ranges(input.flexion_deg, input.varus_deg)};
}

double roughness_of(const Fitted& f)
{
  return roughness(f.set, f.set.surfaces[0], f.ranges);
}

TEST(Roughness, OfQuadraticsIsTheirCurvature)
{
  // s = a f^2 + b f w + c w^2: s_ff = 2a, s_fw = b, s_ww = 2c everywhere.
  struct Row {
    double a, b, c;
  };
  for (const Row row :
       {Row{0.01, 0, 0}, Row{0, 0.02, 0}, Row{0, 0, -0.05}, Row{0.01, -0.02, 0.03}, Row{0, 0, 0}}) {
    const auto value = [&](double f, double w) {
      return 3.0 + 0.1 * f - 0.2 * w + row.a * f * f + row.b * f * w + row.c * w * w;
    };
    const double wanted = std::sqrt(4 * row.a * row.a + 2 * row.b * row.b + 4 * row.c * row.c);
    for (const int degree : {2, 5}) EXPECT_NEAR(roughness_of(fitted(degree, value)), wanted, rounding);
  }
}

TEST(Roughness, AgreesWithDifferencesOfTheSurface)
{
  std::mt19937_64 generator(5);
  const Fitted f = fitted(6, [&](double, double) { return static_cast<double>(generator() % 1000) / 500.0; });
  const auto value = [&](double flexion, double varus) {
    return store::evaluate(f.set, f.set.surfaces[0], f.ranges, flexion, varus);
  };
  // Midpoints of a fine grid; second differences with a step of 0.05 degrees.
  constexpr double h = 0.05;
  constexpr int n = 200;
  double sum = 0.0;
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      const double x = 90.0 * (a + 0.5) / n, y = 20.0 * (b + 0.5) / n - 10.0, s = value(x, y);
      const double ff = (value(x + h, y) - 2 * s + value(x - h, y)) / (h * h);
      const double ww = (value(x, y + h) - 2 * s + value(x, y - h)) / (h * h);
      const double fw =
          (value(x + h, y + h) - value(x + h, y - h) - value(x - h, y + h) + value(x - h, y - h)) /
          (4 * h * h);
      sum += ff * ff + 2 * fw * fw + ww * ww;
    }
  }
  const double wanted = std::sqrt(sum / (n * n));
  EXPECT_GT(wanted, 1e-3);
  // Midpoint rule on 200 cells of a polynomial of degree 8: under a thousandth; differences less.
  EXPECT_NEAR(roughness_of(f), wanted, 1e-3 * wanted);
}

}  // namespace vrda::analysis::compare_test
