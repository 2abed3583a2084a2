// Compares the equilibrium with NLopt's subplex, which uses only the potential of a configuration in
// equilibrium along Delta: no features, gradients or active sets.
#include <gtest/gtest.h>
#include <nlopt.h>

#include <cmath>
#include <exception>

#include "solve/pins.hpp"

#include "solve/potential.hpp"

namespace vrda::cross_check_test {

constexpr double radius_mm = 1.0;  // about the start
constexpr double lever_mm = 20.0;

struct Landscape {
  const test::MinimalKnee& knee;
  Loads loads;
  solve::RotationScale scale{{0, 0, 0}, lever_mm};
  geometry::GapQuery query{knee.joint.reference_gap, knee.joint.moving_gap};
  solve::Configuration start{};
  std::exception_ptr thrown{};  // exceptions must not propagate through a C callback
  nlopt_opt optimiser = nullptr;

  double potential_nmm(const double* step)
  {
    Vector5d step_mm;
    step_mm << step[0], 0, step[1], step[2], step[3];
    const solve::Configuration configuration = solve::moved(start, step_mm, scale);
    query.set_attitude({0.1, configuration.varus_rad});
    const double travel_mm = query.travel_mm(solve::pose_at(configuration, scale));
    check(std::isfinite(travel_mm), "cross-check: nothing faces");
    const solve::NonContactForces forces{knee.ligaments, loads, scale, 0.1};
    return solve::equilibrium_along_delta(forces, configuration,
                                          {configuration.pivot_mm.y() + travel_mm, 100, 1e-9})
        .potential.energy_nmm;
  }
};

double objective(unsigned, const double* x, double*, void* data)
{
  auto& landscape = *static_cast<Landscape*>(data);
  try {
    return landscape.potential_nmm(x);
  } catch (...) {
    landscape.thrown = std::current_exception();
    nlopt_force_stop(landscape.optimiser);
    return 0.0;
  }
}

// Subplex with restarts from its best point, since kinks stall its simplex.
double least_by_subplex(Landscape& landscape)
{
  double x[4] = {0, 0, 0, 0}, least = 0.0;
  for (int k = 0; k < 12; ++k) {
    landscape.optimiser = nlopt_create(NLOPT_LN_SBPLX, 4);
    nlopt_set_min_objective(landscape.optimiser, objective, &landscape);
    nlopt_set_lower_bounds1(landscape.optimiser, -radius_mm);
    nlopt_set_upper_bounds1(landscape.optimiser, radius_mm);
    nlopt_set_initial_step1(landscape.optimiser, k % 2 == 0 ? 0.3 : 0.03);
    nlopt_set_xtol_abs1(landscape.optimiser, 1e-8);
    nlopt_set_maxeval(landscape.optimiser, 4000);
    nlopt_optimize(landscape.optimiser, x, &least);
    nlopt_destroy(landscape.optimiser);
    if (landscape.thrown) std::rethrow_exception(landscape.thrown);
  }
  return least;
}

TEST(CrossCheck, SubplexFindsNoLowerPotentialNearTheEquilibrium)
{
  const test::MinimalKnee knee;
  int n_reached = 0, n_cases = 0;
  for (const double sideways_n : {0.0, 3.0, -2.0}) {
    for (const double moment_nmm : {0.0, 150.0}) {
      Loads loads;
      loads.force_n = {sideways_n, 40, 0.5 * sideways_n};
      loads.moment_nmm = moment_nmm;
      const StepRecord r = knee.solve({{0, -5, 0}, 0}, 0.0, loads);
      ASSERT_EQ(r.status, StepStatus::stable);
      Landscape landscape{knee, loads};
      Vector5d offset;
      offset << 0.3, 0, -0.2, 0.25, -0.3;
      landscape.start = solve::moved(solve::configuration_at(r.pose, r.varus_rad, landscape.scale), offset,
                                     landscape.scale);
      const double found_nmm = least_by_subplex(landscape);
      // The stand-off of 1e-5 mm costs 4e-4 N mm, a step of one tolerance against 40 N ten times as much.
      EXPECT_GE(found_nmm, r.balance.energy_nmm - 5e-3);
      n_reached += found_nmm < r.balance.energy_nmm + 0.5 ? 1 : 0;
      ++n_cases;
    }
  }
  // Kinks between facets sometimes stop the simplex early.
  EXPECT_GE(n_reached, n_cases / 2);
}

}  // namespace vrda::cross_check_test
