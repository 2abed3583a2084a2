#include "store/scaled_model.hpp"

#include <cmath>

#include "core/error.hpp"

namespace vrda {
namespace {

class Scaler {
 public:
  explicit Scaler(double factor) : factor_(factor) {}

  void scale(MotionModel& model) const
  {
    times(model.rotation_centre_mm, model.contact_resolution_mm, model.tx_mm, model.ty_mm, model.tz_mm,
          model.residual_mm, model.gap_medial_mm, model.gap_lateral_mm);
    shifts_times(model.X_reference_moving);
    times(model.push.moment_nmm, model.push.varus_moment_nmm, model.push.point_mm);
    times(model.clinical.anterior_mm, model.clinical.proximal_mm, model.clinical.lateral_mm);
    times(model.contacts.point_world_mm, model.contacts.distance_mm);
    if (model.equilibrium) scale(*model.equilibrium);
    if (model.ligaments) scale(*model.ligaments);
    if (model.contact_paths) {
      times(model.contact_paths->medial_reference_mm, model.contact_paths->medial_moving_mm,
            model.contact_paths->lateral_reference_mm, model.contact_paths->lateral_moving_mm);
    }
    for (Body* body : {&model.reference, &model.moving})
      times(body->contact.mesh.vertices_mm, body->visual.mesh.vertices_mm);
    for (SmoothedSet& set : model.smoothed) scale(set);
    for (AuditSet& audit : model.audits) times(audit.gap_mm, audit.penetration_mm);
    if (model.zero_varus) scale(*model.zero_varus);
  }

 private:
  void by(double& value) const { value *= factor_; }
  void by(std::vector<double>& values) const
  {
    for (double& value : values) value *= factor_;
  }
  template <typename Derived>
  void by(Eigen::DenseBase<Derived>& values) const
  {
    values *= factor_;
  }
  template <typename... Values>
  void times(Values&... values) const
  {
    (by(values), ...);
  }
  /// Of [n, 4, 4] poses, row by row.
  void shifts_times(std::vector<double>& poses) const
  {
    for (std::size_t k = 3; k < poses.size(); k += 4)
      if (k % 16 != 15) poses[k] *= factor_;
  }

  void scale(EquilibriumSurfaces& found) const
  {
    times(found.band_moment_nmm, found.energy_nmm, found.complementarity_mm, found.worst_gap_mm,
          found.flexion_moment_nmm, found.varus_moment_nmm, found.forces.point_world_mm);
    // The residual's moments are divided by a lever that grows along: it stays.
    FreeSpine& spine = found.spine;
    times(spine.tx_mm, spine.ty_mm, spine.tz_mm, spine.energy_nmm, spine.optima_energy_spread_nmm);
  }
  void scale(LigamentRows& fibres) const
  {
    times(fibres.reference_mm, fibres.moving_mm, fibres.slack_length_mm, fibres.wrap_radii_mm,
          fibres.length_mm, fibres.energy_nmm);
    shifts_times(fibres.X_body_wrap);
  }
  void scale(SmoothedSet& set) const
  {
    for (SmoothedSurface& surface : set.surfaces) {
      if (surface.name != "tx" && surface.name != "ty" && surface.name != "tz") continue;
      times(surface.coefficients, surface.values, surface.rms, surface.largest_residual,
            surface.leave_one_out_rms);
    }
    if (set.recontact_mm) by(*set.recontact_mm);
  }
  void scale(ZeroVarus& table) const
  {
    times(table.tx_mm, table.ty_mm, table.tz_mm, table.anterior_mm, table.proximal_mm, table.lateral_mm);
    shifts_times(table.X_reference_moving);
    times(table.medial_reference_mm, table.medial_moving_mm, table.lateral_reference_mm,
          table.lateral_moving_mm);
    times(table.helical_translation_mm, table.helical_point_mm, table.instant_centre_mm);
    times(table.medial_rolling_mm, table.medial_sliding_mm, table.lateral_rolling_mm,
          table.lateral_sliding_mm);
  }

  double factor_;
};

}  // namespace

MotionModel scaled_model(MotionModel model, double factor)
{
  check(std::isfinite(factor) && factor > 0.0, "a model is scaled by a number above 0");
  if (factor != 1.0) Scaler(factor).scale(model);
  return model;
}

}  // namespace vrda
