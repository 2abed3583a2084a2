// [reference.frame] and [moving.frame]: schemas/frames.md.
// The warning of a joint's kind that contradicts the shape of its surfaces.
#include <gmock/gmock.h>

#include "core/units.hpp"
#include "geometry/generated_knee.hpp"
#include "geometry/generic_knee.hpp"
#include "job/auto_frame.hpp"
#include "job/case.hpp"
#include "job/component_loader.hpp"
#include "job/mesh_text.hpp"
#include "support/meshes.hpp"
#include "support/real_knees.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::frames_test {

using test::pose;
using test::refuses;

job::Job job_with_frame(const test::Scratch& scratch, const std::string& frame)
{
  return job::read_job(scratch.write("job.toml", test::small_job("[frame]\n" + frame)).string());
}

// +1 for a rotation, -1 for a left-handed map, 0 for an axis named twice.
int handedness_of(const std::string& anterior, const std::string& proximal, const std::string& right)
{
  job::Job job;
  job.frame = {"frame", "mm", anterior, proximal, right};
  try {
    EXPECT_DOUBLE_EQ(job::axis_map(job).X_canonical_native.linear().determinant(), 1.0);
    return 1;
  } catch (const InputError& error) {
    return error.facts().found.find("left-handed") != std::string::npos ? -1 : 0;
  }
}

TEST(AxisMap, EveryMapIsARotationOrRefused)
{
  const std::vector<std::string> axes{"+X", "-X", "+Y", "-Y", "+Z", "-Z"};
  std::map<int, int> n;
  for (std::size_t i = 0; i < 216; ++i) ++n[handedness_of(axes[i % 6], axes[i / 6 % 6], axes[i / 36])];
  EXPECT_EQ(n[1], 24);
  EXPECT_EQ(n[-1], 24);
  EXPECT_EQ(n[0], 216 - 48);
}

TEST(AxisMap, AlignTurnsAboutTheFilesAxesInOrderBeforeTheyAreRenamed)
{
  const test::Scratch scratch;
  const job::AxisMap map = job::axis_map(job_with_frame(scratch, R"(
unit = "m"
anterior = "+Y"
proximal = "+Z"
right = "+X"
align = { rotation_deg = [90, 0, 90], translation_mm = [1, 2, 3] }
)"));
  // (0, 1, 0) m -> 1000 Y; about X by 90: Z; about Z by 90: Z; shifted: (1, 2, 1003); renamed: Y, Z, X.
  constexpr double rounding_mm = 1e-9;
  EXPECT_LT((map({0, 1, 0}) - Eigen::Vector3d(2, 1003, 1)).norm(), rounding_mm);
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

Mesh shifted(const Mesh& mesh, const Eigen::Vector3d& by_mm)
{
  Pose X_to_from = Pose::Identity();
  X_to_from.translation() = by_mm;
  return transformed(mesh, X_to_from);
}

TEST(Condyles, two_balls)
{
  const Eigen::Vector3d left_mm(420, 511, 600), right_mm(424, 514, 650);
  Mesh femur = shifted(test::ball(20, 48, 96), left_mm);
  append(femur, shifted(test::ball(23, 48, 96), right_mm));
  const std::optional<job::CondyleSpheres> spheres = job::condyle_spheres(femur);
  ASSERT_TRUE(spheres.has_value());
  // Face centres are inside the sphere by its sagitta, at most r (pi / 48)^2 / 2 = 0.05 mm.
  constexpr double sagitta_mm = 0.05;
  EXPECT_LT((spheres->left.centre_mm - left_mm).norm(), sagitta_mm);
  EXPECT_LT((spheres->right.centre_mm - right_mm).norm(), sagitta_mm);
  EXPECT_NEAR(spheres->left.radius_mm, 20.0, sagitta_mm);
  EXPECT_NEAR(spheres->right.radius_mm, 23.0, sagitta_mm);
}

TEST(Condyles, box)
{
  EXPECT_FALSE(job::condyle_spheres(test::box({0, 0, 0}, {60, 60, 80})).has_value());
  EXPECT_FALSE(job::condyle_spheres(Mesh{}).has_value());
}

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

job::Case shipped(const std::string& name, const std::vector<std::string>& overrides)
{
  return job::load_case((test::source_directory() / "jobs" / name).string(), {"", overrides});
}

TEST(JointShape, head_of_a_hip)
{
  const std::optional<job::BallFit> fit = job::ball_fit(shipped("hip-generic.toml", {}));
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->is_ball);
  // Vertices lie on the sphere; some of the fillet of the neck are within the band.
  EXPECT_NEAR(fit->sphere.radius_mm, 24.0, 0.1);
  EXPECT_LT(fit->sphere.centre_mm.norm(), 0.1);
}

TEST(JointShape, no_balls)
{
  for (const char* name : {"knee-generic.toml", "ankle-generic.toml"}) {
    SCOPED_TRACE(name);
    const std::optional<job::BallFit> fit = job::ball_fit(shipped(name, {}));
    ASSERT_TRUE(fit);
    EXPECT_FALSE(fit->is_ball) << fit->sphere.radius_mm << " " << fit->rms_mm;
  }
}

TEST(JointShape, wrong_kind)
{
  const std::string of_knee = "joint: \"hip\", but", of_ball = "write joint = \"hip\"";
  EXPECT_THAT(shipped("knee-generic.toml", {"joint=hip", "push.frame=world"}).warnings,
              Contains(HasSubstr(of_knee)));
  EXPECT_THAT(shipped("ankle-generic.toml", {"joint=hip", "push.frame=world"}).warnings,
              Contains(HasSubstr(of_knee)));
  for (const char* kind : {"joint=knee", "joint=ankle", "joint=subtalar"})
    EXPECT_THAT(shipped("hip-generic.toml", {kind}).warnings, Contains(HasSubstr(of_ball))) << kind;
  EXPECT_THAT(shipped("hip-generic.toml", {"joint=other"}).warnings, Not(Contains(HasSubstr("joint: "))));
}

using testing::ElementsAre;

job::Case load_knee(const std::string& name, const std::vector<std::string>& overrides = {})
{
  return job::load_case((test::source_directory() / ("jobs/knee-" + name + ".toml")).string(),
                        {test::data_directory()->string(), overrides});
}

const std::vector<std::string> all_knees{"jam-smith2019", "pymskt-dess", "vhf-left", "vhf-right"};

TEST(RealKnees, condyle_spheres)
{
  VRDA_REQUIRE_REAL_KNEES();
  // posterior_condyle_spheres_canonical_mm of each dataset.json, left then right, without alignment.
  struct Row {
    const char* name;
    Eigen::Vector3d left_mm, right_mm;
  };
  const std::vector<Row> rows{{"jam-smith2019", {0.038, 1.405, -21.979}, {0.128, 2.966, 24.492}},
                              {"pymskt-dess", {0.932, 14.15, 53.605}, {6.289, 15.947, 94.609}},
                              {"vhf-left", {434.124, 506.156, 448.957}, {439.481, 512.136, 500.011}},
                              {"vhf-right", {427.95, 508.723, 593.074}, {421.07, 514.516, 645.783}}};
  // Condyles are not spheres: two methods of face selection differ by this much.
  constexpr double centre_mm = 7.0, middle_mm = 3.0;
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    const job::Case loaded = load_knee(row.name, {"frame.align.rotation_deg=[0, 0, 0]"});
    const std::optional<job::CondyleSpheres> spheres = job::condyle_spheres(loaded.reference.contact.mesh);
    ASSERT_TRUE(spheres.has_value());
    EXPECT_LT((spheres->left.centre_mm - row.left_mm).norm(), centre_mm);
    EXPECT_LT((spheres->right.centre_mm - row.right_mm).norm(), centre_mm);
    EXPECT_LT((spheres->left.centre_mm + spheres->right.centre_mm - row.left_mm - row.right_mm).norm() / 2.0,
              middle_mm);
  }
}

TEST(RealKnees, alignment)
{
  VRDA_REQUIRE_REAL_KNEES();
  // The sphere centres of the data sets, mapped by the job: their line must be along Z.
  struct Row {
    const char* name;
    Eigen::Vector3d left_mm, right_mm;
  };
  const std::vector<Row> rows{{"vhf-left", {434.124, 506.156, 448.957}, {439.481, 512.136, 500.011}},
                              {"vhf-right", {427.95, 508.723, 593.074}, {421.07, 514.516, 645.783}}};
  constexpr double rounded_deg = 0.1;  // the angles in the job have one decimal
  for (const Row& row : rows) {
    // The rotation centre is mapped like the meshes; native axes: X right, Y anterior, Z up.
    const auto mapped = [&](const Eigen::Vector3d& p) {
      const std::string origin = "frame.origin=[" + std::to_string(p.z()) + "," + std::to_string(p.x()) +
                                 "," + std::to_string(p.y()) + "]";
      return load_knee(row.name, {origin}).frame.rotation_centre_mm;
    };
    const Eigen::Vector3d line = (mapped(row.right_mm) - mapped(row.left_mm)).normalized();
    EXPECT_GT(line.z(), 0.0);
    EXPECT_LT(line.head<2>().norm(), rad_from_deg(rounded_deg));
  }
}

}  // namespace vrda::frames_test
