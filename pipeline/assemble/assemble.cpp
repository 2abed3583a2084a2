#include "assemble/assemble.hpp"

#include <utility>

#include "assemble/assemble_balance.hpp"
#include "assemble/prepare.hpp"
#include "assemble/scaled_result.hpp"
#include "store/solved_cells.hpp"

namespace vrda {
namespace {

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
  for (const Compartment compartment : job_case.compartment_of_triangle)
    model.compartment_of_triangle.push_back(static_cast<std::int8_t>(compartment));
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
  for (const StepRecord& r : result.cells) set_cell(model, r);
  for (std::size_t i = 0; i < result.spine_column.size(); ++i) {
    if (result.spine_column[i] >= 0) model.is_spine(static_cast<Eigen::Index>(i), result.spine_column[i]) = 1;
  }
  model.contacts = contact_rows(model, result.cells);
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
