#include "devices/sample.hpp"

namespace vrda {

Pose pose_of(const Place& place)
{
  const double* q = place.rotation;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(place.position_mm[0], place.position_mm[1], place.position_mm[2]);
  return X;
}

Place place_of(const Pose& pose)
{
  const Eigen::Quaterniond q = Eigen::Quaterniond(Eigen::Matrix3d(pose.linear())).normalized();
  const Eigen::Vector3d p = pose.translation();
  return {{p.x(), p.y(), p.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

}  // namespace vrda
