#include "audit/audit.hpp"

#include <cmath>

#include "audit/attitude_rows.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

/// A pose to measure, if the motion has one there.
struct AuditPose {
  Attitude attitude;
  Pose X_reference_moving = Pose::Identity();
  bool has_pose = false;
};

bool is_node(const AuditSet& out, Eigen::Index i, Eigen::Index j)
{
  return i % out.refine == 0 && j % out.refine == 0;
}

AuditPose pose_of(const Motion& motion, const Attitude& attitude)
{
  const JointPose pose = motion.at(attitude);
  return {pose.attitude, pose.X_reference_moving, pose.status == PoseStatus::solved};
}

AuditPose stored_pose(const MotionModel& model, Eigen::Index flexion, Eigen::Index varus)
{
  AuditPose pose;
  pose.has_pose = model.status(flexion, varus) == status_stable;
  if (!pose.has_pose) return pose;
  pose.attitude = {rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)]),
                   rad_from_deg(model.varus_solved_deg(flexion, varus))};
  const auto cell = static_cast<std::size_t>(flexion * model.status.cols() + varus);
  pose.X_reference_moving = pose_in(model.X_reference_moving, cell);
  return pose;
}

AuditPose pose_at(const MotionModel& model, const Motion& motion, const AuditSet& out, Eigen::Index i,
                  Eigen::Index j)
{
  if (out.name == "raw" && is_node(out, i, j)) return stored_pose(model, i / out.refine, j / out.refine);
  return pose_of(motion, {rad_from_deg(out.flexion_deg[static_cast<std::size_t>(i)]),
                          rad_from_deg(out.varus_deg[static_cast<std::size_t>(j)])});
}

void set_state(AuditSet& out, Eigen::Index i, Eigen::Index j, const PoseAudit& found)
{
  out.penetration_mm(i, j) = found.penetration_mm;
  AuditState state = AuditState::free;
  if (found.is_overlapping) {
    state = AuditState::overlapping;
  } else if (std::isinf(found.gap_mm)) {
    state = AuditState::nothing_ahead;
  } else {
    out.gap_mm(i, j) = found.gap_mm;
  }
  out.state(i, j) = static_cast<std::int8_t>(state);
}

AuditSet unmeasured(const MotionModel& model, const std::string& set, int refine)
{
  AuditSet out;
  out.name = set;
  out.refine = refine;
  out.flexion_deg = refined(model.flexion_deg, refine);
  out.varus_deg = set == "zero_varus" ? std::vector<double>{0.0} : refined(model.varus_deg, refine);
  const auto rows = static_cast<Eigen::Index>(out.flexion_deg.size());
  const auto columns = static_cast<Eigen::Index>(out.varus_deg.size());
  out.state = GridB::Constant(rows, columns, static_cast<std::int8_t>(AuditState::no_pose));
  out.gap_mm = GridD::Constant(rows, columns, nan);
  out.penetration_mm = GridD::Constant(rows, columns, nan);
  return out;
}

void take_larger(AuditExtreme& extreme, const AuditExtreme& found)
{
  if (found.value_mm > extreme.value_mm) extreme = found;
}

}  // namespace

AuditSet audit(const MotionModel& model, const std::string& set, int refine, int n_threads)
{
  check(refine >= 1, "an audit cuts a cell into one part or more");
  const Motion motion(model, set);
  AuditSet out = unmeasured(model, set, refine);
  for_each_row(model, motion, out.flexion_deg, n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    for (Eigen::Index j = 0; j < out.state.cols(); ++j) {
      const AuditPose pose = pose_at(model, motion, out, i, j);
      const Judge judge = is_node(out, i, j) ? Judge::narrow_phase : Judge::sweep;
      if (pose.has_pose) set_state(out, i, j, meter.measure(pose.attitude, pose.X_reference_moving, judge));
    }
  });
  return out;
}

AuditFigures figures_of(const AuditSet& audit)
{
  AuditFigures figures;
  int n_free = 0;
  for (Eigen::Index i = 0; i < audit.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < audit.state.cols(); ++j) {
      const auto state = static_cast<AuditState>(audit.state(i, j));
      if (state == AuditState::no_pose) continue;
      ++figures.n_poses;
      const double flexion_deg = audit.flexion_deg[static_cast<std::size_t>(i)];
      const double varus_deg = audit.varus_deg[static_cast<std::size_t>(j)];
      if (state == AuditState::overlapping) {
        ++figures.n_overlapping;
        figures.mean_penetration_mm += audit.penetration_mm(i, j);
        take_larger(figures.largest_penetration, {audit.penetration_mm(i, j), flexion_deg, varus_deg});
      } else if (state == AuditState::nothing_ahead) {
        ++figures.n_nothing_ahead;
      } else {
        ++n_free;
        figures.mean_gap_mm += audit.gap_mm(i, j);
        take_larger(figures.largest_gap, {audit.gap_mm(i, j), flexion_deg, varus_deg});
      }
    }
  }
  if (n_free > 0) figures.mean_gap_mm /= n_free;
  if (figures.n_overlapping > 0) figures.mean_penetration_mm /= figures.n_overlapping;
  return figures;
}

}  // namespace vrda
