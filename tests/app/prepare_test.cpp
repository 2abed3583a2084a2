// `vrda prepare` on the command line, with the generated knee.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "convert/mesh_writer.hpp"
#include "load/case.hpp"
#include "prepare/template_joint.hpp"
#include "support/messages.hpp"
#include "support/real_knees.hpp"

namespace vrda::prepare_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Prepare : public testing::Test {
 protected:
  // The bones of a left knee in cm, turned and moved, in two files.
  Prepare()
  {
    const prepare::TemplateJoint joint = prepare::mirrored(prepare::generic_template());
    X_.linear() = Eigen::Quaterniond(1, 2, -1, 2).normalized().toRotationMatrix();
    X_.translation() = Eigen::Vector3d(120, -40, 300);
    femur_ = written("femur.stl", joined(joint.knee.surfaces.femur));
    tibia_ = written("tibia.stl", joined(joint.knee.surfaces.tibia));
    fibula_ = written("fibula.stl", joint.fibula);
  }

  std::string written(const std::string& name, Mesh mesh) const
  {
    mesh = transformed(mesh, X_);
    mesh.vertices_mm *= 0.1;
    return scratch_.write(name, convert::stl_bytes(mesh, "")).string();
  }

  nlohmann::json report() const { return nlohmann::json::parse(test::read_bytes(folder_ / "prepare.json")); }

  test::Scratch scratch_;
  fs::path folder_ = scratch_.path() / "knee";
  Pose X_ = Pose::Identity();
  std::string femur_, tibia_, fibula_;
};

TEST_F(Prepare, WritesAJobThatSolves)
{
  const test::Ended ended = test::run_vrda({"prepare", "--femur", femur_, "--tibia", tibia_, "--fibula",
                                            fibula_, "--cartilage", "none", "-o", folder_.string()});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("knee.toml"));
  const nlohmann::json found = report();
  EXPECT_EQ(found.at("side"), "left");
  EXPECT_EQ(found.at("unit"), "cm");
  EXPECT_EQ(found.at("solved_flexions"), nlohmann::json::parse("[10, 10]"));
  EXPECT_NEAR(found.at("scanned").at("flexion_deg").get<double>(), 0.0, 0.1);
  // The matrix takes the file's origin to where it is in the anatomical frame; STL has single precision.
  const Eigen::Vector3d origin_mm = X_.inverse() * Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(
        found.at("femur").at("anatomical_from_file").at(static_cast<std::size_t>(k)).at(3).get<double>(),
        origin_mm[k], 0.05);
    EXPECT_NEAR(found.at("femur").at("scale").at(static_cast<std::size_t>(k)).get<double>(), 1.0, 1e-3);
  }
  for (const char* name : {"femur.stl", "tibia.stl", "fibula.stl", "ligaments.csv", "prepare.png"})
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  // Four views of 800 pixels: the width is in bytes 16 to 19 of a PNG.
  const std::string png = test::read_bytes(folder_ / "prepare.png");
  EXPECT_EQ(256 * static_cast<unsigned char>(png.at(18)) + static_cast<unsigned char>(png.at(19)), 3200);
  const load::Case job = load::load_case((folder_ / "knee.toml").string());
  EXPECT_EQ(job.frame.side, Side::left);
  EXPECT_EQ(job.ligaments.fibres.size(), 26U);
  EXPECT_EQ(job.grid.flexion_deg.size(), 19U);
  const test::Ended other_side =
      test::run_vrda({"check", (folder_ / "knee.toml").string(), "--set", "side=right"});
  EXPECT_THAT(other_side.out + other_side.err, test::warns("side", "left"));
  const test::Ended run =
      test::run_vrda({"run", (folder_ / "knee.toml").string(), "--set", "grid.flexion.step=30", "-o",
                      (folder_ / "knee.h5").string(), "--progress", "none"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(Prepare, ThickensBonesWithoutCartilageAndLeavesLigamentsOut)
{
  const test::Ended ended =
      test::run_vrda({"prepare", "--femur", femur_, "--tibia-cartilage", tibia_, "--cartilage", "1.5",
                      "--side", "left", "--unit", "cm", "--no-ligaments", "--json", "-o", folder_.string()});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.err, testing::AllOf(test::warns("femur", "1.5 mm"), test::warns("tibia", "cartilage")));
  EXPECT_EQ(nlohmann::json::parse(ended.out), report());
  EXPECT_THAT(test::read_bytes(folder_ / "knee.toml"), HasSubstr("inset_mm = -1.5"));
  EXPECT_TRUE(load::load_case((folder_ / "knee.toml").string()).ligaments.fibres.empty());
}

TEST_F(Prepare, ExchangedBonesAreRefusedAndDrawn)
{
  const test::Ended ended =
      test::run_vrda({"prepare", "--femur", tibia_, "--tibia", femur_, "-o", folder_.string()});
  EXPECT_THAT(ended,
              test::refuses({tibia_ + ", " + femur_, "", "exchanged", (folder_ / "prepare.png").string()}));
  EXPECT_TRUE(fs::exists(folder_ / "prepare.png"));
  EXPECT_FALSE(fs::exists(folder_ / "knee.toml"));
}

TEST_F(Prepare, AFibulaThatIsNotLateralIsWarnedOf)
{
  const std::string medial = written("medial.stl", prepare::generic_template().fibula);
  const test::Ended ended = test::run_vrda({"prepare", "--femur", femur_, "--tibia", tibia_, "--fibula",
                                            medial, "--no-ligaments", "-o", folder_.string()});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, test::warns("--fibula", "lateral"));
}

TEST_F(Prepare, BonesOfDifferentPosesAreRefused)
{
  X_.translation() += Eigen::Vector3d(150, 0, 0);
  const std::string elsewhere =
      written("elsewhere.stl", joined(prepare::mirrored(prepare::generic_template()).knee.surfaces.tibia));
  const test::Ended ended =
      test::run_vrda({"prepare", "--femur", femur_, "--tibia", elsewhere, "-o", folder_.string()});
  EXPECT_THAT(ended, test::refuses({femur_ + ", " + elsewhere, "", "pose"}));
}

TEST_F(Prepare, MissingAndWrongOptionsAreNamed)
{
  const test::Ended none = test::run_vrda({"prepare", "--femur", femur_, "-o", folder_.string()});
  EXPECT_THAT(none, test::refuses({"--tibia", "", "nothing"}));
  EXPECT_EQ(test::run_vrda({"prepare", "--femur", femur_, "--tibia", tibia_}).exit_code, 2);
  for (const auto& [option, value] : {std::pair("--side", "middle"), std::pair("--unit", "inch"),
                                      std::pair("--cartilage", "thick"), std::pair("--cartilage", "-1")}) {
    const test::Ended ended = test::run_vrda(
        {"prepare", "--femur", femur_, "--tibia", tibia_, option, value, "-o", folder_.string()});
    EXPECT_THAT(ended, test::refuses({option, "", value}));
  }
  const test::Ended missing =
      test::run_vrda({"prepare", "--femur", femur_, "--tibia", "nowhere.stl", "-o", folder_.string()});
  EXPECT_THAT(missing, test::refuses({"nowhere.stl", "--tibia"}));
  const std::string ball = (test::source_directory() / "jobs/validation/ball-in-dish.toml").string();
  const test::Ended other = test::run_vrda(
      {"prepare", "--femur", femur_, "--tibia", tibia_, "--template", ball, "-o", folder_.string()});
  EXPECT_THAT(other, test::refuses({"--template", "\"Ball in a dish\""}));
}

}  // namespace vrda::prepare_test
