// `vrda export` and `import`: files of a motion, back again, and what other commands do with a sequence of
// frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "support/messages.hpp"

namespace vrda::import_test {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

/// The sample model has 4 flexions, 3 varus and one failed cell next to the spine.
class Export : public test::CommandTest {
 protected:
  Export() { store::write_motion_model(file_, test::sample_model({})); }

  test::Ended run(const std::string& format, const std::string& output,
                  const std::vector<std::string>& more = {}) const
  {
    return test::run_vrda({"export", file_, "--to", format, "-o", path(output)}, more);
  }

  std::string file_ = path("knee.h5");
};

TEST_F(Export, WritesEachFormatAndTheSameBytesAgain)
{
  struct Row {
    std::string format, output, start;
  };
  for (const Row& row : {Row{"sto", "knee.sto", "vrda: "}, Row{"mot", "knee.mot", "vrda: "},
                         Row{"csv", "knee.csv", "flexion_deg,varus_deg,internal_deg,anterior_mm,"},
                         Row{"gltf", "new/folder/knee.glb", "glTF"}, Row{"vtk", "knee.pvd", "<?xml"}}) {
    SCOPED_TRACE(row.format);
    const test::Ended ended = run(row.format, row.output);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.out, StartsWith(path(row.output) + "\n"));
    const std::string first = test::read_bytes(path(row.output));
    EXPECT_THAT(first, StartsWith(row.start));
    EXPECT_EQ(run(row.format, row.output, {"--quiet"}).err, "");
    EXPECT_EQ(test::read_bytes(path(row.output)), first);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(path("knee")), {}), 4);
}

TEST_F(Export, SaysWhatItLeftOut)
{
  const test::Ended ended =
      run("csv", "knee.csv", {"--set", "raw", "--varus", "1", "--flexion", "0:4:1", "--json"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.err, test::warns("", {"2", "1 (unsolved_cell)", "4"}));
  const auto found = json::parse(ended.out);
  EXPECT_EQ(found.at("set"), "raw");
  EXPECT_EQ(found.at("attitudes"), 3);
  EXPECT_EQ(found.at("left_out").at(1).at("flexion_deg"), 4);
  EXPECT_EQ(found.at("files"), nlohmann::json::array({path("knee.csv")}));
  EXPECT_EQ(test::n_lines(test::read_bytes(path("knee.csv"))), 1 + 3);
}

TEST_F(Export, EveryCellIsARow)
{
  EXPECT_EQ(run("csv", "cells.csv", {"--full"}).exit_code, 0);
  EXPECT_EQ(test::n_lines(test::read_bytes(path("cells.csv"))), 1 + 4 * 3);
}

TEST_F(Export, ColumnsGoByTheNamesGiven)
{
  EXPECT_EQ(
      run("mot", "knee.mot", {"--coordinate", "flexion=knee_angle_r", "--coordinate", "tz=z"}).exit_code, 0);
  EXPECT_THAT(test::read_bytes(path("knee.mot")),
              HasSubstr("\ntime\tknee_angle_r\tknee_add_r\tknee_rot_r\tknee_tx_r\tknee_ty_r\tz\n"));
}

// An export writes the fewest digits that read back as the same double: rounding of rotation products
// remains.
constexpr double same_pose = 1e-9;

class Import : public test::CommandTest {
 protected:
  /// A solved grid of the two-ball knee; its job in `job_`.
  std::string solved_knee(const std::string& side)
  {
    job_ = path("knee_" + side + ".toml");
    return CommandTest::solved_knee(side);
  }

  /// The frames of a walk: those of the solved grid, to and fro over time.
  std::string walk(const std::string& side)
  {
    const store::MotionModel grid = store::read_motion_model(solved_knee(side));
    std::string text = "time,flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n";
    int frame = 0;
    for (const Eigen::Index i : {0, 2, 4, 6, 5, 3, 1, 0}) {
      const Pose X = store::pose_in(grid.X_reference_moving, static_cast<std::size_t>(5 * i + 2));
      const ClinicalCoordinates c =
          clinical_coordinates(X, side == "left" ? Side::left : Side::right, grid.rotation_centre_mm);
      const double to_lateral = side == "left" ? -1.0 : 1.0;
      const Eigen::Vector3d t = X.translation();
      text += shortest_decimal(0.25 * frame++);
      for (const double number : {deg_from_rad(c.flexion_rad), deg_from_rad(c.varus_rad),
                                  deg_from_rad(c.internal_rotation_rad), t.x(), t.y(), to_lateral * t.z()})
        text += "," + shortest_decimal(number);
      text += "\n";
    }
    return scratch_.write("walk_" + side + ".csv", text).string();
  }

  std::string imported_walk(const std::string& side)
  {
    const std::string table = walk(side), file = path("walk_" + side + ".h5");
    succeed({"import", job_, "--motion", table, "-o", file});
    return file;
  }

  static void expect_equal_poses(const store::MotionModel& a, const store::MotionModel& b)
  {
    ASSERT_EQ(a.X_reference_moving.size(), b.X_reference_moving.size());
    for (std::size_t k = 0; k < a.X_reference_moving.size(); ++k)
      ASSERT_NEAR(a.X_reference_moving[k], b.X_reference_moving[k], same_pose) << k;
  }

  std::string job_;
};

TEST_F(Import, MakesAValidSequenceOfFrames)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    const std::string file = imported_walk(side);
    const store::MotionModel grid = store::read_motion_model(path(side + ".h5")),
                             model = store::read_motion_model(file);
    succeed({"validate", file});
    EXPECT_EQ(model.method, "import");
    ASSERT_TRUE(model.frames);
    EXPECT_EQ(model.frames->key_name, "time_s");
    EXPECT_EQ(model.frames->key, (std::vector<double>{0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75}));
    std::size_t row = 0;
    for (const std::size_t i : {0u, 2u, 4u, 6u, 5u, 3u, 1u, 0u}) {
      const std::size_t cell = 5 * i + 2;
      for (std::size_t k = 0; k < 16; ++k)
        EXPECT_NEAR(model.X_reference_moving[16 * row + k], grid.X_reference_moving[16 * cell + k],
                    same_pose);
      EXPECT_NEAR(model.flexion_deg[row], grid.flexion_deg[i], same_pose);
      EXPECT_NEAR(model.varus_solved_deg.data()[row], grid.varus_solved_deg.data()[cell], same_pose);
      EXPECT_NEAR(model.theta_deg.data()[row], grid.theta_deg.data()[cell], 1e3 * same_pose);
      EXPECT_NEAR(model.ty_mm.data()[row], grid.ty_mm.data()[cell], same_pose);
      // Gaps and contacts as after the run.
      EXPECT_NEAR(model.gap_mm[0].data()[row], grid.gap_mm[0].data()[cell], 1e-6);
      EXPECT_NEAR(model.gap_mm[1].data()[row], grid.gap_mm[1].data()[cell], 1e-6);
      EXPECT_EQ(model.is_in_contact[0].data()[row], grid.is_in_contact[0].data()[cell]);
      EXPECT_EQ(model.is_in_contact[1].data()[row], grid.is_in_contact[1].data()[cell]);
      EXPECT_EQ(model.status.data()[row], 0);
      ++row;
    }
    EXPECT_GT(model.contacts.distance_mm.size(), 0u);
    ASSERT_EQ(model.audits.size(), 1u);
    EXPECT_EQ(model.audits[0].frame_key, model.frames->key);
    EXPECT_EQ(model.job.inputs.back().name, "walk_" + side + ".csv");
  }
}

TEST_F(Import, ReversesAnExport)
{
  for (const std::string side : {"right", "left"}) {
    const std::string file = imported_walk(side);
    const store::MotionModel model = store::read_motion_model(file);
    const std::vector<std::vector<std::string>> exports{
        {"csv", ".csv"},
        {"mot", ".mot"},
        {"sto", ".sto"},
        {"mot", ".mot", "--degrees"},
        {"sto", ".sto", "--translations", "mesh-origin"},
        {"csv", ".csv", "--full"},
        {"mot", ".mot", "--coordinate", "flexion=-knee_angle_r", "--coordinate", "varus=-v", "--coordinate",
         "tz=-z"}};
    const std::vector<std::string> signs{"--column", "flexion=-knee_angle_r",
                                         "--column", "varus=-v",
                                         "--column", "tz=-z",
                                         "--column", "tx=knee_tx_" + side.substr(0, 1),
                                         "--column", "ty=knee_ty_" + side.substr(0, 1)};
    for (const std::vector<std::string>& how : exports) {
      if (side == "right" && how.size() < 3) continue;  // the left one has all signs
      SCOPED_TRACE(side + testing::PrintToString(how));
      const std::string table = path("exported_" + side + how[1]), again = path("again_" + side + ".h5");
      std::vector<std::string> words{"export", file, "--to", how[0], "-o", table};
      words.insert(words.end(), how.begin() + 2, how.end());
      succeed(words);
      std::vector<std::string> import{"import", job_, "--motion", table, "-o", again, "--replace"};
      if (how.size() > 4) import.insert(import.end(), signs.begin(), signs.end());
      succeed(import);
      const store::MotionModel back = store::read_motion_model(again);
      expect_equal_poses(model, back);
      EXPECT_EQ(back.frames->key, model.frames->key);
      EXPECT_EQ(back.frames->key_name, "time_s");
    }
  }
}

TEST_F(Import, AGridIsImportedFromItsExport)
{
  const std::string file = solved_knee("left"), table = path("grid.csv"), back = path("back.h5");
  succeed({"export", file, "--to", "csv", "--set", "raw", "--varus", "1", "-o", table});
  succeed({"import", job_, "--motion", table, "-o", back});
  const store::MotionModel grid = store::read_motion_model(file), model = store::read_motion_model(back);
  ASSERT_EQ(model.frames->key.size(), 7u);
  EXPECT_EQ(model.frames->key_name, "frame");
  for (std::size_t i = 0; i < 7; ++i)
    for (std::size_t k = 0; k < 16; ++k)
      EXPECT_NEAR(model.X_reference_moving[16 * i + k], grid.X_reference_moving[16 * (5 * i + 3) + k],
                  same_pose);
}

TEST_F(Import, AnImportOfTheSameTableHasTheSameBytes)
{
  const std::string file = imported_walk("right"), bytes = test::text_of(file);
  succeed({"import", job_, "--motion", path("walk_right.csv"), "-o", file, "--threads", "2"});
  EXPECT_EQ(test::text_of(file), bytes);
}

TEST_F(Import, AnotherResultIsReplacedOnlyOnRequest)
{
  const std::string grid = solved_knee("right"), table = walk("right"), bytes = test::text_of(grid);
  test::expect_refused({"import", job_, "--motion", table, "-o", grid},
                       {grid, "output", {"another job"}, {"--replace"}});
  EXPECT_EQ(test::text_of(grid), bytes);
  succeed({"import", job_, "--motion", table, "-o", grid, "--replace"});
  EXPECT_TRUE(store::read_motion_model(grid).frames);
  // Another convention is another result.
  test::expect_refused({"import", job_, "--motion", table, "-o", grid, "--order", "xyz"},
                       {grid, "output", {"another job", "import.order"}, {"--replace"}});
}

TEST_F(Import, WhatCannotBeDistinguishedMustBeStated)
{
  // Bare names, and 12 degrees of flexion with little else: orders and sides leave the same gaps.
  std::string text = test::text_of(walk("right"));
  text.replace(0, text.find('\n'), "time,rz,rx,ry,tx,ty,tz");
  const std::string table = scratch_.write("bare.csv", text).string(), file = path("bare.h5");
  const test::Ended ended = test::run_vrda({"import", job_, "--motion", table, "-o", file, "--json"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(file));
  const json search = json::parse(ended.out);
  EXPECT_GT(search["equally_good"].get<int>(), 1);
  ASSERT_FALSE(search["undecided"].empty());
  for (const json& term : search["undecided"])
    EXPECT_THAT(ended.err, HasSubstr("--" + term.get<std::string>() + " "));
  succeed({"import", job_,        "--motion", table,     "-o",        file,          "--unit",
           "mm",     "--angles",  "deg",      "--order", "zxy",       "--direction", "moving-in-reference",
           "--axes", "canonical", "--side",   "right",   "--lengths", "origin"});
}

TEST_F(Import, AUnitMayBeStatedAgainstTheNumbers)
{
  solved_knee("right");
  const std::string table =
      scratch_
          .write("mixed.csv",
                 "time,flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n0,0.1,2,3,0,0,0\n"
                 "1,1.5,2,9,0,0,0\n")
          .string();
  EXPECT_THAT(succeed({"import", job_, "--motion", table, "-o", path("mixed.h5"), "--angles", "deg"}).err,
              HasSubstr("57.2958"));
}

// Internal rotation of 179.05, then -179.95 degrees; varus past 90 degrees.
TEST_F(Import, WrappedAnglesAreOneCurve)
{
  solved_knee("right");
  struct Row {
    double varus_deg, varus_step, internal_deg, internal_step;
    bool is_locked;
  };
  for (const Row& row : {Row{1, 0, 175.05, 1, false}, Row{85, 1, 5, 0, true}}) {
    SCOPED_TRACE(row.varus_deg);
    std::string text = "time,flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n";
    for (int k = 0; k <= 10; ++k) {
      const double internal_deg = std::remainder(row.internal_deg + k * row.internal_step, 360.0);
      text += std::to_string(k) + ",10," + shortest_decimal(row.varus_deg + k * row.varus_step) + "," +
              shortest_decimal(internal_deg) + ",0,-60,0\n";
    }
    const std::string file = path("wrapped.h5"), table = path("wrapped.mot");
    const std::string motion = scratch_.write("wrapped.csv", text).string();
    const test::Ended ended = succeed({"import", job_, "--motion", motion, "-o", file, "--replace"});
    EXPECT_EQ(ended.err.find("gimbal lock") != std::string::npos, row.is_locked) << ended.err;
    const json info = test::json_of({"info", file});
    EXPECT_EQ(info["gimbal_lock_poses"], row.is_locked ? 6 : 0);
    EXPECT_NEAR(std::abs(info["screw_home"]["peak"]["deg"].get<double>()), 10 * row.internal_step, same_pose);
    EXPECT_NEAR(info["clinical"]["varus_deg"]["max"].get<double>(), row.varus_deg + 10 * row.varus_step,
                1e-5);
    EXPECT_NEAR(info["grid"]["flexion_deg"][0].get<double>(), 10, same_pose);
    EXPECT_NEAR(info["surfaces"]["theta_deg"]["max"].get<double>(), row.internal_deg + 10 * row.internal_step,
                row.is_locked ? 360.0 : same_pose);
    // An export has the curve, and gives the same poses.
    succeed({"export", file, "--to", "mot", "--degrees", "-o", table});
    EXPECT_THAT(test::text_of(table), HasSubstr(row.is_locked ? "\t94" : "\t185.05"));
    succeed({"import", job_, "--motion", table, "-o", path("again.h5"), "--replace"});
    expect_equal_poses(store::read_motion_model(file), store::read_motion_model(path("again.h5")));
    const json report = test::json_of({"report", file, "-o", path("report"), "--quick"});
    const json& internal = report["models"][0]["curves"][0]["internal"];
    EXPECT_NEAR(internal.back().get<double>() - internal.front().get<double>(), 10 * row.internal_step, 1e-3);
  }
}

TEST_F(Import, CommandsTakeASequence)
{
  const std::string file = imported_walk("right");
  const json info = test::json_of({"info", file});
  EXPECT_EQ(info["frames"]["key_name"], "time_s");
  EXPECT_EQ(info["frames"]["key"], json({0.0, 1.75, 8}));
  EXPECT_THAT(succeed({"info", file}).out, HasSubstr("time_s"));

  const json audit = test::json_of({"audit", file, "--refine", "2"});
  EXPECT_EQ(audit[0]["attitudes"], 15);
  EXPECT_TRUE(audit[0]["largest_gap"].contains("key"));
  EXPECT_EQ(audit[0]["travel"]["steps"], 7);
  EXPECT_GT(audit[0]["travel"]["largest_deg"].get<double>(), 1.0);
  succeed({"audit", file});
  succeed({"validate", file});

  succeed({"export", file, "--to", "gltf", "-o", path("walk.glb")});
  succeed({"export", file, "--to", "vtk", "-o", path("walk.pvd")});
  const std::string series = test::text_of(path("walk.pvd"));
  for (const char* time : {"timestep=\"0\"", "timestep=\"0.25\"", "timestep=\"1.75\""})
    EXPECT_THAT(series, HasSubstr(time));

  const json report = test::json_of({"report", file, "-o", path("report"), "--quick"});
  EXPECT_EQ(report["models"][0]["key_name"], "time_s");
  EXPECT_EQ(report["models"][0]["flexion"], json({0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75}));
  // The last frame has the flexion of the first.
  const json& flexion = report["models"][0]["surfaces"][0]["frame_flexion"];
  EXPECT_EQ(flexion.front(), flexion.back());
  EXPECT_EQ(report["models"][0]["curves"][0]["flexion"], report["models"][0]["flexion"]);
}

// Its push turns with the pelvis; the imported motion has the Delta of the meshes, and no roles.
TEST_F(Import, AHipComesBackFromItsExport)
{
  const std::string hip = VRDA_SOURCE_DIR "/jobs/hip-generic.toml";
  succeed({"run", hip, "-o", path("hip.h5"), "--progress", "none", "--set", "coordinates.flexion.step=30"});
  succeed({"export", path("hip.h5"), "--to", "csv", "--set", "raw", "-o", path("hip.csv")});
  succeed({"import", hip, "--motion", path("hip.csv"), "-o", path("back.h5"), "--set",
           "coordinates.flexion.step=30"});
  const store::MotionModel back = store::read_motion_model(path("back.h5"));
  expect_equal_poses(store::read_motion_model(path("hip.h5")), back);
  EXPECT_FALSE(back.coordinates.has_value());
  // The key of both is the flexion, whose column the export had to rename.
  EXPECT_EQ(back.frames->key_name, "flexion_deg");
  const json info = test::json_of({"info", path("back.h5")});
  EXPECT_EQ(info["grid"]["roles"]["flexion"], "measured");
  for (Eigen::Index i = 0; i < back.push.delta.rows(); ++i)
    EXPECT_EQ(back.push.delta.row(i).transpose(), back.delta) << i;
}

}  // namespace vrda::import_test
