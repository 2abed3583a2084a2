#include "calibration/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "noise.hpp"

namespace vrda::aligned_marks_test {

constexpr double solver_tolerance = 1e-8;

/// An even map of places on a line to marks: four numbers, and `known` of them known to 1 beforehand.
LeastSquares line_fit(const std::vector<Eigen::Vector2d>& marks, const std::vector<double>& at,
                      int n_known = 0)
{
  FitProblem problem;
  problem.start = Eigen::VectorXd::Zero(4);
  problem.scale = Eigen::VectorXd::Ones(4);
  problem.residuals = [&](const Eigen::VectorXd& x) {
    const auto n = static_cast<Eigen::Index>(marks.size());
    Eigen::VectorXd r(2 * n + n_known);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      r.segment<2>(2 * i) = x.head<2>() + at[k] * x.tail<2>() - marks[k];
    }
    r.tail(n_known) = x.head(n_known);
    return r;
  };
  return fit_least_squares(problem);
}

struct Marks {
  std::vector<Eigen::Vector2d> marks;
  std::vector<double> at;
};

Marks noisy_line(test::Noise& noise)
{
  Marks line;
  for (int i = 0; i < 8; ++i) {
    line.at.push_back(i);
    line.marks.emplace_back(Eigen::Vector2d(3.0 + 2.0 * i, 1.0 - i) + Eigen::Vector2d(noise.normals(2)));
  }
  return line;
}

TEST(AlignedMarks, NumbersTakeTheirShareOfTheDegreesOfFreedom)
{
  test::Noise noise(1);
  const Marks line = noisy_line(noise);
  EXPECT_NEAR(noise_dof(line_fit(line.marks, line.at), 8), 16.0 - 4.0, solver_tolerance);
  // What was known leaves the marks less to determine.
  const double dof = noise_dof(line_fit(line.marks, line.at, 4), 8);
  EXPECT_GT(dof, 12.0 + 0.1);
  EXPECT_LT(dof, 16.0);
}

TEST(AlignedMarks, IntervalsHaveTheDegreesOfFreedomOfTheMarksShare)
{
  // One number, told by two marks at 1 (variance 1/4 together) and beforehand (variance 1): 4/5 by marks.
  FitProblem problem;
  problem.start = Eigen::VectorXd::Zero(1);
  problem.scale = Eigen::VectorXd::Ones(1);
  problem.residuals = [](const Eigen::VectorXd& x) {
    return Eigen::VectorXd(x[0] - Eigen::ArrayXd{{1.0, 2.0, 0.5, 1.5, 0.0}});
  };
  const LeastSquares fit = fit_least_squares(problem);
  const double dof = 4.0 - 4.0 / 5.0;
  EXPECT_NEAR(noise_dof(fit, 2), dof, solver_tolerance);
  EXPECT_NEAR(interval_dof(fit, 2, Eigen::MatrixXd::Ones(1, 1)), dof / 0.64, solver_tolerance);
  EXPECT_TRUE(std::isinf(interval_dof(fit, 2, Eigen::MatrixXd::Zero(1, 1))));
}

/// The fit really done without the mark. Slopes by differences are off by 1e-15 (rounding of numbers up to
/// 20) / 1e-6 (step), and that by the mark's 25.
TEST(AlignedMarks, TheFurthestMarkIsJudgedByAFitToTheOthers)
{
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Noise noise(seed);
    Marks line = noisy_line(noise);
    const std::size_t off = seed % 8;
    line.marks[off] += Eigen::Vector2d(15.0, -20.0);
    const FurthestMark furthest = furthest_mark(line_fit(line.marks, line.at), 8);
    ASSERT_EQ(furthest.mark, static_cast<Eigen::Index>(off));
    Marks others = line;
    others.marks.erase(others.marks.begin() + seed % 8);
    others.at.erase(others.at.begin() + seed % 8);
    const LeastSquares without = line_fit(others.marks, others.at);
    const Eigen::Vector2d expected =
        without.x.head<2>() + line.at[off] * without.x.tail<2>() - line.marks[off];
    constexpr double difference_tolerance = 1e-7;
    EXPECT_LT((furthest.off - expected).norm(), difference_tolerance);
    EXPECT_GT(furthest.deviations, 6.0);
    line.marks[off] -= Eigen::Vector2d(15.0, -20.0);
    EXPECT_LT(furthest_mark(line_fit(line.marks, line.at), 8).deviations, 6.0);
  }
}

}  // namespace vrda::aligned_marks_test
