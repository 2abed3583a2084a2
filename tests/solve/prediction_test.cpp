#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/units.hpp"
#include "solve/quadratic_program.hpp"
#include "solve/stability_search.hpp"

namespace vrda::prediction_test {

contact::Contact contact(const Eigen::Vector3d& point, const Eigen::Vector3d& direction)
{
  return {point, point, direction.normalized(), 0.0, {}};
}

TEST(PredictRotation, ACoupleTurnsAboutItsMiddle)
{
  // Reactions along +X at z = +1 and along -X at z = -1: torque about +Y.
  const solve::RotationPrediction r =
      solve::predict_rotation({contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {-1, -1, 0})});
  EXPECT_EQ(r.sign, 1);
  EXPECT_EQ(r.centre_mm, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(solve::predict_rotation({contact({0, 0, 1}, {-1, -1, 0}), contact({0, 0, -1}, {1, -1, 0})}).sign,
            -1);
}

TEST(PredictRotation, FewerThanTwoContactsAndParallelPushesNeverTurn)
{
  EXPECT_EQ(solve::predict_rotation({}).sign, 0);
  EXPECT_EQ(solve::predict_rotation({contact({0, 0, 1}, {1, -1, 0})}).sign, 0);
  // Both push along +X: every point qualifies, but their mean fails the verification.
  EXPECT_EQ(solve::predict_rotation({contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {1, -1, 0})}).sign,
            0);
}

TEST(PredictRotation, QualifyingPointsBecomeTheCentre)
{
  // Three forces; only about the first and the last point do the other moments agree (thesis figure 7).
  const std::vector<contact::Contact> contacts = {
      contact({0, 0, 0}, {1, -1, 0}), contact({0, 0, 3}, {1, -1, 0}), contact({1, 0, -0.5}, {0, -1, -1})};
  const solve::RotationPrediction r = solve::predict_rotation(contacts);
  EXPECT_EQ(r.sign, 1);
  EXPECT_EQ(r.centre_mm, Eigen::Vector3d(0.5, 0, -0.25));
}

TEST(PredictRotation, ReactionsActWhereTheirNormalsWereTaken)
{
  // At the points on the reference they would be a couple; at their points of application they share one
  // axis.
  std::vector<contact::Contact> contacts = {contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {-1, -1, 0})};
  for (contact::Contact& c : contacts) c.application_mm = Eigen::Vector3d::Zero();
  EXPECT_EQ(solve::predict_rotation(contacts).sign, 0);
  EXPECT_EQ(solve::mean_point(contacts), Eigen::Vector3d(0, 0, 0));
}

TEST(PredictTranslation, MeansOverTheFourHalfAxesRemoveDuplicates)
{
  // Thesis figure 9: duplicates of one direction do not make the result longer.
  const contact::Contact push_x = contact({0, 0, 0}, {1, -1, 0});
  const contact::Contact push_z = contact({0, 0, 0}, {0, -1, 1});
  EXPECT_EQ(solve::predict_translation({push_x}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(solve::predict_translation({push_x, push_x, push_x}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(solve::predict_translation({push_x, push_z}), Eigen::Vector3d(1, 0, 1));
  EXPECT_EQ(solve::predict_translation({push_x, contact({1, 1, 1}, {-3, -1, 0})}), Eigen::Vector3d(0, 0, 0));
}

TEST(PredictTranslation, SlopesDoNotMatterAndNormalsAlongDeltaContributeNone)
{
  EXPECT_EQ(solve::predict_translation({contact({0, 0, 0}, {0.01, -1, 0})}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(solve::predict_translation({contact({0, 0, 0}, {0, -1, 0})}), Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(solve::predict_translation({}), Eigen::Vector3d(0, 0, 0));
}

TEST(PredictRotation, ANormalThroughTheCentreForbidsTheTurn)
{
  // Two opposite forces on one line and a third beside it, all through one axis: the mean of the first two is
  // on their line, where only the third would have a moment.
  const std::vector<contact::Contact> contacts = {
      contact({1, 0, 0}, {-1, -1, 0}), contact({-2, 0, 0}, {1, -1, 0}), contact({0, 0, 1}, {0, -1, -1})};
  EXPECT_EQ(solve::predict_rotation(contacts).sign, 0);
}

TEST(PredictAscent, ACoupleRotatesOnlyWithALever)
{
  // Moments of 3 mm per mm along Delta, forces balanced: with a lever of 6 mm one mm of motion rotates by 1/6
  // rad.
  const std::vector<contact::Contact> couple = {contact({1, 0, 3}, {1, -1, 0}),
                                                contact({1, 0, -3}, {-1, -1, 0})};
  EXPECT_EQ(solve::predict_ascent(couple).rise, 0.0);
  const solve::Ascent climb = solve::predict_ascent(couple, 6.0);
  EXPECT_NEAR(climb.rise, 0.5, 1e-15);
  EXPECT_NEAR(climb.turn_rad_per_mm, 1.0 / 6.0, 1e-15);
  EXPECT_LT(climb.direction.norm(), 1e-15);
  EXPECT_EQ(climb.centre_mm, Eigen::Vector3d(1, 0, 0));
}

// By duality: every contact allows at least the rise, and no tried motion of unit length allows more.
TEST(PredictAscent, IsTheBestOfAllMotions)
{
  constexpr double lever_mm = 2.0;
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  int n_ways = 0, n_none = 0, n_crowds = 0;
  for (int k = 0; k < 600; ++k) {
    std::vector<contact::Contact> contacts;
    for (int n = 0; n < 1 + k % 12; ++n) {
      contacts.push_back(contact({3 * unit(random), 0, 3 * unit(random)},
                                 {unit(random) + 0.5, -0.1 - std::abs(unit(random)), unit(random)}));
    }
    const Eigen::Vector3d middle = solve::mean_point(contacts);
    const auto rise_of = [&](const Eigen::Vector3d& way, double turn_rad) {
      double rise = std::numeric_limits<double>::infinity();
      for (const contact::Contact& c : contacts)
        rise = std::min(rise,
                        (c.normal.dot(way) + solve::moment_about_mm(c, middle) * turn_rad) / -c.normal.y());
      return rise;
    };
    const solve::Ascent climb = solve::predict_ascent(contacts, lever_mm);
    double best = 0.0;
    for (int trial = 0; trial < 2000; ++trial) {
      const Eigen::Vector3d motion = Eigen::Vector3d(unit(random), unit(random), unit(random)).normalized();
      best = std::max(best, rise_of({motion.x(), 0.0, motion.z()}, motion.y() / lever_mm));
    }
    // The nearest-point search is accurate to a share of 1e-7.
    EXPECT_LE(best, climb.rise + 1e-6);
    EXPECT_GE(rise_of(climb.direction, climb.turn_rad_per_mm), climb.rise - 1e-6);
    ++(climb.rise > 0.0 ? n_ways : n_none);
    n_crowds += climb.rise > 0.0 && contacts.size() > 4 ? 1 : 0;
  }
  EXPECT_GT(n_ways, 150);
  EXPECT_GT(n_none, 150);
  EXPECT_GT(n_crowds, 50);
}

// Contacts whose slopes in x, moment and z are the given ones. Each acts on its line of action; points are
// moved along these lines until their mean, the centre of rotation, is the origin.
std::vector<contact::Contact> contacts_of_slopes(const std::vector<Eigen::Vector3d>& slopes, double lever_mm)
{
  std::vector<contact::Contact> contacts;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Vector3d::UnitY().asDiagonal();
  for (const Eigen::Vector3d& slope : slopes) {
    const Eigen::Vector3d along(slope.x(), 0, slope.z());
    contacts.push_back(
        contact(slope.y() * lever_mm * along.cross(Eigen::Vector3d::UnitY()) / along.squaredNorm(),
                {slope.x(), -1, slope.z()}));
    sum += contacts.back().application_mm;
    spread += along * along.transpose();
  }
  const Eigen::Vector3d shift = spread.inverse() * sum;
  for (std::size_t k = 0; k < slopes.size(); ++k) {
    const Eigen::Vector3d along(slopes[k].x(), 0, slopes[k].z());
    contacts[k].application_mm -= along * along.dot(shift);
  }
  return contacts;
}

// The corners in a plane near the origin surround its foot and no slope is below the plane, so the rise is
// the plane's distance. The last corner brings the estimate nearer by less than a squared distance's
// rounding.
TEST(PredictAscent, FindsASmallRiseAmongSteepSlopes)
{
  constexpr double lever_mm = 2.0;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 20000; ++k) {
    const Eigen::Vector3d normal = Eigen::Vector3d(unit(random), unit(random), unit(random)).normalized();
    const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    const double distance = std::pow(10.0, -3.0 + unit(random)), turned = unit(random);
    std::vector<Eigen::Vector3d> slopes;
    for (int corner = 0; corner < 3; ++corner) {
      const SinCos at = sin_cos(2.0 * pi * corner / 3.0 + turned);
      slopes.push_back(distance * normal + (0.6 + 0.5 * unit(random)) * (at.cos * u + at.sin * v));
    }
    for (int n = 0; n < k % 8; ++n)
      slopes.push_back((distance + std::pow(10.0, -9.0 + unit(random))) * normal + unit(random) * u +
                       unit(random) * v);
    std::shuffle(slopes.begin(), slopes.end(), random);
    EXPECT_NEAR(solve::predict_ascent(contacts_of_slopes(slopes, lever_mm), lever_mm).rise, distance, 1e-9);
  }
}

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

}  // namespace vrda::prediction_test
