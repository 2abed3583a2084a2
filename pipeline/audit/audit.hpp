/// Gap and penetration of a stored motion, measured again from meshes and poses alone: nothing of the
/// solver's own state is trusted.
#pragma once

#include "contact/contacts.hpp"
#include "core/frames.hpp"

namespace vrda {

/// One attitude measured.
struct PoseAudit {
  bool is_overlapping = false;  ///< Bullet's narrow phase finds triangles that share a point
  double penetration_mm = 0.0;  ///< travel back along Delta to the first touch from afar; 0 when free
  double gap_mm = 0.0;          ///< travel along Delta to the next touch; infinite when nothing is in the way
};

/// Both objects as a motion model stores them: contact meshes, canonical, own side.
struct AuditScene {
  SolverFrame frame;
  Mesh moving;         ///< canonical
  TreeMesh reference;  ///< solver frame, zero attitude
};

AuditScene make_audit_scene(const Mesh& reference_canonical, const Mesh& moving_canonical,
                            const SolverFrame& frame);

/// Measures the pose that takes stored moving vertices to stored reference vertices.
PoseAudit audit_pose(const AuditScene& scene, const Attitude& attitude, const Pose& X_reference_moving,
                     NarrowPhase& narrow_phase);

}  // namespace vrda
