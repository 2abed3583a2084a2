#include "player/bench/moves.hpp"

#include "core/units.hpp"

namespace vrda::test {

Eigen::Vector3d random_vector(std::mt19937_64& random, double largest)
{
  std::uniform_real_distribution<double> number(-largest, largest);
  const double x = number(random), y = number(random), z = number(random);
  return {x, y, z};
}

Eigen::Vector3d noise_of(std::mt19937_64& random, double sd)
{
  std::normal_distribution<double> number(0.0, sd);
  const double x = number(random), y = number(random), z = number(random);
  return {x, y, z};
}

Pose random_pose(std::mt19937_64& random)
{
  Pose X = Pose::Identity();
  X.linear() = bench::rotation_of(random_vector(random, pi));
  X.translation() = random_vector(random, 1000.0);
  return X;
}

bench::RigidBody leg_body()
{
  bench::RigidBody body;
  body.markers_mm.resize(6, 3);
  body.markers_mm << 30, 200, -20, -25, 210, 30, 10, 160, 60, 35, -190, 10, -30, -205, -25, 5, -230, 40;
  return body;
}

bench::MarkerRow seen_at(const bench::RigidBody& body, const Pose& X_tracker_body)
{
  bench::MarkerRow row;
  for (Eigen::Index k = 0; k < body.markers_mm.rows(); ++k) {
    const Eigen::Vector3d p_body = body.markers_mm.row(k).transpose();
    row.emplace_back(X_tracker_body * p_body);
  }
  return row;
}

double turn_between_rad(const Pose& a, const Pose& b)
{
  return bench::turn_of(a.linear().transpose() * b.linear()).norm();
}

double distance_mm(const Pose& a, const Pose& b, const Eigen::Vector3d& p_mm)
{
  return (a * p_mm - b * p_mm).norm();
}

}  // namespace vrda::test
