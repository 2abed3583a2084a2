// Least squares by Legendre polynomials, plain and robust, and the errors of what is left out.
#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "analysis/smooth.hpp"
#include "analysis/smooth_inputs.hpp"
#include "core/text.hpp"
#include "store/motion.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::smooth_test {

using test::axis;
using test::blank;
using test::input_error;

/// Backward stable least squares: error of a few terms times epsilon times the condition number (below 100
/// for the grids here) times the size of the data (below 100).
constexpr double fit_tolerance = 1e-11;

/// A polynomial of total degree `degree` with every term, in monomials of the scaled axes.
double polynomial(double u, double v, int degree, double shift)
{
  double sum = 0.0, power_u = 1.0;
  for (int i = 0; i <= degree; ++i, power_u *= u) {
    double power_v = 1.0;
    for (int j = 0; i + j <= degree; ++j, power_v *= v)
      sum += (shift + 3.0 * i - 2.0 * j) * power_u * power_v;
  }
  return sum;
}

void fill_with_polynomial(SmoothInput& input, int degree)
{
  const store::AxisRanges ranges = store::axis_ranges(input.flexion_deg, input.varus_deg);
  for (Eigen::Index i = 0; i < input.tx_mm.rows(); ++i) {
    for (Eigen::Index j = 0; j < input.tx_mm.cols(); ++j) {
      const double u = store::unit_coordinate(input.flexion_deg[static_cast<std::size_t>(i)], ranges.flexion);
      const double v = store::unit_coordinate(input.varus_deg[static_cast<std::size_t>(j)], ranges.varus);
      input.tx_mm(i, j) = polynomial(u, v, degree, 1.0);
      input.ty_mm(i, j) = polynomial(u, v, degree, -2.0);
      input.tz_mm(i, j) = polynomial(v, u, degree, 0.5);
      input.theta_deg(i, j) = polynomial(u, -v, degree, 4.0);
    }
  }
}

void fill_with_noise(SmoothInput& input)
{
  test::UniformNumbers numbers(7);
  test::fill(input, [&](double, double) { return numbers.next(); });
}

TEST(Smooth, ReproducesPolynomialsOfItsDegree)
{
  for (const int degree : {0, 1, 2, 3, 6, 8}) {
    SCOPED_TRACE(degree);
    SmoothInput input = blank(axis(31, 0, 3), axis(11, -10, 2));
    fill_with_polynomial(input, degree);
    const store::SmoothedSet set = smooth(input, degree);
    EXPECT_EQ(set.degree, degree);
    EXPECT_EQ(set.exponents.rows(), (degree + 1) * (degree + 2) / 2);
    const store::GridD* grids[] = {&input.tx_mm, &input.ty_mm, &input.tz_mm, &input.theta_deg};
    const char* names[] = {"tx", "ty", "tz", "theta"};
    ASSERT_EQ(set.surfaces.size(), 4u);
    for (std::size_t s = 0; s < 4; ++s) {
      const store::SmoothedSurface& surface = set.surfaces[s];
      EXPECT_EQ(surface.name, names[s]);
      EXPECT_EQ(surface.n_cells, 31 * 11);
      EXPECT_LT((surface.values - *grids[s]).abs().maxCoeff(), fit_tolerance);
      EXPECT_LT(surface.largest_residual, fit_tolerance);
      EXPECT_LE(surface.rms, surface.largest_residual);
      EXPECT_LT(surface.leave_one_out_rms, fit_tolerance);
      EXPECT_GE(surface.condition_number, 1.0);
      EXPECT_LT(surface.condition_number, 100.0);
    }
  }
}

TEST(Smooth, DegreeZeroIsTheMean)
{
  SmoothInput input = blank({0, 1}, {-1, 1});
  input.tx_mm << 1, 2, 3, 6;
  const store::SmoothedSurface surface = smooth(input, 0).surfaces[0];
  EXPECT_NEAR(surface.coefficients.at(0), 3.0, fit_tolerance);
  EXPECT_NEAR(surface.rms, std::sqrt((4.0 + 1.0 + 0.0 + 9.0) / 4.0), fit_tolerance);
  EXPECT_NEAR(surface.largest_residual, 3.0, fit_tolerance);
  // Omitting one of four moves the mean by a third of its residual.
  EXPECT_NEAR(surface.leave_one_out_rms, surface.rms * 4.0 / 3.0, fit_tolerance);
  EXPECT_NEAR(surface.condition_number, 1.0, fit_tolerance);
}

TEST(Smooth, FailedCellsDoNotMatter)
{
  SmoothInput input = blank(axis(19, 0, 5), axis(9, -8, 2));
  fill_with_polynomial(input, 4);
  const store::GridD wanted = input.ty_mm;
  for (Eigen::Index k = 0; k < input.status.size(); k += 7) {
    input.status.data()[k] =
        static_cast<std::int8_t>(k % 2 == 0 ? StepStatus::no_contact : StepStatus::pending);
    input.tx_mm.data()[k] = input.ty_mm.data()[k] = input.tz_mm.data()[k] = input.theta_deg.data()[k] = nan;
  }
  const store::SmoothedSet set = smooth(input, 4);
  EXPECT_EQ(set.surfaces[1].n_cells, (input.status == 0).count());
  EXPECT_LT((set.surfaces[1].values - wanted).abs().maxCoeff(), fit_tolerance);
}

TEST(Smooth, ThetaIsFittedWhereItIsDetermined)
{
  SmoothInput input = blank(axis(10, 0, 10), axis(7, -3, 1));
  fill_with_polynomial(input, 3);
  const store::GridD wanted = input.theta_deg;
  for (Eigen::Index k = 0; k < input.status.size(); k += 5) {
    input.theta_determined.data()[k] = 0;
    input.theta_deg.data()[k] = 1e6;
  }
  const store::SmoothedSet set = smooth(input, 3);
  EXPECT_EQ(set.surfaces[0].n_cells, 70);
  EXPECT_EQ(set.surfaces[3].n_cells, 56);
  EXPECT_LT((set.surfaces[3].values - wanted).abs().maxCoeff(), fit_tolerance);
}

TEST(Smooth, LeaveOneOutIsThatOfRefits)
{
  SmoothInput input = blank(axis(7, 0, 15), axis(5, -2, 1));
  fill_with_noise(input);
  input.status(2, 3) = static_cast<std::int8_t>(StepStatus::iteration_limit);
  const int degree = 3;
  const store::SmoothedSet whole = smooth(input, degree);
  double sum_sq = 0.0;
  int n = 0;
  for (Eigen::Index k = 0; k < input.status.size(); ++k) {
    if (input.status.data()[k] != 0) continue;
    SmoothInput without = input;
    without.status.data()[k] = status_pending;
    const double error = input.tx_mm.data()[k] - smooth(without, degree).surfaces[0].values.data()[k];
    sum_sq += error * error;
    ++n;
  }
  EXPECT_EQ(n, 34);
  EXPECT_NEAR(whole.surfaces[0].leave_one_out_rms, std::sqrt(sum_sq / n), fit_tolerance);
  EXPECT_GT(whole.surfaces[0].leave_one_out_rms, whole.surfaces[0].rms);
}

TEST(Smooth, LeaveOneOutIsUnknownWhereNothingCanBeLeftOut)
{
  SmoothInput input = blank({0, 1}, {-1, 1});
  fill_with_noise(input);
  input.status(1, 1) = static_cast<std::int8_t>(StepStatus::no_clearance);
  const store::SmoothedSurface surface = smooth(input, 1).surfaces[0];
  EXPECT_LT(surface.largest_residual, fit_tolerance);
  EXPECT_TRUE(std::isnan(surface.leave_one_out_rms));
}

TEST(Smooth, ScalingAndShiftingTheAxesChangesNothing)
{
  // Powers of two and whole numbers keep the bits of the unit coordinates, hence of all results.
  SmoothInput input = blank(axis(13, 0, 5), axis(9, -8, 2));
  fill_with_noise(input);
  SmoothInput moved = input;
  for (double& value : moved.flexion_deg) value = 4.0 * value - 30.0;
  for (double& value : moved.varus_deg) value = 0.5 * value + 7.0;
  const store::SmoothedSet a = smooth(input, 5), b = smooth(moved, 5);
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_EQ(a.surfaces[s].coefficients, b.surfaces[s].coefficients);
    EXPECT_TRUE((a.surfaces[s].values == b.surfaces[s].values).all());
    EXPECT_EQ(a.surfaces[s].leave_one_out_rms, b.surfaces[s].leave_one_out_rms);
    EXPECT_EQ(a.surfaces[s].condition_number, b.surfaces[s].condition_number);
  }
}

TEST(Smooth, AnAxisWithOneValueCarriesItsConstant)
{
  SmoothInput input = blank(axis(10, 0, 10), {0});
  fill_with_polynomial(input, 4);
  const store::SmoothedSet set = smooth(input, 4);
  EXPECT_EQ(set.exponents.rows(), 5);
  EXPECT_TRUE((set.exponents.col(1) == 0).all());
  EXPECT_LT((set.surfaces[0].values - input.tx_mm).abs().maxCoeff(), fit_tolerance);

  SmoothInput across = blank({30}, axis(6, -5, 2));
  fill_with_polynomial(across, 2);
  EXPECT_EQ(smooth(across, 2).exponents.rows(), 3);
  SmoothInput one = blank({30}, {0});
  EXPECT_EQ(smooth(one, 6).exponents.rows(), 1);
}

TEST(Smooth, FiveColumnsCannotCarryDegreeFive)
{
  SmoothInput input = blank(axis(91, 0, 1), axis(5, -2, 1));
  EXPECT_NO_THROW(smooth(input, 4));
  EXPECT_EQ(largest_degree(input), 4);
  EXPECT_THAT(input_error([&] { smooth(input, 5); }),
              test::refuses({"knee.h5", "smooth.degrees", {"455", "91", "5"}, {"21", "5", "4"}}));
}

TEST(Smooth, TooFewCellsAreCounted)
{
  SmoothInput input = blank(axis(6, 0, 1), axis(6, 0, 1));
  input.status.setConstant(static_cast<std::int8_t>(StepStatus::no_contact));
  EXPECT_EQ(largest_degree(input), -1);
  EXPECT_THAT(input_error([&] { smooth(input, 2); }),
              test::refuses({.field = "smooth.degrees", .wanted = {"6", "2"}}));
  input.status(0, 0) = input.status(0, 5) = input.status(5, 0) = input.status(5, 5) = 0;
  EXPECT_EQ(largest_degree(input), 1);
  EXPECT_THAT(input_error([&] { smooth(input, 2); }),
              test::refuses({.field = "smooth.degrees", .found = {"4", "2"}, .wanted = {"6", "2", "1"}}));
}

TEST(Smooth, ThetaIsFittedToAllCellsWhereTooFewDetermineIt)
{
  // A ball in a socket: theta keeps the value of its seed everywhere.
  SmoothInput input = blank(axis(6, 0, 1), axis(6, 0, 1));
  input.theta_determined.setZero();
  input.theta_determined(2, 2) = 1;
  input.theta_deg.setConstant(7.5);
  EXPECT_EQ(largest_degree(input), 5);
  const store::SmoothedSet set = smooth(input, 3);
  EXPECT_EQ(set.surfaces[3].n_cells, 36);
  // A constant is in the basis: residuals are rounding.
  EXPECT_LT((set.surfaces[3].values - 7.5).abs().maxCoeff(), 1e-12);
  EXPECT_EQ(smooth(input, 0).surfaces[3].n_cells, 1) << "one cell determines a constant";
}

TEST(Smooth, ADegreeOutOfRangeIsRefused)
{
  const SmoothInput input = blank(axis(6, 0, 1), axis(6, 0, 1));
  for (const int degree : {-1, 21}) {
    EXPECT_THAT(
        input_error([&] { smooth(input, degree); }),
        test::refuses({.field = "smooth.degrees", .found = std::to_string(degree), .wanted = {"0", "20"}}));
  }
}

/// Planes with noise within +-0.1 and given varus.
SmoothInput noisy_planes(int rows, int columns)
{
  SmoothInput input = test::blank(test::axis(rows, 0, 3), test::axis(columns, -2, 1));
  test::UniformNumbers numbers(17);
  test::fill(input, [&](double flexion_deg, double varus_deg) {
    return flexion_deg / 15.0 - 0.5 * (varus_deg + 2.0) + 0.1 * numbers.next();
  });
  return input;
}

TEST(SmoothFit, GridValuesAreThoseOfEvaluate)
{
  const SmoothInput input = noisy_planes(17, 9);
  const store::SmoothedSet set = smooth(input, 5);
  const store::AxisRanges ranges = store::axis_ranges(input.flexion_deg, input.varus_deg);
  for (const store::SmoothedSurface& surface : set.surfaces) {
    for (Eigen::Index i = 0; i < 17; ++i) {
      for (Eigen::Index j = 0; j < 9; ++j) {
        EXPECT_EQ(surface.values(i, j),
                  store::evaluate(set, surface, ranges, input.flexion_deg[static_cast<std::size_t>(i)],
                                  input.varus_deg[static_cast<std::size_t>(j)]));
      }
    }
  }
}

TEST(SmoothFit, LeftOutBlocksAreThoseOfRefits)
{
  SmoothInput input = noisy_planes(9, 7);
  input.status(4, 2) = static_cast<std::int8_t>(StepStatus::no_contact);
  input.theta_determined(1, 1) = 0;
  const SmoothFit whole = smooth_fit(input, 3);
  const BlockSize size{4, 3};
  const std::vector<store::GridD> errors = leave_blocks_out(input, whole, size);
  const store::GridI blocks = block_numbers(9, 7, size);
  EXPECT_EQ(blocks.maxCoeff(), 3 * 3 - 1);
  EXPECT_EQ(blocks(3, 2), blocks(0, 0));
  EXPECT_NE(blocks(4, 2), blocks(3, 2));
  for (std::int32_t block = 0; block < 9; ++block) {
    SmoothInput without = input;
    without.status = (blocks == block).select(static_cast<std::int8_t>(StepStatus::no_contact), input.status);
    const store::SmoothedSet refit = smooth(without, 3);
    for (Eigen::Index k = 0; k < blocks.size(); ++k) {
      if (blocks.data()[k] != block || input.status.data()[k] != status_stable) continue;
      EXPECT_NEAR(errors[0].data()[k], input.tx_mm.data()[k] - refit.surfaces[0].values.data()[k],
                  fit_tolerance);
    }
  }
  EXPECT_TRUE(std::isnan(errors[0](4, 2)));
  EXPECT_TRUE(std::isnan(errors[3](1, 1)));
  EXPECT_EQ(errors[3].isNaN().count(), 2);
  // Four columns of seven are one block, and the other three do not determine degree 3, nor do the four
  // without a column; the last three leave four.
  const store::GridD wide = leave_blocks_out(input, whole, {9, 4})[0];
  EXPECT_TRUE(wide.leftCols(4).isNaN().all());
  EXPECT_FALSE(wide.rightCols(3).isNaN().any());
}

TEST(SmoothFit, LeftOutBlocksOfOneCellAreTheLeaveOneOutErrors)
{
  SmoothInput input = noisy_planes(9, 7);
  input.tx_mm(3, 3) += 5.0;
  for (const bool is_robust : {false, true}) {
    const SmoothFit fit = smooth_fit(input, 2, {is_robust});
    const std::vector<store::GridD> errors = leave_blocks_out(input, fit, {1, 1});
    for (std::size_t s = 0; s < 4; ++s)
      EXPECT_LE((errors[s] - fit.leave_one_out[s]).abs().maxCoeff(), fit_tolerance);
    EXPECT_EQ((fit.weight[0] == 1.0).all(), !is_robust);
  }
}

TEST(SmoothFit, RobustWeightsIgnoreGrossErrors)
{
  SmoothInput input = noisy_planes(21, 7);
  const store::SmoothedSet clean = smooth(input, 2);
  for (Eigen::Index k = 3; k < input.tx_mm.size(); k += 13) input.tx_mm.data()[k] += 8.0;
  const SmoothFit robust = smooth_fit(input, 2, {.is_robust = true});
  const store::SmoothedSet plain = smooth(input, 2);
  EXPECT_TRUE(robust.set.is_robust);
  EXPECT_FALSE(plain.is_robust);
  for (const bool is_converged : robust.is_converged) EXPECT_TRUE(is_converged);
  const auto moved = [&](const store::SmoothedSet& set) {
    return (set.surfaces[0].values - clean.surfaces[0].values).abs().maxCoeff();
  };
  EXPECT_GT(moved(plain), 0.5);
  // One cell in thirteen has an influence of 1.345 scales of noise, whose maximum is 0.1.
  EXPECT_LT(moved(robust.set), 0.1);
  // Every cell counts in the measures, including outliers.
  EXPECT_NEAR(robust.set.surfaces[0].largest_residual, 8.0, 0.2);
  EXPECT_EQ(robust.set.surfaces[0].n_cells, 21 * 7);
  EXPECT_EQ(robust.set.surfaces[0].condition_number, plain.surfaces[0].condition_number);
}

TEST(SmoothFit, RobustFitRecoversExactPolynomials)
{
  SmoothInput input = noisy_planes(15, 7);
  for (Eigen::Index i = 0; i < 15; ++i) {
    for (Eigen::Index j = 0; j < 7; ++j)
      input.tz_mm(i, j) = static_cast<double>(i * i) - 3.0 * static_cast<double>(i * j);
  }
  const store::SmoothedSet set = smooth(input, 3, {.is_robust = true});
  EXPECT_LT((set.surfaces[2].values - input.tz_mm).abs().maxCoeff(), fit_tolerance);
}

/// Restores Eigen's cache sizes at the end.
class CacheSizes {
 public:
  CacheSizes() { Eigen::internal::manage_caching_sizes(Eigen::GetAction, &l1_, &l2_, &l3_); }
  CacheSizes(const CacheSizes&) = delete;
  ~CacheSizes() { Eigen::setCpuCacheSizes(l1_, l2_, l3_); }

 private:
  std::ptrdiff_t l1_ = 0, l2_ = 0, l3_ = 0;
};

TEST(SmoothFit, EveryCacheGivesTheSameBits)
{
  const CacheSizes restored_at_the_end;
  // With 560 cells and 91 terms Eigen's matrix products and blocked QR differ between these settings.
  SmoothInput input = noisy_planes(28, 20);
  for (Eigen::Index k = 3; k < input.tx_mm.size(); k += 7) input.tx_mm.data()[k] += 8.0;
  const auto fit_with_caches = [&](std::ptrdiff_t l1, std::ptrdiff_t l2, std::ptrdiff_t l3) {
    Eigen::setCpuCacheSizes(l1, l2, l3);
    return std::pair(smooth_fit(input, 12), smooth_fit(input, 12, {.is_robust = true}));
  };
  const auto small = fit_with_caches(8 << 10, 64 << 10, 128 << 10);
  const auto large = fit_with_caches(128 << 10, 2 << 20, 64 << 20);
  EXPECT_GT(small.second.set.surfaces[0].largest_residual, 4.0) << "weighted";
  for (const auto& [a, b] : {std::pair(small.first, large.first), std::pair(small.second, large.second)}) {
    for (std::size_t s = 0; s < 4; ++s) {
      EXPECT_EQ(a.set.surfaces[s].coefficients, b.set.surfaces[s].coefficients);
      EXPECT_EQ(a.set.surfaces[s].condition_number, b.set.surfaces[s].condition_number);
      EXPECT_TRUE((a.leave_one_out[s] == b.leave_one_out[s]).all());
    }
  }
  // The settings do affect Eigen functions that use them.
  const Eigen::MatrixXd tall = Eigen::MatrixXd::Random(2000, 91);
  const auto product_with_caches = [&](std::ptrdiff_t l1, std::ptrdiff_t l2, std::ptrdiff_t l3) {
    Eigen::setCpuCacheSizes(l1, l2, l3);
    return Eigen::MatrixXd(tall.transpose() * tall);
  };
  EXPECT_NE(product_with_caches(8 << 10, 64 << 10, 128 << 10),
            product_with_caches(128 << 10, 2 << 20, 64 << 20));
}

TEST(SmoothFit, VarusIsAFifthSurfaceWhereItWasFree)
{
  store::MotionModel model;
  model.varus_deg = {0.0};
  const SmoothInput planes = noisy_planes(12, 1);
  model.flexion_deg = planes.flexion_deg;
  model.tx_mm = model.ty_mm = model.tz_mm = model.theta_deg = planes.tx_mm;
  model.status = store::GridB::Zero(12, 1);
  model.theta_determined = store::GridB::Ones(12, 1);
  model.varus_solved_deg = store::GridD::Zero(12, 1);
  EXPECT_EQ(smooth(smooth_input(model, "knee.h5"), 3).surfaces.size(), 4u) << "varus is that of the axis";

  for (Eigen::Index i = 0; i < 12; ++i)
    model.varus_solved_deg(i, 0) = 0.01 * static_cast<double>(i * i) - 1.0;
  const store::SmoothedSet set = smooth(smooth_input(model, "knee.h5"), 3);
  ASSERT_EQ(set.surfaces.size(), 5u);
  EXPECT_EQ(set.surfaces[4].name, "varus");
  EXPECT_LT((set.surfaces[4].values - model.varus_solved_deg).abs().maxCoeff(), fit_tolerance);

  model.varus_deg = {0.0, 1.0};
  for (store::GridD* grid :
       {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg, &model.varus_solved_deg})
    *grid = store::GridD::Ones(12, 2);
  model.status = store::GridB::Zero(12, 2);
  model.theta_determined = store::GridB::Ones(12, 2);
  EXPECT_EQ(smooth(smooth_input(model, "knee.h5"), 1).surfaces.size(), 4u) << "varus was given";
}

/// A few dozen operations on numbers near 1, weighted by numbers down to a hundredth.
constexpr double rounding = 1e-11;

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed)
{
  std::mt19937_64 generator(seed);
  Eigen::MatrixXd A(rows, columns);
  for (Eigen::Index k = 0; k < A.size(); ++k)
    A.data()[k] = static_cast<double>(generator() % 2001) / 1000.0 - 1.0;
  return A;
}

/// Noise within [-1, 1]; every tenth datum is an outlier on one side.
Eigen::VectorXd noisy_data(const Eigen::MatrixXd& A)
{
  Eigen::VectorXd data = 3.0 * A.rowwise().sum() + random_matrix(A.rows(), 1, 5);
  for (Eigen::Index i = 0; i < data.size(); i += 10) data(i) += 20.0 + static_cast<double>(i);
  return data;
}

Eigen::VectorXd weighted_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& weights,
                                       const Eigen::VectorXd& data)
{
  const Eigen::MatrixXd normal = A.transpose() * weights.asDiagonal() * A;
  return normal.fullPivLu().solve(A.transpose() * weights.asDiagonal() * data);
}

TEST(PivotedQr, ConditionNumberIsThatOfTheSingularValues)
{
  Eigen::MatrixXd A = random_matrix(60, 15, 3);
  A.col(3) *= 1e4;
  A.col(9) = A.col(8) + 1e-3 * A.col(9);
  const Eigen::VectorXd singular_values = Eigen::JacobiSVD<Eigen::MatrixXd>(A).singularValues();
  const double wanted = singular_values(0) / singular_values(14);
  EXPECT_GT(wanted, 1e5);
  EXPECT_NEAR(condition_number(pivoted_qr(A)) / wanted, 1.0, 1e-9);
}

TEST(RobustScale, IsTheMedianScaledForNormalNoise)
{
  EXPECT_EQ(robust_scale(Eigen::VectorXd()), 0.0);
  EXPECT_EQ(robust_scale(Eigen::VectorXd{{-2.0}}), 2.0 * normal_scale);
  EXPECT_EQ(robust_scale(Eigen::VectorXd{{5.0, -1.0, 100.0}}), 5.0 * normal_scale);
  EXPECT_EQ(robust_scale(Eigen::VectorXd{{1.0, -4.0, 2.0, -100.0}}), 3.0 * normal_scale);
  // P(|x| < 1 / normal_scale) = 1/2 of a standard normal number.
  EXPECT_NEAR(std::erf(1.0 / normal_scale / std::sqrt(2.0)), 0.5, 1e-12);
}

TEST(HuberFit, SolvesItsEquation)
{
  const Eigen::MatrixXd A = random_matrix(80, 5, 3);
  const Eigen::VectorXd data = noisy_data(A);
  const HuberFit fit = huber_fit(pivoted_qr(A), data);
  ASSERT_TRUE(fit.is_converged);
  const Eigen::VectorXd residual = data - A * fit.coefficients;
  const double scale = robust_scale(residual);
  // The iteration ended at changes of 1e-6 of the scale, which at least halve per step.
  EXPECT_NEAR(fit.scale, scale, 1e-5 * scale);
  Eigen::VectorXd pull = residual;
  int n_limited = 0;
  for (Eigen::Index i = 0; i < 80; ++i) {
    const double limit = huber_constant * scale;
    n_limited += std::abs(residual(i)) > limit ? 1 : 0;
    pull(i) = std::clamp(residual(i), -limit, limit);
  }
  EXPECT_GE(n_limited, 8);
  EXPECT_LT((A.transpose() * pull).cwiseAbs().maxCoeff(), 80 * 1e-5 * scale);
  const Eigen::VectorXd wanted = weighted_least_squares(A, fit.weights, data);
  EXPECT_LT((fit.coefficients - wanted).cwiseAbs().maxCoeff(), rounding);
}

TEST(HuberFit, LeverageIsThatOfRefitsWithTheSameWeights)
{
  const Eigen::MatrixXd A = random_matrix(40, 4, 3);
  const Eigen::VectorXd data = noisy_data(A);
  const HuberFit fit = huber_fit(pivoted_qr(A), data);
  const Eigen::VectorXd residual = data - A * fit.coefficients;
  for (Eigen::Index i = 0; i < 40; ++i) {
    Eigen::VectorXd weights = fit.weights;
    weights(i) = 0.0;
    const double refit = data(i) - A.row(i).dot(weighted_least_squares(A, weights, data));
    EXPECT_NEAR(residual(i) / (1.0 - fit.leverage(i)), refit, 100 * rounding);
  }
}

TEST(HuberFit, AColumnThatOnlyRowsFarOffDetermineTakesWeightedSteps)
{
  // The last column is nonzero where the data are 3000, -1000 and -1500: unweighted steps would converge
  // slowly.
  Eigen::MatrixXd A = random_matrix(60, 3, 4);
  A.col(2).setZero();
  Eigen::VectorXd data = random_matrix(60, 1, 6);
  A(0, 2) = A(1, 2) = A(2, 2) = 1.0;
  data.head(3) << 3000.0, -1000.0, -1500.0;
  const HuberFit fit = huber_fit(pivoted_qr(A), data);
  EXPECT_TRUE(fit.is_converged);
  EXPECT_GT(fit.n_iterations, 30);
  // The median of three, as the other two cancel.
  EXPECT_NEAR(fit.coefficients(2), -1000.0, 3.0);
}

TEST(HuberFit, SaysWhenTheStepsRanOut)
{
  const Eigen::MatrixXd A = random_matrix(80, 5, 3);
  const HuberFit fit = huber_fit(pivoted_qr(A), noisy_data(A), {.max_iterations = 2});
  EXPECT_FALSE(fit.is_converged);
  EXPECT_EQ(fit.n_iterations, 2);
  EXPECT_EQ(fit.coefficients.size(), 5);
}

}  // namespace vrda::analysis::smooth_test
