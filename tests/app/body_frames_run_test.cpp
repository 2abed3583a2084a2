// A job whose frames are found (schemas/frames.md), from check to poses.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "job/thesis_files.hpp"
#include "prepare/template_joint.hpp"
#include "store/motion_model.hpp"

namespace vrda::body_frames_run_test {

namespace fs = std::filesystem;

struct Scan {
  test::Scratch scratch;

  fs::path job(const Pose& X_femur, const Pose& X_tibia, const std::string& frames) const
  {
    const prepare::TemplateJoint joint = prepare::generic_template();
    const auto write = [&](const std::string& name, const Mesh& mesh, const Pose& X) {
      scratch.write(name, job::stl_bytes(transformed(mesh, X), ""));
    };
    write("femur.stl", joint.joint.reference.contact.mesh, X_femur);
    write("tibia.stl", joint.joint.moving.contact.mesh, X_tibia);
    return scratch.write("knee.toml", R"(
[reference]
name = "femur"
[[reference.component]]
name = "femur"
file = "femur.stl"
[moving]
name = "tibia"
[[moving.component]]
name = "tibia"
file = "tibia.stl"
[ligaments]
generate = { shape = "knee-template" }
[grid]
flexion = { from = 0, to = 90, step = 30 }
varus = "free"
)" + frames);
  }

  store::MotionModel solved(const fs::path& job_file, const std::string& name) const
  {
    const std::string output = (scratch.path() / name).string();
    const test::Ended ended = test::run_vrda({"run", job_file.string(), "-o", output, "--quiet"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return store::read_motion_model(output);
  }
};

TEST(BodyFramesRun, ATurnedKneeWithAutoHasThePosesOfTheKneeItself)
{
  const Scan scan;
  const store::MotionModel own = scan.solved(scan.job(Pose::Identity(), Pose::Identity(), ""), "own.h5");
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(1, 2, -1, 2).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(120, -40, 300);
  Pose X_femur = X;
  X_femur.linear() = X.linear() * rotation_z(0.4);
  const fs::path job = scan.job(X_femur, X,
                                "[reference.frame]\norigin = \"auto\"\nalign = \"auto\"\n"
                                "[moving.frame]\norigin = \"auto\"\nalign = \"auto\"\n");
  const store::MotionModel found = scan.solved(job, "found.h5");
  ASSERT_EQ(found.theta_deg.rows(), own.theta_deg.rows());
  // A fit ends within some thousandths of a degree; single precision of the files.
  EXPECT_LT((found.theta_deg - own.theta_deg).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT((found.varus_solved_deg - own.varus_solved_deg).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT((found.ty_mm - own.ty_mm).cwiseAbs().maxCoeff(), 0.05);
  const test::Ended check = test::run_vrda({"check", job.string(), "--json"});
  ASSERT_EQ(check.exit_code, 0) << check.err;
  const nlohmann::json origin = nlohmann::json::parse(check.out).at("found_frames").at("moving").at("origin");
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(origin.at(k).get<double>(), X.translation()[static_cast<Eigen::Index>(k)], 0.05);
}

}  // namespace vrda::body_frames_run_test
