#include "devices/sample.hpp"

namespace vrda {

Pose pose_of(const Place& place)
{
  const Eigen::Map<const Eigen::Vector3d> position(place.position_mm);
  const double* q = place.rotation;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  pose.translation() = position;
  return pose;
}

Place place_of(const Pose& pose)
{
  const Eigen::Quaterniond q = Eigen::Quaterniond(pose.linear()).normalized();
  const Eigen::Vector3d& t = pose.translation();
  return {{t.x(), t.y(), t.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

}  // namespace vrda
