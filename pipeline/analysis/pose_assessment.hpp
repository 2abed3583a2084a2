/// Independent check of the solved poses of a motion model.
#pragma once

#include <cstdint>
#include <vector>

#include "model/joint_bounds.hpp"
#include "model/mesh.hpp"
#include "model/ligaments.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// One entry per cell of the grid.
struct PoseAssessment {
  store::GridB is_overlapping;  ///< 1 if the meshes of a stable pose overlap
  store::GridB plausibility;    ///< Plausibility; `not_judged` if not stable or overlapping
};

/// Measures every stable pose of the raw motion again (audit/pose_meter.hpp); the first of these that
/// applies: dislocated: beyond `bounds`. border_contact: a stored contact is within the contact resolution of
/// an edge that belongs to one triangle only, so that the surface ends there. overstrained: a fibre is
/// longer, or a bundle carries more tension, than ligaments bear: strain 0.44 and 1730 N, where anterior
/// cruciate ligaments of young adults failed (Noyes and Grood 1976, J Bone Joint Surg Am 58:1074). The last
/// two displace the pose by a contact resolution d to both sides: along X and Z of S, their diagonals,
/// rotation about Delta through the moving object's centre and, if varus was free, varus; angles are d over
/// half the object's larger horizontal extent. nothing_ahead: one of them has no contact within d along
/// Delta. unstable_balance: on both sides, after moving into contact, the energy of loads and ligaments is
/// lower than in the pose by more than the work of the push over d / 1000. Poses held by fibres without
/// contact are exempt from both.
/// `ligaments` are canonical. Same bits for any number of threads.
PoseAssessment assess_poses(const store::MotionModel& model, const model::Ligaments& ligaments,
                            const JointBounds& bounds, int n_threads);

/// Edges of one triangle only, per triangle: bit k is the edge from its corner k to the next.
std::vector<std::int8_t> boundary_edges(const Mesh& mesh);

/// Whether a point on triangle `t` is within `resolution_mm` of one of its boundary edges. `border`:
/// boundary_edges(mesh). False for a triangle outside the mesh.
bool is_at_border(const Mesh& mesh, const std::vector<std::int8_t>& border, std::int32_t t,
                  const Eigen::Vector3d& p_mm, double resolution_mm);

}  // namespace vrda::analysis
