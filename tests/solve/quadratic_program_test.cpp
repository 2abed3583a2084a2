#include "solve/quadratic_program.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace vrda::quadratic_program_test {

// Coordinates of size 1 to 100, half-spaces satisfied to 1e-11, Hessians of condition up to 1e6.
constexpr double rounding = 1e-7;

solve::HalfSpace half_space(const std::vector<double>& normal, double offset)
{
  solve::HalfSpace h;
  for (std::size_t k = 0; k < normal.size(); ++k) h.normal(static_cast<Eigen::Index>(k)) = normal[k];
  h.offset = offset;
  return h;
}

double value(const solve::QpMatrix& H, const solve::QpVector& g, const solve::QpVector& d)
{
  return 0.5 * d.dot(H * d) + g.dot(d);
}

// The best minimum over every choice of at most five half-spaces as equalities.
double brute_force(const solve::QpMatrix& H, const solve::QpVector& g,
                   const std::vector<solve::HalfSpace>& rows)
{
  double best = std::numeric_limits<double>::infinity();
  for (unsigned choice = 0; choice < (1U << rows.size()); ++choice) {
    std::vector<std::size_t> active;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if ((choice >> k & 1U) != 0) active.push_back(k);
    }
    if (active.size() > 5) continue;
    const auto m = static_cast<Eigen::Index>(active.size());
    Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(5 + m, 5 + m);
    Eigen::VectorXd right(5 + m);
    kkt.topLeftCorner(5, 5) = H;
    right.head(5) = -g;
    for (Eigen::Index k = 0; k < m; ++k) {
      kkt.block(0, 5 + k, 5, 1) = rows[active[static_cast<std::size_t>(k)]].normal;
      kkt.block(5 + k, 0, 1, 5) = rows[active[static_cast<std::size_t>(k)]].normal.transpose();
      right(5 + k) = rows[active[static_cast<std::size_t>(k)]].offset;
    }
    const solve::QpVector d = kkt.fullPivLu().solve(right).head(5);
    bool is_kept = true;
    for (const solve::HalfSpace& row : rows) is_kept = is_kept && row.normal.dot(d) >= row.offset - 1e-8;
    if (is_kept) best = std::min(best, value(H, g, d));
  }
  return best;
}

solve::QpMatrix random_hessian(std::mt19937_64& random, double least)
{
  std::normal_distribution<double> normal;
  solve::QpMatrix A;
  for (Eigen::Index k = 0; k < 25; ++k) A(k / 5, k % 5) = normal(random);
  return A * A.transpose() + least * solve::QpMatrix::Identity();
}

TEST(QuadraticProgram, WithoutHalfSpacesIsNewtonsStep)
{
  std::mt19937_64 random(1);
  const solve::QpMatrix H = random_hessian(random, 0.1);
  const solve::QpVector g = solve::QpVector::LinSpaced(-2, 3);
  const solve::QpSolution s = solve::solve_quadratic_program<5>(H, g, {});
  EXPECT_TRUE(s.is_solved);
  EXPECT_EQ(s.n_active, 0u);
  EXPECT_LT((H * s.d + g).norm(), 1e-12 * g.norm() * H.norm());
}

TEST(QuadraticProgram, ACornerIsHeldByItsWalls)
{
  // Nearest point to the origin with x >= 1, y >= 2: multipliers are the coordinates.
  const solve::QpSolution s = solve::solve_quadratic_program<5>(
      solve::QpMatrix::Identity(), solve::QpVector::Zero(), {half_space({1}, 1), half_space({0, 1}, 2)});
  ASSERT_TRUE(s.is_solved);
  ASSERT_EQ(s.n_active, 2u);
  EXPECT_NEAR((s.d - solve::QpVector(1, 2, 0, 0, 0)).norm(), 0.0, 1e-14);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(s.active[k].multiplier, static_cast<double>(s.active[k].row) + 1.0, 1e-14);
}

TEST(QuadraticProgram, InfeasibleIsReported)
{
  const solve::QpSolution s = solve::solve_quadratic_program<5>(
      solve::QpMatrix::Identity(), solve::QpVector::Zero(), {half_space({1}, 1), half_space({-1}, 0)});
  EXPECT_FALSE(s.is_solved);
}

TEST(QuadraticProgram, CopiesOfAHalfSpaceChangeNothing)
{
  std::vector<solve::HalfSpace> rows(20, half_space({1, 1}, 1));
  for (int k = 0; k < 20; ++k) rows.push_back(half_space({1, 1 + 1e-13 * k}, 1));
  const solve::QpSolution s =
      solve::solve_quadratic_program<5>(solve::QpMatrix::Identity(), solve::QpVector::Zero(), rows);
  ASSERT_TRUE(s.is_solved);
  EXPECT_NEAR(s.d(0), 0.5, 1e-10);
  EXPECT_NEAR(s.d(1), 0.5, 1e-10);
}

struct Sweep {
  std::array<int, 6> n_with_support{};
  int n_infeasible = 0;
};

void expect_optimal(const solve::QpMatrix& H, const solve::QpVector& g,
                    const std::vector<solve::HalfSpace>& rows, Sweep& sweep)
{
  const solve::QpSolution s = solve::solve_quadratic_program<5>(H, g, rows);
  const double best = brute_force(H, g, rows);
  ASSERT_EQ(s.is_solved, std::isfinite(best));
  if (!s.is_solved) {
    ++sweep.n_infeasible;
    return;
  }
  ++sweep.n_with_support[s.n_active];
  EXPECT_NEAR(value(H, g, s.d), best, rounding * (1.0 + std::abs(best)));
  solve::QpVector residual = H * s.d + g;
  for (std::size_t k = 0; k < s.n_active; ++k) {
    EXPECT_GE(s.active[k].multiplier, 0.0);
    EXPECT_NEAR(rows[s.active[k].row].normal.dot(s.d), rows[s.active[k].row].offset, rounding);
    residual -= s.active[k].multiplier * rows[s.active[k].row].normal;
  }
  EXPECT_LT(residual.norm(), rounding * (1.0 + (H * s.d).norm() + g.norm()));
  for (const solve::HalfSpace& row : rows) EXPECT_GE(row.normal.dot(s.d), row.offset - rounding);
}

TEST(QuadraticProgram, MatchesEveryChoiceOfActiveHalfSpaces)
{
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  Sweep sweep;
  for (int k = 0; k < 600; ++k) {
    std::vector<solve::HalfSpace> rows(static_cast<std::size_t>(1 + k % 9));
    for (solve::HalfSpace& row : rows) {
      for (Eigen::Index i = 0; i < 5; ++i) row.normal(i) = normal(random);
      row.normal.normalize();
      row.offset = normal(random) - (k % 3 == 0 ? 0.0 : 0.5);
    }
    solve::QpVector g;
    for (Eigen::Index i = 0; i < 5; ++i) g(i) = 3.0 * normal(random);
    expect_optimal(random_hessian(random, k % 2 == 0 ? 1e-4 : 1.0), g, rows, sweep);
  }
  for (int n = 0; n <= 5; ++n) EXPECT_GT(sweep.n_with_support[static_cast<std::size_t>(n)], 5) << n;
  EXPECT_GT(sweep.n_infeasible, 5);
}

TEST(QuadraticProgram, AHeldCoordinateStays)
{
  std::mt19937_64 random(3);
  solve::QpMatrix H = random_hessian(random, 0.1);
  H.row(4).setZero();
  H.col(4).setZero();
  H(4, 4) = 1.0;
  const solve::QpSolution s = solve::solve_quadratic_program<5>(
      H, solve::QpVector(1, 2, 3, 4, 0), {half_space({1, 0, 0, 1}, 5), half_space({0, 1, 1}, 0)});
  ASSERT_TRUE(s.is_solved);
  EXPECT_EQ(s.d(4), 0.0);
}

// Many half-spaces through one point (a vertex on a vertex) and an almost linear objective: the solution is
// determined by the constraints.
TEST(QuadraticProgram, DegenerateCornersOfAContactAreFound)
{
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  int n_supported = 0;
  for (int k = 0; k < 200; ++k) {
    std::vector<solve::HalfSpace> rows;
    for (int i = 0; i < 60; ++i)
      rows.push_back(half_space({unit(random), -1, unit(random), unit(random)}, 0));
    for (std::size_t axis : {0U, 2U, 3U}) {
      std::vector<double> wall(4, 0.0);
      wall[axis] = 1;
      rows.push_back(half_space(wall, -2));
      wall[axis] = -1;
      rows.push_back(half_space(wall, -2));
    }
    solve::QpMatrix H = 2e-5 * solve::QpMatrix::Identity();
    H(4, 4) = 1.0;
    const solve::QpSolution s = solve::solve_quadratic_program<5>(H, solve::QpVector(0, -20, 0, 0, 0), rows);
    ASSERT_TRUE(s.is_solved);
    // With 60 random slopes about it, the corner itself is the highest point.
    EXPECT_LT(s.d.norm(), 1e-9);
    n_supported += s.n_active == 4 ? 1 : 0;
  }
  EXPECT_GT(n_supported, 150);
}

}  // namespace vrda::quadratic_program_test
