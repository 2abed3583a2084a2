// The certificate of the equilibrium: compressive contact forces, compared with an independent solution.
#include "solve/potential.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "solve/pins.hpp"

namespace vrda::balance_test {

constexpr std::array<bool, 5> all_free{true, true, true, true, true};
const solve::RotationScale scale{{0, 0, 0}, 20};

// Minimum of |g - A l| over l >= 0 by exhaustive search over the active columns.
double least_residual(const Vector5d& g, const std::vector<solve::Clearance>& touching)
{
  double best = g.norm();
  for (unsigned choice = 1; choice < (1U << touching.size()); ++choice) {
    Eigen::MatrixXd A(5, 0);
    for (std::size_t k = 0; k < touching.size(); ++k) {
      if ((choice >> k & 1U) == 0) continue;
      A.conservativeResize(5, A.cols() + 1);
      A.col(A.cols() - 1) = touching[k].gradient;
    }
    A.bottomRows(2) /= scale.lever_mm;
    const Eigen::VectorXd l = A.colPivHouseholderQr().solve(g);
    if (l.minCoeff() >= 0.0) best = std::min(best, (A * l - g).norm());
  }
  return best;
}

TEST(Balance, IsTheLeastSquaresOfForcesThatPush)
{
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  int n_balanced = 0, n_unbalanced = 0;
  for (int k = 0; k < 300; ++k) {
    Potential u;
    u.gradient << normal(random), -20, normal(random), 20 * normal(random), 20 * normal(random);
    std::vector<solve::Clearance> touching(static_cast<std::size_t>(1 + k % 9));
    for (solve::Clearance& c : touching)
      c.gradient << 0.3 * normal(random), -1, 0.3 * normal(random), 10 * normal(random), 10 * normal(random);
    const solve::ContactForceBalance balance = solve::balance_contact_forces(u, touching, scale, all_free);
    Vector5d g = u.gradient;
    g.tail<2>() /= scale.lever_mm;
    EXPECT_NEAR(balance.residual_n, least_residual(g, touching), 1e-7);
    for (const solve::ContactForceBalance::ActiveConstraint& b : balance.active)
      EXPECT_GT(b.along_delta_n, 0.0);
    ++(balance.residual_n < 1e-9 ? n_balanced : n_unbalanced);
  }
  EXPECT_GT(n_balanced, 5);
  EXPECT_GT(n_unbalanced, 50);
}

TEST(Balance, PoseOffEquilibriumHasResidual)
{
  const solve::Joint joint = test::joint_of(
      test::ceiling(60, 12, [](double x, double z) { return -0.5 * (std::abs(x) + std::abs(z)); }),
      test::pins({{0, 0, 0}}));
  const model::Ligaments none;
  const Loads loads;
  geometry::GapQuery query(joint.reference_gap, joint.moving_gap);
  query.set_attitude({});
  struct Row {
    double x_mm, residual_share;
  };
  // In the middle all four flanks are in the band and balance the push. On one flank the residual is the
  // component of the push perpendicular to the normal (1, -2, 1) / sqrt(6).
  for (const Row row : {Row{0.0, 0.0}, Row{1.0, std::sqrt(1.0 / 3.0)}}) {
    MovingPose pose{{row.x_mm, 0, row.x_mm}, 0};
    pose.translation_mm.y() += query.travel_mm(pose);
    const solve::Configuration configuration = solve::configuration_at(pose, 0.0, scale);
    const solve::Rotations rotations(configuration, 0.0);
    std::vector<solve::Clearance> touching;
    for (const geometry::GapFeature& f : query.features(pose, 1e-3).features) {
      const solve::ContactConstraint constraint = solve::contact_constraint_of(
          f, {joint.reference.tree_mesh.mesh, joint.moving.tree_mesh.mesh, scale}, configuration, rotations);
      touching.push_back(solve::clearance(constraint, configuration, rotations));
    }
    const solve::ContactForceBalance balance =
        solve::balance_contact_forces(solve::potential_at({none, loads, scale, 0.0}, configuration), touching,
                                      scale, {true, true, true, true, false});
    EXPECT_NEAR(balance.residual_n, row.residual_share * 20, 1e-6);
  }
}

TEST(Balance, NothingTouchingLeavesThePush)
{
  Potential u;
  u.gradient << 0, -20, 0, 0, 0;
  EXPECT_NEAR(solve::balance_contact_forces(u, {}, scale, all_free).residual_n, 20, 1e-12);
}

}  // namespace vrda::balance_test
