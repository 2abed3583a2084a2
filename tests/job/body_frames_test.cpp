// [reference.frame] and [moving.frame]: schemas/frames.md.
#include <gmock/gmock.h>

#include "core/units.hpp"
#include "geometry/generic_knee.hpp"
#include "job/auto_frame.hpp"
#include "job/case.hpp"
#include "job/mesh_text.hpp"
#include "support/meshes.hpp"
#include "support/scratch.hpp"

namespace vrda::body_frames_test {

Pose pose(const Eigen::Vector4d& quaternion, const Eigen::Vector3d& t_mm)
{
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(quaternion).normalized().toRotationMatrix();
  X.translation() = t_mm;
  return X;
}

Mesh in_unit(Mesh mesh, double unit_mm)
{
  mesh.vertices_mm /= unit_mm;
  return mesh;
}

// A right knee, each bone in its own scan.
struct Knee {
  test::Scratch scratch;
  geometry::Shape shape = geometry::right_template_knee();

  void write(const Pose& X_femur, const Pose& X_tibia, double unit_mm = 1.0) const
  {
    scratch.write("reference.stl",
                  test::binary_stl(in_unit(transformed(shape.reference.front().mesh, X_femur), unit_mm)));
    scratch.write("moving.stl",
                  test::binary_stl(in_unit(transformed(shape.moving.front().mesh, X_tibia), unit_mm)));
  }
  job::Case loaded(const std::string& tail, const std::vector<std::string>& overrides = {}) const
  {
    return job::load_case(scratch.write("job.toml", test::small_job("", tail)).string(), {"", overrides});
  }
};

const std::string automatic = R"(
[reference.frame]
origin = "auto"
align = "auto"
[moving.frame]
origin = "auto"
align = "auto"
)";

// Single precision of the files, some 100 mm from their origin.
constexpr double stl_mm = 1e-4;

TEST(BodyFrames, own_axes)
{
  const test::Scratch scratch;
  const Mesh upper = test::box({0, 40, 0}, {60, 20, 80}), lower = test::box({0, 0, 0}, {50, 20, 70});
  scratch.write("reference.stl", test::binary_stl(upper));
  // In cm, X posterior, Z proximal, Y to the right, about (100, 50, 30) mm.
  Pose X = Pose::Identity();
  X.linear() << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  X.translation() = Eigen::Vector3d(100, 50, 30);
  scratch.write("moving.stl", test::binary_stl(in_unit(transformed(lower, X), 10.0)));
  const job::Case whole = job::load_case(
      scratch
          .write("job.toml", test::small_job("joint = \"other\"\n[frame]\norigin = [0, 30, 0]\n", R"(
[moving.frame]
unit = "cm"
anterior = "-X"
proximal = "+Z"
right = "+Y"
origin = [10, 5, 6]
align = { translation_mm = [1, 0, 0] }
)"))
          .string());
  EXPECT_LT((whole.reference.contact.mesh.vertices_mm -
             job::load_case(scratch.write("plain.toml", test::small_job("joint = \"other\"\n")).string())
                 .reference.contact.mesh.vertices_mm)
                .cwiseAbs()
                .maxCoeff(),
            stl_mm);
  // (10, 5, 6) cm is 30 mm above the box's middle and goes to the rotation centre, (0, 30, 0); then -1
  // anterior.
  const Box box = bounding_box(whole.moving.contact.mesh);
  EXPECT_LT((0.5 * (box.min_mm + box.max_mm) - Eigen::Vector3d(-1, 0, 0)).norm(), stl_mm);
  EXPECT_LT((box.max_mm - box.min_mm - Eigen::Vector3d(50, 20, 70)).norm(), stl_mm);
}

TEST(BodyFrames, attachments)
{
  const Knee knee;
  const Pose X_tibia = pose({1, 2, 0, 3}, {40, -10, 5});
  knee.write(Pose::Identity(), X_tibia);
  const Eigen::Matrix3d R = X_tibia.linear().transpose();
  const Eigen::Vector3d end_mm = X_tibia * Eigen::Vector3d(10, -30, 5);
  const auto list = [](const Eigen::Vector3d& v) {
    return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) + "]";
  };
  const Eigen::Vector3d angles_deg(deg_from_rad(std::atan2(R(2, 1), R(2, 2))),
                                   deg_from_rad(std::asin(-R(2, 0))),
                                   deg_from_rad(std::atan2(R(1, 0), R(0, 0))));
  const job::Case loaded =
      knee.loaded("[moving.frame]\norigin = [40, -10, 5]\nalign = { rotation_deg = " + list(angles_deg) +
                  " }\n[[ligaments.fibre]]\nname = \"A\"\nreference_mm = "
                  "[1, 2, 3]\nstiffness_n = 100\nslack_length_mm = 30\nmoving_mm = " +
                  list(end_mm) + "\n");
  EXPECT_LT((loaded.ligaments.fibres.at(0).moving_mm - Eigen::Vector3d(10, -30, 5)).norm(), 1e-4);
  EXPECT_EQ(loaded.ligaments.fibres.at(0).reference_mm, Eigen::Vector3d(1, 2, 3));
}

TEST(BodyFrames, found_frames)
{
  const Knee knee;
  const Pose X = pose({1, -2, 3, 1}, {310, -200, 40});
  Pose X_femur = X;
  X_femur.linear() = X.linear() * rotation_z(rad_from_deg(20.0));
  knee.write(X_femur, X, 10.0);
  const job::Case loaded = knee.loaded(automatic, {"reference.frame.unit=cm", "moving.frame.unit=cm"});
  knee.write(Pose::Identity(), Pose::Identity());
  const job::Case plain = knee.loaded("");
  ASSERT_TRUE(loaded.found_frames.has_value());
  // The last step of a fit is 1e-5; 100 mm away some hundredths of a millimetre.
  constexpr double fit_mm = 0.05;
  EXPECT_LT((loaded.reference.contact.mesh.vertices_mm - plain.reference.contact.mesh.vertices_mm)
                .cwiseAbs()
                .maxCoeff(),
            fit_mm);
  EXPECT_LT(
      (loaded.moving.contact.mesh.vertices_mm - plain.moving.contact.mesh.vertices_mm).cwiseAbs().maxCoeff(),
      fit_mm);
  EXPECT_FALSE(plain.found_frames.has_value());
}

TEST(BodyFrames, resolved_job)
{
  const Knee knee;
  const Pose X = pose({1, -2, 3, 1}, {310, -200, 40});
  knee.write(X, X);
  const job::Case found = knee.loaded(automatic);
  EXPECT_THAT(found.resolved_job, testing::Not(testing::HasSubstr("auto")));
  const job::Case numeric = job::load_case(knee.scratch.write("numeric.toml", found.resolved_job).string());
  EXPECT_EQ(numeric.resolved_job, found.resolved_job);
  EXPECT_EQ(numeric.steps_job_text, found.steps_job_text);
  EXPECT_EQ(numeric.moving.contact.mesh.vertices_mm, found.moving.contact.mesh.vertices_mm);
  EXPECT_EQ(numeric.reference.contact.mesh.vertices_mm, found.reference.contact.mesh.vertices_mm);
  const job::Case planned =
      job::case_with_joint(job::read_job((knee.scratch.path() / "job.toml").string()), "", found);
  EXPECT_EQ(planned.resolved_job, found.resolved_job);
  EXPECT_EQ(planned.steps_job_text, found.steps_job_text);
}

TEST(BodyFrames, found_origin)
{
  const Knee knee;
  Pose X = Pose::Identity();
  X.translation() = Eigen::Vector3d(12, 700, -5);
  knee.write(X, X);
  const job::Case loaded =
      knee.loaded("[reference.frame]\norigin = \"auto\"\n[moving.frame]\norigin = \"auto\"\n");
  EXPECT_LT((loaded.found_frames->reference.origin_native - X.translation()).norm(), 0.05);
  const Box box = bounding_box(loaded.reference.contact.mesh);
  EXPECT_LT((box.min_mm - bounding_box(knee.shape.reference.front().mesh).min_mm).norm(), 0.05);
}

}  // namespace vrda::body_frames_test
