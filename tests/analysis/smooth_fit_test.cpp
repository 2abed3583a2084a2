#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <utility>

#include "analysis/smooth.hpp"
#include "analysis/smooth_inputs.hpp"

namespace vrda::analysis::smooth_fit_test {

/// As in smooth_test.cpp: a few terms times epsilon times condition (below 100) times data (below 100).
constexpr double fit_tolerance = 1e-11;

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

}  // namespace vrda::analysis::smooth_fit_test
