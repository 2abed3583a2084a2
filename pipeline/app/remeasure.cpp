#include "app/remeasure.hpp"

#include <algorithm>
#include <atomic>
#include <memory>
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

// One scene for each run of flexions with the same Delta.
std::vector<std::shared_ptr<const AuditScene>> scenes_of(const MotionModel& model)
{
  std::vector<std::shared_ptr<const AuditScene>> scenes;
  for (Eigen::Index i = 0; i < model.push.delta.rows(); ++i) {
    const bool is_same = i > 0 && model.push.delta.row(i) == model.push.delta.row(i - 1);
    scenes.push_back(is_same
                         ? scenes.back()
                         : std::make_shared<const AuditScene>(make_audit_scene(
                               model.reference.contact.mesh, model.moving.contact.mesh, frame_of(model, i))));
  }
  return scenes;
}

}  // namespace

std::vector<PoseAudit> remeasured(const MotionModel& model, int n_threads)
{
  const std::vector<std::shared_ptr<const AuditScene>> scenes = scenes_of(model);
  std::vector<PoseAudit> cells(static_cast<std::size_t>(model.status.size()));
  std::atomic<Eigen::Index> next = 0;
  const auto work = [&] {
    NarrowPhase narrow_phase;
    for (Eigen::Index cell = next++; cell < model.status.size(); cell = next++) {
      if (!is_stable(model, cell)) continue;
      const auto i = static_cast<std::size_t>(cell / model.status.cols());
      cells[static_cast<std::size_t>(cell)] = audit_pose(
          *scenes[i], {rad_from_deg(model.flexion_deg[i]), rad_from_deg(model.varus_solved_deg.data()[cell])},
          stored_pose(model, cell), narrow_phase);
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
