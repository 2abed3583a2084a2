// Motion models whose push, equilibrium or ligaments break a rule: what the finding names.
#include <gtest/gtest.h>

#include <limits>

#include "core/units.hpp"
#include "store/changed_file.hpp"
#include "store/sample_model.hpp"

namespace vrda::mechanics_validate_test {

constexpr double infinity = std::numeric_limits<double>::infinity();
const char* const where_stable = "where status is stable, NaN elsewhere";

/// Of an equilibrium with five fibres and two wraps; cell 5 is not solved, the spine's last row not stable.
void expect_finding(const test::Damage& damage)
{
  test::expect_finding(test::sample_model({4, 3, true, true, true, true, 5, 2}), damage);
}

TEST(ValidateMechanics, Push)
{
  expect_finding({"/push/delta", "length 2 at entry 3", "unit vectors",
                  [](MotionModel& m) { m.push.delta.row(3) *= 2.0; }});
  expect_finding({"/push/delta", "length 1.0000001", "unit vectors",
                  [](MotionModel& m) { m.push.delta.row(3) *= 1.0000001; }});
  expect_finding(
      {"/push/force", "nan at entry 4", "finite", [](MotionModel& m) { m.push.force_n(1, 1) = nan; }});
  expect_finding({"/push/moment", "inf", "finite", [](MotionModel& m) { m.push.moment_nmm[0] = infinity; }});
  expect_finding(
      {"/push/varus_moment", "nan", "finite", [](MotionModel& m) { m.push.varus_moment_nmm[2] = nan; }});
  expect_finding({"/push@point_mm", "nan", "finite", [](MotionModel& m) { m.push.point_mm.z() = nan; }});
}

TEST(ValidateMechanics, VarusSolved)
{
  expect_finding({"/varus_solved", "nan at entry 4", where_stable,
                  [](MotionModel& m) { m.varus_solved_deg(1, 1) = nan; }});
  expect_finding({"/varus_solved", "1 at entry 5", where_stable,
                  [](MotionModel& m) { m.varus_solved_deg(1, 2) = 1.0; }});
  expect_finding({"/varus_solved", "-1.5 at entry 0", "axis has several",
                  [](MotionModel& m) { m.varus_solved_deg(0, 0) = -1.5; }});
}

TEST(ValidateMechanics, AFreeVarusMayDifferFromTheAxis)
{
  const test::SampleOptions one_column{4, 1, true, false, false};
  test::expect_finding(test::sample_model(one_column), {"/@side", "both", "right", [](MotionModel& m) {
                                                          m.varus_solved_deg(2, 0) = 3.25;
                                                          m.side = "both";
                                                        }});
}

TEST(ValidateMechanics, ContactPaths)
{
  expect_finding({"/contact_paths/medial_reference", "no point at entry 0", "a point or NaN",
                  [](MotionModel& m) { m.contact_paths->medial_reference_mm[1] = nan; }});
  expect_finding({"/contact_paths/medial_moving", "no point at entry 0", "a point or NaN",
                  [](MotionModel& m) { m.contact_paths->medial_moving_mm[0] = infinity; }});
  expect_finding({"/contact_paths/lateral_reference", "unsolved cell at entry 5", "NaN elsewhere",
                  [](MotionModel& m) { m.contact_paths->lateral_reference_mm[15] = 1.0; }});
  expect_finding({"/contact_paths/lateral_moving", "unsolved cell at entry 5", "NaN elsewhere",
                  [](MotionModel& m) { m.contact_paths->lateral_moving_mm[17] = 1.0; }});
}

TEST(ValidateMechanics, EquilibriumSurfaces)
{
  expect_finding({"/equilibrium@band_moment_nmm", "-1", "0 or a moment",
                  [](MotionModel& m) { m.equilibrium->band_moment_nmm = -1.0; }});
  expect_finding({"/equilibrium/energy", "nan at entry 0", where_stable,
                  [](MotionModel& m) { m.equilibrium->energy_nmm(0, 0) = nan; }});
  expect_finding({"/equilibrium/balance_residual", "-0.5 at entry 1", "at least 0",
                  [](MotionModel& m) { m.equilibrium->balance_residual_n(0, 1) = -0.5; }});
  expect_finding({"/equilibrium/complementarity", "0 at entry 5", where_stable,
                  [](MotionModel& m) { m.equilibrium->complementarity_mm(1, 2) = 0.0; }});
  expect_finding({"/equilibrium/worst_gap", "inf", where_stable,
                  [](MotionModel& m) { m.equilibrium->worst_gap_mm(3, 0) = infinity; }});
  expect_finding({"/equilibrium/flexion_moment", "nan", where_stable,
                  [](MotionModel& m) { m.equilibrium->flexion_moment_nmm(0, 0) = nan; }});
  expect_finding({"/equilibrium/varus_moment", "nan", where_stable,
                  [](MotionModel& m) { m.equilibrium->varus_moment_nmm(0, 0) = nan; }});
  expect_finding({"/equilibrium/force_medial", "nan at entry 2", where_stable,
                  [](MotionModel& m) { m.equilibrium->force_medial_n[2] = nan; }});
  expect_finding({"/equilibrium/force_lateral", "7 at entry 16", where_stable,
                  [](MotionModel& m) { m.equilibrium->force_lateral_n[16] = 7.0; }});
}

TEST(ValidateMechanics, Forces)
{
  expect_finding({"/equilibrium/forces/row_start", "at entry 3", "number of forces",
                  [](MotionModel& m) { m.equilibrium->forces.row_start[2] = 5; }});
  expect_finding({"/equilibrium/forces/row_start", "1 at entry 0", "number of forces",
                  [](MotionModel& m) { m.equilibrium->forces.row_start[0] = 1; }});
  expect_finding({"/equilibrium/forces/point", "nan at entry 0", "finite",
                  [](MotionModel& m) { m.equilibrium->forces.point_world_mm(0, 0) = nan; }});
  expect_finding({"/equilibrium/forces/normal", "length 3 at entry 2", "unit vectors",
                  [](MotionModel& m) { m.equilibrium->forces.normal_world.row(2) *= 3.0; }});
  expect_finding({"/equilibrium/forces/normal", "at entry 2", "oppose Delta",
                  [](MotionModel& m) { m.equilibrium->forces.normal_world.row(3) *= -1.0; }});
  for (const double bad_n : {0.0, -1.0, nan, infinity}) {
    expect_finding({"/equilibrium/forces/along_delta", "at entry 1", "above 0",
                    [&](MotionModel& m) { m.equilibrium->forces.along_delta_n[1] = bad_n; }});
  }
  expect_finding({"/equilibrium/forces/triangle_reference", "168", "0 to 167",
                  [](MotionModel& m) { m.equilibrium->forces.triangle_reference[0] = 168; }});
  expect_finding({"/equilibrium/forces/triangle_moving", "-1", "0 to 167",
                  [](MotionModel& m) { m.equilibrium->forces.triangle_moving[0] = -1; }});
  expect_finding({"/equilibrium/forces/compartment", "3", "0 to 2",
                  [](MotionModel& m) { m.equilibrium->forces.compartment[0] = 3; }});
}

TEST(ValidateMechanics, FreeSpine)
{
  expect_finding({"/equilibrium/spine/status", "9 at entry 3", "flag_values",
                  [](MotionModel& m) { m.equilibrium->spine.status[3] = 9; }});
  expect_finding({"/equilibrium/spine/varus", "nan at entry 0", where_stable,
                  [](MotionModel& m) { m.equilibrium->spine.varus_deg[0] = nan; }});
  expect_finding({"/equilibrium/spine/theta", "1 at entry 3", where_stable,
                  [](MotionModel& m) { m.equilibrium->spine.theta_deg[3] = 1.0; }});
  expect_finding({"/equilibrium/spine/energy", "inf", where_stable,
                  [](MotionModel& m) { m.equilibrium->spine.energy_nmm[2] = infinity; }});
  expect_finding({"/equilibrium/spine/theta_low", "inf", "number or NaN",
                  [](MotionModel& m) { m.equilibrium->spine.theta_low_deg[1] = infinity; }});
  expect_finding({"/equilibrium/spine/theta_high", "2 at entry 3", "NaN elsewhere",
                  [](MotionModel& m) { m.equilibrium->spine.theta_high_deg[3] = 2.0; }});
  expect_finding({"/equilibrium/spine/n_optima", "-1", "from 0",
                  [](MotionModel& m) { m.equilibrium->spine.n_optima[0] = -1; }});
  expect_finding({"/equilibrium/spine/optima_theta_spread", "-1", "at least 0",
                  [](MotionModel& m) { m.equilibrium->spine.optima_theta_spread_deg[0] = -1.0; }});
  expect_finding({"/equilibrium/spine/optima_energy_spread", "nan", where_stable,
                  [](MotionModel& m) { m.equilibrium->spine.optima_energy_spread_nmm[0] = nan; }});
}

TEST(ValidateMechanics, Fibres)
{
  expect_finding({"/ligaments@transition_strain", "0", "above 0",
                  [](MotionModel& m) { m.ligaments->transition_strain = 0.0; }});
  expect_finding(
      {"/ligaments/name", "\"\" at entry 2", "not empty", [](MotionModel& m) { m.ligaments->name[2] = ""; }});
  expect_finding({"/ligaments/reference", "nan at entry 3", "finite",
                  [](MotionModel& m) { m.ligaments->reference_mm(1, 0) = nan; }});
  expect_finding({"/ligaments/moving", "inf at entry 0", "finite",
                  [](MotionModel& m) { m.ligaments->moving_mm(0, 0) = infinity; }});
  expect_finding({"/ligaments/stiffness", "-5 at entry 4", "above 0",
                  [](MotionModel& m) { m.ligaments->stiffness_n[4] = -5.0; }});
  expect_finding({"/ligaments/slack_length", "0 at entry 1", "above 0",
                  [](MotionModel& m) { m.ligaments->slack_length_mm[1] = 0.0; }});
  for (const std::int32_t bad : {-2, 2}) {
    expect_finding(
        {"/ligaments/wrap", "at entry 1", "-1 to 1", [&](MotionModel& m) { m.ligaments->wrap[1] = bad; }});
  }
}

TEST(ValidateMechanics, Wraps)
{
  expect_finding(
      {"/ligaments/wrap_name", "\"\"", "not empty", [](MotionModel& m) { m.ligaments->wrap_name[1] = ""; }});
  expect_finding({"/ligaments/wrap_shape", "2 at entry 0", "flag_values",
                  [](MotionModel& m) { m.ligaments->wrap_shape[0] = 2; }});
  expect_finding({"/ligaments/wrap_body", "-1 at entry 1", "flag_values",
                  [](MotionModel& m) { m.ligaments->wrap_body[1] = -1; }});
  expect_finding({"/ligaments/X_body_wrap", "no rigid pose at entry 1", "a rotation and a translation",
                  [](MotionModel& m) { m.ligaments->X_body_wrap[16] += 1e-6; }});
  expect_finding({"/ligaments/wrap_radii", "0 at entry 5", "above 0",
                  [](MotionModel& m) { m.ligaments->wrap_radii_mm(1, 2) = 0.0; }});
}

TEST(ValidateMechanics, FibreStates)
{
  expect_finding({"/ligaments/length", "nan at entry 0", where_stable,
                  [](MotionModel& m) { m.ligaments->length_mm[0] = nan; }});
  expect_finding({"/ligaments/strain", "0.5 at entry 27", where_stable,
                  [](MotionModel& m) { m.ligaments->strain[27] = 0.5; }});
  expect_finding({"/ligaments/tension", "-1 at entry 4", "at least 0",
                  [](MotionModel& m) { m.ligaments->tension_n[4] = -1.0; }});
  expect_finding({"/ligaments/energy", "inf", where_stable,
                  [](MotionModel& m) { m.ligaments->energy_nmm[4] = infinity; }});
  expect_finding({"/ligaments/is_wrapped", "-1 at entry 3", "0 or 1",
                  [](MotionModel& m) { m.ligaments->is_wrapped[3] = -1; }});
  expect_finding({"/ligaments/is_wrapped", "0 at entry 25", "-1 elsewhere",
                  [](MotionModel& m) { m.ligaments->is_wrapped[25] = 0; }});
}

}  // namespace vrda::mechanics_validate_test
