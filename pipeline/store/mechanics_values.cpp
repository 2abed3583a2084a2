#include "store/mechanics_values.hpp"

#include <algorithm>
#include <cmath>

#include "store/layout.hpp"

namespace vrda {
namespace {

bool is_stable(std::int8_t status)
{
  return status == status_stable;
}

/// The status of every cell, or of every flexion of the free spine.
struct Statuses {
  const std::int8_t* data = nullptr;
  std::size_t size = 0;
  bool is_stable(std::size_t i) const { return vrda::is_stable(data[i]); }
};

class MechanicsCheck {
 public:
  MechanicsCheck(const MotionModel& model, ValueFindings& findings)
      : model_(model),
        findings_(findings),
        cells_{model.status.data(), static_cast<std::size_t>(model.status.size())}
  {
  }

  void run()
  {
    check_varus_solved();
    check_push();
    if (model_.contact_paths) check_contact_paths(*model_.contact_paths);
    if (model_.equilibrium) check_equilibrium(*model_.equilibrium);
    if (model_.ligaments) check_ligaments(*model_.ligaments);
  }

 private:
  /// `width` numbers an entry: finite, and at least `least`, where it is stable, NaN elsewhere.
  void answers(const std::string& where, const double* values, const Statuses& statuses,
               std::size_t width = 1, double least = -std::numeric_limits<double>::infinity())
  {
    const std::string bound = std::isfinite(least) ? " of at least " + text_of(least) : "";
    findings_.each_number(where, values, statuses.size * width,
                          "a number" + bound + " where status is stable, NaN elsewhere", [&](std::size_t i) {
                            if (!statuses.is_stable(i / width)) return !std::isnan(values[i]);
                            return !is_number(values[i]) || values[i] < least;
                          });
  }

  /// A number or NaN where it is stable, NaN elsewhere.
  void answers_or_nan(const std::string& where, const std::vector<double>& values, const Statuses& statuses)
  {
    findings_.each_number(where, values.data(), values.size(),
                          "a number or NaN where status is stable, NaN elsewhere", [&](std::size_t i) {
                            return statuses.is_stable(i) ? !is_number_or_nan(values[i])
                                                         : !std::isnan(values[i]);
                          });
  }

  void positive(const std::string& where, const double* values, std::size_t size)
  {
    findings_.each_number(where, values, size, "numbers above 0",
                          [&](std::size_t i) { return !is_number(values[i]) || !(values[i] > 0.0); });
  }

  void texts(const std::string& where, const std::vector<std::string>& values)
  {
    findings_.each(
        where, values.size(), "names that are not empty", [&](std::size_t i) { return values[i].empty(); },
        [&](std::size_t) { return "\"\""; });
  }

  void check_varus_solved()
  {
    const GridD& solved_deg = model_.varus_solved_deg;
    answers("/varus_solved", solved_deg.data(), cells_);
    const std::size_t n_varus = model_.varus_deg.size();
    if (n_varus == 1) return;
    findings_.each_number("/varus_solved", solved_deg.data(), cells_.size,
                          "the cell's varus where the axis has several", [&](std::size_t cell) {
                            const double wanted_deg = model_.varus_deg[cell % n_varus];
                            return cells_.is_stable(cell) && is_number(wanted_deg) &&
                                   std::abs(solved_deg.data()[cell] - wanted_deg) > exact_tolerance;
                          });
  }

  void check_push()
  {
    const PushRows& push = model_.push;
    findings_.unit_rows("/push/delta", push.delta, false, exact_tolerance);
    findings_.all_finite("/push/force", push.force_n.data(), static_cast<std::size_t>(push.force_n.size()));
    findings_.all_finite("/push/moment", push.moment_nmm.data(), push.moment_nmm.size());
    findings_.all_finite("/push/varus_moment", push.varus_moment_nmm.data(), push.varus_moment_nmm.size());
    findings_.all_finite("/push@point_mm", push.point_mm.data(), 3);
  }

  void check_path(const std::string& where, const std::vector<double>& points)
  {
    findings_.each(
        where, cells_.size, "a point or NaN where status is stable, NaN elsewhere",
        [&](std::size_t cell) {
          const double* p = &points[3 * cell];
          if (std::all_of(p, p + 3, [](double x) { return std::isnan(x); })) return false;
          return !cells_.is_stable(cell) || !std::all_of(p, p + 3, [](double x) { return is_number(x); });
        },
        [&](std::size_t cell) {
          return cells_.is_stable(cell) ? "no point" : "numbers in an unsolved cell";
        });
  }

  void check_contact_paths(const ContactPaths& paths)
  {
    check_path("/contact_paths/medial_reference", paths.medial_reference_mm);
    check_path("/contact_paths/medial_moving", paths.medial_moving_mm);
    check_path("/contact_paths/lateral_reference", paths.lateral_reference_mm);
    check_path("/contact_paths/lateral_moving", paths.lateral_moving_mm);
  }

  void check_equilibrium(const EquilibriumSurfaces& equilibrium)
  {
    if (!(equilibrium.band_moment_nmm >= 0.0) || !is_number(equilibrium.band_moment_nmm)) {
      findings_.find("/equilibrium@band_moment_nmm", text_of(equilibrium.band_moment_nmm), "0 or a moment");
    }
    answers("/equilibrium/energy", equilibrium.energy_nmm.data(), cells_);
    answers("/equilibrium/balance_residual", equilibrium.balance_residual_n.data(), cells_, 1, 0.0);
    answers("/equilibrium/complementarity", equilibrium.complementarity_mm.data(), cells_);
    answers("/equilibrium/worst_gap", equilibrium.worst_gap_mm.data(), cells_);
    answers("/equilibrium/flexion_moment", equilibrium.flexion_moment_nmm.data(), cells_);
    answers("/equilibrium/varus_moment", equilibrium.varus_moment_nmm.data(), cells_);
    if (model_.has_compartments) {
      answers("/equilibrium/force_medial", equilibrium.force_medial_n.data(), cells_, 3);
      answers("/equilibrium/force_lateral", equilibrium.force_lateral_n.data(), cells_, 3);
    }
    check_forces(equilibrium.forces);
    check_spine(equilibrium.spine);
  }

  void check_forces(const ForceRows& forces)
  {
    const std::string group = "/equilibrium/forces";
    const std::size_t n = forces.along_delta_n.size(), n_before = findings_.size();
    findings_.starts(group + "/row_start", forces.row_start, n, "forces");
    const bool are_rows_sound = findings_.size() == n_before;
    findings_.all_finite(group + "/point", forces.point_world_mm.data(), 3 * n);
    findings_.unit_rows(group + "/normal", forces.normal_world, false);
    positive(group + "/along_delta", forces.along_delta_n.data(), n);
    findings_.each_within(group + "/triangle_reference", forces.triangle_reference.data(), n, 0,
                          model_.reference.contact.mesh.triangles.rows() - 1);
    findings_.each_within(group + "/triangle_moving", forces.triangle_moving.data(), n, 0,
                          model_.moving.contact.mesh.triangles.rows() - 1);
    findings_.each_within(group + "/compartment", forces.compartment.data(), n, 0, 2);
    if (are_rows_sound) check_directions(forces);
  }

  /// The force is along_delta * normal / -(normal . Delta): it exists where the normal opposes Delta.
  void check_directions(const ForceRows& forces)
  {
    const std::size_t n_varus = model_.varus_deg.size();
    findings_.each(
        "/equilibrium/forces/normal", cells_.size, "normals that oppose Delta",
        [&](std::size_t cell) {
          const Eigen::RowVector3d delta = model_.push.delta.row(static_cast<Eigen::Index>(cell / n_varus));
          for (std::int64_t row = forces.row_start[cell]; row < forces.row_start[cell + 1]; ++row) {
            if (forces.normal_world.row(row).dot(delta) >= 0.0) return true;
          }
          return false;
        },
        [&](std::size_t) { return "a cell with one that does not"; });
  }

  void check_spine(const FreeSpine& spine)
  {
    const std::string group = "/equilibrium/spine";
    const Statuses rows{spine.status.data(), spine.status.size()};
    findings_.codes(group + "/status", rows.data, rows.size, flag_table(FlagSet::solver_status).values);
    answers(group + "/varus", spine.varus_deg.data(), rows);
    answers(group + "/tx", spine.tx_mm.data(), rows);
    answers(group + "/ty", spine.ty_mm.data(), rows);
    answers(group + "/tz", spine.tz_mm.data(), rows);
    answers(group + "/theta", spine.theta_deg.data(), rows);
    answers(group + "/energy", spine.energy_nmm.data(), rows);
    answers_or_nan(group + "/theta_low", spine.theta_low_deg, rows);
    answers_or_nan(group + "/theta_high", spine.theta_high_deg, rows);
    constexpr std::int64_t any = std::numeric_limits<std::int32_t>::max();
    findings_.each_within(group + "/n_optima", spine.n_optima.data(), rows.size, 0, any);
    answers(group + "/optima_theta_spread", spine.optima_theta_spread_deg.data(), rows, 1, 0.0);
    answers(group + "/optima_energy_spread", spine.optima_energy_spread_nmm.data(), rows, 1, 0.0);
  }

  void check_ligaments(const LigamentRows& ligaments)
  {
    const std::size_t n = ligaments.name.size();
    if (!(ligaments.transition_strain > 0.0) || !is_number(ligaments.transition_strain)) {
      findings_.find("/ligaments@transition_strain", text_of(ligaments.transition_strain),
                     "a strain above 0");
    }
    texts("/ligaments/name", ligaments.name);
    findings_.all_finite("/ligaments/reference", ligaments.reference_mm.data(), 3 * n);
    findings_.all_finite("/ligaments/moving", ligaments.moving_mm.data(), 3 * n);
    positive("/ligaments/stiffness", ligaments.stiffness_n.data(), n);
    positive("/ligaments/slack_length", ligaments.slack_length_mm.data(), n);
    const auto n_wraps = static_cast<std::int64_t>(ligaments.wrap_name.size());
    findings_.each_within("/ligaments/wrap", ligaments.wrap.data(), n, -1, n_wraps - 1);
    check_wraps(ligaments);
    answers("/ligaments/length", ligaments.length_mm.data(), cells_, n, 0.0);
    answers("/ligaments/strain", ligaments.strain.data(), cells_, n);
    answers("/ligaments/tension", ligaments.tension_n.data(), cells_, n, 0.0);
    answers("/ligaments/energy", ligaments.energy_nmm.data(), cells_, n, 0.0);
    findings_.each(
        "/ligaments/is_wrapped", cells_.size * n, "0 or 1 where status is stable, -1 elsewhere",
        [&](std::size_t i) {
          const std::int8_t answer = ligaments.is_wrapped[i];
          return cells_.is_stable(i / n) ? answer != 0 && answer != 1 : answer != -1;
        },
        [&](std::size_t i) { return std::to_string(ligaments.is_wrapped[i]); });
  }

  void check_wraps(const LigamentRows& ligaments)
  {
    const std::size_t n = ligaments.wrap_name.size();
    texts("/ligaments/wrap_name", ligaments.wrap_name);
    findings_.codes("/ligaments/wrap_shape", ligaments.wrap_shape.data(), n,
                    flag_table(FlagSet::wrap_shape).values);
    findings_.codes("/ligaments/wrap_body", ligaments.wrap_body.data(), n, flag_table(FlagSet::body).values);
    findings_.each(
        "/ligaments/X_body_wrap", n, "a rotation and a translation",
        [&](std::size_t i) { return !is_rigid_pose(&ligaments.X_body_wrap[16 * i]); },
        [](std::size_t) { return "no rigid pose"; });
    positive("/ligaments/wrap_radii", ligaments.wrap_radii_mm.data(), 3 * n);
  }

  const MotionModel& model_;
  ValueFindings& findings_;
  Statuses cells_;
};

}  // namespace

void check_mechanics(const MotionModel& model, ValueFindings& findings)
{
  MechanicsCheck(model, findings).run();
}

}  // namespace vrda
