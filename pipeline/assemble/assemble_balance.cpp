#include "assemble/assemble_balance.hpp"

#include "assemble/case_solver.hpp"
#include "core/units.hpp"
#include "store/contact_paths.hpp"
#include "store/touch_rows.hpp"

namespace vrda {
namespace {

bool is_stable(const StepRecord& r)
{
  return r.status == StepStatus::stable;
}

void put(std::vector<double>& rows, std::size_t row, const Eigen::Vector3d& v)
{
  for (std::size_t k = 0; k < 3; ++k) rows[3 * row + k] = v[static_cast<Eigen::Index>(k)];
}

Eigen::Vector3d force_n(const ContactForce& f)
{
  return f.along_delta_n * f.normal_solver / -f.normal_solver.y();
}

class BalanceAssembly {
 public:
  BalanceAssembly(MotionModel& model, const Case& job_case) : model_(model), case_(job_case) {}

  void add(const StepRecord& r)
  {
    if (!is_stable(r)) return;
    stand_at(r.key.flexion);
    const auto cell = static_cast<std::size_t>(r.key.flexion) * model_.varus_deg.size() +
                      static_cast<std::size_t>(r.key.varus);
    if (model_.equilibrium) add_certificate(r, cell);
    if (model_.ligaments) add_fibres(r, cell);
  }

 private:
  Attitude attitude_of(const StepRecord& r) const
  {
    return {rad_from_deg(model_.flexion_deg[static_cast<std::size_t>(r.key.flexion)]), r.varus_rad};
  }

  // Cells come flexion by flexion: frame and fibres change with the flexion only.
  void stand_at(std::int32_t flexion)
  {
    if (flexion == flexion_) return;
    flexion_ = flexion;
    frame_ = frame_at(case_, flexion);
    ligaments_ = solver_ligaments(case_.ligaments, frame_);
  }

  void add_certificate(const StepRecord& r, std::size_t cell)
  {
    EquilibriumSurfaces& surfaces = *model_.equilibrium;
    const auto at = static_cast<Eigen::Index>(cell);
    surfaces.energy_nmm.data()[at] = r.balance.energy_nmm;
    surfaces.balance_residual_n.data()[at] = r.balance.residual_n;
    surfaces.complementarity_mm.data()[at] = r.balance.complementarity_mm;
    surfaces.worst_gap_mm.data()[at] = r.balance.worst_gap_mm;
    surfaces.flexion_moment_nmm.data()[at] = r.balance.flexion_moment_nmm;
    surfaces.varus_moment_nmm.data()[at] = r.balance.varus_moment_nmm;
    if (!model_.has_compartments) return;
    Eigen::Vector3d medial_n = Eigen::Vector3d::Zero(), lateral_n = Eigen::Vector3d::Zero();
    for (const ContactForce& f : r.balance.forces) {
      if (f.compartment == static_cast<std::int8_t>(Compartment::medial)) medial_n += force_n(f);
      if (f.compartment == static_cast<std::int8_t>(Compartment::lateral)) lateral_n += force_n(f);
    }
    put(surfaces.force_medial_n, cell, world_from_solver(frame_, medial_n));
    put(surfaces.force_lateral_n, cell, world_from_solver(frame_, lateral_n));
  }

  void add_fibres(const StepRecord& r, std::size_t cell)
  {
    LigamentRows& rows = *model_.ligaments;
    const std::vector<FibreState> states = fibre_states(ligaments_, attitude_of(r), r.pose);
    for (std::size_t k = 0; k < states.size(); ++k) {
      const std::size_t at = cell * states.size() + k;
      rows.length_mm[at] = states[k].length_mm;
      rows.strain[at] = states[k].strain;
      rows.tension_n[at] = states[k].force_n;
      rows.energy_nmm[at] = states[k].energy_nmm;
      rows.is_wrapped[at] = states[k].is_wrapped ? 1 : 0;
    }
  }

  MotionModel& model_;
  const Case& case_;
  std::int32_t flexion_ = -1;  // the one in hand
  SolverFrame frame_;          // at it
  Ligaments ligaments_;        // in that frame
};

ForceRows force_rows(const MotionModel& model, const std::vector<StepRecord>& cells)
{
  const auto forces_of = [](const StepRecord& r) {
    return is_stable(r) ? std::span<const ContactForce>(r.balance.forces) : std::span<const ContactForce>();
  };
  return touch_rows(model, cells, forces_of, &ContactForce::along_delta_n, &ForceRows::along_delta_n);
}

void set_spine(FreeSpine& spine, const Case& job_case, const SweepResult& result)
{
  for (std::size_t i = 0; i < result.free_spine.size(); ++i) {
    const FreeSpineStep& step = result.free_spine[i];
    spine.status[i] = static_cast<std::int8_t>(step.chosen.status);
    spine.n_optima[i] = step.n_optima;
    if (!is_stable(step.chosen)) continue;
    const Eigen::Vector3d t =
        world_translation_mm(frame_at(job_case, static_cast<std::int32_t>(i)), step.chosen.pose);
    spine.varus_deg[i] = deg_from_rad(step.chosen.varus_rad);
    spine.tx_mm[i] = t.x();
    spine.ty_mm[i] = t.y();
    spine.tz_mm[i] = t.z();
    spine.theta_deg[i] = deg_from_rad(step.chosen.pose.theta_rad);
    spine.energy_nmm[i] = step.chosen.balance.energy_nmm;
    spine.optima_theta_spread_deg[i] = deg_from_rad(step.theta_spread_rad);
    spine.optima_energy_spread_nmm[i] = step.energy_spread_nmm;
    if (is_stable(step.band_low)) spine.theta_low_deg[i] = deg_from_rad(step.band_low.pose.theta_rad);
    if (is_stable(step.band_high)) spine.theta_high_deg[i] = deg_from_rad(step.band_high.pose.theta_rad);
  }
}

}  // namespace

LigamentRows ligament_rows(const Ligaments& canonical)
{
  LigamentRows rows;
  const auto n_fibres = static_cast<Eigen::Index>(canonical.fibres.size());
  rows.reference_mm.resize(n_fibres, 3);
  rows.moving_mm.resize(n_fibres, 3);
  rows.transition_strain = canonical.transition_strain;
  for (Eigen::Index k = 0; k < n_fibres; ++k) {
    const Fibre& fibre = canonical.fibres[static_cast<std::size_t>(k)];
    rows.name.push_back(fibre.name);
    rows.bundle.push_back(fibre.bundle);
    rows.reference_mm.row(k) = fibre.reference_mm.transpose();
    rows.moving_mm.row(k) = fibre.moving_mm.transpose();
    rows.stiffness_n.push_back(fibre.stiffness_n);
    rows.slack_length_mm.push_back(fibre.slack_length_mm);
    rows.wrap.push_back(fibre.wrap);
  }
  const auto n_wraps = static_cast<Eigen::Index>(canonical.wraps.size());
  rows.wrap_radii_mm.resize(n_wraps, 3);
  for (Eigen::Index k = 0; k < n_wraps; ++k) {
    const Wrap& wrap = canonical.wraps[static_cast<std::size_t>(k)];
    rows.wrap_name.push_back(wrap.name);
    rows.wrap_shape.push_back(wrap.shape == WrapShape::cylinder ? 0 : 1);
    rows.wrap_body.push_back(wrap.body == WrapBody::reference ? 0 : 1);
    rows.wrap_radii_mm.row(k) = wrap.radii_mm.transpose();
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) rows.X_body_wrap.push_back(wrap.X_body_wrap.matrix()(i, j));
    }
  }
  return rows;
}

void add_balance(MotionModel& model, const Case& job_case, const SweepResult& result)
{
  BalanceAssembly assembly(model, job_case);
  for (const StepRecord& r : result.cells) assembly.add(r);
  if (model.equilibrium) {
    model.equilibrium->forces = force_rows(model, result.cells);
    set_spine(model.equilibrium->spine, job_case, result);
  }
  if (model.contact_paths) model.contact_paths = contact_paths_of(model);
}

}  // namespace vrda
