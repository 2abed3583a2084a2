#include "tables/imported_model.hpp"

#include <utility>

#include "analysis/audit.hpp"
#include "core/units.hpp"
#include "job/component_loader.hpp"
#include "model/coordinates.hpp"
#include "solve/case_solver.hpp"
#include "solve/followers.hpp"
#include "store/solved_cells.hpp"
#include "tables/convention_search.hpp"

namespace vrda::tables {

MotionSequence read_motion(const std::string& file, const MotionConvention& convention)
{
  const MotionTable table = read_motion_table(file, convention.columns);
  const Convention complete = completed(convention.stated, table.stated, convention.joint.side);
  const UnitSource source = convention.stated.angles ? UnitSource::option
                            : table.stated.angles    ? UnitSource::file
                                                     : UnitSource::assumed;
  std::vector<std::string> warnings = table.warnings;
  for (std::string& line : unit_warnings(table, complete.angles, source, convention.joint))
    warnings.push_back(std::move(line));
  return {table.key_name, table.key, poses_of(table, complete, convention.joint), table.absent_columns,
          std::move(warnings)};
}

ImportFrame import_frame(const job::Job& job, const job::Case& job_case)
{
  const job::Job found = job_case.found_frames ? job::with_found_frames(job, *job_case.found_frames) : job;
  const job::BodyMaps maps = job::body_maps(found);
  const job::Case subject = job::scaled_to_subject(job_case);
  ImportFrame frame;
  frame.joint = {subject.frame.side, subject.frame.rotation_centre_mm, maps.reference.X_canonical_native,
                 maps.moving.X_canonical_native, joint_kind(job.joint).has_large_flexion};
  frame.has_file_axes = !job_case.scaling;
  return frame;
}

job::Case import_case(const job::Case& job_case, const MotionSequence& motion, const std::string& record)
{
  job::Case result = job::scaled_to_subject(job_case);
  const job::Push push = result.push.front();
  if (result.method == "equilibrium")
    result.search.translation_resolution_mm = result.equilibrium.contact_resolution_mm;
  result.method = "import";
  result.is_varus_free = true;
  result.coordinates.reset();  // roles of a solver
  result.grid = {{}, {0.0}};
  for (const Pose& X : motion.X_reference_moving)
    result.grid.flexion_deg.push_back(
        deg_from_rad(solve::solver_position(result.frame, X).attitude.flexion_rad));
  result.push.assign(motion.key.size(), push);
  result.path_flexion_deg.clear();
  result.path_push.clear();
  result.smooth_degrees.clear();
  result.resolved_job += record;
  return result;
}

namespace {

// Pending if it was not measured. A measured pose is no equilibrium: it has no balance.
StepRecord follower_record(const job::Case& job_case, std::size_t follower, std::size_t frame,
                           const MotionSequence& motion)
{
  StepRecord r;
  r.balance.energy_nmm = r.balance.residual_n = r.balance.complementarity_mm = r.balance.worst_gap_mm = nan;
  if (follower >= motion.followers.size() || motion.followers[follower].empty()) return r;
  const job::Follower& of = job_case.followers[follower];
  const Pose X_of = follower_pose(motion.followers[follower][frame], job_case.frame.side, of.centre_mm);
  const solve::SolverPosition at = solve::solver_position(solve::follower_frame(job_case, of), X_of);
  r.status = StepStatus::stable;
  r.pose = at.pose;
  r.varus_rad = at.attitude.varus_rad;
  r.coordinates.emplace();
  r.coordinates->flexion_rad = at.attitude.flexion_rad;
  return r;
}

}  // namespace

store::MotionModel imported_model(const job::Case& job_case, const MotionSequence& motion, int n_threads)
{
  store::MotionModel model = solve::pending_model_of(job_case);
  model.frames = store::FrameSequence{motion.key_name, motion.key};
  const solve::Joint joint = solve::joint_of(job_case, job_case.frame);
  analysis::FrameMeter meter(joint, model.contact_resolution_mm);
  solve::SweepResult result;
  std::vector<StepRecord>& records = result.cells;
  for (std::size_t i = 0; i < motion.key.size(); ++i) {
    const solve::SolverPosition at = solve::solver_position(job_case.frame, motion.X_reference_moving[i]);
    records.push_back(meter.record(static_cast<std::int32_t>(i), at, meter.gaps(at)));
    store::set_cell(model, records.back());
    model.is_spine(static_cast<Eigen::Index>(i), 0) = 1;
  }
  model.contacts = store::contact_rows(model, records);
  solve::add_balance(model, job_case, result);  // contact paths and fibres
  result.followers.assign(records.size(), {});
  for (std::size_t i = 0; i < records.size(); ++i) {
    for (std::size_t k = 0; k < job_case.followers.size(); ++k)
      result.followers[i].push_back(follower_record(job_case, k, i, motion));
  }
  solve::add_followers(model, job_case, result);
  model.audits = {analysis::audit(model, "raw", 1, n_threads)};
  return model;
}

}  // namespace vrda::tables
