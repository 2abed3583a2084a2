// Help, `vrda check`, `info`, `shape`, and `convert` of the thesis's files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/thesis_files.hpp"
#include "solve/case_solver.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "support/meshes.hpp"
#include "support/messages.hpp"
#include "support/real_knees.hpp"

namespace vrda::commands_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(Commands, HelpNamesEveryCommandWithAnExample)
{
  const test::Ended help = test::run_vrda({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const std::string name :
       {"run", "check", "plan", "index", "info", "validate", "smooth", "audit", "trace", "compare", "reduce",
        "export", "import", "report", "prepare", "shape", "convert"}) {
    EXPECT_THAT(help.out, HasSubstr(name));
    const test::Ended own = test::run_vrda({name, "--help"});
    EXPECT_EQ(own.exit_code, 0);
    EXPECT_THAT(own.out, HasSubstr("Example:"));
    EXPECT_THAT(own.out, HasSubstr("--quiet"));
  }
  EXPECT_THAT(help.out, HasSubstr("Example:\n  vrda run "));
  for (const std::string code :
       {"0  done", "2  bad input", "3  finished", "4  interrupted", "5  internal error"})
    EXPECT_THAT(help.out, HasSubstr(code));
  EXPECT_EQ(test::run_vrda({"--version"}).out, "vrda 0.1.0\n");
}

TEST(Commands, CheckSaysWhatItUnderstood)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch).string();
  const test::Ended text = test::run_vrda({"check", job});
  EXPECT_EQ(text.exit_code, 0);
  for (const char* value : {"Ball in a dish", "15 attitudes", "closed"})
    EXPECT_THAT(text.out, test::reports("", value));
  const auto json = test::json_of({"check", job});
  EXPECT_EQ(json.at("components").size(), 2u);
  EXPECT_EQ(json.at("components").at(1).at("triangles"), 168);
  EXPECT_EQ(json.at("components").at(1).at("closed"), true);
  // The ball's top is at -40 + 6, the dish above (3, 2) at -13/80; facets of 5 mm have a sagitta of 0.2 mm.
  EXPECT_NEAR(json.at("initial_pose").at("travel_along_delta_mm").get<double>(), 34.0 - 13.0 / 80.0, 0.3);
  EXPECT_EQ(json.at("initial_pose").at("overlapping"), false);
}

TEST(Commands, CheckSaysWhatHoldsAndLoadsTheJoint)
{
  const std::string job = (test::source_directory() / "jobs/knee-generic.toml").string();
  const std::vector<std::string> more{"--set", "grid.varus=free",
                                      "--set", "push.force_n={ flexion_deg = [0, 90], value = [20, 40] }",
                                      "--set", "push.varus_moment_nmm=-300",
                                      "--set", "solver.equilibrium.tolerance_mm=2e-4"};
  std::vector<std::string> words{"check", job};
  words.insert(words.end(), more.begin(), more.end());
  const test::Ended text = test::run_vrda(words);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  for (const test::Values& values : {test::Values{"varus", "free"},
                                     {"20 N", "0", "40 N", "90"},
                                     {"-300 N mm"},
                                     {"0.0002 mm"},
                                     {"0.01 mm"}})
    EXPECT_THAT(text.out, test::reports("", values));
  for (const test::Values& values : {test::Values{"0 to 0"}, {"translation", "1 mm"}})
    EXPECT_THAT(text.out, Not(test::reports("", values)));
  words.emplace_back("--json");
  const auto json = nlohmann::json::parse(test::run_vrda(words).out);
  const nlohmann::json& ligaments = json.at("ligaments");
  int n_fibres = 0;
  for (const nlohmann::json& bundle : ligaments.at("bundles")) {
    n_fibres += bundle.at("fibres").get<int>();
    EXPECT_THAT(text.out, HasSubstr(bundle.at("name").get<std::string>()));
  }
  EXPECT_GT(n_fibres, 0);
  EXPECT_EQ(ligaments.at("fibres"), n_fibres);
  EXPECT_THAT(text.out, test::reports("ligaments", {std::to_string(n_fibres),
                                                    std::to_string(ligaments.at("bundles").size()),
                                                    std::to_string(ligaments.at("wraps").size())}));
  EXPECT_TRUE(json.at("grid").at("varus").is_null());
  EXPECT_EQ(json.at("grid").at("varus_is_free"), true);
  EXPECT_EQ(json.at("push").at("force_n").at("value"), nlohmann::json({20.0, 40.0}));
  EXPECT_NEAR(json.at("push").at("force_n").at("flexion_deg").at(1).get<double>(), 90.0, 1e-12);
  EXPECT_EQ(json.at("push").at("varus_moment_nmm"), -300.0);
  EXPECT_EQ(json.at("push").at("lateral_force_n"), nlohmann::json({0.0, 0.0}));
  EXPECT_EQ(json.at("equilibrium").at("tolerance_mm"), 2e-4);
  EXPECT_TRUE(json.at("steps").is_null());
}

TEST(Commands, CheckOfASearchHasItsStepsAndNoLoads)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch).string();
  const std::vector<std::string> words{"check", job, "--set", "solver.method=stability-search"};
  const test::Ended text = test::run_vrda(words);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out,
              AllOf(test::reports("ligaments", "none"), test::reports("", {"translation", "1 mm"})));
  EXPECT_THAT(text.out, Not(AnyOf(test::reports("", "tolerance"), test::reports("", {"N", "delta"}))));
  std::vector<std::string> as_json = words;
  as_json.emplace_back("--json");
  const auto json = nlohmann::json::parse(test::run_vrda(as_json).out);
  EXPECT_TRUE(json.at("equilibrium").is_null());
  EXPECT_TRUE(json.at("ligaments").is_null());
  EXPECT_EQ(json.at("steps").at("translation_mm"), 1.0);
  EXPECT_THAT(json.at("solver_version").get<std::string>(), testing::MatchesRegex("stability-search [0-9]+"));
  EXPECT_THAT(json.at("job_key").get<std::string>(), testing::MatchesRegex("[0-9a-f]+"));
  EXPECT_EQ(json.at("grid").at("varus_is_free"), false);
  EXPECT_EQ(json.at("grid").at("varus").at("count"), 5);
}

TEST(Commands, InfoOfNothingSolvedMeasuresNothing)
{
  const test::Scratch scratch;
  const std::string output = (scratch.path() / "none.h5").string();
  EXPECT_EQ(test::run_vrda({"run", test::small_job(scratch).string(), "-o", output, "--set",
                            "moving.initial.translation_mm=[500, -40, 0]"})
                .exit_code,
            3);
  const auto json = test::json_of({"info", output});
  EXPECT_EQ(json.at("remeasured").at("attitudes"), 0);
  EXPECT_TRUE(json.at("remeasured").at("largest_gap_mm").is_null());
  EXPECT_TRUE(json.at("remeasured").at("largest_penetration_mm").is_null());
}

TEST(Commands, InfoReportsTheStabilityOfAnEquilibrium)
{
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "knee.h5").string();
  store::write_motion_model(file, test::sample_model({4, 3, true, false, true, true, 5, 2}));
  const test::Ended info = test::run_vrda({"info", file});
  EXPECT_EQ(info.exit_code, 0);
  for (const test::Values& values :
       {test::Values{"-1.1e-05 mm", "0.0012 N", "5"}, {"medial 0.75", "lateral 0.25"}, {"optima", "1"}})
    EXPECT_THAT(info.out, test::reports("", values));
  const auto json = test::json_of({"info", file});
  EXPECT_EQ(json.at("fibres"), 5);
  EXPECT_EQ(json.at("equilibrium").at("largest_share").at("medial"), 0.75);
  EXPECT_EQ(json.at("equilibrium").at("flexions_with_several_optima"), 1);
  EXPECT_EQ(test::run_vrda({"validate", file}).exit_code, 0);

  store::write_motion_model(
      file, store::with_pending_cells(test::sample_model({4, 3, false, false, true, true, 0, 0})));
  const auto pending = test::json_of({"info", file});
  EXPECT_TRUE(pending.at("equilibrium").at("worst_gap_mm").is_null());
  EXPECT_TRUE(pending.at("equilibrium").at("largest_share").at("lateral").is_null());
  const test::Ended unsolved = test::run_vrda({"info", file});
  EXPECT_EQ(unsolved.exit_code, 0);
  EXPECT_THAT(unsolved.out, testing::Not(testing::HasSubstr("inf")));

  store::write_motion_model(file, test::sample_model());
  const auto search = test::json_of({"info", file});
  EXPECT_TRUE(search.at("equilibrium").is_null());
  EXPECT_EQ(search.at("fibres"), 0);
}

TEST(Commands, InfoMeasuresAgainAndValidateIsContent)
{
  const test::Scratch scratch;
  const std::string output = (scratch.path() / "knee.h5").string();
  ASSERT_EQ(test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o", output}).exit_code,
            0);
  const test::Ended info = test::run_vrda({"info", output});
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.out, test::reports("", {"35 attitudes", "35 stable"}));
  const auto json = test::json_of({"info", output});
  EXPECT_EQ(json.at("remeasured").at("overlapping_attitudes"), 0);
  EXPECT_EQ(json.at("remeasured").at("largest_penetration_mm"), 0.0);
  EXPECT_LE(json.at("remeasured").at("largest_gap_mm").get<double>(), 0.1);
  EXPECT_EQ(json.at("screw_home").at("spine").size(), 7u);
  EXPECT_EQ(json.at("smoothed").at(0).at("degree"), 2);
  EXPECT_EQ(json.at("grid").at("varus_is_free"), false);
  EXPECT_EQ(json.at("grid").at("varus_deg").at(2), 5);
  const test::Ended validate = test::run_vrda({"validate", output});
  EXPECT_EQ(validate.exit_code, 0);
  EXPECT_THAT(validate.out, IsEmpty());
  EXPECT_THAT(validate.err, test::reports(output, "valid"));
}

TEST(Commands, InfoOfFreeVarusReportsTheSolvedVarus)
{
  const test::Scratch scratch;
  const std::string output = (scratch.path() / "free.h5").string();
  ASSERT_EQ(test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o", output, "--set",
                            "solver.method=equilibrium", "--set", "grid.varus=free"})
                .exit_code,
            0);
  const test::Ended info = test::run_vrda({"info", output});
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.out, AllOf(test::reports("", {"varus", "free"}), Not(test::reports("", "0 to 0"))));
  const auto grid = test::json_of({"info", output}).at("grid");
  EXPECT_TRUE(grid.at("varus_deg").is_null());
  EXPECT_EQ(grid.at("varus_is_free"), true);
  const store::MotionModel model = store::read_motion_model(output);
  EXPECT_EQ(grid.at("varus_found_deg").at("min"), model.varus_solved_deg.minCoeff());
  EXPECT_EQ(grid.at("varus_found_deg").at("max"), model.varus_solved_deg.maxCoeff());
}

TEST(Commands, ShapeWritesItsParts)
{
  const test::Scratch scratch;
  const std::string folder = (scratch.path() / "hip").string();
  const test::Ended ended = test::run_vrda({"shape", "hip", "-o", folder});
  EXPECT_EQ(ended.exit_code, 0);
  for (const char* value : {"socket.stl", "head.stl"}) EXPECT_THAT(ended.out, test::reports("", value));
  const std::string bytes = test::read_bytes(folder + "/head.stl");
  std::uint32_t n = 0;
  std::memcpy(&n, bytes.data() + 80, 4);
  EXPECT_EQ(bytes.size(), 84 + 50 * static_cast<std::size_t>(n));
  EXPECT_GT(n, 100u);
  EXPECT_EQ(test::run_vrda({"shape", "hat", "-o", folder}).exit_code, 2);
}

TEST(Commands, ShapeWritesLigamentsThatAJobCanRead)
{
  const test::Scratch scratch;
  const std::string folder = (scratch.path() / "knee").string();
  const test::Ended ended = test::run_vrda({"shape", "knee", "--ligaments", "-o", folder, "side=left"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, test::reports("", "ligaments.csv"));
  const std::string job = (test::source_directory() / "jobs/knee-generic-contact.toml").string();
  const std::string fibres = "ligaments.fibres=\"" + folder + "/ligaments.csv\"";
  const test::Ended check = test::run_vrda({"check", job, "--set", "side=left", "--set", fibres});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  const test::Ended hip = test::run_vrda({"shape", "hip", "--ligaments", "-o", folder + "2"});
  EXPECT_EQ(hip.exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder + "2"));
}

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

}  // namespace vrda::commands_test
