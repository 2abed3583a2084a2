#include "tables/imported_model.hpp"

#include <cmath>
#include <utility>

#include "analysis/audit.hpp"
#include "contact/contacts.hpp"
#include "core/error.hpp"
#include "model/frames.hpp"
#include "model/joint_kind.hpp"
#include "core/units.hpp"
#include "job/axis_map.hpp"
#include "solve/case_solver.hpp"
#include "solve/model_build.hpp"
#include "geometry/gap_query.hpp"
#include "solve/joint.hpp"
#include "store/solved_cells.hpp"
#include "solve/sweep.hpp"

namespace vrda::tables {
namespace {

/// Measures the frames of a model with one Delta.
class FrameMeter {
 public:
  FrameMeter(const solve::Joint& joint, double contact_resolution_mm)
      : joint_(joint),
        resolution_mm_(contact_resolution_mm),
        whole_(joint.reference_gap, joint.moving_gap),
        medial_(joint.reference_gap, joint.medial_gap),
        lateral_(joint.reference_gap, joint.lateral_gap)
  {
  }

  StepRecord record(std::int32_t frame, const SolverPosition& found)
  {
    StepRecord r;
    r.key = {StepKind::row, frame, 0};
    r.pose = found.pose;
    r.varus_rad = found.attitude.varus_rad;
    r.status = StepStatus::stable;
    whole_.set_attitude(found.attitude);
    contact::ContactOptions options;
    options.band_mm = resolution_mm_;
    const std::vector<contact::Contact> contacts =
        contact::find_contacts(joint_.reference, joint_.moving, {found.attitude, found.pose},
                               whole_.close_pairs(found.pose, resolution_mm_), narrow_phase_, options);
    for (const contact::Contact& contact : contacts)
      r.contacts.push_back(solve::contact_record(joint_, contact));
    r.theta_determined = true;  // measured
    if (joint_.compartment_of_triangle.empty()) return r;
    r.gap_medial_mm = gap_mm(medial_, found);
    r.gap_lateral_mm = gap_mm(lateral_, found);
    r.contact_medial = r.gap_medial_mm <= resolution_mm_;
    r.contact_lateral = r.gap_lateral_mm <= resolution_mm_;
    return r;
  }

 private:
  static double gap_mm(geometry::GapQuery& query, const SolverPosition& found)
  {
    query.set_attitude(found.attitude);
    const double travel_mm = query.travel_mm(found.pose);
    return std::isfinite(travel_mm) ? travel_mm : nan;
  }

  const solve::Joint& joint_;
  double resolution_mm_;
  geometry::GapQuery whole_, medial_, lateral_;
  contact::NarrowPhase narrow_phase_;
};

}  // namespace

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

job::Case import_case(const job::Case& job_case, const tables::MotionSequence& motion,
                       const std::string& record)
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
    result.grid.flexion_deg.push_back(deg_from_rad(solver_position(result.frame, X).attitude.flexion_rad));
  result.push.assign(motion.key.size(), push);
  result.path_flexion_deg.clear();
  result.path_push.clear();
  result.smooth_degrees.clear();
  result.resolved_job += record;
  return result;
}

store::MotionModel imported_model(const job::Case& job_case, const tables::MotionSequence& motion,
                                  int n_threads)
{
  store::MotionModel model = solve::pending_model_of(job_case);
  model.frames = store::FrameSequence{motion.key_name, motion.key};
  const solve::Joint joint = solve::joint_of(job_case, job_case.frame);
  FrameMeter meter(joint, model.contact_resolution_mm);
  solve::SweepResult result;
  std::vector<StepRecord>& records = result.cells;
  for (std::size_t i = 0; i < motion.key.size(); ++i) {
    records.push_back(meter.record(static_cast<std::int32_t>(i),
                                   solver_position(job_case.frame, motion.X_reference_moving[i])));
    store::set_cell(model, records.back());
    model.is_spine(static_cast<Eigen::Index>(i), 0) = 1;
  }
  model.contacts = store::contact_rows(model, records);
  solve::add_balance(model, job_case, result);  // contact paths and fibres
  model.audits = {analysis::audit(model, "raw", 1, n_threads)};
  return model;
}

}  // namespace vrda::tables
