// The start of a joint whose job gives none.
#include "job/case_geometry.hpp"

#include <cmath>

#include "contact/contacts.hpp"
#include "geometry/directional_gap.hpp"

namespace vrda::job {
namespace {

// Ahead of the first contact: far more than rounding, less than the space of any joint.
constexpr double start_clearance_mm = 0.1;
// Of the retreat from an overlap; doubled until the objects are apart or farther than any two bones.
constexpr double first_retreat_mm = 0.1;
constexpr double last_retreat_mm = 1000.0;

}  // namespace

double start_travel_mm(const Case& loaded)
{
  SolverFrame frame = loaded.frame;
  frame.delta = loaded.push_at_meshes.delta;
  const geometry::TreeMesh reference =
      geometry::make_tree_mesh(solver_mesh(loaded.reference.contact.mesh, frame));
  const geometry::TreeMesh moving =
      geometry::make_tree_mesh(solver_mesh(loaded.moving.contact.mesh, frame));
  contact::NarrowPhase narrow_phase;
  MovingPose pose;
  pose.theta_rad = loaded.initial.theta_rad;
  for (double retreat_mm = first_retreat_mm; contact::find_collision(reference, moving, pose, narrow_phase);
       retreat_mm *= 2.0) {
    if (retreat_mm > last_retreat_mm) return 0.0;
    pose.translation_mm.y() = -retreat_mm;
  }
  const double travel_mm =
      geometry::directional_gap(reference, moving.mesh, moving.tree, pose, {}).travel_mm;
  if (!std::isfinite(travel_mm)) return 0.0;
  return pose.translation_mm.y() + travel_mm - start_clearance_mm;
}

}  // namespace vrda::job
