#include "model/ligaments.hpp"

#include "core/error.hpp"
#include "model/wrap_path.hpp"

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

double strain_of(const Fibre& fibre, const FibrePath& path)
{
  return (path.length_mm - fibre.slack_length_mm) / fibre.slack_length_mm;
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

// The energy of a path as a function of its length.
struct PathEnergy {
  double energy_nmm = 0.0;
  double force_n = 0.0;         // first derivative
  double stiffness_n_mm = 0.0;  // second derivative
};

void add_path(const FibrePath& path, const PathEnergy& of_length, const MovingPose& pose, Potential& sum)
{
  const Eigen::Matrix<double, 3, 5> J = point_jacobian(path.end_mm, pose);
  const Vector5d slope = J.transpose() * path.direction;
  const Matrix5d turning = path.end_body == WrapBody::moving ? turning_of_moving_end(path, pose)
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

std::vector<FibreState> fibre_states(const Ligaments& ligaments, const Attitude& attitude,
                                     const MovingPose& pose)
{
  const JointPlacement placement = joint_placement(attitude, pose);
  std::vector<FibreState> states;
  states.reserve(ligaments.fibres.size());
  for (const Fibre& fibre : ligaments.fibres) {
    const FibrePath path = fibre_path(fibre, ligaments.wraps, placement);
    const double strain = strain_of(fibre, path);
    const Tension tension = tension_of(strain, fibre.stiffness_n, ligaments.transition_strain);
    states.push_back(
        {path.length_mm, strain, tension.force_n, tension.energy_n * fibre.slack_length_mm, path.is_wrapped});
  }
  return states;
}

Potential ligament_energy(const Ligaments& ligaments, const Attitude& attitude, const MovingPose& pose)
{
  const JointPlacement placement = joint_placement(attitude, pose);
  Potential sum;
  for (const Fibre& fibre : ligaments.fibres) {
    const FibrePath path = fibre_path(fibre, ligaments.wraps, placement);
    const Tension tension =
        tension_of(strain_of(fibre, path), fibre.stiffness_n, ligaments.transition_strain);
    if (tension.force_n > 0.0) {
      add_path(path,
               {tension.energy_n * fibre.slack_length_mm, tension.force_n,
                tension.stiffness_n / fibre.slack_length_mm},
               pose, sum);
    }
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
WrapPath wrapped_path(const Fibre& fibre, const Wrap& wrap, const JointPlacement& placement)
{
  const Eigen::Matrix3d R_moving_S = placement.R_S_moving.transpose();
  const auto in_wrap = [&](const Eigen::Vector3d& p_body_mm) {
    return Eigen::Vector3d(wrap.X_body_wrap.linear().transpose() *
                           (p_body_mm - wrap.X_body_wrap.translation()));
  };
  Eigen::Vector3d start_mm, end_mm;
  if (wrap.body == WrapBody::moving) {
    start_mm = in_wrap(fibre.moving_mm);
    end_mm = in_wrap(R_moving_S * (placement.R_S_reference * fibre.reference_mm - placement.t_S_moving_mm));
  } else {
    const Eigen::Vector3d moving_mm = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
    start_mm = in_wrap(fibre.reference_mm);
    end_mm = in_wrap(placement.R_S_reference.transpose() * moving_mm);
  }
  switch (wrap.shape) {
    case WrapShape::cylinder:
      return cylinder_path(start_mm, end_mm, wrap.radii_mm.x(), wrap.radii_mm.z());
    case WrapShape::ellipsoid:
      return ellipsoid_path(start_mm, end_mm, wrap.radii_mm);
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

FibrePath fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps, const JointPlacement& placement)
{
  const Eigen::Vector3d reference_mm = placement.R_S_reference * fibre.reference_mm;
  const Eigen::Vector3d moving_mm = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
  if (fibre.wrap < 0) return straight_path(reference_mm, moving_mm);
  const Wrap& wrap = wraps[static_cast<std::size_t>(fibre.wrap)];
  const WrapPath wrapped = wrapped_path(fibre, wrap, placement);
  if (!wrapped.is_wrapped) return straight_path(reference_mm, moving_mm);
  const bool is_on_moving = wrap.body == WrapBody::moving;
  const Eigen::Matrix3d R_S_wrap =
      (is_on_moving ? placement.R_S_moving : placement.R_S_reference) * wrap.X_body_wrap.linear();
  FibrePath path;
  path.length_mm = wrapped.length_mm;
  path.is_wrapped = true;
  path.direction =
      R_S_wrap * (is_on_moving ? Eigen::Vector3d(-wrapped.end_direction) : wrapped.end_direction);
  path.end_mm = is_on_moving ? reference_mm : moving_mm;
  path.end_body = is_on_moving ? WrapBody::reference : WrapBody::moving;
  path.bending = R_S_wrap * wrapped.bending * R_S_wrap.transpose();
  return path;
}

SampledFibre sample_fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps,
                               const JointPlacement& placement, std::span<Eigen::Vector3d> points_mm)
{
  check(points_mm.size() >= 4, "points_mm has room for four points");
  points_mm.front() = placement.R_S_reference * fibre.reference_mm;
  points_mm.back() = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
  const Eigen::Vector3d start_mm = points_mm.front(), span_mm = points_mm.back() - start_mm;
  const std::size_t last = points_mm.size() - 1;
  const WrapPath wrapped = fibre.wrap < 0
                               ? WrapPath{}
                               : wrapped_path(fibre, wraps[static_cast<std::size_t>(fibre.wrap)], placement);
  if (!wrapped.is_wrapped) {
    for (std::size_t k = 1; k < last; ++k)
      points_mm[k] = start_mm + static_cast<double>(k) / static_cast<double>(last) * span_mm;
    return {span_mm.norm(), false};
  }
  const Wrap& wrap = wraps[static_cast<std::size_t>(fibre.wrap)];
  const bool is_on_moving = wrap.body == WrapBody::moving;
  for (std::size_t k = 1; k < last; ++k) {
    // The path starts at the object with the wrap; the points start at the reference.
    const double part = static_cast<double>(k - 1) / static_cast<double>(last - 2);
    const double along_mm = (is_on_moving ? 1.0 - part : part) * wrapped.arc_mm;
    const Eigen::Vector3d p_body_mm =
        wrap.X_body_wrap * (wrap.shape == WrapShape::cylinder
                                ? cylinder_point_mm(wrapped, along_mm, wrap.radii_mm.x())
                                : ellipsoid_point_mm(wrapped, along_mm, wrap.radii_mm));
    points_mm[k] = is_on_moving ? Eigen::Vector3d(placement.t_S_moving_mm + placement.R_S_moving * p_body_mm)
                                : Eigen::Vector3d(placement.R_S_reference * p_body_mm);
  }
  return {wrapped.length_mm, true};
}

}  // namespace vrda::inline model
