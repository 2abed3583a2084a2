#include "audit/audit.hpp"

#include <algorithm>
#include <utility>

#include "proximity/directional_gap.hpp"

namespace vrda {

AuditScene make_audit_scene(const Mesh& reference_canonical, const Mesh& moving_canonical,
                            const SolverFrame& frame)
{
  return {frame, moving_canonical, make_tree_mesh(solver_mesh(reference_canonical, frame))};
}

PoseAudit audit_pose(const AuditScene& scene, const Attitude& attitude, const Pose& X_reference_moving,
                     NarrowPhase& narrow_phase)
{
  const TreeMesh reference = turned(scene.reference, attitude);
  // Moving vertices seen as vertices of the reference's frame, then both turned alike: theta and translation
  // of the solver play no part.
  const TreeMesh moving = turned(
      make_tree_mesh(solver_mesh(transformed(scene.moving, X_reference_moving), scene.frame)), attitude);
  PoseAudit audit;
  audit.is_overlapping = find_collision(reference, moving, {}, narrow_phase).has_value();
  if (audit.is_overlapping) {
    const Gap afar = directional_gap(reference, moving.mesh, moving.tree, {}, {GapKind::from_afar, {}});
    audit.penetration_mm = std::max(0.0, -afar.travel_mm);
    return audit;
  }
  audit.gap_mm = directional_gap(reference, moving.mesh, moving.tree, {}).travel_mm;
  return audit;
}

}  // namespace vrda
