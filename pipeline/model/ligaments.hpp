/// Ligament fibres between two bodies, as a rule the reference and the moving object: tension law, wrapping,
/// energy and its derivatives (model/README.md).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/step_record.hpp"

namespace vrda::inline model {

enum class WrapShape { cylinder, ellipsoid };

/// A smooth wrapping surface fixed to one object; fibres wrap on the shorter side. A cylinder's axis is its
/// Z and counts as infinite where inside and outside matter. It is ignored for a fibre that starts inside it
/// on its own object, that ends inside an ellipsoid, or that would touch a cylinder wholly beyond one of its
/// ends: the fibre is then straight, and its length is discontinuous there. For a fibre with a stiffness, an
/// end of the other object inside a cylinder is EndInside::around; at constant tension, which its force must
/// not exceed, the fibre is straight.
struct Wrap {
  std::string name;
  WrapShape shape = WrapShape::cylinder;
  BodyIndex body = BodyIndex::reference;
  Pose X_body_wrap = Pose::Identity();  ///< of the object's frame
  Eigen::Vector3d radii_mm{0, 0, 0};    ///< ellipsoid: half-axes; cylinder: x = y = radius, z = half length
};

struct Fibre {
  std::string name;
  std::string bundle;            ///< the same for all fibres of one ligament
  Eigen::Vector3d reference_mm;  ///< attachment to `from`, in that body's frame
  Eigen::Vector3d moving_mm;     ///< attachment to `to`, in that body's frame
  double stiffness_n = 0.0;      ///< per unit strain, above 0
  double slack_length_mm = 0.0;  ///< above 0
  int wrap = -1;                 ///< row of Ligaments::wraps, or -1
  double tension_n = 0.0;        ///< above 0: constant, whatever stiffness and length
  /// Of a body that follows the joint, another one and itself.
  BodyIndex from = BodyIndex::reference, to = BodyIndex::moving;
};

/// Its attachment to a body, in the body's frame.
template <typename AFibre>
auto& attachment_mm(AFibre& fibre, BodyIndex body)
{
  return body == BodyIndex::moving ? fibre.moving_mm : fibre.reference_mm;
}

/// The ligaments of a knee that names of bundles are recognised by.
inline constexpr const char* knee_ligaments[] = {"ACL", "PCL", "MCL", "LCL"};

/// The bundles into which the generic and the template knee divide them; the LCL is one.
inline constexpr const char* divided_bundles[] = {"ACLam", "ACLpl", "PCLal", "PCLpm", "MCLs", "MCLd", "MCLp"};

/// The ligament of a bundle: one of `knee_ligaments` if the name contains it, in either case ("ACLam",
/// "sMCL", "lcl_2"), otherwise the name itself.
std::string ligament_of(const std::string& bundle);

/// Attachments are canonical as loaded; for the solver, in the objects' frames in S at zero attitude.
struct Ligaments {
  std::vector<Fibre> fibres;
  std::vector<Wrap> wraps;
  double transition_strain = 0.06;  ///< where the toe of the tension law ends
};

/// From canonical (own side, meshes' origin) to the solver's frames, like solver_mesh() for meshes.
Ligaments solver_ligaments(const Ligaments& canonical, const SolverFrame& frame);

/// [2 + n_followers] X_reference_body of stored vertices: the reference itself, the moving object, then the
/// bodies that follow.
using BodyPoses = std::vector<Pose>;

/// Row of a body in such lists.
inline std::size_t row_of(BodyIndex body)
{
  return static_cast<std::size_t>(body);
}
/// The body of a follower.
inline BodyIndex follower_index(std::size_t follower)
{
  return static_cast<BodyIndex>(2 + follower);
}
/// Its inverse.
inline std::size_t follower_row(BodyIndex body)
{
  return row_of(body) - 2;
}
/// Bodies that may follow a joint.
inline constexpr std::size_t most_followers = 8;

/// Fibres between any bodies as those between `fixed`, the reference, and `moved`: other bodies are fixed to
/// the first, where they are placed. Canonical. Fibres without an end on `moved` are left out.
Ligaments ligaments_between(const Ligaments& canonical, BodyIndex fixed, BodyIndex moved,
                            const BodyPoses& placed);

/// Tension of a fibre. Source: Blankevoort et al. 1991, J Biomech 24:1019-1031.
struct Tension {
  double force_n = 0.0;
  double stiffness_n = 0.0;  ///< derivative over strain
  double energy_n = 0.0;     ///< integral over strain; times slack length: energy in N mm
};
Tension tension_of(double strain, double stiffness_n, double transition_strain);

/// Energy of a fibre as a function of its length.
struct LengthEnergy {
  double energy_nmm = 0.0;
  double force_n = 0.0;         ///< first derivative
  double stiffness_n_mm = 0.0;  ///< second derivative
};
LengthEnergy energy_of(const Fibre& fibre, double length_mm, double transition_strain);

struct FibreState {
  double length_mm = 0.0;
  double strain = 0.0;  ///< negative: slack; 0 at constant tension
  double force_n = 0.0;
  double energy_nmm = 0.0;
  bool is_wrapped = false;  ///< touches its wrap
};

/// One state per fibre.
std::vector<FibreState> fibre_states(const Ligaments& ligaments, const Attitude& attitude,
                                     const MovingPose& pose);

/// Energy of all fibres with exact gradient and second derivatives. The latter are discontinuous where a
/// fibre becomes slack or lifts off its wrap. No allocation.
Potential ligament_energy(const Ligaments& ligaments, const Attitude& attitude, const MovingPose& pose);

/// Tension times length of all lines, with gradient and second derivatives. A line of length 0 has neither.
Potential line_energy(std::span<const TensionLine> lines, const Attitude& attitude, const MovingPose& pose);

/// Potential of a force that keeps its direction in the reference's frame, at a material point of the moving
/// object: minus the force times the position of the point in the reference's frame. `force_reference_n` and
/// `point_moving_mm` are in the objects' frames.
Potential point_force_energy(const Eigen::Vector3d& force_reference_n, const Eigen::Vector3d& point_moving_mm,
                             const Attitude& attitude, const MovingPose& pose);

/// Both objects in S at one attitude and pose.
struct JointPlacement {
  Eigen::Matrix3d R_S_reference = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_S_moving = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_S_moving_mm = Eigen::Vector3d::Zero();
};
JointPlacement joint_placement(const Attitude& attitude, const MovingPose& pose);

/// Path of a fibre in S. One free segment connects the object with the wrap to the other object (straight
/// fibre: the whole fibre). Only this segment exerts a force between the objects.
struct FibrePath {
  double length_mm = 0.0;
  bool is_wrapped = false;
  /// Along the free segment from the reference to the moving object, a unit vector as a rule
  /// (WrapPath::end_direction); zero for coincident attachments.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  /// The attachment at the end of the free segment, and its object.
  Eigen::Vector3d end_mm = Eigen::Vector3d::Zero();
  BodyIndex end_body = BodyIndex::moving;
  /// Second derivatives of the length over `end_mm` with the wrap fixed; 1/mm.
  Eigen::Matrix3d bending = Eigen::Matrix3d::Zero();
};

/// No allocation.
FibrePath fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps, const JointPlacement& placement);

/// The same of a fibre under tension. Of a slack one `length_mm` may be an upper bound below the slack
/// length, and the rest unset.
FibrePath taut_path(const Fibre& fibre, const std::vector<Wrap>& wraps, const JointPlacement& placement);

struct SampledFibre {
  double length_mm = 0.0;  ///< as from fibre_path, not the length of the polyline
  bool is_wrapped = false;
};

/// Writes points of the fibre's path to `points_mm` (at least four), in S, from the reference's attachment to
/// the moving object's: evenly spaced on a straight fibre; on a wrapped one both attachments and points
/// evenly spaced on the arc on the surface, its ends included. No allocation.
SampledFibre sample_fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps,
                               const JointPlacement& placement, std::span<Eigen::Vector3d> points_mm);

// The shortest path between two points around a wrapping surface, in the surface's own frame.

struct WrapPath {
  bool is_wrapped = false;  ///< false: the path is straight; the other members are unset
  double length_mm = 0.0;
  /// Derivative of the length over the end: unit, along the last free segment from the surface to the end;
  /// longer where the end is inside a cylinder.
  Eigen::Vector3d end_direction = Eigen::Vector3d::Zero();
  /// Second derivatives of the length over the end, 1/mm. The free segment rolls on the surface: in the plane
  /// of the surface normal the value is 1 / its length; across that plane it follows the divergence of
  /// neighbouring geodesics.
  Eigen::Matrix3d bending = Eigen::Matrix3d::Zero();
  /// First point on the surface, unit direction there, and length of the arc on the surface.
  Eigen::Vector3d touch_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d start_direction = Eigen::Vector3d::Zero();
  double arc_mm = 0.0;
  double radius_mm = 0.0;  ///< of a cylinder
};

/// The path to an end inside a cylinder: straight, or around a cylinder about the same axis through the end,
/// so that the length is continuous.
enum class EndInside { straight, around };

/// Around a cylinder along Z, on the shorter side: a helix between two tangents, in closed form. Not wrapped
/// when the start is inside the infinite cylinder, or when both ends of the arc are beyond the same end of
/// the cylinder.
WrapPath cylinder_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm, double radius_mm,
                       double half_length_mm, EndInside end_inside = EndInside::around);

/// Around an ellipsoid: a geodesic between two tangents, the shortest found from initial planes around the
/// straight line. Not wrapped when a point is inside. The length is accurate to 1e-8 mm for lengths of tens
/// of mm and half-axes up to 5 : 1; for flatter shapes the result may be a longer geodesic or a planar path.
/// A path that is surely shorter than `slack_mm` may have an upper bound of its length and nothing else.
WrapPath ellipsoid_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm,
                        const Eigen::Vector3d& half_axes_mm, double slack_mm = 0.0);

/// The point on a cylinder or an ellipsoid at arc length `along_mm` from the first tangent point; to 1e-8 mm.
Eigen::Vector3d cylinder_point_mm(const WrapPath& path, double along_mm);
Eigen::Vector3d ellipsoid_point_mm(const WrapPath& path, double along_mm,
                                   const Eigen::Vector3d& half_axes_mm);

}  // namespace vrda::inline model
