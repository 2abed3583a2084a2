#include "app/assemble.hpp"

#include <utility>

#include "app/assemble_balance.hpp"
#include "app/case_solver.hpp"
#include "app/prepare.hpp"
#include "app/scaled_result.hpp"
#include "app/touch_rows.hpp"
#include "core/clinical.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

// The axis's own number where varus was given: degrees that went through radians may differ in the last bit.
double solved_varus_deg(const MotionModel& model, const StepRecord& r)
{
  const double given_deg = model.varus_deg[static_cast<std::size_t>(r.key.varus)];
  return r.varus_rad == rad_from_deg(given_deg) ? given_deg : deg_from_rad(r.varus_rad);
}

Attitude attitude_of(const MotionModel& model, const StepRecord& r)
{
  return {rad_from_deg(model.flexion_deg[static_cast<std::size_t>(r.key.flexion)]), r.varus_rad};
}

void set_pose(MotionModel& model, const SolverFrame& frame, const StepRecord& r)
{
  const Eigen::Index i = r.key.flexion, j = r.key.varus;
  const Attitude attitude = attitude_of(model, r);
  const Eigen::Vector3d t = world_translation_mm(frame, r.pose);
  model.tx_mm(i, j) = t.x();
  model.ty_mm(i, j) = t.y();
  model.tz_mm(i, j) = t.z();
  model.theta_deg(i, j) = deg_from_rad(r.pose.theta_rad);
  model.varus_solved_deg(i, j) = solved_varus_deg(model, r);

  const Pose X = X_reference_moving(frame, attitude, r.pose);
  const std::size_t first = 16 * static_cast<std::size_t>(i * model.status.cols() + j);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      model.X_reference_moving[first + static_cast<std::size_t>(4 * row + column)] = X.matrix()(row, column);
    }
  }
  const Clinical clinical = clinical_of(X, frame.side, frame.rotation_centre_mm);
  model.clinical.flexion_deg(i, j) = deg_from_rad(clinical.flexion_rad);
  model.clinical.varus_deg(i, j) = deg_from_rad(clinical.varus_rad);
  model.clinical.internal_rotation_deg(i, j) = deg_from_rad(clinical.internal_rotation_rad);
  model.clinical.anterior_mm(i, j) = clinical.anterior_mm;
  model.clinical.proximal_mm(i, j) = clinical.proximal_mm;
  model.clinical.lateral_mm(i, j) = clinical.lateral_mm;
}

void set_cell(MotionModel& model, const SolverFrame& frame, const StepRecord& r)
{
  const Eigen::Index i = r.key.flexion, j = r.key.varus;
  model.status(i, j) = static_cast<std::int8_t>(r.status);
  model.iterations(i, j) = r.iterations;
  model.queries(i, j) = r.queries;
  if (r.status != StepStatus::stable) return;
  set_pose(model, frame, r);
  model.residual_mm(i, j) = r.residual_mm;
  model.gap_medial_mm(i, j) = r.gap_medial_mm;
  model.gap_lateral_mm(i, j) = r.gap_lateral_mm;
  model.contact_medial(i, j) = r.contact_medial ? 1 : 0;
  model.contact_lateral(i, j) = r.contact_lateral ? 1 : 0;
  model.theta_determined(i, j) = r.theta_determined ? 1 : 0;
}

ContactRows contact_rows(const Case& job_case, const std::vector<StepRecord>& cells)
{
  const auto contacts_of = [](const StepRecord& r) { return std::span<const ContactRecord>(r.contacts); };
  return touch_rows(job_case, cells, contacts_of, &ContactRecord::distance_mm, &ContactRows::distance_mm);
}

PushRows push_rows(const Case& job_case)
{
  PushRows rows;
  const auto n = static_cast<Eigen::Index>(job_case.push.size());
  rows.delta.resize(n, 3);
  rows.force_n.resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Push& push = job_case.push[static_cast<std::size_t>(i)];
    rows.delta.row(i) = push.delta.transpose();
    rows.force_n.row(i) = push.force_n.transpose();
    rows.moment_nmm.push_back(push.moment_nmm);
    rows.varus_moment_nmm.push_back(push.varus_moment_nmm);
  }
  rows.point_mm = job_case.push_point_mm;
  return rows;
}

MotionModel pending_model_at_size(const Case& job_case)
{
  MotionModel model;
  model.title = job_case.title;
  model.joint = job_case.joint;
  model.side = job_case.frame.side == Side::left ? "left" : "right";
  model.method = job_case.method;
  model.rotation_centre_mm = job_case.frame.rotation_centre_mm;
  model.delta = job_case.frame.delta;
  model.push = push_rows(job_case);
  model.contact_resolution_mm = job_case.method == "equilibrium" ? job_case.equilibrium.contact_resolution_mm
                                                                 : job_case.search.translation_resolution_mm;
  model.has_compartments = !job_case.compartment_of_triangle.empty();
  model.flexion_deg = job_case.grid.flexion_deg;
  model.varus_deg = job_case.grid.varus_deg;
  model.reference = job_case.reference;
  model.moving = job_case.moving;
  model.job = {job_case.job_text, job_case.resolved_job, {}, job_case.scaling};
  for (const LoadedInput& input : job_case.inputs) model.job.inputs.push_back({input.name, input.sha256});
  if (job_case.method == "equilibrium") {
    model.equilibrium.emplace();
    model.equilibrium->band_moment_nmm = plan_of(job_case).has_band ? job_case.spine.band_moment_nmm : 0.0;
  }
  if (!job_case.ligaments.fibres.empty()) model.ligaments = ligament_rows(job_case.ligaments);
  if (model.has_compartments) model.contact_paths.emplace();
  return with_pending_cells(std::move(model));
}

MotionModel motion_model_at_size(const Case& job_case, const SweepResult& result)
{
  MotionModel model = pending_model_at_size(job_case);
  for (const StepRecord& r : result.cells) set_cell(model, frame_at(job_case, r.key.flexion), r);
  for (std::size_t i = 0; i < result.spine_column.size(); ++i) {
    if (result.spine_column[i] >= 0) model.is_spine(static_cast<Eigen::Index>(i), result.spine_column[i]) = 1;
  }
  model.contacts = contact_rows(job_case, result.cells);
  add_balance(model, job_case, result);
  return model;
}

}  // namespace

MotionModel pending_model_of(const Case& job_case)
{
  return pending_model_at_size(of_subject(job_case));
}

MotionModel motion_model_of(const Case& job_case, const SweepResult& result)
{
  if (job_case.steps_scale == 1.0) return motion_model_at_size(job_case, result);
  return motion_model_at_size(of_subject(job_case), scaled(result, job_case.steps_scale));
}

}  // namespace vrda
