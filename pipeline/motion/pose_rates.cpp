// Derivatives of the poses: the steps of Motion::at, differentiated.
#include <algorithm>

#include "motion/poses.hpp"

namespace vrda::motion {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
  Eigen::Matrix3d V;
  V << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return V;
}

/// Vector of the antisymmetric part: the inverse of cross_matrix.
Eigen::Vector3d cross_vector(const Eigen::Matrix3d& V)
{
  return 0.5 * Eigen::Vector3d(V(2, 1) - V(1, 2), V(0, 2) - V(2, 0), V(1, 0) - V(0, 1));
}

/// Derivative of shortest_rotation(from, to) = I + V + V V / (1 + c) by `from`. 0 for opposite directions,
/// where that rotation is discontinuous.
Eigen::Matrix3d shortest_rotation_rate(const Eigen::Vector3d& from, const Eigen::Vector3d& from_rate,
                                       const Eigen::Vector3d& to)
{
  constexpr double opposite = 1e-12;  // as in core/frames.cpp
  const double c = 1.0 + from.dot(to), c_rate = from_rate.dot(to);
  if (c < opposite) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d V = cross_matrix(from.cross(to)), V_rate = cross_matrix(from_rate.cross(to));
  const Eigen::Matrix3d VV_rate = V_rate * V + V * V_rate;
  return V_rate + VV_rate / c - V * V * (c_rate / (c * c));
}

/// Slope of varus_between: at a node that of the preceding piece, 0 beyond the first and last.
double varus_slope(const std::vector<Attitude>& attitudes, double flexion_rad)
{
  const auto after =
      std::lower_bound(attitudes.begin(), attitudes.end(), flexion_rad,
                       [](const Attitude& cell, double flexion) { return cell.flexion_rad < flexion; });
  if (after == attitudes.end() || attitudes.size() < 2) return 0.0;
  if (after == attitudes.begin() && flexion_rad < after->flexion_rad) return 0.0;
  const auto end = after == attitudes.begin() ? after + 1 : after;
  const Attitude& before = *(end - 1);
  return (end->varus_rad - before.varus_rad) / (end->flexion_rad - before.flexion_rad);
}

PoseCoordinates first_four(const PoseAndVarus& numbers)
{
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

}  // namespace

Eigen::Vector3d Motion::delta_rate(double flexion_rad) const
{
  if (deltas_.size() < 2) return Eigen::Vector3d::Zero();
  const std::vector<double>& at = raw_.flexion_rad;
  const auto after = std::upper_bound(at.begin() + 1, at.end() - 1, flexion_rad);
  const auto i = static_cast<std::size_t>(after - at.begin());
  const double step_rad = at[i] - at[i - 1];
  const Eigen::Vector3d rise = (deltas_[i] - deltas_[i - 1]) / step_rad;
  const Eigen::Vector3d between = deltas_[i - 1] + (flexion_rad - at[i - 1]) * rise;
  const Eigen::Vector3d unit = between.normalized();
  return (rise - rise.dot(unit) * unit) / between.norm();
}

Motion::EvaluationRate Motion::raw_rate_at(const Attitude& attitude) const
{
  const HermiteRate<4> rate = sample_rate(raw_, attitude);
  return {{attitude, rate.value.values, rate.value.is_solved}, rate.by_flexion, rate.by_varus, 0.0};
}

Motion::EvaluationRate Motion::smoothed_rate_at(const Attitude& attitude) const
{
  const SmoothedRate rate = evaluate_rate(*smoothed_, attitude);
  EvaluationRate result{{attitude, first_four(rate.value), true},
                        first_four(rate.by_flexion),
                        first_four(rate.by_varus),
                        rate.by_flexion[4]};
  if (smoothed_->has_varus) result.found.attitude.varus_rad = rate.value[4];
  if (!travel_) return result;
  const HermiteRate<1> travel = sample_rate(*travel_, attitude);
  result.found.is_solved = travel.value.is_solved;
  const Eigen::Vector3d unit = delta(attitude.flexion_rad);
  const Eigen::Vector3d shift_mm = travel.value.values[0] * unit;
  const Eigen::Vector3d by_flexion =
      travel.by_flexion[0] * unit + travel.value.values[0] * delta_rate(attitude.flexion_rad);
  for (int axis = 0; axis < 3; ++axis) {
    const auto number = static_cast<std::size_t>(axis);
    result.found.numbers[number] += shift_mm[axis];
    result.by_flexion[number] += by_flexion[axis];
    result.by_varus[number] += travel.by_varus[0] * unit[axis];
  }
  return result;
}

Motion::EvaluationRate Motion::flexion_table_rate_at(const Attitude& attitude) const
{
  const HermiteRate<5> rate = sample_rate(*by_flexion_, attitude);
  if (!rate.value.is_solved) return {{attitude, {}, false}, {}, {}, 0.0};
  return {{{attitude.flexion_rad, rate.value.values[4]}, first_four(rate.value.values), true},
          first_four(rate.by_flexion),
          {},
          rate.by_flexion[4]};
}

/// The evaluation is bitwise equal to that of evaluation_at.
Motion::EvaluationRate Motion::evaluation_rate_at(const Attitude& wanted) const
{
  const Attitude attitude = with_set_varus(wanted);
  if (by_flexion_) return flexion_table_rate_at(attitude);
  EvaluationRate result = smoothed_ ? smoothed_rate_at(attitude) : raw_rate_at(attitude);
  const bool has_varus_surface = smoothed_ && smoothed_->has_varus;
  if (has_varus_surface || free_varus_.empty()) return result;
  // The surfaces are evaluated along the varus line, so its slope enters by the chain rule.
  result.varus_by_flexion = varus_slope(free_varus_, attitude.flexion_rad);
  for (std::size_t number = 0; number < result.by_flexion.size(); ++number)
    result.by_flexion[number] += result.varus_by_flexion * result.by_varus[number];
  return result;
}

/// Angular rate w by flexion of the solver's frame (columns of `R` in W) if Delta depends on it: R' = [w]x R.
Eigen::Vector3d Motion::solver_turn(double flexion_rad, const Eigen::Matrix3d& R) const
{
  if (deltas_.empty()) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d mirror(1.0, 1.0, frame_.side == Side::left ? -1.0 : 1.0);
  const Eigen::Matrix3d turned =
      shortest_rotation_rate(mirror.cwiseProduct(delta(flexion_rad)),
                             mirror.cwiseProduct(delta_rate(flexion_rad)), Eigen::Vector3d::UnitY());
  const Eigen::Matrix3d R_rate = mirror.asDiagonal() * turned.transpose();
  return cross_vector(R_rate * R.transpose());
}

/// Sets the twists of `rate` from its pose, numbers and varus.
///
/// L and Q are the rotations of reference and moving object about the centre c: p_W = L (p - c) and
/// Q (x - c) + s, with angular rates a and b in W. A point of the moving object at p moves in the reference
/// by angular x (p - c) + L^T (s' - b x s), with angular = L^T (b - a).
/// L = R A R^T with the solver's frame R and A = Rx(-varus) Rz(flexion): a is the image under R of
/// A Z flexion' - X varus', negated if R reflects; a rotation w of R itself adds w - L w. Q likewise with Y
/// theta'.
void Motion::set_twists(JointRate& rate) const
{
  const JointPose& pose = rate.pose;
  const Eigen::Matrix3d R = R_world_solver(pose.attitude.flexion_rad);
  const double sign = frame_.side == Side::left ? -1.0 : 1.0;
  const Eigen::Matrix3d L = pose.X_world_reference.linear(), Q = pose.X_world_moving.linear();
  const Eigen::Vector3d& c = frame_.rotation_centre_mm;
  const Eigen::Vector3d s = pose.X_world_moving.translation() + Q * c;
  const Eigen::Vector3d w = solver_turn(pose.attitude.flexion_rad, R);
  const Eigen::Vector3d by_flexion = sign * (L * R.col(2)), by_varus = -sign * R.col(0),
                        by_theta = sign * R.col(1);
  const auto twist_of = [&](const PoseRate& of, double flexion_rate) {
    const Eigen::Vector3d a = flexion_rate * (by_flexion + w - L * w) + of.varus * by_varus;
    const Eigen::Vector3d b = flexion_rate * (w - Q * w) + of.coordinates[3] * by_theta;
    const Eigen::Vector3d s_rate(of.coordinates[0], of.coordinates[1], of.coordinates[2]);
    Twist twist;
    twist.angular = L.transpose() * (b - a);
    twist.linear_mm = L.transpose() * (s_rate - b.cross(s)) - twist.angular.cross(c);
    return twist;
  };
  if (rate.is_flexion_free) rate.by_flexion.twist = twist_of(rate.by_flexion, 1.0);
  if (rate.is_varus_free) rate.by_varus.twist = twist_of(rate.by_varus, 0.0);
}

JointRate Motion::rate_at(const Attitude& wanted) const
{
  const EvaluationRate found = evaluation_rate_at(clamped(wanted));
  JointRate result;
  result.pose = posed(found.found, wanted);
  const bool is_solved = found.found.is_solved;
  result.is_flexion_free = is_solved && !result.pose.is_flexion_clamped && raw_.flexion_rad.size() > 1;
  result.is_varus_free =
      is_solved && !result.pose.is_varus_clamped && !is_varus_free() && raw_.varus_rad.size() > 1;
  if (result.is_flexion_free) {
    result.by_flexion.coordinates = found.by_flexion;
    result.by_flexion.varus = found.varus_by_flexion;
  }
  if (result.is_varus_free) {
    result.by_varus.coordinates = found.by_varus;
    result.by_varus.varus = 1.0;
  }
  set_twists(result);
  return result;
}

}  // namespace vrda::motion
