/// The five coordinates of the equilibrium, in the solver frame S (model/frames.hpp): translation of the
/// moving object (mm), its rotation about Delta = +Y, and the varus of the attitude (rad). Energies are in
/// N mm, so gradients hold forces in N and moments in N mm; second derivatives are in N/mm, N and N mm.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "model/frames.hpp"
#include "model/mesh.hpp"

namespace vrda::inline model {

enum Coordinate : Eigen::Index { along_x = 0, along_y = 1, along_z = 2, about_y = 3, about_varus = 4 };
inline constexpr Eigen::Index n_coordinates = 5;

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

/// Derivative of the position of the moving object's point `p_mm` (S) relative to the reference: one column a
/// coordinate. Varus rotates the reference by -X about the origin of S, which is equivalent to rotating the
/// moving object by +X.
inline Eigen::Matrix<double, 3, 5> point_jacobian(const Eigen::Vector3d& p_mm, const MovingPose& pose)
{
  Eigen::Matrix<double, 3, 5> J;
  J.leftCols<3>().setIdentity();
  J.col(about_y) = Eigen::Vector3d::UnitY().cross(p_mm - pose.translation_mm);
  J.col(about_varus) = Eigen::Vector3d::UnitX().cross(p_mm);
  return J;
}

/// An energy as a function of the coordinates, with its derivatives.
struct Potential {
  double energy_nmm = 0.0;
  Vector5d gradient = Vector5d::Zero();
  Matrix5d hessian = Matrix5d::Zero();  ///< symmetric
};

// How far a pose may be from the neutral pose of a joint before the joint counts as dislocated.

/// Unbounded by default.
struct JointBounds {
  Eigen::Vector3d neutral_mm = Eigen::Vector3d::Zero();  ///< translation in W of the joint's own side
  double neutral_theta_rad = 0.0;
  double max_travel_mm = std::numeric_limits<double>::infinity();  ///< distance of translations, inclusive
  double max_theta_rad = std::numeric_limits<double>::infinity();  ///< of the smaller rotation, inclusive
};

/// `pose` in the solver frame `frame`. False for a pose that is not finite.
bool is_within(const JointBounds& bounds, const SolverFrame& frame, const MovingPose& pose);

// The six coordinates of a joint after Grood and Suntay (schemas/clinical.md) and their map to a pose.

/// Rows of JointCoordinates.
enum class JointCoordinate : std::uint8_t { flexion, varus, internal, anterior, proximal, lateral };
inline constexpr std::size_t n_joint_coordinates = 6;
/// Names in jobs and files.
inline constexpr std::array<const char*, n_joint_coordinates> joint_coordinate_names{
    "flexion", "varus", "internal", "anterior", "proximal", "lateral"};

inline constexpr Eigen::Index row_of(JointCoordinate coordinate)
{
  return static_cast<Eigen::Index>(coordinate);
}
inline constexpr bool is_rotation(std::size_t coordinate)
{
  return coordinate < 3;
}

/// The unit of a coordinate in files.
inline constexpr const char* unit_name(std::size_t coordinate)
{
  return is_rotation(coordinate) ? "degree" : "mm";
}
/// In the names of columns.
inline constexpr const char* unit_suffix(std::size_t coordinate)
{
  return is_rotation(coordinate) ? "_deg" : "_mm";
}

/// A coordinate (rad or mm) in degrees or mm, as in files, and the inverse.
inline double in_file(double value, std::size_t coordinate)
{
  return is_rotation(coordinate) ? deg_from_rad(value) : value;
}
inline double from_file(double value, std::size_t coordinate)
{
  return is_rotation(coordinate) ? rad_from_deg(value) : value;
}

/// An entry for each coordinate, by the coordinate or its row.
template <typename Entry>
struct OfCoordinates : std::array<Entry, n_joint_coordinates> {
  using std::array<Entry, n_joint_coordinates>::operator[];
  Entry& operator[](JointCoordinate c) { return this->at(static_cast<std::size_t>(c)); }
  const Entry& operator[](JointCoordinate c) const { return this->at(static_cast<std::size_t>(c)); }
};

/// Three angles (rad) and three translations (mm). Signs are those of schemas/clinical.md for both sides.
using JointCoordinates = Eigen::Matrix<double, 6, 1>;

/// The same in degrees and mm, as in files.
inline OfCoordinates<double> in_files(const JointCoordinates& coordinates)
{
  OfCoordinates<double> numbers;
  for (std::size_t k = 0; k < numbers.size(); ++k)
    numbers[k] = in_file(coordinates(static_cast<Eigen::Index>(k)), k);
  return numbers;
}

/// Where a coordinate comes from: a grid's axis, an input, or the equilibrium.
enum class CoordinateRole : std::int8_t { driven = 0, given = 1, free = 2 };
const char* name_of(CoordinateRole role);

/// Axes that belong to the coordinates, columns in the reference's frame (right side): anterior (floating),
/// proximal (of the moving object) and across both.
Eigen::Matrix3d floating_axes(const JointCoordinates& coordinates);

/// Translation of the rotation centre's moving point along floating_axes(), mm. Undefined at a varus of 90
/// degrees.
Eigen::Vector3d floating_translation_mm(const JointCoordinates& coordinates);

/// Pose of the moving object in the reference's frame: right side, both centred on the rotation centre. The
/// inverse of clinical_coordinates().
Pose joint_pose(const JointCoordinates& coordinates);

/// The coordinates of such a pose.
JointCoordinates joint_coordinates(const Pose& X_reference_moving);

// Coordinates of a body that follows the joint, relative to the body whose frame they use
// (schemas/followers.md): R = Rz(-flexion) Rx(rotation) Ry(tilt) on the right side, and the displacement of
// the follower's centre along the axes of that body, lateral positive on both sides. Rows as those of
// JointCoordinates.

/// Names in files, with the unit of their values there.
inline constexpr std::array<const char*, n_joint_coordinates> follower_coordinate_names{
    "flexion", "rotation", "tilt", "anterior", "proximal", "lateral"};

/// `X` maps the follower's stored vertices to those of the other body; `centre_mm` is in canonical axes of
/// the joint's own side.
JointCoordinates follower_coordinates(const Pose& X, Side side, const Eigen::Vector3d& centre_mm);
Pose follower_pose(const JointCoordinates& coordinates, Side side, const Eigen::Vector3d& centre_mm);

// The kinds of joints that a job may name, and their words for the six coordinates.
//
// Every kind has the same coordinates with the same signs (schemas/clinical.md); a kind says how they are
// called. Source: Grood and Suntay (1983) for the knee; Wu et al. (2002), J Biomech 35:543-548, for hip and
// ankle.

/// A coordinate by the direction that counts positive, and the opposite direction.
struct CoordinateWords {
  const char* positive;
  const char* negative;
  const char* of(double value) const { return value < 0.0 ? negative : positive; }
};

/// Angles in degrees, from `least` to `most`.
struct AngleRange {
  double least_deg, most_deg;
};

struct JointKind {
  const char* name;  ///< as in jobs and files
  std::array<CoordinateWords, n_joint_coordinates> words;
  /// Healthy joints stay within these (schemas/clinical.md).
  AngleRange usual_flexion, usual_varus;
  bool has_compartments = false;  ///< medial and lateral, where the job names none
  bool has_large_flexion = true;  ///< false: it may turn more about its other axes
};

inline constexpr std::array<const char*, 5> joint_kind_names{"knee", "hip", "ankle", "subtalar", "other"};

/// `name` is one of joint_kind_names.
const JointKind& joint_kind(const std::string& name);

/// Whether it calls the rotations otherwise than their keys: all but knee and other.
bool has_own_words(const JointKind& kind);

/// "flexion" and "varus" of a knee, "adduction (abduction -)" of a hip.
std::string label_of(const JointKind& kind, JointCoordinate coordinate);

// Clinical description of motion: the Grood-Suntay coordinates of a pose (moving body, the tibia, in the
// reference, the femur; formulas in schemas/clinical.md) and the helical axis between two poses.

/// Angles: flexion +, varus (adduction) +, internal rotation +. Translations of the tibial point that
/// coincides with the rotation centre at the zero pose, along the Grood-Suntay axes: anterior +,
/// proximal +, lateral + on both sides.
struct ClinicalCoordinates {
  double flexion_rad = 0.0;
  double varus_rad = 0.0;
  double internal_rotation_rad = 0.0;
  double anterior_mm = 0.0;
  double proximal_mm = 0.0;
  double lateral_mm = 0.0;

  JointCoordinates rows() const;
};
inline OfCoordinates<double> in_files(const ClinicalCoordinates& coordinates)
{
  return in_files(coordinates.rows());
}

/// Decomposes `X_reference_moving`: R = Rz(-flexion) Rx(varus) Ry(internal) on the right side; on the left
/// the mirrored pose is decomposed. `rotation_centre_mm` is in canonical coordinates of the joint's own side.
/// Source: Grood and Suntay (1983) J Biomech Eng 105:136-144.
ClinicalCoordinates clinical_coordinates(const Pose& X_reference_moving, Side side,
                                         const Eigen::Vector3d& rotation_centre_mm);

/// `angle` plus whole turns, within half a turn of `near`; the same bits where none is added.
double nearest_turn(double angle, double near, double turn = 2.0 * pi);

/// The angles plus whole turns: each is within half a turn of the one before it. NaN is skipped.
std::vector<double> unwrapped(std::vector<double> angles, double turn = 2.0 * pi);

/// Of the numbers (f, v, i) and (f + pi, pi - v, i + pi) of one orientation, plus whole turns, those that
/// change least from `before`; the latter point the floating axis, and anterior, the other way. At gimbal
/// lock, where only f - i or f + i is defined, both change equally; anterior is then undefined.
ClinicalCoordinates nearest_numbers(const ClinicalCoordinates& c, const ClinicalCoordinates& before);

/// The coordinates of successive poses as continuous curves, beyond the ranges of clinical_coordinates():
/// nearest_numbers() of each pose to those of the pose before.
class ContinuousCoordinates {
 public:
  ContinuousCoordinates(Side side, const Eigen::Vector3d& rotation_centre_mm);

  /// Of the next pose. The first has the numbers of clinical_coordinates(), and so has every pose, with equal
  /// bits, whose numbers need no change.
  ClinicalCoordinates next(const Pose& X_reference_moving);

  /// Poses so far at gimbal lock, or beyond it.
  int n_locked() const { return n_locked_; }

 private:
  Side side_;
  Eigen::Vector3d rotation_centre_mm_;
  std::optional<ClinicalCoordinates> before_;
  int n_locked_ = 0;
};

/// A warning about poses at gimbal lock; empty without any.
std::string gimbal_lock_text(int n_locked);

/// Smallest rotation with a defined axis: below it, rounding of coordinates of some 100 mm (1e-13 mm) shifts
/// the axis by more than 1e-7 mm.
inline constexpr double min_rotation_rad = 1e-6;

/// The screw motion from one pose of a body to another.
struct HelicalAxis {
  double rotation_rad = 0.0;    ///< in (0, pi]
  double translation_mm = 0.0;  ///< along `direction`
  Eigen::Vector3d direction;    ///< unit; the rotation about it is right-handed
  Eigen::Vector3d point_mm;     ///< of the axis, nearest to the given point
};

/// The screw motion from `X_fixed_start` to `X_fixed_end` of a moving body; the axis and `near_fixed_mm` are
/// in the fixed frame. Empty where the rotation is below min_rotation_rad. Source: Spoor and Veldpaus (1980)
/// J Biomech 13:391-393. Differs: the angle is the arc tangent of the skew part's norm and the trace, which
/// is accurate for small rotations; beyond a right angle the direction comes from the symmetric part.
std::optional<HelicalAxis> helical_axis(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                        const Eigen::Vector3d& near_fixed_mm);

/// The start's orientation rotated by half the screw's angle; the start's orientation where there is no axis.
Eigen::Matrix3d midpoint_orientation(const Pose& X_fixed_start, const Pose& X_fixed_end);

/// The instant centre of the rotation about Z, (x, y) of the fixed frame: the intersection of the
/// perpendicular bisectors of the planar displacements of the moving point that starts at `near_fixed_mm` and
/// of any other point that stays in the plane (Reuleaux; thesis figure 3). Empty where the rotation about Z
/// is below min_rotation_rad.
std::optional<Eigen::Vector2d> instant_centre_mm(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                                 const Eigen::Vector3d& near_fixed_mm);

}  // namespace vrda::inline model
