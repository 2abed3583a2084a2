#include "app/remeasure.hpp"

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>

namespace vrda {
namespace {

bool is_stable(const MotionModel& model, Eigen::Index cell)
{
  return model.status.data()[cell] == static_cast<std::int8_t>(StepStatus::stable);
}

Pose stored_pose(const MotionModel& model, Eigen::Index cell)
{
  Pose X = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      X.matrix()(row, column) =
          model.X_reference_moving[static_cast<std::size_t>(16 * cell + 4 * row + column)];
    }
  }
  return X;
}

SolverFrame frame_of(const MotionModel& model, Eigen::Index flexion)
{
  return {model.side == "left" ? Side::left : Side::right, model.rotation_centre_mm,
          model.push.delta.row(flexion).transpose()};
}

/// The scene of one flexion, kept until another Delta is asked for.
class SceneOfFlexion {
 public:
  explicit SceneOfFlexion(const MotionModel& model) : model_(model) {}

  const AuditScene& at(Eigen::Index flexion)
  {
    const SolverFrame frame = frame_of(model_, flexion);
    if (!scene_ || scene_->frame.delta != frame.delta)
      scene_ = make_audit_scene(model_.reference.contact.mesh, model_.moving.contact.mesh, frame);
    return *scene_;
  }

 private:
  const MotionModel& model_;
  std::optional<AuditScene> scene_;
};

}  // namespace

std::vector<PoseAudit> remeasured(const MotionModel& model, int n_threads)
{
  std::vector<PoseAudit> cells(static_cast<std::size_t>(model.status.size()));
  std::atomic<Eigen::Index> next = 0;
  const auto work = [&] {
    NarrowPhase narrow_phase;
    SceneOfFlexion scenes(model);
    for (Eigen::Index cell = next++; cell < model.status.size(); cell = next++) {
      if (!is_stable(model, cell)) continue;
      const Eigen::Index flexion = cell / model.status.cols();
      const Attitude attitude{rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)]),
                              rad_from_deg(model.varus_solved_deg.data()[cell])};
      cells[static_cast<std::size_t>(cell)] =
          audit_pose(scenes.at(flexion), attitude, stored_pose(model, cell), narrow_phase);
    }
  };
  std::vector<std::jthread> workers;
  for (int k = 0; k < std::max(1, n_threads); ++k) workers.emplace_back(work);
  workers.clear();
  return cells;
}

AuditExtremes extremes(const MotionModel& model, const std::vector<PoseAudit>& cells)
{
  AuditExtremes result;
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    if (!is_stable(model, cell)) continue;
    const PoseAudit& audit = cells[static_cast<std::size_t>(cell)];
    result.n_overlapping += audit.is_overlapping ? 1 : 0;
    result.largest_penetration_mm = std::max(result.largest_penetration_mm, audit.penetration_mm);
    result.largest_gap_mm = std::max(result.largest_gap_mm, audit.gap_mm);
  }
  return result;
}

}  // namespace vrda
