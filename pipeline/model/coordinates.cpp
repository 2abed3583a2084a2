#include "model/coordinates.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "model/linear_algebra.hpp"

namespace vrda::inline model {

bool is_within(const JointBounds& bounds, const SolverFrame& frame, const MovingPose& pose)
{
  const double travel_mm = (world_translation_mm(frame, pose) - bounds.neutral_mm).norm();
  const double theta_rad = std::abs(std::remainder(pose.theta_rad - bounds.neutral_theta_rad, 2.0 * pi));
  return travel_mm <= bounds.max_travel_mm && theta_rad <= bounds.max_theta_rad;
}

const char* name_of(CoordinateRole role)
{
  return role == CoordinateRole::driven ? "driven" : role == CoordinateRole::given ? "given" : "free";
}

Eigen::Matrix3d floating_axes(const JointCoordinates& coordinates)
{
  return rotation_z(-coordinates(0)) * rotation_x(coordinates(1));
}

Eigen::Vector3d floating_translation_mm(const JointCoordinates& coordinates)
{
  // lateral = T . e1 with e1 = (0, sin varus, cos varus) along the floating axes.
  const SinCos varus = sin_cos(coordinates(1));
  return {coordinates(3), coordinates(4), (coordinates(5) - coordinates(4) * varus.sin) / varus.cos};
}

Pose joint_pose(const JointCoordinates& coordinates)
{
  const Eigen::Matrix3d axes = floating_axes(coordinates);
  Pose X = Pose::Identity();
  X.linear() = axes * rotation_y(coordinates(2));
  X.translation() = axes * floating_translation_mm(coordinates);
  return X;
}

JointCoordinates joint_coordinates(const Pose& X_reference_moving)
{
  return clinical_coordinates(X_reference_moving, Side::right, Eigen::Vector3d::Zero()).rows();
}

JointCoordinates ClinicalCoordinates::rows() const
{
  JointCoordinates rows;
  rows << flexion_rad, varus_rad, internal_rotation_rad, anterior_mm, proximal_mm, lateral_mm;
  return rows;
}

JointCoordinates follower_coordinates(const Pose& X, Side side, const Eigen::Vector3d& centre_mm)
{
  JointCoordinates coordinates = clinical_coordinates(X, side, centre_mm).rows();
  const Eigen::Vector3d shift_mm = X * centre_mm - centre_mm;
  coordinates.tail<3>() << shift_mm.x(), shift_mm.y(), side == Side::left ? -shift_mm.z() : shift_mm.z();
  return coordinates;
}

Pose follower_pose(const JointCoordinates& coordinates, Side side, const Eigen::Vector3d& centre_mm)
{
  const Eigen::Vector3d own(1.0, 1.0, side == Side::left ? -1.0 : 1.0);
  Pose X = Pose::Identity();
  X.linear() = own.asDiagonal() * Eigen::Matrix3d(joint_pose(coordinates).linear()) * own.asDiagonal();
  X.translation() = centre_mm + own.cwiseProduct(coordinates.tail<3>()) - X.linear() * centre_mm;
  return X;
}

namespace {

constexpr CoordinateWords anterior{"anterior", "posterior"};
constexpr CoordinateWords proximal{"proximal", "distal"};
constexpr CoordinateWords lateral{"lateral", "medial"};
constexpr CoordinateWords internal{"internal rotation", "external rotation"};
constexpr CoordinateWords plantarflexion{"plantarflexion", "dorsiflexion"};
constexpr CoordinateWords inversion{"inversion", "eversion"};

constexpr AngleRange any_angle{-360.0, 360.0};

constexpr std::array<JointKind, joint_kind_names.size()> kinds{{
    {"knee",
     {{{"flexion", "extension"}, {"varus", "valgus"}, internal, anterior, proximal, lateral}},
     {-15.0, 145.0},
     {-25.0, 25.0},
     true},
    // The same rotation about Z that bends a knee swings a thigh backwards.
    {"hip",
     {{{"extension", "flexion"}, {"adduction", "abduction"}, internal, anterior, proximal, lateral}},
     {-140.0, 30.0},
     {-60.0, 45.0},
     false},
    {"ankle",
     {{plantarflexion, inversion, internal, anterior, proximal, lateral}},
     {-35.0, 60.0},
     {-40.0, 40.0},
     false},
    {"subtalar",
     {{plantarflexion, inversion, internal, anterior, proximal, lateral}},
     {-30.0, 30.0},
     {-40.0, 40.0},
     false,
     false},
    {"other",
     {{{"flexion", "extension"}, {"varus", "valgus"}, internal, anterior, proximal, lateral}},
     any_angle,
     any_angle,
     false,
     false},
}};

}  // namespace

const JointKind& joint_kind(const std::string& name)
{
  const auto* const found =
      std::find_if(kinds.begin(), kinds.end(), [&](const JointKind& kind) { return kind.name == name; });
  check(found != kinds.end(), "a joint has one of the names of joint_kind_names");
  return *found;
}

bool has_own_words(const JointKind& kind)
{
  return kind.name != std::string("knee") && kind.name != std::string("other");
}

std::string label_of(const JointKind& kind, JointCoordinate coordinate)
{
  const CoordinateWords& words = kind.words.at(static_cast<std::size_t>(coordinate));
  const bool is_plain = coordinate != JointCoordinate::flexion && coordinate != JointCoordinate::varus;
  if (is_plain || !has_own_words(kind)) return words.positive;
  return std::string(words.positive) + " (" + words.negative + " -)";
}

namespace {

/// Of varus: below it rounding (1e-16) turns flexion and internal rotation by more than 1e-9 rad.
constexpr double least_varus_cosine = 1e-7;

}  // namespace

ClinicalCoordinates clinical_coordinates(const Pose& X_reference_moving, Side side,
                                         const Eigen::Vector3d& rotation_centre_mm)
{
  Eigen::Matrix3d R = X_reference_moving.linear();
  // Displacement of the moving point at the rotation centre: independent of the meshes' origin.
  Eigen::Vector3d t = X_reference_moving * rotation_centre_mm - rotation_centre_mm;
  if (side == Side::left) {
    const Eigen::Vector3d m(1.0, 1.0, -1.0);
    R = m.asDiagonal() * R * m.asDiagonal();
    t.z() = -t.z();
  }
  // R = Rz(-f) Rx(v) Ry(i): row 2 is (-cos v sin i, sin v, cos v cos i), column 1 is
  // (sin f cos v, cos f cos v, sin v).
  ClinicalCoordinates result;
  result.varus_rad = arc_sine(R(2, 1));
  result.flexion_rad = arc_tangent2(R(0, 1), R(1, 1));
  result.internal_rotation_rad = arc_tangent2(-R(2, 0), R(2, 2));
  if (R(0, 1) * R(0, 1) + R(1, 1) * R(1, 1) < least_varus_cosine * least_varus_cosine) {
    // Gimbal lock: f is any, and f - i (varus 90 degrees) or f + i (-90) gives i.
    const double i = R(2, 1) > 0.0 ? result.flexion_rad - arc_tangent2(-R(1, 0) - R(0, 2), R(0, 0) - R(1, 2))
                                   : arc_tangent2(R(0, 2) - R(1, 0), R(0, 0) + R(1, 2)) - result.flexion_rad;
    result.internal_rotation_rad = nearest_turn(i, 0.0);
  }
  // Axes of Grood-Suntay: e1 the femoral flexion axis (Z), e3 the tibial long axis (R's column 1),
  // e2 = e3 x e1, floating and anterior.
  const Eigen::Vector3d e1 = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d e3 = R.col(1);
  const Eigen::Vector3d e2 = e3.cross(e1).normalized();
  result.lateral_mm = t.dot(e1);
  result.anterior_mm = t.dot(e2);
  result.proximal_mm = t.dot(e3);
  return result;
}

double nearest_turn(double angle, double near, double turn)
{
  const double n = std::round((near - angle) / turn);
  return n == 0.0 ? angle : angle + n * turn;
}

std::vector<double> unwrapped(std::vector<double> angles, double turn)
{
  double before = nan;
  for (double& angle : angles) {
    if (std::isfinite(before) && std::isfinite(angle)) angle = nearest_turn(angle, before, turn);
    if (std::isfinite(angle)) before = angle;
  }
  return angles;
}

namespace {

/// Plus whole turns, near `before`.
ClinicalCoordinates with_turns(ClinicalCoordinates c, const ClinicalCoordinates& before)
{
  c.flexion_rad = nearest_turn(c.flexion_rad, before.flexion_rad);
  c.varus_rad = nearest_turn(c.varus_rad, before.varus_rad);
  c.internal_rotation_rad = nearest_turn(c.internal_rotation_rad, before.internal_rotation_rad);
  return c;
}

/// The other numbers of the same orientation. The floating axis points the other way.
ClinicalCoordinates other_numbers(ClinicalCoordinates c)
{
  c.flexion_rad += pi;
  c.varus_rad = pi - c.varus_rad;
  c.internal_rotation_rad += pi;
  c.anterior_mm = -c.anterior_mm;
  return c;
}

double change_sq(const ClinicalCoordinates& c, const ClinicalCoordinates& before)
{
  const Eigen::Vector3d change_rad(c.flexion_rad - before.flexion_rad, c.varus_rad - before.varus_rad,
                                   c.internal_rotation_rad - before.internal_rotation_rad);
  return change_rad.squaredNorm();
}

bool is_at_lock(const ClinicalCoordinates& c)
{
  return std::abs(cosine(c.varus_rad)) < least_varus_cosine;
}

}  // namespace

ClinicalCoordinates nearest_numbers(const ClinicalCoordinates& found, const ClinicalCoordinates& before)
{
  const ClinicalCoordinates other = with_turns(other_numbers(found), before);
  ClinicalCoordinates c = with_turns(found, before);
  if (change_sq(other, before) < change_sq(c, before)) c = other;
  if (!is_at_lock(c)) return c;
  // Varus of 90 degrees: the orientation depends on f - i, of -90 degrees on f + i.
  const double sign = sine(c.varus_rad) > 0.0 ? -1.0 : 1.0;
  const double before_rad = before.flexion_rad + sign * before.internal_rotation_rad;
  const double half_rad =
      0.5 * (nearest_turn(c.flexion_rad + sign * c.internal_rotation_rad, before_rad) - before_rad);
  c.flexion_rad = before.flexion_rad + half_rad;
  c.internal_rotation_rad = before.internal_rotation_rad + sign * half_rad;
  return c;
}

ContinuousCoordinates::ContinuousCoordinates(Side side, const Eigen::Vector3d& rotation_centre_mm)
    : side_(side), rotation_centre_mm_(rotation_centre_mm)
{
}

ClinicalCoordinates ContinuousCoordinates::next(const Pose& X_reference_moving)
{
  const ClinicalCoordinates found = clinical_coordinates(X_reference_moving, side_, rotation_centre_mm_);
  ClinicalCoordinates c = before_ ? nearest_numbers(found, *before_) : found;
  if (before_ && is_at_lock(c)) {
    const Eigen::Vector3d t = X_reference_moving * rotation_centre_mm_ - rotation_centre_mm_;
    const SinCos f = sin_cos(c.flexion_rad);
    c.anterior_mm = f.cos * t.x() - f.sin * t.y();
  }
  n_locked_ += cosine(c.varus_rad) < least_varus_cosine ? 1 : 0;
  return before_.emplace(c);
}

std::string gimbal_lock_text(int n_locked)
{
  if (n_locked == 0) return "";
  return "varus reaches or passes 90 degrees at " + std::to_string(n_locked) +
         " poses: flexion and internal rotation are not unique there (gimbal lock); the curves have those "
         "that change least from the pose before";
}

namespace {

struct Turn {
  double sin = 0.0, cos = 1.0;  ///< sin >= 0
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
};

Turn turn_of(const Eigen::Matrix3d& R)
{
  const Eigen::Vector3d skew = 0.5 * Eigen::Vector3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  Turn turn;
  turn.sin = skew.norm();
  turn.cos = 0.5 * (R.trace() - 1.0);
  if (turn.cos >= 0.0) {
    if (turn.sin > 0.0) turn.direction = skew / turn.sin;
    return turn;
  }
  // (R + R^T) / 2 = cos I + (1 - cos) n n^T: after subtracting cos I the longest column is parallel to n.
  const Eigen::Matrix3d along =
      0.5 * (R + Eigen::Matrix3d(R.transpose())) - turn.cos * Eigen::Matrix3d::Identity();
  Eigen::Index longest = 0;
  along.diagonal().maxCoeff(&longest);
  turn.direction = along.col(longest).normalized();
  if (turn.direction.dot(skew) < 0.0) turn.direction = -turn.direction;
  return turn;
}

/// Cotangent of half the angle, from the form without cancellation.
double half_cotangent(double sin, double cos)
{
  return cos >= 0.0 ? (1.0 + cos) / sin : sin / (1.0 - cos);
}

Eigen::Matrix3d turned_by(const Eigen::Vector3d& n, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  const Eigen::Matrix3d N = cross_matrix(n);
  return Eigen::Matrix3d::Identity() + a.sin * N + (1.0 - a.cos) * N * N;
}

}  // namespace

std::optional<HelicalAxis> helical_axis(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                        const Eigen::Vector3d& near_fixed_mm)
{
  const Eigen::Matrix3d R = X_fixed_end.linear() * X_fixed_start.linear().transpose();
  const Turn turn = turn_of(R);
  HelicalAxis axis;
  axis.rotation_rad = arc_tangent2(turn.sin, turn.cos);
  if (axis.rotation_rad < min_rotation_rad) return {};
  axis.direction = turn.direction;
  // Displacement of the body's point that starts at `near`.
  const Eigen::Vector3d way_mm =
      X_fixed_end.translation() - near_fixed_mm + R * (near_fixed_mm - X_fixed_start.translation());
  axis.translation_mm = way_mm.dot(turn.direction);
  const Eigen::Vector3d across_mm = way_mm - axis.translation_mm * turn.direction;
  axis.point_mm = near_fixed_mm +
                  0.5 * (across_mm + half_cotangent(turn.sin, turn.cos) * turn.direction.cross(across_mm));
  return axis;
}

Eigen::Matrix3d midpoint_orientation(const Pose& X_fixed_start, const Pose& X_fixed_end)
{
  const std::optional<HelicalAxis> axis =
      helical_axis(X_fixed_start, X_fixed_end, X_fixed_start.translation());
  const Eigen::Matrix3d R_start = X_fixed_start.linear();
  return axis ? Eigen::Matrix3d(turned_by(axis->direction, 0.5 * axis->rotation_rad) * R_start) : R_start;
}

std::optional<Eigen::Vector2d> instant_centre_mm(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                                 const Eigen::Vector3d& near_fixed_mm)
{
  const Eigen::Matrix3d R = X_fixed_end.linear() * X_fixed_start.linear().transpose();
  // The rotation about Z nearest to R, projected along Z.
  const double y = R(1, 0) - R(0, 1), x = R(0, 0) + R(1, 1);
  const double length = std::sqrt(x * x + y * y);
  if (std::abs(arc_tangent2(y, x)) < min_rotation_rad) return {};
  const Eigen::Vector3d way_mm =
      X_fixed_end.translation() - near_fixed_mm + R * (near_fixed_mm - X_fixed_start.translation());
  const Eigen::Vector2d across_mm(-way_mm.y(), way_mm.x());
  return near_fixed_mm.head<2>() +
         0.5 * (way_mm.head<2>() + half_cotangent(y / length, x / length) * across_mm);
}

}  // namespace vrda::inline model
