// The offset of two flat plates: its estimate and error are mean and standard error of the gaps.
#include "analysis/offset_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/units.hpp"
#include "model/frames.hpp"
#include "support/meshes.hpp"

namespace vrda::analysis::offset_fit_test {

job::Case two_plates()
{
  job::Case plates;
  plates.reference.contact = {test::plate(20.0, false), {0, 0}};
  plates.moving.contact = {test::plate(10.0, true), {0, 0}};
  return plates;
}

OffsetFitInput at_gaps(const std::vector<double>& gaps_mm)
{
  OffsetFitInput input;
  input.moving = {0};
  for (const double gap_mm : gaps_mm) {
    Pose X = Pose::Identity();
    X.translation().y() = -gap_mm;
    input.X_reference_moving.push_back(X);
  }
  return input;
}

TEST(OffsetFit, OfPlatesIsMeanAndStandardErrorOfTheGaps)
{
  const OffsetFit fit = fit_offset(two_plates(), at_gaps({1.2, 1.3, 1.5, 1.1, 1.4}));
  EXPECT_EQ(fit.status, FitStatus::converged);
  EXPECT_NEAR(fit.offset_mm, 1.3, 1e-6);  // settled_mm
  EXPECT_NEAR(fit.travel_per_mm, -1.0, 1e-9);
  // Deviations -0.1, 0, 0.2, -0.2, 0.1: variance 0.1 / 4, of the mean 0.025 / 5.
  EXPECT_NEAR(fit.standard_error_mm, std::sqrt(0.005), 1e-6);
  EXPECT_NEAR(fit.gap_rms_mm, std::sqrt(0.02), 1e-6);
}

// As where walls overlap sideways: the gap along Delta leads out of the joint.
TEST(OffsetFit, AFrameFarFromTheOthersCountsLikeOneAtThreeDeviations)
{
  const OffsetFit fit = fit_offset(two_plates(), at_gaps({1.2, 1.3, 1.5, 1.1, 1.4, -20.0}));
  EXPECT_EQ(fit.status, FitStatus::converged);
  // Median 1.3 and median deviation 0.2: the last one counts as 1.3 - 0.2 * 3 * 1.4826.
  EXPECT_NEAR(fit.offset_mm, (6.5 + 1.3 - 0.6 * 1.4826) / 6.0, 1e-5);
}

// A ball turned by 90 degrees below a plate: Delta belongs to the plate.
TEST(OffsetFit, ADeltaFixedInTheReferenceTurnsAgainstTheMovingObject)
{
  job::Case joint = two_plates();
  const Mesh ball = test::ball(5.0);
  joint.moving.contact = {ball,
                          std::vector<std::int32_t>(static_cast<std::size_t>(ball.triangles.rows()), 0)};
  joint.is_push_fixed_in_reference = true;
  OffsetFitInput input = at_gaps({6.2, 6.4, 6.3});
  for (Pose& X : input.X_reference_moving) X.linear() = rotation_z(rad_from_deg(90.0));
  const OffsetFit fit = fit_offset(joint, input);
  EXPECT_EQ(fit.status, FitStatus::converged);
  EXPECT_NEAR(fit.offset_mm, 1.3, 1e-5);
  joint.is_push_fixed_in_reference = false;
  EXPECT_EQ(fit_offset(joint, input).status, FitStatus::undetermined);
}

TEST(OffsetFit, ItsIntervalHoldsTheTruthAsOftenAsItSays)
{
  std::mt19937 random(26);
  std::normal_distribution<double> noise(0.0, 0.1);
  constexpr int n_trials = 200;
  int n_held = 0;
  for (int trial = 0; trial < n_trials; ++trial) {
    std::vector<double> gaps_mm(40);
    for (double& gap_mm : gaps_mm) gap_mm = 1.3 + noise(random);
    const OffsetFit fit = fit_offset(two_plates(), at_gaps(gaps_mm));
    n_held += std::abs(fit.offset_mm - 1.3) <= 1.96 * fit.standard_error_mm ? 1 : 0;
  }
  // 95 % of 200 with a binomial standard deviation of 3.1; three of them.
  EXPECT_GE(n_held, 180);
  EXPECT_LE(n_held, 199);
}

}  // namespace vrda::analysis::offset_fit_test
