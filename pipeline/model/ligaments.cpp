#include "model/ligaments.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"

namespace vrda::inline model {
namespace {

Eigen::Vector3d flipped_z(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), -v.z()};
}

// From C of the joint's own side to S, like solver_mesh().
struct ToSolver {
  bool is_left = false;
  Eigen::Vector3d centre_mm;  // of the right-sided joint
  Eigen::Matrix3d R_solver_world;

  Eigen::Vector3d point(const Eigen::Vector3d& p_mm) const
  {
    const Eigen::Vector3d centred_mm = (is_left ? flipped_z(p_mm) : p_mm) - centre_mm;
    return R_solver_world.isIdentity(0.0) ? centred_mm : Eigen::Vector3d(R_solver_world * centred_mm);
  }

  // Wraps are symmetric in their own Z, so a mirrored one is the same surface at the pose M X M.
  Eigen::Matrix3d rotation(const Eigen::Matrix3d& R) const
  {
    const Eigen::Vector3d m(1.0, 1.0, is_left ? -1.0 : 1.0);
    const Eigen::Matrix3d of_right = m.asDiagonal() * R * m.asDiagonal();
    return R_solver_world.isIdentity(0.0) ? of_right : Eigen::Matrix3d(R_solver_world * of_right);
  }
};

ToSolver to_solver(const SolverFrame& frame)
{
  const bool is_left = frame.side == Side::left;
  const auto of_right = [&](const Eigen::Vector3d& v) { return is_left ? flipped_z(v) : v; };
  return {is_left, of_right(frame.rotation_centre_mm),
          shortest_rotation(of_right(frame.delta), Eigen::Vector3d::UnitY())};
}

double strain_of(const Fibre& fibre, double length_mm)
{
  return fibre.tension_n > 0.0 ? 0.0 : (length_mm - fibre.slack_length_mm) / fibre.slack_length_mm;
}

// Second derivatives of `direction . end` over the coordinates, for an end on the moving object relative to
// the reference: varus rotates it about X last.
Matrix5d turning_of_moving_end(const FibrePath& path, const MovingPose& pose)
{
  const Eigen::Vector3d X = Eigen::Vector3d::UnitX(), Y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d turned_mm = Y.cross(path.end_mm - pose.translation_mm);
  Matrix5d H = Matrix5d::Zero();
  H.block<3, 1>(0, about_varus) = path.direction.cross(X);
  H(about_y, about_y) = path.direction.dot(Y.cross(turned_mm));
  H(about_y, about_varus) = path.direction.dot(X.cross(turned_mm));
  H(about_varus, about_varus) = path.direction.dot(X.cross(X.cross(path.end_mm)));
  return H.selfadjointView<Eigen::Upper>();
}

// The same of `-direction . end` for an end on the reference relative to the moving object: the rotation
// about Y is last, and rotations and translation are inverted.
Matrix5d turning_of_reference_end(const FibrePath& path, const MovingPose& pose)
{
  const Eigen::Vector3d X = Eigen::Vector3d::UnitX(), Y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d turned_mm = X.cross(path.end_mm);
  const Eigen::Vector3d pull = -path.direction;
  Matrix5d H = Matrix5d::Zero();
  H.block<3, 1>(0, about_y) = pull.cross(Y);
  H(about_y, about_y) = pull.dot(Y.cross(Y.cross(path.end_mm - pose.translation_mm)));
  H(about_y, about_varus) = pull.dot(Y.cross(turned_mm));
  H(about_varus, about_varus) = pull.dot(X.cross(turned_mm));
  return H.selfadjointView<Eigen::Upper>();
}

void add_path(const FibrePath& path, const LengthEnergy& of_length, const MovingPose& pose, Potential& sum)
{
  const Eigen::Matrix<double, 3, 5> J = point_jacobian(path.end_mm, pose);
  const Vector5d slope = J.transpose() * path.direction;
  const Matrix5d turning = path.end_body == BodyIndex::moving ? turning_of_moving_end(path, pose)
                                                              : turning_of_reference_end(path, pose);
  const Matrix5d bending = J.transpose() * path.bending * J;
  sum.energy_nmm += of_length.energy_nmm;
  sum.gradient += of_length.force_n * slope;
  sum.hessian +=
      of_length.stiffness_n_mm * (slope * slope.transpose()) + of_length.force_n * (bending + turning);
}

// J^T B J is symmetric up to rounding only.
Potential symmetric(Potential sum)
{
  sum.hessian.triangularView<Eigen::StrictlyLower>() = sum.hessian.transpose();
  return sum;
}

}  // namespace

std::string ligament_of(const std::string& bundle)
{
  std::string name = bundle;
  for (char& c : name) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  for (const char* known : knee_ligaments) {
    if (name.find(known) != std::string::npos) return known;
  }
  return bundle;
}

Ligaments solver_ligaments(const Ligaments& canonical, const SolverFrame& frame)
{
  const ToSolver map = to_solver(frame);
  Ligaments out = canonical;
  for (Fibre& fibre : out.fibres) {
    fibre.reference_mm = map.point(fibre.reference_mm);
    fibre.moving_mm = map.point(fibre.moving_mm);
  }
  for (Wrap& wrap : out.wraps) {
    const Eigen::Vector3d centre_mm = wrap.X_body_wrap.translation();
    wrap.X_body_wrap.linear() = map.rotation(wrap.X_body_wrap.linear());
    wrap.X_body_wrap.translation() = map.point(centre_mm);
  }
  return out;
}

Ligaments ligaments_between(const Ligaments& canonical, BodyIndex fixed, BodyIndex moved,
                            const BodyPoses& placed)
{
  const auto X_fixed = [&](BodyIndex body) {
    return body == fixed ? Pose(Pose::Identity())
                         : Pose(placed.at(row_of(fixed)).inverse() * placed.at(row_of(body)));
  };
  Ligaments out;
  out.transition_strain = canonical.transition_strain;
  out.wraps = canonical.wraps;
  for (Wrap& wrap : out.wraps) {
    const bool is_on_moved = wrap.body == moved;
    if (!is_on_moved) wrap.X_body_wrap = X_fixed(wrap.body) * wrap.X_body_wrap;
    wrap.body = is_on_moved ? BodyIndex::moving : BodyIndex::reference;
  }
  for (const Fibre& fibre : canonical.fibres) {
    if ((fibre.from == moved) == (fibre.to == moved)) continue;
    Fibre between = fibre;
    const bool is_turned = fibre.from == moved;
    between.reference_mm =
        is_turned ? X_fixed(fibre.to) * fibre.moving_mm : X_fixed(fibre.from) * fibre.reference_mm;
    between.moving_mm = is_turned ? fibre.reference_mm : fibre.moving_mm;
    between.from = BodyIndex::reference;
    between.to = BodyIndex::moving;
    out.fibres.push_back(std::move(between));
  }
  return out;
}

Tension tension_of(double strain, double stiffness_n, double transition_strain)
{
  if (!(strain > 0.0)) return {};
  if (strain < transition_strain) {
    const double slope_n = stiffness_n * strain / transition_strain;
    return {0.5 * slope_n * strain, slope_n, slope_n * strain * strain / 6.0};
  }
  const double toe_energy_n = stiffness_n * transition_strain * transition_strain / 6.0;
  const double force_n = stiffness_n * (strain - 0.5 * transition_strain);
  // Beyond the toe the force is linear: its mean times the additional strain.
  const double mean_force_n = 0.5 * (0.5 * stiffness_n * transition_strain + force_n);
  return {force_n, stiffness_n, toe_energy_n + mean_force_n * (strain - transition_strain)};
}

LengthEnergy energy_of(const Fibre& fibre, double length_mm, double transition_strain)
{
  if (fibre.tension_n > 0.0) return {fibre.tension_n * length_mm, fibre.tension_n, 0.0};
  const Tension tension = tension_of(strain_of(fibre, length_mm), fibre.stiffness_n, transition_strain);
  return {tension.energy_n * fibre.slack_length_mm, tension.force_n,
          tension.stiffness_n / fibre.slack_length_mm};
}

std::vector<FibreState> fibre_states(const Ligaments& ligaments, const Attitude& attitude,
                                     const MovingPose& pose)
{
  const JointPlacement placement = joint_placement(attitude, pose);
  std::vector<FibreState> states;
  states.reserve(ligaments.fibres.size());
  for (const Fibre& fibre : ligaments.fibres) {
    const FibrePath path = fibre_path(fibre, ligaments.wraps, placement);
    const LengthEnergy energy = energy_of(fibre, path.length_mm, ligaments.transition_strain);
    states.push_back({path.length_mm, strain_of(fibre, path.length_mm), energy.force_n, energy.energy_nmm,
                      path.is_wrapped});
  }
  return states;
}

Potential ligament_energy(const Ligaments& ligaments, const Attitude& attitude, const MovingPose& pose)
{
  const JointPlacement placement = joint_placement(attitude, pose);
  Potential sum;
  for (const Fibre& fibre : ligaments.fibres) {
    const FibrePath path = taut_path(fibre, ligaments.wraps, placement);
    const LengthEnergy energy = energy_of(fibre, path.length_mm, ligaments.transition_strain);
    if (energy.force_n > 0.0) add_path(path, energy, pose, sum);
  }
  return symmetric(sum);
}

namespace {

FibrePath straight_path(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm)
{
  FibrePath path;
  path.end_mm = to_mm;
  const Eigen::Vector3d span_mm = to_mm - from_mm;
  path.length_mm = span_mm.norm();
  if (path.length_mm == 0.0) return path;
  path.direction = span_mm / path.length_mm;
  path.bending = (Eigen::Matrix3d::Identity() - path.direction * path.direction.transpose()) / path.length_mm;
  return path;
}

/// Path around the fibre's wrap, in the wrap's frame. It starts at the object with the wrap, so that its end
/// moves relative to the wrap.
WrapPath wrapped_path(const Fibre& fibre, const Wrap& wrap, const JointPlacement& placement, double slack_mm)
{
  const Eigen::Matrix3d R_moving_S = placement.R_S_moving.transpose();
  const auto in_wrap = [&](const Eigen::Vector3d& p_body_mm) {
    return Eigen::Vector3d(wrap.X_body_wrap.linear().transpose() *
                           (p_body_mm - wrap.X_body_wrap.translation()));
  };
  Eigen::Vector3d start_mm, end_mm;
  if (wrap.body == BodyIndex::moving) {
    start_mm = in_wrap(fibre.moving_mm);
    end_mm = in_wrap(R_moving_S * (placement.R_S_reference * fibre.reference_mm - placement.t_S_moving_mm));
  } else {
    const Eigen::Vector3d moving_mm = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
    start_mm = in_wrap(fibre.reference_mm);
    end_mm = in_wrap(placement.R_S_reference.transpose() * moving_mm);
  }
  switch (wrap.shape) {
    case WrapShape::cylinder:
      return cylinder_path(start_mm, end_mm, wrap.radii_mm.x(), wrap.radii_mm.z(),
                           fibre.tension_n > 0.0 ? EndInside::straight : EndInside::around);
    case WrapShape::ellipsoid:
      return ellipsoid_path(start_mm, end_mm, wrap.radii_mm, slack_mm);
  }
  return {};
}

}  // namespace

Potential line_energy(std::span<const TensionLine> lines, const Attitude& attitude, const MovingPose& pose)
{
  const JointPlacement placement = joint_placement(attitude, pose);
  Potential sum;
  for (const TensionLine& line : lines) {
    const FibrePath path = straight_path(placement.R_S_reference * line.reference_mm,
                                         placement.t_S_moving_mm + placement.R_S_moving * line.moving_mm);
    add_path(path, {line.tension_n * path.length_mm, line.tension_n, 0.0}, pose, sum);
  }
  return symmetric(sum);
}

Potential point_force_energy(const Eigen::Vector3d& force_reference_n, const Eigen::Vector3d& point_moving_mm,
                             const Attitude& attitude, const MovingPose& pose)
{
  const JointPlacement placement = joint_placement(attitude, pose);
  // Minus the position along the force is a path's length without bending.
  FibrePath path;
  path.direction = -(placement.R_S_reference * force_reference_n);
  path.end_mm = placement.t_S_moving_mm + placement.R_S_moving * point_moving_mm;
  Potential sum;
  add_path(path, {path.direction.dot(path.end_mm), 1.0, 0.0}, pose, sum);
  return sum;
}

JointPlacement joint_placement(const Attitude& attitude, const MovingPose& pose)
{
  return {reference_rotation(attitude), rotation_y(pose.theta_rad), pose.translation_mm};
}

namespace {

// A path that is certainly at most `slack_mm` long may have an upper bound of its length alone.
FibrePath path_unless_slack(const Fibre& fibre, const std::vector<Wrap>& wraps,
                            const JointPlacement& placement, double slack_mm)
{
  const Eigen::Vector3d reference_mm = placement.R_S_reference * fibre.reference_mm;
  const Eigen::Vector3d moving_mm = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
  if (fibre.wrap < 0) return straight_path(reference_mm, moving_mm);
  const Wrap& wrap = wraps[static_cast<std::size_t>(fibre.wrap)];
  const WrapPath wrapped = wrapped_path(fibre, wrap, placement, slack_mm);
  if (!wrapped.is_wrapped) return straight_path(reference_mm, moving_mm);
  const bool is_on_moving = wrap.body == BodyIndex::moving;
  const Eigen::Matrix3d R_S_wrap =
      (is_on_moving ? placement.R_S_moving : placement.R_S_reference) * wrap.X_body_wrap.linear();
  FibrePath path;
  path.length_mm = wrapped.length_mm;
  path.is_wrapped = true;
  path.direction =
      R_S_wrap * (is_on_moving ? Eigen::Vector3d(-wrapped.end_direction) : wrapped.end_direction);
  path.end_mm = is_on_moving ? reference_mm : moving_mm;
  path.end_body = is_on_moving ? BodyIndex::reference : BodyIndex::moving;
  path.bending = R_S_wrap * wrapped.bending * R_S_wrap.transpose();
  return path;
}

}  // namespace

FibrePath fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps, const JointPlacement& placement)
{
  return path_unless_slack(fibre, wraps, placement, 0.0);
}

FibrePath taut_path(const Fibre& fibre, const std::vector<Wrap>& wraps, const JointPlacement& placement)
{
  return path_unless_slack(fibre, wraps, placement, fibre.tension_n > 0.0 ? 0.0 : fibre.slack_length_mm);
}

SampledFibre sample_fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps,
                               const JointPlacement& placement, std::span<Eigen::Vector3d> points_mm)
{
  check(points_mm.size() >= 4, "points_mm has room for four points");
  points_mm.front() = placement.R_S_reference * fibre.reference_mm;
  points_mm.back() = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
  const Eigen::Vector3d start_mm = points_mm.front(), span_mm = points_mm.back() - start_mm;
  const std::size_t last = points_mm.size() - 1;
  const WrapPath wrapped =
      fibre.wrap < 0 ? WrapPath{}
                     : wrapped_path(fibre, wraps[static_cast<std::size_t>(fibre.wrap)], placement, 0.0);
  if (!wrapped.is_wrapped) {
    for (std::size_t k = 1; k < last; ++k)
      points_mm[k] = start_mm + static_cast<double>(k) / static_cast<double>(last) * span_mm;
    return {span_mm.norm(), false};
  }
  const Wrap& wrap = wraps[static_cast<std::size_t>(fibre.wrap)];
  const bool is_on_moving = wrap.body == BodyIndex::moving;
  for (std::size_t k = 1; k < last; ++k) {
    // The path starts at the object with the wrap; the points start at the reference.
    const double part = static_cast<double>(k - 1) / static_cast<double>(last - 2);
    const double along_mm = (is_on_moving ? 1.0 - part : part) * wrapped.arc_mm;
    const Eigen::Vector3d p_body_mm =
        wrap.X_body_wrap * (wrap.shape == WrapShape::cylinder
                                ? cylinder_point_mm(wrapped, along_mm)
                                : ellipsoid_point_mm(wrapped, along_mm, wrap.radii_mm));
    points_mm[k] = is_on_moving ? Eigen::Vector3d(placement.t_S_moving_mm + placement.R_S_moving * p_body_mm)
                                : Eigen::Vector3d(placement.R_S_reference * p_body_mm);
  }
  return {wrapped.length_mm, true};
}

// Shortest path around a cylinder along Z, its tangent points and points on it; lengths in mm.

namespace {

// Nearer to the axis than this part of the radius a path is straight.
constexpr double least_end_radius = 1e-3;

// Tangent point on the unit circle of the line from `p`, on the side of increasing (turn = 1) or decreasing
// (turn = -1) angle from p's own.
Eigen::Vector2d tangent_point(const Eigen::Vector2d& p, double turn)
{
  const double square = p.squaredNorm();
  const double root = std::sqrt(std::max(0.0, square - 1.0));
  return (p + turn * root * Eigen::Vector2d(-p.y(), p.x())) / square;
}

}  // namespace

WrapPath cylinder_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm, double radius_mm,
                       double half_length_mm, EndInside end_inside)
{
  Eigen::Vector2d start = start_mm.head<2>() / radius_mm, end = end_mm.head<2>() / radius_mm;
  double start_sq = start.squaredNorm(), end_sq = end.squaredNorm();
  if (start_sq < 1.0) return {};
  const bool is_end_inside = end_sq < 1.0;
  if (is_end_inside) {
    const double part = std::sqrt(end_sq);
    if (end_inside == EndInside::straight || !(part > least_end_radius)) return {};
    radius_mm *= part;
    start /= part;
    end /= part;
    start_sq /= end_sq;
    end_sq = 1.0;
  }
  const double turn = start.x() * end.y() - start.y() * end.x() >= 0.0 ? 1.0 : -1.0;
  const double between_rad =
      arc_tangent2(std::abs(start.x() * end.y() - start.y() * end.x()), start.dot(end));
  const double arc_rad =
      between_rad - arc_cosine(1.0 / std::sqrt(start_sq)) - arc_cosine(1.0 / std::sqrt(end_sq));
  if (!(arc_rad > 0.0)) return {};
  // In the unrolled surface the path is one straight line over tangent, arc and tangent.
  const double first_mm = radius_mm * std::sqrt(start_sq - 1.0),
               last_mm = radius_mm * std::sqrt(end_sq - 1.0);
  const double across_mm = first_mm + radius_mm * arc_rad + last_mm;
  const double rise_mm = end_mm.z() - start_mm.z();
  const double touch_z_mm = start_mm.z() + rise_mm * (first_mm / across_mm);
  const double leave_z_mm = end_mm.z() - rise_mm * (last_mm / across_mm);
  const bool is_above = std::min(touch_z_mm, leave_z_mm) > half_length_mm;
  const bool is_below = std::max(touch_z_mm, leave_z_mm) < -half_length_mm;
  if (is_above || is_below) return {};
  WrapPath path;
  path.is_wrapped = true;
  path.length_mm = std::sqrt(across_mm * across_mm + rise_mm * rise_mm);
  path.radius_mm = radius_mm;
  const Eigen::Vector2d normal = is_end_inside ? end : tangent_point(end, -turn);
  const double cosine_rise = across_mm / path.length_mm, sine_rise = rise_mm / path.length_mm;
  path.end_direction << -turn * cosine_rise * normal.y(), turn * cosine_rise * normal.x(), sine_rise;
  const Eigen::Vector3d n(normal.x(), normal.y(), 0.0);
  if (is_end_inside) {
    // The radius is the end's: d(across) = turn * radius * d(angle) + arc_rad * d(radius).
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ(), t = z.cross(n);
    const Eigen::Vector3d across = arc_rad * n + turn * t;
    path.end_direction += cosine_rise * arc_rad * n;
    const Eigen::Matrix3d curved =
        n * n.transpose() / std::max(first_mm, 1e-9 * radius_mm) + arc_rad / radius_mm * t * t.transpose();
    path.bending = (across * across.transpose() + across_mm * curved + z * z.transpose() -
                    path.end_direction * path.end_direction.transpose()) /
                   path.length_mm;
  } else {
    const Eigen::Vector3d b = path.end_direction.cross(n);
    const double free_mm = std::max(last_mm / cosine_rise, 1e-9 * radius_mm);
    path.bending = n * n.transpose() / free_mm + b * b.transpose() / path.length_mm;
  }
  const Eigen::Vector2d touch = tangent_point(start, turn);
  path.touch_mm << radius_mm * touch, touch_z_mm;
  path.start_direction << -turn * cosine_rise * touch.y(), turn * cosine_rise * touch.x(), sine_rise;
  path.arc_mm = radius_mm * arc_rad / cosine_rise;
  return path;
}

Eigen::Vector3d cylinder_point_mm(const WrapPath& path, double along_mm)
{
  const Eigen::Vector2d touch_mm = path.touch_mm.head<2>();
  const Eigen::Vector2d left_mm(-touch_mm.y(), touch_mm.x());
  const SinCos turn =
      sin_cos(along_mm * path.start_direction.head<2>().dot(left_mm) / (path.radius_mm * path.radius_mm));
  Eigen::Vector3d point_mm;
  point_mm << turn.cos * touch_mm + turn.sin * left_mm,
      path.touch_mm.z() + along_mm * path.start_direction.z();
  return point_mm;
}

// Shortest path around an ellipsoid: a geodesic between two tangent points; axes along X, Y, Z, lengths in
// mm.

namespace {

using Eigen::Vector4d;

constexpr int max_steps = 2000;
// The largest angle of an integration step; with fine steps errors of the length are at most 1e-8 mm.
constexpr double step_rad = 0.25;
constexpr double integration_mm = 1e-8;

/// A point of a geodesic with its Jacobi field. Positions are scaled to the unit sphere: q = p / half-axes.
struct GeodesicState {
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
  Eigen::Vector3d q_slope = Eigen::Vector3d::Zero();  ///< derivative over the length, 1/mm
  double width = 0.0;                                 ///< Jacobi field: distance of a neighbouring geodesic
  double width_slope = 0.0;
};

// State of the ODE: scaled position and width, y'' = -w^-2 rate y for both.
struct OdeState {
  Vector4d y, slope;
};

struct Ellipsoid {
  Eigen::Vector3d inverse_sq;  // 1 / a^2
  Vector4d rate;               // C / a^2, and 1 / (a b c)^2 for the width

  double w(const Vector4d& y) const
  {
    return inverse_sq.x() * y.x() * y.x() + inverse_sq.y() * y.y() * y.y() + inverse_sq.z() * y.z() * y.z();
  }

  Vector4d acceleration(const Vector4d& y) const
  {
    const double w_now = w(y);
    return (-1.0 / (w_now * w_now)) * rate.cwiseProduct(y);
  }
};

// Stoermer's rule divides a step into 1, 2, ... parts; the results are extrapolated to parts of length 0: the
// order is twice the number of divisions.
constexpr int coarse = 3, fine = 6;

template <int n_divisions>
constexpr std::array<double, n_divisions> extrapolation()
{
  std::array<double, n_divisions> weights{};
  for (int n = 1; n <= n_divisions; ++n) {
    double weight = 1.0;
    for (int m = 1; m <= n_divisions; ++m)
      weight *= m == n ? 1.0 : n * n / static_cast<double>(n * n - m * m);
    weights[static_cast<std::size_t>(n - 1)] = weight;
  }
  return weights;
}

// Source: Hairer, Noersett, Wanner (1993), II.14.
template <int n_divisions>
OdeState step(const OdeState& at, double h, const Ellipsoid& surface)
{
  static constexpr std::array<double, n_divisions> weights = extrapolation<n_divisions>();
  const Vector4d first = surface.acceleration(at.y);
  OdeState sum{Vector4d::Zero(), Vector4d::Zero()};
  for (int n = 1; n <= n_divisions; ++n) {
    const double part = h / n, weight = weights[static_cast<std::size_t>(n - 1)];
    Vector4d change = part * at.slope + (0.5 * part * part) * first;
    Vector4d y = at.y + change;
    for (int i = 1; i < n; ++i) {
      change += (part * part) * surface.acceleration(y);
      y += change;
    }
    sum.y += weight * y;
    sum.slope += (weight / part) * change + (0.5 * weight * part) * surface.acceleration(y);
  }
  return sum;
}

/// Integrates the geodesic by `length_mm`, backwards if negative. With q scaled and Joachimsthal's invariant
/// C the equation is q'' = -C w^-2 q / a^2 with w = sum of q^2 / a^2; the width follows Jacobi's equation.
GeodesicState integrate_geodesic(const GeodesicState& from, double length_mm,
                                 const Eigen::Vector3d& half_axes_mm, bool is_fine)
{
  Ellipsoid surface;
  surface.inverse_sq = half_axes_mm.cwiseProduct(half_axes_mm).cwiseInverse();
  OdeState state;
  state.y << from.q, from.width;
  state.slope << from.q_slope, from.width_slope;
  const double invariant = surface.w(state.y) * from.q_slope.squaredNorm();
  surface.rate << invariant * surface.inverse_sq, surface.inverse_sq.prod();
  // The largest angle per length is sqrt(C) / (smallest half-axis * w): steps are short where w is small.
  const double pace = step_rad / std::sqrt(invariant * surface.inverse_sq.maxCoeff());
  double left_mm = length_mm;
  for (int i = 0; i < max_steps && left_mm != 0.0; ++i) {
    const double longest_mm = pace * surface.w(state.y);
    const bool is_last = std::abs(left_mm) <= longest_mm;
    const double h_mm = is_last                                 ? left_mm
                        : std::abs(left_mm) <= 2.0 * longest_mm ? 0.5 * left_mm
                                                                : std::copysign(longest_mm, left_mm);
    state = is_fine ? step<fine>(state, h_mm, surface) : step<coarse>(state, h_mm, surface);
    left_mm = is_last ? 0.0 : left_mm - h_mm;
  }
  return {state.y.head<3>(), state.slope.head<3>(), state.y.w(), state.slope.w()};
}

/// Two points outside an ellipsoid, scaled so that it is the unit sphere (q = p / half-axes), and the
/// straight line between them.
struct WrapProblem {
  Eigen::Vector3d half_axes_mm = Eigen::Vector3d::Ones();
  Eigen::Vector3d start, end;        ///< scaled
  Eigen::Vector3d along;             ///< unit, from start to end
  Eigen::Vector3d outward;           ///< unit, from the centre to the line's nearest point
  Eigen::Vector3d sideways;          ///< unit, completing the axes
  double depth = 0.0;                ///< distance of the line from the centre, below 1
  double before = 0.0, after = 0.0;  ///< distances of both points from the line's nearest point

  Eigen::Vector3d mm(const Eigen::Vector3d& q) const { return half_axes_mm.cwiseProduct(q); }
};

/// A unit vector perpendicular to a unit vector; deterministic.
Eigen::Vector3d any_perpendicular(const Eigen::Vector3d& unit)
{
  const Eigen::Vector3d trial =
      std::abs(unit.x()) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  return (trial - trial.dot(unit) * unit).normalized();
}

/// Computes `along` and the members after it. False when the straight line misses the ellipsoid.
bool set_straight_line(WrapProblem& scene)
{
  const Eigen::Vector3d span = scene.end - scene.start;
  const double length = span.norm();
  if (length == 0.0) return false;
  scene.along = span / length;
  scene.before = -scene.start.dot(scene.along);
  scene.after = scene.end.dot(scene.along);
  const Eigen::Vector3d nearest = scene.start + scene.before * scene.along;
  scene.depth = nearest.norm();
  if (!(scene.before > 0.0 && scene.after > 0.0 && scene.depth < 1.0)) return false;
  // For a line through the centre any plane is valid.
  scene.outward =
      scene.depth > 1e-12 ? Eigen::Vector3d(nearest / scene.depth) : any_perpendicular(scene.along);
  scene.sideways = scene.outward.cross(scene.along);
  return true;
}

// Planar paths (tangent, arc, tangent) in half-planes bounded by the straight line, `n` at once. A plane cuts
// the unit sphere in a circle, whose top is its point farthest from the line.
template <int n>
using PerPlane = Eigen::Array<double, n, 1>;

/// One side of the tops, up to an attachment.
template <int n>
struct PlanarSides {
  PerPlane<n> sine, cosine;  ///< of the angle between the top and the tangent point
  PerPlane<n> free_mm, arc_mm;
  PerPlane<n> enclosing_mm;  ///< from the attachment along its tangent to that of the top
};

template <int n>
struct PlanarPaths {
  PerPlane<n> up, across;      ///< of the circle's top: along `outward` and `sideways`
  PerPlane<n> height, radius;  ///< of the line over the circle's centre, and of the circle
  PlanarSides<n> first, last;

  PerPlane<n> length_mm() const { return first.free_mm + first.arc_mm + last.arc_mm + last.free_mm; }
};

// Evenly around the straight line, the first plane through `outward`.
template <int n>
PlanarPaths<n> planar_paths(const WrapProblem& scene)
{
  static const PlanarPaths<n> planes = [] {
    PlanarPaths<n> out;
    for (int i = 0; i < n; ++i) {
      const SinCos tilt = sin_cos(i * (2.0 * pi / n));
      out.up(i) = tilt.cos;
      out.across(i) = tilt.sin;
    }
    return out;
  }();
  PlanarPaths<n> paths = planes;
  paths.height = scene.depth * paths.up;
  paths.radius = (1.0 - scene.depth * scene.depth + paths.height.square()).max(0.0).sqrt();
  const Eigen::Vector3d along_mm = scene.mm(scene.along), up_mm = scene.mm(scene.outward),
                        across_mm = scene.mm(scene.sideways);
  // Squares and product of the lengths of steps along the line and upwards.
  const double along_sq = along_mm.squaredNorm(), along_norm = std::sqrt(along_sq);
  const PerPlane<n> up_sq = up_mm.squaredNorm() * paths.up.square() +
                            2.0 * up_mm.dot(across_mm) * paths.up * paths.across +
                            across_mm.squaredNorm() * paths.across.square();
  const PerPlane<n> along_up = along_mm.dot(up_mm) * paths.up + along_mm.dot(across_mm) * paths.across;
  const auto side = [&](double distance, double sign) {
    const PerPlane<n>& r = paths.radius;
    const PerPlane<n>& h = paths.height;
    const auto length = [&](const PerPlane<n>& x, const PerPlane<n>& y) {
      return PerPlane<n>(
          (along_sq * x.square() + (2.0 * sign) * along_up * x * y + up_sq * y.square()).sqrt());
    };
    PlanarSides<n> out;
    const PerPlane<n> square = distance * distance + h.square();
    const PerPlane<n> root = (square - r.square()).max(0.0).sqrt();
    out.sine = (r * distance - root * h) / square;
    out.cosine = (r * h + root * distance) / square;
    out.free_mm = length(distance - r * out.sine, h - r * out.cosine);
    // Simpson's rule over the angle, which is four times that of a quarter.
    const PerPlane<n> half_cosine = (0.5 + 0.5 * out.cosine).max(1e-12).sqrt();
    const PerPlane<n> half_sine = 0.5 * out.sine / half_cosine;
    const PerPlane<n> quarter_sine = 0.5 * half_sine / (0.5 + 0.5 * half_cosine).sqrt();
    const PerPlane<n> sq = quarter_sine.square();
    const PerPlane<n> angle =
        4.0 * quarter_sine * (1.0 + sq * (1.0 / 6.0 + sq * (3.0 / 40.0 + sq * (5.0 / 112.0))));
    out.arc_mm = angle * r / 6.0 *
                 (along_norm + 4.0 * length(half_cosine, -half_sine) + length(out.cosine, -out.sine));
    const PerPlane<n> corner = r * half_sine / half_cosine;  // of both tangents, from the top
    out.enclosing_mm = length(distance - corner, h - r) + along_norm * corner;
    return out;
  };
  paths.first = side(scene.before, -1.0);
  paths.last = side(scene.after, 1.0);
  return paths;
}

// Tangent point of plane `i`, scaled; `sign` of the side: -1 before the top, +1 after it.
template <int n>
Eigen::Vector3d tangent_point(const WrapProblem& scene, const PlanarPaths<n>& paths, int i, double sign)
{
  const PlanarSides<n>& side = sign < 0.0 ? paths.first : paths.last;
  const Eigen::Vector3d up = paths.up(i) * scene.outward + paths.across(i) * scene.sideways;
  const double over_centre = paths.radius(i) * side.cosine(i) - paths.height(i);
  return scene.depth * scene.outward + over_centre * up +
         (sign * paths.radius(i) * side.sine(i)) * scene.along;
}

constexpr int max_shots = 30;
// A path that misses the end by this share of the largest half-axis has converged.
constexpr double no_miss = 1e-10;
// Newton steps as shares of the smallest half-axis: fine integration begins; as a share of the last free
// segment too: second derivatives at the end replace the step.
constexpr double near_step = 0.1, small_step = 1e-5;

// Moves a point on the surface slightly outside, so that its tangent points are distinct.
Eigen::Vector3d moved_outside(const Eigen::Vector3d& q)
{
  constexpr double least_square = 1.0 + 1e-12;
  const double square = q.squaredNorm();
  return square < least_square ? Eigen::Vector3d(q * std::sqrt(least_square / square)) : q;
}

// The tangent points of the start form a circle on the sphere, parametrised by an angle.
struct Horizon {
  Eigen::Vector3d start, centre, first, second;  // scaled; the last two have the length of the radius
};

Horizon horizon_of(const Eigen::Vector3d& start, const Eigen::Vector3d& touch)
{
  const double square = start.squaredNorm();
  const Eigen::Vector3d axis = start / std::sqrt(square);
  const Eigen::Vector3d spoke = touch - touch.dot(axis) * axis;
  const Eigen::Vector3d unit =
      spoke.squaredNorm() > 0.0 ? Eigen::Vector3d(spoke.normalized()) : any_perpendicular(axis);
  const double radius = std::sqrt(1.0 - 1.0 / square);
  return {start, start / square, radius * unit, radius * axis.cross(unit)};
}

// The tangent point at an angle.
Eigen::Vector3d on_horizon(const Horizon& horizon, double angle_rad)
{
  const SinCos turn = sin_cos(angle_rad);
  return horizon.centre + turn.cos * horizon.first + turn.sin * horizon.second;
}

struct InitialValues {
  double angle_rad = 0.0;  // round the horizon
  double arc_mm = 0.0;     // on the surface
};

// The path for given initial values, and the miss of its last segment at the end.
struct Shot {
  double first_mm = 0.0;
  double ahead_mm = 0.0;   // derivative of the tangent point over the angle, along the path
  GeodesicState at_leave;  // the width is over the angle, negative at the start
  Eigen::Vector3d direction, normal, across;
  double last_mm = 0.0;  // the end's distance along the direction
  double miss_normal_mm = 0.0, miss_across_mm = 0.0;
};

Shot shoot(const WrapProblem& scene, const Horizon& horizon, const InitialValues& initial, bool is_fine)
{
  const Eigen::Vector3d& a = scene.half_axes_mm;
  const SinCos turn = sin_cos(initial.angle_rad);
  GeodesicState state;
  state.q = horizon.centre + turn.cos * horizon.first + turn.sin * horizon.second;
  const Eigen::Vector3d pace_mm = scene.mm(turn.cos * horizon.second - turn.sin * horizon.first);
  const Eigen::Vector3d free_mm = scene.mm(state.q - horizon.start);
  Shot shot;
  shot.first_mm = free_mm.norm();
  const Eigen::Vector3d v = free_mm / shot.first_mm;
  state.q_slope = v.cwiseQuotient(a);
  state.width = v.cross(state.q.cwiseQuotient(a).normalized()).dot(pace_mm);
  state.width_slope = state.width / shot.first_mm;
  shot.ahead_mm = v.dot(pace_mm);
  shot.at_leave = integrate_geodesic(state, initial.arc_mm, a, is_fine);
  const Eigen::Vector3d end_mm = scene.mm(scene.end - shot.at_leave.q);
  shot.direction = scene.mm(shot.at_leave.q_slope).normalized();
  shot.normal = shot.at_leave.q.cwiseQuotient(a).normalized();
  shot.across = shot.direction.cross(shot.normal);
  shot.last_mm = end_mm.dot(shot.direction);
  shot.miss_normal_mm = end_mm.dot(shot.normal);
  shot.miss_across_mm = end_mm.dot(shot.across);
  return shot;
}

// Newton step for a zero miss. The frame of direction, normal and across rotates by the surface's curvatures
// (Darboux frame).
InitialValues newton_step(const WrapProblem& scene, const InitialValues& initial, const Shot& shot)
{
  const Eigen::Vector3d& a = scene.half_axes_mm;
  const Eigen::Vector3d v = shot.direction.cwiseQuotient(a), b = shot.across.cwiseQuotient(a);
  const double scale = shot.at_leave.q.cwiseQuotient(a).norm();
  const double along = v.dot(v) / scale, side = b.dot(b) / scale, twist = v.dot(b) / scale;
  const double j = shot.at_leave.width, j_slope = shot.at_leave.width_slope;
  // Derivatives of the misses along normal (n) and across (b) over arc and angle.
  const double n_arc = along * shot.last_mm + twist * shot.miss_across_mm;
  const double n_angle = j * (twist * shot.last_mm + side * shot.miss_across_mm);
  const double b_arc = -twist * shot.miss_normal_mm;
  const double b_angle = -j - j_slope * shot.last_mm - side * j * shot.miss_normal_mm;
  const double determinant = n_arc * b_angle - n_angle * b_arc;
  const double angle_rad = (b_arc * shot.miss_normal_mm - n_arc * shot.miss_across_mm) / determinant;
  const double arc_mm = (n_angle * shot.miss_across_mm - b_angle * shot.miss_normal_mm) / determinant -
                        shot.ahead_mm * angle_rad;
  // Far from the solution the step is limited to the neighbourhood of its plane.
  const double longest = 0.3;
  const double damping =
      std::min({1.0, longest / std::abs(angle_rad), longest * a.maxCoeff() / std::abs(arc_mm)});
  InitialValues next = initial;
  next.angle_rad += damping * angle_rad;
  next.arc_mm += damping * arc_mm;
  return next;
}

// No conjugate point up to the end: a local minimum, not a saddle.
bool is_locally_shortest(const InitialValues& initial, const Shot& shot)
{
  return initial.arc_mm >= 0.0 && shot.at_leave.width < 0.0 &&
         shot.at_leave.width + shot.last_mm * shot.at_leave.width_slope < 0.0;
}

// Sets the first point on the surface, the direction there and the arc length.
void set_touch(WrapPath& path, const WrapProblem& scene, const Eigen::Vector3d& touch, double arc_mm)
{
  path.touch_mm = scene.mm(touch);
  path.start_direction = scene.mm(touch - scene.start).normalized();
  path.arc_mm = arc_mm;
}

// The path of a shot that nearly meets the end. `at` are the initial values of one that does; both misses are
// those left.
WrapPath path_of(const WrapProblem& scene, const Horizon& horizon, const InitialValues& at, const Shot& shot,
                 double length_mm)
{
  // For an end on the surface the free segment vanishes; its length is bounded below.
  const double bending_normal = 1.0 / std::max(shot.last_mm, 1e-9 * length_mm);
  const double bending_across =
      shot.at_leave.width_slope / (shot.at_leave.width + shot.last_mm * shot.at_leave.width_slope);
  const double turn_normal = bending_normal * shot.miss_normal_mm;
  const double turn_across = bending_across * shot.miss_across_mm;
  WrapPath path;
  path.is_wrapped = true;
  path.length_mm = length_mm + 0.5 * (turn_normal * shot.miss_normal_mm + turn_across * shot.miss_across_mm);
  path.end_direction = (shot.direction + turn_normal * shot.normal + turn_across * shot.across).normalized();
  path.bending = bending_normal * shot.normal * shot.normal.transpose() +
                 bending_across * shot.across * shot.across.transpose();
  set_touch(path, scene, on_horizon(horizon, at.angle_rad), at.arc_mm);
  return path;
}

// Newton iteration for the geodesic; not wrapped if none is found.
WrapPath geodesic_path(const WrapProblem& scene, const Horizon& horizon, InitialValues initial)
{
  const double no_miss_mm = no_miss * scene.half_axes_mm.maxCoeff();
  const double least_axis_mm = scene.half_axes_mm.minCoeff();
  double least_miss_mm = std::numeric_limits<double>::infinity();
  InitialValues nearest = initial;
  bool is_fine = false;
  for (int i = 0; i < max_shots; ++i) {
    Shot shot = shoot(scene, horizon, initial, is_fine);
    if (shot.last_mm < 0.0) {
      // The arc ends beyond the end's tangent point: the tangent point is about as far before the end.
      initial.arc_mm = std::max(0.0, initial.arc_mm + 2.0 * shot.last_mm);
      continue;
    }
    const double miss_mm = std::abs(shot.miss_normal_mm) + std::abs(shot.miss_across_mm);
    if (miss_mm > least_miss_mm) {  // the step was too long
      initial = {0.5 * (initial.angle_rad + nearest.angle_rad), 0.5 * (initial.arc_mm + nearest.arc_mm)};
      continue;
    }
    least_miss_mm = miss_mm;
    nearest = initial;
    const InitialValues next = newton_step(scene, initial, shot);
    const double step_mm = std::abs(next.arc_mm - initial.arc_mm) +
                           std::abs(shot.at_leave.width * (next.angle_rad - initial.angle_rad));
    const bool is_converged = miss_mm < no_miss_mm;
    if (is_fine && (is_converged || step_mm < small_step * std::min(shot.last_mm, least_axis_mm))) {
      if (!is_locally_shortest(initial, shot)) return {};
      if (is_converged) shot.miss_normal_mm = shot.miss_across_mm = 0.0;
      return path_of(scene, horizon, is_converged ? initial : next, shot,
                     shot.first_mm + initial.arc_mm + shot.last_mm);
    }
    initial = next;
    if (is_fine || step_mm > near_step * least_axis_mm) continue;
    is_fine = true;
    least_miss_mm = std::numeric_limits<double>::infinity();
  }
  return {};
}

constexpr int n_planes = 16;

// Starts from the planar paths that are shorter than both neighbours, or from all. Paths much longer than the
// shortest cannot lead to the shortest geodesic.
WrapPath shortest_geodesic(const WrapProblem& scene, const PlanarPaths<n_planes>& paths, bool from_all)
{
  constexpr double worth_trying = 1.1;
  const PerPlane<n_planes> length_mm = paths.length_mm();
  const double longest_mm = worth_trying * length_mm.minCoeff();
  WrapPath best;
  for (int i = 0; i < n_planes; ++i) {
    if (length_mm(i) > longest_mm) continue;
    const bool is_shorter = length_mm(i) <= length_mm((i + 1) % n_planes) &&
                            length_mm(i) < length_mm((i + n_planes - 1) % n_planes);
    if (!is_shorter && !from_all) continue;
    const Horizon horizon = horizon_of(scene.start, tangent_point(scene, paths, i, -1.0));
    const WrapPath path = geodesic_path(scene, horizon, {0.0, paths.first.arc_mm(i) + paths.last.arc_mm(i)});
    if (path.is_wrapped && (!best.is_wrapped || path.length_mm < best.length_mm)) best = path;
  }
  return best;
}

// The shortest planar path, where no geodesic was found.
WrapPath shortest_planar(const WrapProblem& scene, const PlanarPaths<n_planes>& paths)
{
  int i = 0;
  WrapPath path;
  path.is_wrapped = true;
  path.length_mm = paths.length_mm().minCoeff(&i);
  path.end_direction = scene.mm(scene.end - tangent_point(scene, paths, i, 1.0)).normalized();
  path.bending =
      (Eigen::Matrix3d::Identity() - path.end_direction * path.end_direction.transpose()) / path.length_mm;
  set_touch(path, scene, tangent_point(scene, paths, i, -1.0), paths.first.arc_mm(i) + paths.last.arc_mm(i));
  return path;
}

}  // namespace

WrapPath ellipsoid_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm,
                        const Eigen::Vector3d& half_axes_mm, double slack_mm)
{
  WrapProblem scene;
  scene.half_axes_mm = half_axes_mm;
  scene.start = start_mm.cwiseQuotient(half_axes_mm);
  scene.end = end_mm.cwiseQuotient(half_axes_mm);
  if (scene.start.squaredNorm() < 1.0 || scene.end.squaredNorm() < 1.0) return {};
  scene.start = moved_outside(scene.start);
  scene.end = moved_outside(scene.end);
  if (!set_straight_line(scene)) return {};
  if (slack_mm > 0.0) {
    const PlanarPaths<1> over = planar_paths<1>(scene);
    const double enclosing_mm = over.first.enclosing_mm(0) + over.last.enclosing_mm(0);
    if (enclosing_mm < slack_mm - integration_mm) return {true, enclosing_mm};
  }
  const PlanarPaths<n_planes> paths = planar_paths<n_planes>(scene);
  WrapPath best = shortest_geodesic(scene, paths, false);
  if (!best.is_wrapped) best = shortest_geodesic(scene, paths, true);
  return best.is_wrapped ? best : shortest_planar(scene, paths);
}

Eigen::Vector3d ellipsoid_point_mm(const WrapPath& path, double along_mm, const Eigen::Vector3d& half_axes_mm)
{
  GeodesicState state;
  state.q = path.touch_mm.cwiseQuotient(half_axes_mm);
  state.q_slope = path.start_direction.cwiseQuotient(half_axes_mm);
  return half_axes_mm.cwiseProduct(integrate_geodesic(state, along_mm, half_axes_mm, true).q);
}

}  // namespace vrda::inline model
