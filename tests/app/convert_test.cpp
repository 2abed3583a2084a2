// `vrda convert` on the command line: converts the thesis's files; one message for malformed input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/thesis_files.hpp"
#include "solve/case_solver.hpp"
#include "support/meshes.hpp"
#include "support/messages.hpp"

namespace vrda::convert_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

// Converts a mesh from canonical axes in mm to the thesis's axes: metres, X left, Y up, Z forward.
std::string thesis_file(const Mesh& canonical)
{
  job::RawMesh raw;
  raw.vertices.resize(canonical.vertices_mm.rows(), 3);
  raw.vertices.col(0) = -0.001 * canonical.vertices_mm.col(2);
  raw.vertices.col(1) = 0.001 * canonical.vertices_mm.col(1);
  raw.vertices.col(2) = 0.001 * canonical.vertices_mm.col(0);
  raw.corner.assign(canonical.triangles.data(), canonical.triangles.data() + canonical.triangles.size());
  raw.size.assign(static_cast<std::size_t>(canonical.triangles.rows()), 3);
  return job::vertices_faces_bytes(raw);
}

const std::string knee_configuration = R"(MODEL 0 femur
MODEL 1 tibmen
INITIAL_POSITION 1 0 -0.02 0
INITIAL_MOTION 1 0 0.005 0
INITIAL_ORIENTATION 1 0 10 0
SHIFT_MODEL 0 -0.1 0 0
DISPLAY 1280 1024
ZOOM 5
CONTACT_RESOLUTION 0.0001
MODELING_RESOLUTION 0.001
ANGLE_RANGE 0 0 90 30
ANGLE_RANGE 1 -5 5 5
RENDER fill
)";

class ConvertConfig : public testing::Test {
 protected:
  ConvertConfig()
  {
    scratch_.write("models/femur.obj", thesis_file(test::box({3, 10, -5}, {40, 20, 60})));
    scratch_.write("models/tibmen.obj", thesis_file(test::box({1, -10, -4}, {30, 20, 50})));
    scratch_.write("knee.cfg", knee_configuration);
  }

  test::Ended convert() const
  {
    return test::run_vrda({"convert", "config", configuration_.string(), "-o", job_.string()});
  }

  test::Scratch scratch_;
  fs::path configuration_ = scratch_.path() / "knee.cfg";
  fs::path job_ = scratch_.path() / "knee.toml";
};

TEST_F(ConvertConfig, TheJobIsUnderstoodAsTheThesisMeantIt)
{
  const test::Ended converted = convert();
  ASSERT_EQ(converted.exit_code, 0) << converted.err;
  EXPECT_EQ(converted.out, job_.string() + "\n");
  EXPECT_EQ(converted.err, "");
  const test::Ended checked = test::run_vrda({"check", job_.string(), "--json"});
  ASSERT_EQ(checked.exit_code, 0) << checked.err;
  const auto json = nlohmann::json::parse(checked.out);
  EXPECT_EQ(json.at("side"), "left");
  EXPECT_EQ(json.at("delta"), (std::vector<double>{0, 1, 0}));
  EXPECT_EQ(json.at("grid").at("attitudes"), 12);
  EXPECT_EQ(json.at("initial_pose").at("approach_step_mm"), 5.0);
  constexpr double rounding_mm = 1e-9;  // metres to millimetres and back
  // The femur's box from -17 to 23 forward, 0 to 20 up, -35 to 25 to the right.
  const std::vector<double> expected_min{-17, 0, -35}, expected_max{23, 20, 25};
  const auto& femur = json.at("components").at(0);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(femur.at("box_min_mm").at(k).get<double>(), expected_min[k], rounding_mm);
    EXPECT_NEAR(femur.at("box_max_mm").at(k).get<double>(), expected_max[k], rounding_mm);
  }
  // The faces of both boxes are at y = 0, the lower box 20 mm below.
  EXPECT_NEAR(json.at("initial_pose").at("travel_along_delta_mm").get<double>(), 20.0, rounding_mm);
  EXPECT_THAT(checked.out, Not(HasSubstr("player")));
}

// Transforms a point in the files' own axes and by the solver's poses.
TEST_F(ConvertConfig, TurnsOfTheThesisAreTurnsOfTheSolver)
{
  ASSERT_EQ(convert().exit_code, 0);
  const job::Case job_case = job::load_case(job_.string());
  const job::AxisMap map = job::axis_map(job::read_job(job_.string()));
  const MovingPose initial = solve::plan_of(job_case).initial;
  constexpr double rounding_mm = 1e-9;  // poses a few centimetres from the origin
  const Eigen::Vector3d p(0.01, -0.03, 0.02);
  // Rotated by 10 degrees about the files' Y, then translated.
  const Eigen::Vector3d turned = rotation_y(rad_from_deg(10.0)) * p + Eigen::Vector3d(0, -0.02, 0);
  EXPECT_LT((X_reference_moving(job_case.frame, {0.0, 0.0}, initial) * map(p) - map(turned)).norm(),
            rounding_mm);
  // The femur rotates about X by the negative flexion (5.4: 0 to -90) and about Z by the varus.
  struct Row {
    Attitude attitude;
    Eigen::Matrix3d femur;
  };
  const double angle_rad = rad_from_deg(30.0);
  for (const Row& row :
       {Row{{angle_rad, 0.0}, rotation_x(-angle_rad)}, Row{{0.0, angle_rad}, rotation_z(angle_rad)}}) {
    const Eigen::Vector3d seen_from_femur = row.femur.transpose() * turned;
    EXPECT_LT(
        (X_reference_moving(job_case.frame, row.attitude, initial) * map(p) - map(seen_from_femur)).norm(),
        rounding_mm);
  }
}

TEST_F(ConvertConfig, ModelsMayBeInAFolderNextToThatOfTheConfiguration)
{
  // The thesis's disk has modeler/config and modeler/models.
  configuration_ = scratch_.write("config/knee.cfg", knee_configuration);
  fs::create_directory(scratch_.path() / "jobs");
  job_ = scratch_.path() / "jobs" / "knee.toml";
  ASSERT_EQ(convert().exit_code, 0);
  EXPECT_THAT(test::text_of(job_), HasSubstr("file = \"../models/femur.obj\""));
  EXPECT_EQ(test::run_vrda({"check", job_.string()}).exit_code, 0);
}

TEST_F(ConvertConfig, AModelThatIsNotThereIsAWarning)
{
  fs::remove(scratch_.path() / "models" / "tibmen.obj");
  const test::Ended ended = convert();
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, test::warns("", "tibmen.obj"));
}

TEST_F(ConvertConfig, TheUnitIsTheUsersToSay)
{
  test::edit(configuration_, "0 -0.02 0", "0 -20 0");
  test::edit(configuration_, "0 0.005 0", "0 5 0");
  test::edit(configuration_, "0.0001", "0.1");
  test::edit(configuration_, "0.001", "1");
  const test::Ended ended =
      test::run_vrda({"convert", "config", configuration_.string(), "-o", job_.string(), "--unit", "mm"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(test::text_of(job_), HasSubstr("unit = \"mm\""));
  EXPECT_THAT(test::text_of(job_), HasSubstr("translation_mm = [0, -20, 0]"));
  EXPECT_EQ(test::run_vrda({"convert", "config", "a", "-o", "b", "--unit", "inch"}).exit_code, 2);
}

// The square Tibia is one polygon of two triangles; the Femur a triangle, and one without area.
class ConvertObject : public testing::Test {
 protected:
  ConvertObject()
  {
    scratch_.write("knee.coor",
                   "6\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 2, 0, 0\n6, 3, 0, 0\n");
    scratch_.write("knee.norm", "1 0 0 1\n2 0 0 1\n3 0 0 1\n4 0 0 1\n5 0 1 0\n6 0 0 1\n");
    scratch_.write("knee.elem", "Tibia 1 2 3 4\nFemur 2 5 3\nFemur 2 5 6\n");
  }

  test::Ended convert() const
  {
    return test::run_vrda({"convert", "object", (scratch_.path() / "knee").string(), "-o", models_.string()});
  }

  test::Scratch scratch_;
  fs::path models_ = scratch_.path() / "out" / "models";
};

TEST_F(ConvertObject, OneFileAComponentAndTheTableOfTheThesis)
{
  const test::Ended ended = convert();
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(ended.out,
            "Components   Polygons  Triangles\n"
            "Tibia               1          2\n"
            "Femur               2          1\n");
  EXPECT_THAT(ended.err, test::warns("Femur", "1"));
  EXPECT_EQ(test::text_of(models_ / "Tibia.obj"), "4 1\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n");
  EXPECT_EQ(test::text_of(models_ / "Femur.obj"), "4 2\n1 0 0\n1 1 0\n2 0 0\n3 0 0\n3 0 2 1\n3 0 2 3\n");
  EXPECT_EQ(test::text_of(models_ / "Femur.normals"), "4\n0 0 1\n0 0 1\n0 1 0\n0 0 1\n");
}

TEST(ConvertMesh, ThereAndBackThroughEveryFormat)
{
  const test::Scratch scratch;
  // A thesis file under its own extension, with a polygon.
  const std::string vf = "5 3\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.5 1\n4 3 2 1 0\n3 0 1 4\n3 1 2 4\n";
  fs::path from = scratch.write("a.obj", vf);
  for (const std::string name : {"b.ply", "c.obj", "d.vf"}) {
    const fs::path to = scratch.path() / name;
    const test::Ended ended = test::run_vrda({"convert", "mesh", from.string(), to.string()});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_EQ(ended.out, to.string() + "\n");
    EXPECT_THAT(ended.err, test::reports("", {"5", "3"}));
    from = to;
  }
  // The Wavefront reader numbers vertices as the faces use them.
  EXPECT_EQ(test::text_of(from), "5 3\n0 1 0\n1 1 0\n1 0 0\n0 0 0\n0.5 0.5 1\n4 0 1 2 3\n3 3 2 4\n3 2 1 4\n");
  const std::string stl = (scratch.path() / "e.stl").string();
  EXPECT_THAT(test::run_vrda({"convert", "mesh", from.string(), stl}).exit_code, 0);
  EXPECT_EQ(fs::file_size(stl), 84u + 50u * 4u);
}

}  // namespace vrda::convert_test
