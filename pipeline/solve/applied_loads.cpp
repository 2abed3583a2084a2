#include "solve/applied_loads.hpp"

#include <Eigen/Geometry>

namespace vrda::solve {
namespace {

// Rotation of a load's axes in S.
Eigen::Matrix3d rotation_of(LoadFrame frame, const model::JointPlacement& placement)
{
  switch (frame) {
    case LoadFrame::world:
      return Eigen::Matrix3d::Identity();
    case LoadFrame::reference:
      return placement.R_S_reference;
    case LoadFrame::moving:
      return placement.R_S_moving;
  }
  return Eigen::Matrix3d::Identity();
}

void add(Wrench& sum, const Eigen::Vector3d& at_mm, const Eigen::Vector3d& force_n)
{
  sum.force_n += force_n;
  sum.moment_nmm += at_mm.cross(force_n);
}

Wrench wrench_of(const AppliedLoad& load, const model::JointPlacement& placement)
{
  const Eigen::Matrix3d R = rotation_of(load.frame, placement);
  Wrench sum;
  add(sum, placement.t_S_moving_mm + placement.R_S_moving * load.point_mm, R * load.force_n);
  sum.moment_nmm += R * load.moment_nmm;
  return sum;
}

// Along the coordinates (core/coordinates.hpp): theta turns about the object's own axis, varus about X.
Vector5d generalised(const Wrench& wrench, const MovingPose& pose)
{
  Vector5d force;
  force << wrench.force_n, (wrench.moment_nmm - pose.translation_mm.cross(wrench.force_n)).y(),
      wrench.moment_nmm.x();
  return force;
}

}  // namespace

Wrench wrench_of(const Loads& loads, const Attitude& attitude, const MovingPose& pose)
{
  const model::JointPlacement placement = model::joint_placement(attitude, pose);
  Wrench sum;
  for (const AppliedLoad& load : loads.applied) {
    const Wrench one = wrench_of(load, placement);
    sum.force_n += one.force_n;
    sum.moment_nmm += one.moment_nmm;
  }
  for (const TensionLine& line : loads.lines) {
    const Eigen::Vector3d from_mm = placement.t_S_moving_mm + placement.R_S_moving * line.moving_mm;
    const Eigen::Vector3d to_mm = placement.R_S_reference * line.reference_mm;
    add(sum, from_mm, line.tension_n * (to_mm - from_mm).normalized());
  }
  return sum;
}

LoadPotential potential_near(const Loads& loads, const Attitude& attitude, const MovingPose& pose)
{
  const model::JointPlacement placement = model::joint_placement(attitude, pose);
  LoadPotential out;
  out.lines = loads.lines;
  for (const AppliedLoad& load : loads.applied) {
    AppliedLoad constant = load;
    if (load.frame != LoadFrame::moving) {
      const Eigen::Matrix3d R_S_load = rotation_of(load.frame, placement);
      out.forces.push_back({placement.R_S_reference.transpose() * (R_S_load * load.force_n), load.point_mm});
      constant.force_n.setZero();
    }
    out.constant += generalised(wrench_of(constant, placement), pose);
  }
  return out;
}

Potential energy_of(const LoadPotential& loads, const Attitude& attitude, const MovingPose& pose)
{
  Potential sum = model::line_energy(loads.lines, attitude, pose);
  for (const LoadPotential::PointForce& force : loads.forces) {
    const Potential one =
        model::point_force_energy(force.force_reference_n, force.point_moving_mm, attitude, pose);
    sum.energy_nmm += one.energy_nmm;
    sum.gradient += one.gradient;
    sum.hessian += one.hessian;
  }
  Vector5d at;
  at << pose.translation_mm, pose.theta_rad, attitude.varus_rad;
  sum.energy_nmm -= loads.constant.dot(at);
  sum.gradient -= loads.constant;
  return sum;
}

}  // namespace vrda::solve
