#include "store/equal_models.hpp"

#include <gtest/gtest.h>

namespace vrda::test {
namespace {

template <typename Scalar>
void expect_equal(const Grid<Scalar>& a, const Grid<Scalar>& b, const char* what)
{
  ASSERT_EQ(a.rows(), b.rows()) << what;
  ASSERT_EQ(a.cols(), b.cols()) << what;
  for (Eigen::Index k = 0; k < a.size(); ++k) {
    const bool both_nan = a.data()[k] != a.data()[k] && b.data()[k] != b.data()[k];
    EXPECT_TRUE(both_nan || a.data()[k] == b.data()[k]) << what << " at " << k;
  }
}

void expect_equal(const std::vector<double>& a, const std::vector<double>& b, const char* what)
{
  ASSERT_EQ(a.size(), b.size()) << what;
  const Eigen::Index n = static_cast<Eigen::Index>(a.size());
  expect_equal<double>(Eigen::Map<const GridD>(a.data(), n, 1), Eigen::Map<const GridD>(b.data(), n, 1),
                       what);
}

void expect_equal(const Part& a, const Part& b)
{
  EXPECT_EQ(a.mesh.vertices_mm, b.mesh.vertices_mm);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.mesh.normals, b.mesh.normals);
  EXPECT_EQ(a.component, b.component);
}

void expect_equal(const Body& a, const Body& b)
{
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.components.size(), b.components.size());
  for (std::size_t i = 0; i < a.components.size(); ++i) {
    EXPECT_EQ(a.components[i].name, b.components[i].name);
    EXPECT_EQ(a.components[i].material, b.components[i].material);
  }
  expect_equal(a.contact, b.contact);
  expect_equal(a.visual, b.visual);
}

void expect_equal(const SmoothedSet& a, const SmoothedSet& b)
{
  EXPECT_EQ(a.degree, b.degree);
  EXPECT_EQ(a.is_robust, b.is_robust);
  ASSERT_EQ(a.recontact_mm.has_value(), b.recontact_mm.has_value());
  expect_equal(a.recontact_mm.value_or(GridD()), b.recontact_mm.value_or(GridD()), "recontact");
  EXPECT_TRUE((a.exponents == b.exponents).all());
  ASSERT_EQ(a.surfaces.size(), b.surfaces.size());
  for (std::size_t s = 0; s < a.surfaces.size(); ++s) {
    EXPECT_EQ(a.surfaces[s].name, b.surfaces[s].name);
    EXPECT_EQ(a.surfaces[s].coefficients, b.surfaces[s].coefficients);
    expect_equal(a.surfaces[s].values, b.surfaces[s].values, "smoothed values");
    EXPECT_EQ(a.surfaces[s].n_cells, b.surfaces[s].n_cells);
    EXPECT_EQ(a.surfaces[s].rms, b.surfaces[s].rms);
    EXPECT_EQ(a.surfaces[s].largest_residual, b.surfaces[s].largest_residual);
    EXPECT_EQ(a.surfaces[s].leave_one_out_rms, b.surfaces[s].leave_one_out_rms);
    EXPECT_EQ(a.surfaces[s].condition_number, b.surfaces[s].condition_number);
  }
}

void expect_equal(const ZeroVarus& a, const ZeroVarus& b)
{
  EXPECT_EQ(a.set, b.set);
  EXPECT_EQ(a.source, b.source);
  expect_equal(a.varus_deg, b.varus_deg, "zero varus");
  expect_equal(a.varus_first_deg, b.varus_first_deg, "varus_first");
  expect_equal(a.varus_last_deg, b.varus_last_deg, "varus_last");
  expect_equal(a.tx_mm, b.tx_mm, "zero-varus tx");
  expect_equal(a.ty_mm, b.ty_mm, "zero-varus ty");
  expect_equal(a.tz_mm, b.tz_mm, "zero-varus tz");
  expect_equal(a.theta_deg, b.theta_deg, "zero-varus theta");
  expect_equal(a.X_reference_moving, b.X_reference_moving, "zero-varus X_reference_moving");
  expect_equal(a.clinical_flexion_deg, b.clinical_flexion_deg, "zero-varus flexion_angle");
  expect_equal(a.clinical_varus_deg, b.clinical_varus_deg, "zero-varus varus_angle");
  expect_equal(a.internal_rotation_deg, b.internal_rotation_deg, "zero-varus internal_rotation");
  expect_equal(a.anterior_mm, b.anterior_mm, "zero-varus anterior");
  expect_equal(a.proximal_mm, b.proximal_mm, "zero-varus proximal");
  expect_equal(a.lateral_mm, b.lateral_mm, "zero-varus lateral");
  expect_equal(a.medial_reference_mm, b.medial_reference_mm, "zero-varus medial_reference");
  expect_equal(a.medial_moving_mm, b.medial_moving_mm, "zero-varus medial_moving");
  expect_equal(a.lateral_reference_mm, b.lateral_reference_mm, "zero-varus lateral_reference");
  expect_equal(a.lateral_moving_mm, b.lateral_moving_mm, "zero-varus lateral_moving");
  expect_equal(a.helical_rotation_deg, b.helical_rotation_deg, "helical_rotation");
  expect_equal(a.helical_translation_mm, b.helical_translation_mm, "helical_translation");
  expect_equal(a.helical_direction, b.helical_direction, "helical_direction");
  expect_equal(a.helical_point_mm, b.helical_point_mm, "helical_point");
  expect_equal(a.instant_centre_mm, b.instant_centre_mm, "instant_centre");
  expect_equal(a.medial_rolling_mm, b.medial_rolling_mm, "medial_rolling");
  expect_equal(a.medial_sliding_mm, b.medial_sliding_mm, "medial_sliding");
  expect_equal(a.lateral_rolling_mm, b.lateral_rolling_mm, "lateral_rolling");
  expect_equal(a.lateral_sliding_mm, b.lateral_sliding_mm, "lateral_sliding");
}

void expect_equal(const AuditSet& a, const AuditSet& b)
{
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.refine, b.refine);
  EXPECT_EQ(a.flexion_deg, b.flexion_deg);
  EXPECT_EQ(a.varus_deg, b.varus_deg);
  expect_equal(a.state, b.state, "audit state");
  expect_equal(a.gap_mm, b.gap_mm, "audit gap");
  expect_equal(a.penetration_mm, b.penetration_mm, "audit penetration");
}

void expect_equal_derived(const MotionModel& a, const MotionModel& b)
{
  ASSERT_EQ(a.smoothed.size(), b.smoothed.size());
  for (std::size_t i = 0; i < a.smoothed.size(); ++i) expect_equal(a.smoothed[i], b.smoothed[i]);
  ASSERT_EQ(a.zero_varus.has_value(), b.zero_varus.has_value());
  expect_equal(a.zero_varus.value_or(ZeroVarus()), b.zero_varus.value_or(ZeroVarus()));
  ASSERT_EQ(a.audits.size(), b.audits.size());
  for (std::size_t i = 0; i < a.audits.size(); ++i) expect_equal(a.audits[i], b.audits[i]);
}

void expect_equal_cells(const MotionModel& a, const MotionModel& b)
{
  expect_equal(a.tx_mm, b.tx_mm, "tx");
  expect_equal(a.ty_mm, b.ty_mm, "ty");
  expect_equal(a.tz_mm, b.tz_mm, "tz");
  expect_equal(a.theta_deg, b.theta_deg, "theta");
  expect_equal(a.X_reference_moving, b.X_reference_moving, "X_reference_moving");
  expect_equal(a.status, b.status, "status");
  expect_equal(a.iterations, b.iterations, "iterations");
  expect_equal(a.queries, b.queries, "queries");
  expect_equal(a.residual_mm, b.residual_mm, "residual");
  expect_equal(a.gap_medial_mm, b.gap_medial_mm, "gap_medial_mm");
  expect_equal(a.gap_lateral_mm, b.gap_lateral_mm, "gap_lateral_mm");
  expect_equal(a.contact_medial, b.contact_medial, "contact_medial");
  expect_equal(a.contact_lateral, b.contact_lateral, "contact_lateral");
  expect_equal(a.plausibility, b.plausibility, "plausibility");
  expect_equal(a.theta_determined, b.theta_determined, "theta_determined");
  expect_equal(a.is_spine, b.is_spine, "is_spine");
  expect_equal(a.varus_solved_deg, b.varus_solved_deg, "varus_solved");
  expect_equal(a.clinical.flexion_deg, b.clinical.flexion_deg, "flexion_angle");
  expect_equal(a.clinical.varus_deg, b.clinical.varus_deg, "varus_angle");
  expect_equal(a.clinical.internal_rotation_deg, b.clinical.internal_rotation_deg, "internal_rotation");
  expect_equal(a.clinical.anterior_mm, b.clinical.anterior_mm, "anterior");
  expect_equal(a.clinical.proximal_mm, b.clinical.proximal_mm, "proximal");
  expect_equal(a.clinical.lateral_mm, b.clinical.lateral_mm, "lateral");
}

void expect_equal(const PushRows& a, const PushRows& b)
{
  EXPECT_EQ(a.delta, b.delta);
  EXPECT_EQ(a.force_n, b.force_n);
  EXPECT_EQ(a.moment_nmm, b.moment_nmm);
  EXPECT_EQ(a.varus_moment_nmm, b.varus_moment_nmm);
  EXPECT_EQ(a.point_mm, b.point_mm);
}

void expect_equal(const ContactPaths& a, const ContactPaths& b)
{
  expect_equal(a.medial_reference_mm, b.medial_reference_mm, "medial_reference");
  expect_equal(a.medial_moving_mm, b.medial_moving_mm, "medial_moving");
  expect_equal(a.lateral_reference_mm, b.lateral_reference_mm, "lateral_reference");
  expect_equal(a.lateral_moving_mm, b.lateral_moving_mm, "lateral_moving");
}

void expect_equal(const ForceRows& a, const ForceRows& b)
{
  EXPECT_EQ(a.row_start, b.row_start);
  EXPECT_EQ(a.point_world_mm, b.point_world_mm);
  EXPECT_EQ(a.normal_world, b.normal_world);
  EXPECT_EQ(a.along_delta_n, b.along_delta_n);
  EXPECT_EQ(a.triangle_reference, b.triangle_reference);
  EXPECT_EQ(a.triangle_moving, b.triangle_moving);
  EXPECT_EQ(a.compartment, b.compartment);
}

void expect_equal(const FreeSpine& a, const FreeSpine& b)
{
  EXPECT_EQ(a.status, b.status);
  expect_equal(a.varus_deg, b.varus_deg, "spine varus");
  expect_equal(a.tx_mm, b.tx_mm, "spine tx");
  expect_equal(a.ty_mm, b.ty_mm, "spine ty");
  expect_equal(a.tz_mm, b.tz_mm, "spine tz");
  expect_equal(a.theta_deg, b.theta_deg, "spine theta");
  expect_equal(a.energy_nmm, b.energy_nmm, "spine energy");
  expect_equal(a.theta_low_deg, b.theta_low_deg, "theta_low");
  expect_equal(a.theta_high_deg, b.theta_high_deg, "theta_high");
  EXPECT_EQ(a.n_optima, b.n_optima);
  expect_equal(a.optima_theta_spread_deg, b.optima_theta_spread_deg, "optima_theta_spread");
  expect_equal(a.optima_energy_spread_nmm, b.optima_energy_spread_nmm, "optima_energy_spread");
}

void expect_equal(const EquilibriumSurfaces& a, const EquilibriumSurfaces& b)
{
  EXPECT_EQ(a.band_moment_nmm, b.band_moment_nmm);
  expect_equal(a.energy_nmm, b.energy_nmm, "energy");
  expect_equal(a.balance_residual_n, b.balance_residual_n, "balance_residual");
  expect_equal(a.complementarity_mm, b.complementarity_mm, "complementarity");
  expect_equal(a.worst_gap_mm, b.worst_gap_mm, "worst_gap");
  expect_equal(a.flexion_moment_nmm, b.flexion_moment_nmm, "flexion_moment");
  expect_equal(a.varus_moment_nmm, b.varus_moment_nmm, "varus_moment");
  expect_equal(a.force_medial_n, b.force_medial_n, "force_medial");
  expect_equal(a.force_lateral_n, b.force_lateral_n, "force_lateral");
  expect_equal(a.forces, b.forces);
  expect_equal(a.spine, b.spine);
}

void expect_equal(const LigamentRows& a, const LigamentRows& b)
{
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.bundle, b.bundle);
  EXPECT_EQ(a.reference_mm, b.reference_mm);
  EXPECT_EQ(a.moving_mm, b.moving_mm);
  EXPECT_EQ(a.stiffness_n, b.stiffness_n);
  EXPECT_EQ(a.slack_length_mm, b.slack_length_mm);
  EXPECT_EQ(a.wrap, b.wrap);
  EXPECT_EQ(a.transition_strain, b.transition_strain);
  EXPECT_EQ(a.wrap_name, b.wrap_name);
  EXPECT_EQ(a.wrap_shape, b.wrap_shape);
  EXPECT_EQ(a.wrap_body, b.wrap_body);
  EXPECT_EQ(a.X_body_wrap, b.X_body_wrap);
  EXPECT_EQ(a.wrap_radii_mm, b.wrap_radii_mm);
  expect_equal(a.length_mm, b.length_mm, "length");
  expect_equal(a.strain, b.strain, "strain");
  expect_equal(a.tension_n, b.tension_n, "tension");
  expect_equal(a.energy_nmm, b.energy_nmm, "energy of fibres");
  EXPECT_EQ(a.is_wrapped, b.is_wrapped);
}

void expect_equal(const Scaling& a, const Scaling& b)
{
  EXPECT_EQ(a.factor, b.factor);
  EXPECT_EQ(a.keeps_steps, b.keeps_steps);
  EXPECT_EQ(a.landmark, b.landmark);
  EXPECT_EQ(a.model_mm, b.model_mm);
  EXPECT_EQ(a.subject_mm, b.subject_mm);
  EXPECT_EQ(a.residual_mm, b.residual_mm);
  expect_equal(std::vector{a.residual_rms_mm, a.standard_error},
               std::vector{b.residual_rms_mm, b.standard_error}, "fit of the scaling");
}

void expect_equal_mechanics(const MotionModel& a, const MotionModel& b)
{
  expect_equal(a.push, b.push);
  ASSERT_EQ(a.contact_paths.has_value(), b.contact_paths.has_value());
  ASSERT_EQ(a.equilibrium.has_value(), b.equilibrium.has_value());
  ASSERT_EQ(a.ligaments.has_value(), b.ligaments.has_value());
  expect_equal(a.contact_paths.value_or(ContactPaths()), b.contact_paths.value_or(ContactPaths()));
  expect_equal(a.equilibrium.value_or(EquilibriumSurfaces()), b.equilibrium.value_or(EquilibriumSurfaces()));
  expect_equal(a.ligaments.value_or(LigamentRows()), b.ligaments.value_or(LigamentRows()));
}

}  // namespace

void expect_equal(const MotionModel& a, const MotionModel& b)
{
  EXPECT_EQ(a.title, b.title);
  EXPECT_EQ(a.joint, b.joint);
  EXPECT_EQ(a.side, b.side);
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.rotation_centre_mm, b.rotation_centre_mm);
  EXPECT_EQ(a.delta, b.delta);
  EXPECT_EQ(a.contact_resolution_mm, b.contact_resolution_mm);
  EXPECT_EQ(a.has_compartments, b.has_compartments);
  EXPECT_EQ(a.flexion_deg, b.flexion_deg);
  EXPECT_EQ(a.varus_deg, b.varus_deg);
  expect_equal_cells(a, b);
  EXPECT_EQ(a.contacts.row_start, b.contacts.row_start);
  EXPECT_EQ(a.contacts.point_world_mm, b.contacts.point_world_mm);
  EXPECT_EQ(a.contacts.normal_world, b.contacts.normal_world);
  EXPECT_EQ(a.contacts.distance_mm, b.contacts.distance_mm);
  EXPECT_EQ(a.contacts.triangle_reference, b.contacts.triangle_reference);
  EXPECT_EQ(a.contacts.triangle_moving, b.contacts.triangle_moving);
  EXPECT_EQ(a.contacts.compartment, b.contacts.compartment);
  expect_equal(a.reference, b.reference);
  expect_equal(a.moving, b.moving);
  expect_equal_derived(a, b);
  expect_equal_mechanics(a, b);
  ASSERT_EQ(a.job.scaling.has_value(), b.job.scaling.has_value());
  expect_equal(a.job.scaling.value_or(Scaling()), b.job.scaling.value_or(Scaling()));
  EXPECT_EQ(a.job.text, b.job.text);
  EXPECT_EQ(a.job.resolved, b.job.resolved);
  ASSERT_EQ(a.job.inputs.size(), b.job.inputs.size());
  for (std::size_t i = 0; i < a.job.inputs.size(); ++i) {
    EXPECT_EQ(a.job.inputs[i].name, b.job.inputs[i].name);
    EXPECT_EQ(a.job.inputs[i].sha256, b.job.inputs[i].sha256);
  }
}

}  // namespace vrda::test
