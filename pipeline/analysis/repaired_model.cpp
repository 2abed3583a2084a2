#include "analysis/repaired_model.hpp"

#include <cmath>
#include <utility>

#include "contact/contacts.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "solve/joint.hpp"
#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"

namespace vrda::analysis {
namespace {

solve::Joint joint_of(const store::MotionModel& model, const SolverFrame& frame)
{
  std::vector<Compartment> compartments;
  for (const std::int8_t code : model.compartment_of_triangle)
    compartments.push_back(static_cast<Compartment>(code));
  return solve::make_joint(
      {solver_mesh(model.reference.contact.mesh, frame), model.reference.contact.component},
      {solver_mesh(model.moving.contact.mesh, frame), model.moving.contact.component}, compartments);
}

/// Contacts, gaps and flags of repaired frames, as after an import.
class FrameRecords {
 public:
  FrameRecords(const store::MotionModel& model, const SolverFrame& frame)
      : joint_(joint_of(model, frame)),
        resolution_mm_(model.contact_resolution_mm),
        has_compartments_(model.has_compartments),
        query_(joint_.reference_gap, joint_.moving_gap)
  {
  }

  StepRecord record(std::int32_t row, const RepairedFrame& frame)
  {
    StepRecord r;
    r.key = {StepKind::row, row, 0};
    r.status = StepStatus::stable;
    r.pose = frame.pose;
    r.varus_rad = frame.attitude.varus_rad;
    r.theta_determined = true;  // measured
    query_.set_attitude(frame.attitude);
    contact::ContactOptions options;
    options.band_mm = resolution_mm_;
    for (const contact::Contact& contact :
         contact::find_contacts(joint_.reference, joint_.moving, {frame.attitude, frame.pose},
                                query_.close_pairs(frame.pose, resolution_mm_), narrow_phase_, options))
      r.contacts.push_back(solve::contact_record(joint_, contact));
    if (!has_compartments_) return r;
    r.gap_medial_mm = frame.after.compartments.medial_mm;
    r.gap_lateral_mm = frame.after.compartments.lateral_mm;
    r.contact_medial = r.gap_medial_mm <= resolution_mm_;
    r.contact_lateral = r.gap_lateral_mm <= resolution_mm_;
    return r;
  }

 private:
  solve::Joint joint_;
  double resolution_mm_ = 0.0;
  bool has_compartments_ = false;
  geometry::GapQuery query_;
  contact::NarrowPhase narrow_phase_;
};

void append(std::vector<double>& rows, const Eigen::Vector3d& v)
{
  rows.insert(rows.end(), {v.x(), v.y(), v.z()});
}

std::vector<double> values_of(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}

double free_gap_mm(const analysis::PoseAudit& audit)
{
  return audit.is_overlapping || std::isinf(audit.gap_mm) ? nan : audit.gap_mm;
}

store::RepairedFrames rows_of(const MeasuredMotion& measured, const RepairedMotion& motion,
                              const MeasurementNoise& noise)
{
  store::RepairedFrames out;
  out.is_converged = motion.is_converged;
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    const RepairedFrame& frame = motion.frames[k];
    for (Eigen::Index i = 0; i < 16; ++i)
      out.X_measured.push_back(measured.X_reference_moving[k].matrix()(i / 4, i % 4));
    out.status.push_back(static_cast<std::int8_t>(frame.status));
    out.distance.push_back(frame.displacement.norm());
    append(out.rotation_shift, frame.displacement.head<3>());
    append(out.translation_shift, frame.displacement.tail<3>());
    out.gap_before_mm.push_back(free_gap_mm(frame.before.audit));
    out.gap_after_mm.push_back(free_gap_mm(frame.after.audit));
    out.penetration_before_mm.push_back(frame.before.audit.penetration_mm);
    out.penetration_after_mm.push_back(frame.after.audit.penetration_mm);
  }
  for (Eigen::Index k = 0; k < 3; ++k) out.noise_deg.push_back(deg_from_rad(noise.rotation_rad(k)));
  out.noise_mm = values_of(noise.translation_mm);
  out.rotation_period = values_of(motion.period_frames.head<3>());
  out.translation_period = values_of(motion.period_frames.tail<3>());
  for (const double limit_mm : motion.gap_limit_mm)
    out.gap_limit_mm.push_back(std::isinf(limit_mm) ? nan : limit_mm);
  return out;
}

}  // namespace

MeasuredMotion measured_motion(const store::MotionModel& model, const std::string& file)
{
  if (!model.frames)
    throw InputError({file, "/frame", "a grid of attitudes", "a sequence of frames, e.g. of vrda import"});
  MeasuredMotion out;
  out.name = file;
  out.key = model.frames->key;
  for (std::size_t k = 0; k < out.key.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const std::string frame = "frame " + std::to_string(k + 1);
    if (model.status(row, 0) != store::code_of(StepStatus::stable))
      throw InputError({file, frame, "no pose", "a pose in every frame"});
    if (model.push.delta.row(row) != model.push.delta.row(0))
      throw InputError({file, "/push/delta of " + frame, "another direction", "one Delta for all frames"});
    out.X_reference_moving.push_back(model.repair ? store::pose_in(model.repair->X_measured, k)
                                                  : store::pose_in(model.X_reference_moving, k));
  }
  return out;
}

analysis::AuditScene scene_of(const store::MotionModel& model)
{
  return analysis::make_audit_scene(model.reference.contact.mesh, model.moving.contact.mesh,
                                 store::solver_frame(model, 0), model.compartment_of_triangle);
}

store::MotionModel repaired_model(const store::MotionModel& model, const MeasuredMotion& measured,
                                  const RepairedMotion& motion, const MeasurementNoise& noise)
{
  store::MotionModel out = model;
  for (std::size_t k = 0; k < motion.frames.size(); ++k)
    out.flexion_deg[k] = deg_from_rad(motion.frames[k].attitude.flexion_rad);
  out.ligaments.reset();
  const store::PushRows push = out.push;
  out = store::with_pending_cells(std::move(out));
  out.push = push;
  FrameRecords records(out, store::solver_frame(out, 0));
  std::vector<StepRecord> cells;
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    cells.push_back(records.record(static_cast<std::int32_t>(k), motion.frames[k]));
    store::set_cell(out, cells.back());
    out.is_spine(static_cast<Eigen::Index>(k), 0) = 1;
  }
  out.contacts = store::contact_rows(out, cells);
  if (out.has_compartments) out.contact_paths = store::contact_paths_of(out);
  out.repair = rows_of(measured, motion, noise);
  return out;
}

}  // namespace vrda::analysis
