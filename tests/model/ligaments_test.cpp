#include "model/ligaments.hpp"

#include <gtest/gtest.h>

#include <random>

#include "model/differences.hpp"

namespace vrda::ligaments_test {

using test::Place;

constexpr double rounding = 1e-12;  // relative, of a few operations on doubles

model::Ligaments one_fibre(double stiffness_n, double slack_length_mm)
{
  model::Ligaments ligaments;
  ligaments.fibres = {{"a", "a", {0, 0, 0}, {0, 0, 0}, stiffness_n, slack_length_mm, -1}};
  return ligaments;
}

// Straight fibres of a joint's size, from slack to well beyond the toe.
model::Ligaments random_fibres(int n, std::uint64_t seed)
{
  std::mt19937_64 random(seed);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  const auto point = [&](double y_mm) {
    return Eigen::Vector3d(uniform(-30, 30), y_mm + uniform(-10, 10), uniform(-40, 40));
  };
  model::Ligaments ligaments;
  for (int i = 0; i < n; ++i) {
    model::Fibre fibre{"f" + std::to_string(i), "f", point(5), point(-25), uniform(100, 3000), 1.0, -1};
    fibre.slack_length_mm = (fibre.moving_mm - fibre.reference_mm).norm() * uniform(0.85, 1.05);
    ligaments.fibres.push_back(fibre);
  }
  return ligaments;
}

const Place bent{{0.6, -0.08}, {{1.5, -2.0, 0.7}, 0.15}};

TEST(Tension, FollowsTheLawOfBlankevoort)
{
  // k e^2 / (2 et) up to et = 0.06, then k (e - et / 2)
  struct Row {
    double strain, force_n, stiffness_n;
  };
  for (const Row row :
       {Row{-0.1, 0, 0}, Row{0, 0, 0}, Row{0.03, 15, 1000}, Row{0.06, 60, 2000}, Row{0.1, 140, 2000}}) {
    SCOPED_TRACE(row.strain);
    const model::Tension tension = model::tension_of(row.strain, 2000, 0.06);
    EXPECT_NEAR(tension.force_n, row.force_n, 140 * rounding);
    EXPECT_NEAR(tension.stiffness_n, row.stiffness_n, 2000 * rounding);
  }
}

TEST(Tension, EnergyIsTheIntegralOfTheForce)
{
  // Simpson's rule is exact for the square of the toe and for the line after it.
  const auto integral = [](double from, double to) {
    const double middle = 0.5 * (from + to);
    return (to - from) / 6 *
           (model::tension_of(from, 800, 0.06).force_n + 4 * model::tension_of(middle, 800, 0.06).force_n +
            model::tension_of(to, 800, 0.06).force_n);
  };
  EXPECT_NEAR(model::tension_of(0.05, 800, 0.06).energy_n, integral(0, 0.05), rounding);
  EXPECT_NEAR(model::tension_of(0.2, 800, 0.06).energy_n, integral(0, 0.06) + integral(0.06, 0.2),
              10 * rounding);
  EXPECT_EQ(model::tension_of(-0.01, 800, 0.06).energy_n, 0.0);
}

TEST(LigamentEnergy, OfOneStretchedFibreIsThatOfASpring)
{
  const model::Ligaments ligaments = one_fibre(2000, 20);
  // 25 mm along y: strain 0.25
  const MovingPose pose{{0, -25, 0}, 0};
  const Potential potential = model::ligament_energy(ligaments, {}, pose);
  const double force_n = 2000 * (0.25 - 0.03);
  EXPECT_NEAR(potential.gradient[along_y], -force_n, force_n * rounding);
  EXPECT_NEAR(potential.hessian(along_y, along_y), 2000.0 / 20, 100 * rounding);
  // Across itself a taut fibre is stiff as force over length.
  EXPECT_NEAR(potential.hessian(along_x, along_x), force_n / 25, 100 * rounding);
  // k l0 (e^2/2 - e et/2 + et^2/6)
  const double energy_nmm = 2000 * 20 * (0.25 * 0.25 / 2 - 0.25 * 0.03 + 0.06 * 0.06 / 6);
  EXPECT_NEAR(potential.energy_nmm, energy_nmm, energy_nmm * rounding);
}

TEST(LigamentEnergy, OfSlackFibresIsNothing)
{
  const Potential potential = model::ligament_energy(one_fibre(2000, 26), {}, {{0, -25, 0}, 0});
  EXPECT_EQ(potential.energy_nmm, 0.0);
  EXPECT_EQ(potential.gradient, Vector5d(Vector5d::Zero()));
  EXPECT_EQ(potential.hessian, Matrix5d(Matrix5d::Zero()));
}

TEST(LigamentEnergy, IsTheSumOfTheStates)
{
  const model::Ligaments ligaments = random_fibres(40, 1);
  double energy_nmm = 0.0;
  int n_slack = 0, n_toe = 0, n_linear = 0;
  for (const model::FibreState& state : model::fibre_states(ligaments, bent.attitude, bent.pose)) {
    energy_nmm += state.energy_nmm;
    n_slack += state.strain <= 0.0;
    n_toe += state.strain > 0.0 && state.strain < 0.06;
    n_linear += state.strain > 0.06;
  }
  EXPECT_GE(std::min({n_slack, n_toe, n_linear}), 4);
  EXPECT_NEAR(test::energy_at(ligaments, bent).energy_nmm, energy_nmm, energy_nmm * rounding);
}

TEST(LigamentEnergy, DerivativesMatchDifferences)
{
  const model::Ligaments ligaments = random_fibres(40, 2);
  const Potential exact = test::energy_at(ligaments, bent);
  const Potential measured = test::energy_by_differences(ligaments, bent);
  // Rounding of the energy (1e-16 of 1e4 N mm over steps of 1e-4 mm or 2e-6 rad) and squares of the steps.
  for (Eigen::Index i = 0; i < n_coordinates; ++i) {
    const double unit = i < about_y ? 1.0 : 50.0;  // mm a radian
    EXPECT_NEAR(exact.gradient[i], measured.gradient[i], 1e-6 * unit);
    for (Eigen::Index j = 0; j < n_coordinates; ++j) {
      SCOPED_TRACE(std::to_string(i) + " " + std::to_string(j));
      EXPECT_NEAR(exact.hessian(i, j), measured.hessian(i, j), 1e-5 * unit * (j < about_y ? 1.0 : 50.0));
    }
  }
  EXPECT_EQ(exact.hessian, Matrix5d(exact.hessian.transpose()));
}

}  // namespace vrda::ligaments_test
