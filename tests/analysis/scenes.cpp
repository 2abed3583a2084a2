#include "analysis/scenes.hpp"

#include <cmath>

#include "analysis/repair.hpp"
#include "core/units.hpp"
#include "support/meshes.hpp"

namespace vrda::test {

double normal_number(std::mt19937_64& generator)
{
  double sum = -6.0;
  for (int k = 0; k < 12; ++k) sum += static_cast<double>(generator() >> 11U) * 0x1p-53;
  return sum;
}

analysis::MeasuredMotion resting_motion(std::size_t n, const Eigen::Vector3d& p_mm)
{
  analysis::MeasuredMotion motion;
  motion.name = "motion.csv";
  for (std::size_t k = 0; k < n; ++k) {
    motion.key.push_back(static_cast<double>(k));
    motion.X_reference_moving.push_back(Pose(Eigen::Translation3d(p_mm)));
  }
  return motion;
}

analysis::MeasurementNoise isotropic_noise(double mm, double deg)
{
  return {Eigen::Vector3d::Constant(rad_from_deg(deg)), Eigen::Vector3d::Constant(mm)};
}

analysis::AuditScene condyle_scene()
{
  Mesh dishes, balls;
  for (const double side_mm : {-20.0, 20.0}) {
    Mesh dish = sheet(30, 12);
    for (Eigen::Index v = 0; v < dish.vertices_mm.rows(); ++v) {
      const double x = dish.vertices_mm(v, 0), z = dish.vertices_mm(v, 2);
      dish.vertices_mm(v, 1) = -(x * x + z * z) / 60.0;
    }
    dish.triangles.col(1).swap(dish.triangles.col(2));
    dish.normals = vertex_normals(dish);
    append(dishes, transformed(dish, Pose(Eigen::Translation3d(0, 10, side_mm))));
    append(balls, transformed(ball(10), Pose(Eigen::Translation3d(0, -5, side_mm))));
  }
  return analysis::make_audit_scene(dishes, balls, {});
}

std::vector<Pose> contact_motion(const analysis::AuditScene& scene, std::size_t n, std::mt19937_64& generator)
{
  const auto share = [&generator] { return static_cast<double>(generator() >> 11U) * 0x1p-53; };
  std::array<double, 5> size{}, phase{};
  for (std::size_t c = 0; c < 5; ++c) {
    size[c] = 1.0 + 3.0 * share();
    phase[c] = 2.0 * pi * share();
  }
  analysis::PoseMeter meter(scene);
  std::vector<Pose> X;
  for (std::size_t k = 0; k < n; ++k) {
    const double turn = pi * static_cast<double>(k) / static_cast<double>(n);
    const auto value = [&](std::size_t c) { return size[c] * sine(turn + phase[c]); };
    const Attitude attitude{rad_from_deg(4.0 * value(0)), rad_from_deg(0.5 * value(1))};
    MovingPose pose{{value(2), 0.0, value(3)}, rad_from_deg(value(4))};
    pose.translation_mm.y() +=
        meter.travel_into_contact_mm(attitude, X_reference_moving(scene.frame, attitude, pose));
    X.push_back(X_reference_moving(scene.frame, attitude, pose));
  }
  return X;
}

std::vector<Pose> with_noise(const std::vector<Pose>& X_true, const analysis::MeasurementNoise& noise,
                             std::mt19937_64& generator)
{
  const analysis::NoiseScale scale = analysis::noise_scale({}, noise);
  std::vector<Pose> X;
  for (const Pose& pose : X_true) {
    analysis::Vector6d error;
    for (Eigen::Index c = 0; c < 6; ++c) error(c) = normal_number(generator);
    X.push_back(analysis::displaced(pose, error, scale));
  }
  return X;
}

double distance_from(const std::vector<Pose>& X_true, const std::vector<Pose>& X,
                     const analysis::MeasurementNoise& noise)
{
  double sum = 0.0;
  for (std::size_t k = 0; k < X.size(); ++k) {
    const Eigen::Vector3d turn =
        analysis::rotation_vector(Eigen::Matrix3d(X[k].linear()) * X_true[k].linear().transpose());
    const Eigen::Vector3d shift = X[k].translation() - X_true[k].translation();
    sum += turn.cwiseQuotient(noise.rotation_rad).squaredNorm() +
           shift.cwiseQuotient(noise.translation_mm).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(X.size()));
}

std::vector<Pose> poses_of(const analysis::RepairedMotion& motion)
{
  std::vector<Pose> X;
  for (const analysis::RepairedFrame& frame : motion.frames) X.push_back(frame.X_reference_moving);
  return X;
}

}  // namespace vrda::test
