// The points of jobs/bench-desk.toml are on the bones of the knee that jobs/knee-generic.toml generates.
#include <gtest/gtest.h>

#include <algorithm>

#include "bench/bench_file.hpp"
#include "geometry/generic_knee.hpp"

namespace vrda::calibration::example_points_test {

/// Facets of 5 mm on a radius of 9.5 mm are up to 5^2 / (8 * 9.5) mm inside; the gradient of the fields
/// differs from 1 by up to 0.1.
constexpr double off_surface_mm = 0.4;

bench::CalibrationSettings example()
{
  return bench::read_bench_file(VRDA_JOBS "/bench-desk.toml").calibration;
}

Eigen::Vector3d at(const std::vector<bench::CalibrationPoint>& points, const std::string& name)
{
  for (const bench::CalibrationPoint& point : points) {
    if (point.name == name) return point.p_model_mm;
  }
  ADD_FAILURE() << "no point " << name;
  return Eigen::Vector3d::Zero();
}

TEST(ExampleBench, ItsPointsLieOnTheGenericKnee)
{
  const bench::CalibrationSettings settings = example();
  EXPECT_GE(settings.points.size(), 8u);
  EXPECT_GE(settings.tibia_points.size(), 6u);
  for (const bench::CalibrationPoint& point : settings.points)
    EXPECT_NEAR(geometry::femur_field(point.p_model_mm), 0.0, off_surface_mm) << point.name;
  for (const bench::CalibrationPoint& point : settings.tibia_points) {
    const Eigen::Vector3d in_design_pose =
        point.p_model_mm + Eigen::Vector3d(0.0, geometry::initial_clearance_mm(), 0.0);
    const double bone_mm =
        std::min(geometry::tibia_field(in_design_pose), geometry::fibula_field(in_design_pose));
    EXPECT_NEAR(bone_mm, 0.0, off_surface_mm) << point.name;
  }
}

TEST(ExampleBench, ItsDistancesAreThoseOfItsPoints)
{
  const bench::CalibrationSettings settings = example();
  const auto femur = [&](const char* name) { return at(settings.points, name); };
  const auto tibia = [&](const char* name) { return at(settings.tibia_points, name); };
  const std::vector<double> wanted{(femur("medial epicondyle") - femur("lateral epicondyle")).norm(),
                                   (femur("medial condyle, back") - femur("trochlea, upper rim")).norm(),
                                   (tibia("medial plateau, edge") - tibia("lateral plateau, edge")).norm(),
                                   (tibia("tibial tuberosity") - tibia("fibula's head")).norm()};
  constexpr double rounded_mm = 0.05;
  ASSERT_EQ(settings.landmarks.size(), wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k)
    EXPECT_NEAR(settings.landmarks[k].model_mm, wanted[k], rounded_mm) << settings.landmarks[k].name;
}

}  // namespace vrda::calibration::example_points_test
