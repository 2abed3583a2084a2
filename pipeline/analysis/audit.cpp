#include "analysis/audit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis/pose_meter.hpp"
#include "model/clinical.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda::analysis {
namespace {

/// A pose to measure, if the motion has one at the attitude.
struct AuditPose {
  Attitude attitude;
  Pose X_reference_moving = Pose::Identity();
  bool has_pose = false;
};

bool is_node(const store::AuditSet& out, Eigen::Index i, Eigen::Index j)
{
  return i % out.refine == 0 && j % out.refine == 0;
}

AuditPose pose_of(const store::JointPose& pose)
{
  return {pose.attitude, pose.X_reference_moving, pose.status == store::PoseStatus::solved};
}

AuditPose stored_pose(const store::MotionModel& model, Eigen::Index flexion, Eigen::Index varus)
{
  AuditPose pose;
  pose.has_pose = model.status(flexion, varus) == status_stable;
  if (!pose.has_pose) return pose;
  pose.attitude = {rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)]),
                   rad_from_deg(model.varus_solved_deg(flexion, varus))};
  const auto cell = static_cast<std::size_t>(flexion * model.status.cols() + varus);
  pose.X_reference_moving = store::pose_in(model.X_reference_moving, cell);
  return pose;
}

AuditPose pose_at(const store::MotionModel& model, const store::Motion& motion, const store::AuditSet& out,
                  Eigen::Index i, Eigen::Index j)
{
  if (out.name == "raw" && is_node(out, i, j)) return stored_pose(model, i / out.refine, j / out.refine);
  if (motion.is_sequence()) return pose_of(motion.at_frame(out.frame_key[static_cast<std::size_t>(i)]));
  return pose_of(motion.at({rad_from_deg(out.flexion_deg[static_cast<std::size_t>(i)]),
                            rad_from_deg(out.varus_deg[static_cast<std::size_t>(j)])}));
}

void set_state(store::AuditSet& out, Eigen::Index i, Eigen::Index j, const PoseAudit& found)
{
  out.penetration_mm(i, j) = found.penetration_mm;
  store::AuditState state = store::AuditState::free;
  if (found.is_overlapping) {
    state = store::AuditState::overlapping;
  } else if (std::isinf(found.gap_mm)) {
    state = store::AuditState::nothing_ahead;
  } else {
    out.gap_mm(i, j) = found.gap_mm;
  }
  out.state(i, j) = static_cast<std::int8_t>(state);
}

/// Flexion of each audited frame; between two frames without a pose there, the mean weighted by the key.
std::vector<double> flexion_of_frames(const store::MotionModel& model, const store::Motion& motion,
                                      const store::AuditSet& out)
{
  std::vector<double> flexion_deg;
  for (std::size_t i = 0; i < out.frame_key.size(); ++i) {
    const auto refine = static_cast<std::size_t>(out.refine);
    const std::size_t frame = i / refine;
    const double part = static_cast<double>(i % refine) / static_cast<double>(refine);
    const store::JointPose pose = motion.at_frame(out.frame_key[i]);
    if (part == 0.0) {
      flexion_deg.push_back(model.flexion_deg[frame]);
    } else if (pose.status == store::PoseStatus::solved) {
      flexion_deg.push_back(deg_from_rad(pose.attitude.flexion_rad));
    } else {
      flexion_deg.push_back((1.0 - part) * model.flexion_deg[frame] + part * model.flexion_deg[frame + 1]);
    }
  }
  return flexion_deg;
}

std::vector<Eigen::Vector3d> deltas_of(const store::Motion& motion, const store::AuditSet& out)
{
  std::vector<Eigen::Vector3d> deltas;
  for (const double key : out.frame_key) deltas.push_back(motion.delta_of(motion.at_frame(key)));
  if (motion.is_sequence()) return deltas;
  for (const double angle_deg : out.flexion_deg) deltas.push_back(motion.delta(rad_from_deg(angle_deg)));
  return deltas;
}

store::AuditSet unmeasured(const store::MotionModel& model, const store::Motion& motion,
                           const std::string& set, int refine)
{
  store::AuditSet out;
  out.name = set;
  out.refine = refine;
  const bool is_two_sided = set == "two_sided";
  if (motion.is_sequence()) {
    out.frame_key = refined(motion.keys(), refine);
    out.flexion_deg = flexion_of_frames(model, motion, out);
  } else {
    out.flexion_deg = refined(is_two_sided ? model.two_sided->flexion_deg : model.flexion_deg, refine);
  }
  out.varus_deg =
      is_two_sided || set == "zero_varus" ? std::vector<double>{0.0} : refined(model.varus_deg, refine);
  const auto rows = static_cast<Eigen::Index>(out.flexion_deg.size());
  const auto columns = static_cast<Eigen::Index>(out.varus_deg.size());
  out.state = store::GridB::Constant(rows, columns, static_cast<std::int8_t>(store::AuditState::no_pose));
  out.gap_mm = store::GridD::Constant(rows, columns, nan);
  out.penetration_mm = store::GridD::Constant(rows, columns, nan);
  if (model.has_compartments) out.gap_medial_mm = out.gap_lateral_mm = out.penetration_mm;
  return out;
}

void take_larger(AuditExtreme& extreme, const AuditExtreme& found)
{
  if (found.value_mm > extreme.value_mm) extreme = found;
}

}  // namespace

store::AuditSet audit(const store::MotionModel& model, const std::string& set, int refine, int n_threads)
{
  check(refine >= 1, "an audit divides a cell into at least one part");
  const store::Motion motion(model, set);
  store::AuditSet out = unmeasured(model, motion, set, refine);
  for_each_delta(model, deltas_of(motion, out), n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    for (Eigen::Index j = 0; j < out.state.cols(); ++j) {
      const AuditPose pose = pose_at(model, motion, out, i, j);
      const OverlapTest judge = is_node(out, i, j) ? OverlapTest::narrow_phase : OverlapTest::sweep;
      if (!pose.has_pose) continue;
      set_state(out, i, j, meter.measure(pose.attitude, pose.X_reference_moving, judge));
      if (!model.has_compartments) continue;
      const CompartmentGaps gaps = meter.compartment_gaps(pose.attitude, pose.X_reference_moving);
      out.gap_medial_mm(i, j) = gaps.medial_mm;
      out.gap_lateral_mm(i, j) = gaps.lateral_mm;
    }
  });
  return out;
}

AuditFigures figures_of(const store::AuditSet& audit)
{
  AuditFigures figures;
  figures.two_sided = store::two_sided_figures(audit);
  int n_free = 0;
  for (Eigen::Index i = 0; i < audit.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < audit.state.cols(); ++j) {
      const auto state = static_cast<store::AuditState>(audit.state(i, j));
      if (state == store::AuditState::no_pose) continue;
      ++figures.n_poses;
      const double flexion_deg = audit.flexion_deg[static_cast<std::size_t>(i)];
      const double varus_deg = audit.varus_deg[static_cast<std::size_t>(j)];
      const double key = audit.frame_key.empty() ? nan : audit.frame_key[static_cast<std::size_t>(i)];
      if (state == store::AuditState::overlapping) {
        ++figures.n_overlapping;
        figures.mean_penetration_mm += audit.penetration_mm(i, j);
        take_larger(figures.largest_penetration, {audit.penetration_mm(i, j), flexion_deg, varus_deg, key});
      } else if (state == store::AuditState::nothing_ahead) {
        ++figures.n_nothing_ahead;
      } else {
        ++n_free;
        figures.mean_gap_mm += audit.gap_mm(i, j);
        take_larger(figures.largest_gap, {audit.gap_mm(i, j), flexion_deg, varus_deg, key});
      }
    }
  }
  if (n_free > 0) figures.mean_gap_mm /= n_free;
  if (figures.n_overlapping > 0) figures.mean_penetration_mm /= figures.n_overlapping;
  return figures;
}

FrameTravel frame_travel(const store::MotionModel& model)
{
  check(model.frames.has_value(), "only a sequence of frames has steps");
  FrameTravel travel;
  std::optional<Pose> before;
  for (std::size_t i = 0; i < model.frames->key.size(); ++i) {
    if (model.status.data()[i] != status_stable) continue;
    const Pose X = store::pose_in(model.X_reference_moving, i);
    if (before) {
      const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
      const double way_mm = (X * centre_mm - *before * centre_mm).norm();
      const std::optional<HelicalAxis> axis = helical_axis(*before, X, centre_mm);
      const double angle_rad = axis ? axis->rotation_rad : 0.0;
      if (way_mm > travel.largest_mm) travel.key_of_mm = model.frames->key[i];
      if (angle_rad > travel.largest_rad) travel.key_of_rad = model.frames->key[i];
      travel.largest_mm = std::max(travel.largest_mm, way_mm);
      travel.largest_rad = std::max(travel.largest_rad, angle_rad);
      travel.mean_mm += way_mm;
      travel.mean_rad += angle_rad;
      ++travel.n_steps;
    }
    before = X;
  }
  if (travel.n_steps == 0) return travel;
  travel.mean_mm /= travel.n_steps;
  travel.mean_rad /= travel.n_steps;
  return travel;
}

store::GridD recontact(const store::MotionModel& model, const store::SmoothedSet& set, int n_threads)
{
  const store::Motion motion(model, set);
  store::GridD travel_mm(static_cast<Eigen::Index>(model.flexion_deg.size()),
                         static_cast<Eigen::Index>(model.varus_deg.size()));
  for_each_row(model, motion, model.flexion_deg, n_threads, [&](std::size_t row, PoseMeter& meter) {
    for (Eigen::Index j = 0; j < travel_mm.cols(); ++j) {
      const store::JointPose pose = motion.at(
          {rad_from_deg(model.flexion_deg[row]), rad_from_deg(model.varus_deg[static_cast<std::size_t>(j)])});
      travel_mm(static_cast<Eigen::Index>(row), j) =
          meter.travel_into_contact_mm(pose.attitude, pose.X_reference_moving);
    }
  });
  return travel_mm;
}

}  // namespace vrda::analysis
