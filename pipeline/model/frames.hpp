/// The frames of a joint (schemas/frames.md) and the maps between them.
///
/// Canonical C: X anterior, Y proximal, Z the subject's right; the meshes' own origin.
/// World W: axes of C, origin at the rotation centre, at zero attitude.
/// Solver S: W reflected in Z for a left joint, then rotated so that Delta is +Y. In S an attitude rotates
/// the reference by Rx(-varus) Rz(flexion); the moving object rotates by theta about +Y and translates.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/fields.hpp"
#include "model/mesh.hpp"

namespace vrda::inline model {

/// A body as its row in the list of a joint's bodies, as motion models number them; `world` is the frame that
/// no body carries.
enum class BodyIndex : std::int8_t { world = -1, reference = 0, moving = 1 };
/// Names in jobs and files.
inline constexpr Named<BodyIndex> body_names[] = {
    {BodyIndex::reference, "reference"}, {BodyIndex::moving, "moving"}, {BodyIndex::world, "world"}};
constexpr const auto& names_of(BodyIndex)
{
  return body_names;
}
inline constexpr BodyIndex all_bodies[] = {BodyIndex::reference, BodyIndex::moving};
/// The name of a body, of `followers` by their order.
inline std::string object_name(BodyIndex body, const std::vector<std::string>& followers)
{
  const auto row = static_cast<std::size_t>(body);
  return row < std::size(all_bodies) ? name_of(body) : followers.at(row - std::size(all_bodies));
}

/// The canonical axes X, Y and Z.
inline constexpr std::array<const char*, 3> axis_names{"anterior", "proximal", "right"};

/// The member of `its` that belongs to a body: `its.reference` or `its.moving`.
template <typename Bodies>
auto& part_of(Bodies& its, BodyIndex body)
{
  return body == BodyIndex::moving ? its.moving : its.reference;
}

/// Whether a body that follows the joint may have this name: a letter, then letters, digits, - and _; no name
/// of another body.
bool is_follower_name(const std::string& name);

enum class Side { right, left };

struct Attitude {
  double flexion_rad = 0.0;
  double varus_rad = 0.0;
};

/// Pose of the moving object in S: p_S = translation + Ry(theta) p_moving.
struct MovingPose {
  Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();
  double theta_rad = 0.0;
};

/// Definition of S relative to C. `rotation_centre_mm` and `delta` are in C of the joint's own side.
struct SolverFrame {
  Side side = Side::right;
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d delta = Eigen::Vector3d::UnitY();
};

Eigen::Matrix3d rotation_x(double angle_rad);
Eigen::Matrix3d rotation_y(double angle_rad);
Eigen::Matrix3d rotation_z(double angle_rad);

/// Shortest rotation from the unit vector `from` to `to`; about X (or Z) by pi when opposite.
Eigen::Matrix3d shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Rotation of the reference in S at an attitude: Rx(-varus) Rz(flexion).
Eigen::Matrix3d reference_rotation(const Attitude& attitude);

/// X_S_moving of a pose.
Pose pose_of(const MovingPose& pose);

/// Canonical mesh in S at zero attitude: mirrored if left, recentred, rotated so that Delta is +Y. Where it
/// has an allowed overlap: its inward_limit(), by which gaps, contacts and overlaps are measured.
Mesh solver_mesh(const Mesh& canonical, const SolverFrame& frame);

/// The pose, in C of the joint's own side, that maps stored moving vertices to stored reference
/// vertices (neither recentred).
Pose X_reference_moving(const SolverFrame& frame, const Attitude& attitude, const MovingPose& pose);

/// The same pose for the vertices of solver_mesh: the moving object in the reference's frame, both in S at
/// zero attitude. reference_rotation(attitude) * result equals pose_of(pose) to rounding.
Pose X_solver_reference_moving(const SolverFrame& frame, const Pose& X_reference_moving);

/// Translation of `pose` expressed in W of the joint's own side (theta keeps the right-knee sign).
Eigen::Vector3d world_translation_mm(const SolverFrame& frame, const MovingPose& pose);
/// Inverse of world_translation_mm.
Eigen::Vector3d solver_translation_mm(const SolverFrame& frame, const Eigen::Vector3d& p_world_mm);

/// A moment in canonical axes of the joint's own side (right-handed), in S: mirroring reverses its components
/// in the sagittal plane.
Eigen::Vector3d solver_moment_nmm(const SolverFrame& frame, const Eigen::Vector3d& moment_world_nmm);

/// A point or direction of S, in W of the joint's own side; both frames have the same origin.
Eigen::Vector3d world_from_solver(const SolverFrame& frame, const Eigen::Vector3d& v_solver);

// Names of the sides of the body, as in job files, motion models and messages.

/// "right" or "left".
inline std::string side_name(Side side)
{
  return side == Side::left ? "left" : "right";
}

/// The side of that name; right for any other text, which the readers of files refuse.
inline Side side_named(const std::string& name)
{
  return name == "left" ? Side::left : Side::right;
}

// Scaling of a joint to a subject, passed between load, store and app. schemas/scaling.md defines what is
// scaled and how a factor is fitted.

struct Scaling {
  Eigen::Vector3d factor{1.0, 1.0, 1.0};  ///< anterior, proximal, right; about the rotation centre
  bool keeps_steps = false;               ///< steps solved at factor 1, lengths of the results scaled

  // Landmark pairs to which a uniform factor was fitted; empty where the job gives the factor.
  std::vector<std::string> landmark;  ///< [n_pairs]
  std::vector<double> model_mm;       ///< [n_pairs] distance at factor 1
  std::vector<double> subject_mm;     ///< [n_pairs] distance in the subject
  std::vector<double> residual_mm;    ///< [n_pairs] subject_mm - factor * model_mm
  double residual_rms_mm = std::numeric_limits<double>::quiet_NaN();  ///< NaN without pairs
  double standard_error = std::numeric_limits<double>::quiet_NaN();   ///< of the factor; NaN below two pairs
};

/// Whether the three factors are equal.
bool is_uniform(const Eigen::Vector3d& factor);

}  // namespace vrda::inline model
