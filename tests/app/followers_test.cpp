// Bodies that follow the joint, from the job to the motion model and its readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "app/scenes.hpp"
#include "contact/contacts.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "job/thesis_files.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "support/meshes.hpp"
#include "support/messages.hpp"

namespace vrda::followers_app_test {

namespace fs = std::filesystem;

const store::FollowerRows& follower_of(const store::MotionModel& model)
{
  EXPECT_EQ(model.followers.size(), 1u);
  return model.followers.at(0);
}

double solved_share(const store::FollowerRows& follower)
{
  return static_cast<double>((follower.status == status_stable).count()) /
         static_cast<double>(follower.status.size());
}

// By Bullet's triangles, whole meshes and drawn parts: not the gap that the solver used.
bool crosses(const store::MotionModel& model, const store::FollowerRows& follower, std::size_t cell)
{
  contact::NarrowPhase narrow_phase;
  const geometry::TreeMesh own = geometry::make_tree_mesh(follower.body.contact.mesh);
  const geometry::RigidPlacement place(store::pose_in(follower.X_of_follower, cell));
  for (const Mesh* mesh : {&model.reference.contact.mesh, &model.reference.visual.mesh}) {
    if (mesh->triangles.rows() == 0) continue;
    if (contact::find_collision(geometry::make_tree_mesh(*mesh), own, place, narrow_phase)) return true;
  }
  return false;
}

// The generic knee's patella at every flexion of its job: solved, certified, free of overlap, in front of the
// femur, and turning with the knee as measured patellae do, by 0.6 to 0.9 degrees a degree.
TEST(Followers, TheKneecapFollowsTheGenericKnee)
{
  const store::MotionModel model = test::solved(fs::path(VRDA_SOURCE_DIR) / "jobs/knee-generic.toml",
                                                {"grid.varus=free", "grid.flexion.step=30"});
  const store::FollowerRows& patella = follower_of(model);
  EXPECT_EQ(patella.name, "patella");
  ASSERT_EQ(solved_share(patella), 1.0);
  for (std::size_t cell = 0; cell < 4; ++cell) {
    EXPECT_FALSE(crosses(model, patella, cell)) << cell;
    EXPECT_GE(patella.worst_gap_mm.data()[cell], -1e-4);
    EXPECT_LE(patella.balance_residual_n.data()[cell], 0.01 * 30.0);
  }
  const double rate = (patella.coordinates[JointCoordinate::flexion](3, 0) -
                       patella.coordinates[JointCoordinate::flexion](0, 0)) /
                      90.0;
  EXPECT_GT(rate, 0.6);
  EXPECT_LT(rate, 0.9);
  EXPECT_LT(patella.coordinates[JointCoordinate::proximal](3, 0), -30.0);
  // The lines carry 30 N, all of them on the patella.
  const store::LigamentRows& fibres = *patella.ligaments;
  double lines_n = 0.0;
  for (const double tension_n : fibres.constant_tension_n) lines_n += tension_n;
  EXPECT_NEAR(lines_n, 30.0, 1e-9);
  // What draws and exports it has the same pose at a cell.
  const store::JointPose pose = store::Motion(model, "raw").at({0.0, 0.0});
  ASSERT_TRUE(pose.has_follower[0]);
  EXPECT_LT(
      (pose.X_reference_follower[0].matrix() - store::pose_in(patella.X_of_follower, 0).matrix()).norm(),
      1e-9);
}

// A tendon of constant tension pulls the tibia as a line from the same point of the femur does.
TEST(Followers, ReactionEqualsALineFromWhereItsFibreEnds)
{
  const test::Scratch scratch;
  const fs::path job = test::sesamoid_job(scratch, test::small_knee_job(scratch, "right"));
  const std::vector<std::string> settings{"solver.method=equilibrium", "grid.flexion.to=0",
                                          "grid.varus=free"};
  const std::string lines =
      "name,bundle,from_body,from_x_mm,from_y_mm,from_z_mm,to_body,to_x_mm,to_y_mm,to_z_mm,tension_share\n"
      "line1,line,femur,70,20,30,bead,34,-18,23,2\nline2,line,femur,70,20,10,bead,34,-18,17,2\n"
      "line3,line,femur,20,40,20,bead,29,-18,20,1\n";
  scratch.write("bead.csv", lines + "tendon1,tendon,tibia,5,-12,20,bead,29,-22,20,1\n");
  test::edit(job, "tension_n = 20", "tension_n = 18\nreaction = true");
  test::edit(job, "[[follower.direction]]\nbundle = \"tendon\"\nstiffness_nmm_per_rad = 300\n", "");
  const store::MotionModel reacted = test::solved(job, settings);
  const store::FollowerRows& bead = follower_of(reacted);
  ASSERT_EQ(solved_share(bead), 1.0);
  const Eigen::Vector3d end = store::pose_in(bead.X_of_follower, 0) * Eigen::Vector3d(29, -22, 20);
  const fs::path other = test::small_knee_job(scratch, "right");
  const std::string line = "[[push.line]]\nname = \"tendon\"\nreference_mm = [[" + shortest_decimal(end.x()) +
                           "," + shortest_decimal(end.y()) + "," + shortest_decimal(end.z()) +
                           "]]\nmoving_mm = [[5, -12, 20]]\ntension_n = 3\n";
  test::edit(other, "[grid]\n", line + "[grid]\n");
  const store::MotionModel pulled = test::solved(other, settings);
  ASSERT_EQ(pulled.status(0, 0), status_stable);
  // Rounds end below 0.01 mm.
  EXPECT_NEAR(reacted.tx_mm(0, 0), pulled.tx_mm(0, 0), 0.02);
  EXPECT_NEAR(reacted.tz_mm(0, 0), pulled.tz_mm(0, 0), 0.02);
  EXPECT_NEAR(reacted.theta_deg(0, 0), pulled.theta_deg(0, 0), 0.05);
  const store::MotionModel unloaded = test::solved(test::small_knee_job(scratch, "right"), settings);
  EXPECT_GT(std::abs(unloaded.theta_deg(0, 0) - pulled.theta_deg(0, 0)), 1.0)
      << "the tendon pulls too little";
}

// A bead behind a hip's socket, pushed onto it and held by four lines across. Nothing of it is a knee's.
TEST(Followers, ASesamoidOfAHipNeedsNoOtherCode)
{
  const test::Scratch scratch;
  Mesh bead = test::ball(5.0);
  bead.vertices_mm.col(0).array() -= 45.0;
  scratch.write("bead.stl", job::stl_bytes(bead, "bead"));
  scratch.write("bead.csv",
                "name,from_body,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm,stiffness_n_per_strain,"
                "slack_length_mm,tension_share\n"
                "a,pelvis,-30,40,0,-45,4,0,,,1\nb,pelvis,-30,-40,0,-45,-4,0,,,1\n"
                "c,pelvis,-30,0,40,-45,0,4,,,1\nd,pelvis,-30,0,-40,-45,0,-4,,,1\n"
                "e,femur,-20,-5,0,-45,0,0,10,60,\n");
  std::string text = test::text_of(fs::path(VRDA_SOURCE_DIR) / "jobs/hip-generic.toml");
  text +=
      "\n[[follower]]\nname = \"bead\"\npush = { delta = [1, 0, 0], force_n = 5 }\nfibres = \"bead.csv\"\n"
      "[[follower.component]]\nname = \"bead\"\nfile = \"bead.stl\"\n";
  const store::MotionModel model =
      test::solved(scratch.write("hip.toml", text), {"coordinates.flexion={from=-20,to=0,step=20}"});
  const store::FollowerRows& follower = follower_of(model);
  ASSERT_EQ(solved_share(follower), 1.0);
  for (std::size_t cell = 0; cell < 2; ++cell) {
    const Eigen::Vector3d centre = store::pose_in(follower.X_of_follower, cell) * Eigen::Vector3d(-45, 0, 0);
    // The socket's wall is 24.5 + 6 mm about the origin, and its facets are up to 0.3 mm inside.
    EXPECT_NEAR(centre.norm(), 30.5 + 5.0, 0.3);
    EXPECT_LT(centre.x(), -34.0);
    EXPECT_FALSE(crosses(model, follower, cell));
  }
}

// A strain of the tendon that only the bead's measured motion shows, by the fit of a job that does not have
// it.
TEST(Followers, AFitFindsTheStrainOfATendonInTheMotionOfItsBody)
{
  const test::Scratch scratch;
  const fs::path job = test::sesamoid_job(scratch, test::small_knee_job(scratch, "right"));
  const std::vector<std::string> settings{"solver.method=equilibrium", "grid.flexion.step=4",
                                          "grid.varus=free", "smooth.degrees=[]"};
  const std::string text = test::text_of(job), fibres = *read_text_file(scratch.path() / "bead.csv");
  const auto with_strain = [&](const char* strain) {
    return std::regex_replace(fibres, std::regex("500,0.02"), std::string("500,") + strain);
  };
  scratch.write("bead.csv", with_strain("0.3"));
  scratch.write("true.csv", with_strain("0.33"));
  scratch.write("true.toml", std::regex_replace(text, std::regex("bead.csv"), "true.csv"));
  const auto at = [&](const char* file) { return (scratch.path() / file).string(); };
  const auto run = [&](std::vector<std::string> words) {
    for (const std::string& setting : words.front() == "run" ? settings : std::vector<std::string>{})
      words.insert(words.end(), {"--set", setting});
    const test::Ended ended = test::run_vrda(words);
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
  };
  run({"run", at("true.toml"), "-o", at("true.h5"), "--progress", "none"});
  run({"export", at("true.h5"), "--to", "csv", "-o", at("motion.csv"), "--set", "raw"});
  const std::string question = R"(
[fit]
noise = { varus_deg = inf, internal_deg = inf, anterior_mm = inf, proximal_mm = inf, lateral_mm = inf }
[[fit.follower]]
name = "bead"
noise = { flexion_deg = 0.1, rotation_deg = 0.1, tilt_deg = 0.1, anterior_mm = 0.05, proximal_mm = 0.05, lateral_mm = 0.05 }
[[fit.parameter]]
quantity = "reference_strain"
follower = "bead"
sd = 0.05
from = -0.1
to = 0.1
)";
  scratch.write("fit.toml", text + question);
  run({"fit", at("fit.toml"), "--to", at("motion.csv"), "-o", at("fitted.toml"), "--progress", "none",
       "--set", "solver.method=equilibrium"});
  const auto facts = nlohmann::json::parse(*read_text_file(scratch.path() / "fitted.fit.json"));
  EXPECT_EQ(facts["status"], "converged");
  const nlohmann::json& strain = facts["unknowns"][0];
  EXPECT_EQ(strain["name"], "bead reference_strain tendon");
  EXPECT_NEAR(strain["change"].get<double>(), 0.03, 3e-4);  // settled_decrease, in these deviations
  const nlohmann::json& misfit = facts["trials"][0]["followers"]["bead"];
  EXPECT_GT(misfit["rms_before"]["proximal_mm"].get<double>(), 0.1);
  EXPECT_LT(misfit["rms_after"]["proximal_mm"].get<double>(), 0.01);
  // The fitted job moves the bead as the true one does.
  run({"run", at("fitted.toml"), "-o", at("fitted.h5"), "--progress", "none"});
  const store::MotionModel truth = store::read_motion_model(at("true.h5"));
  const store::MotionModel fitted = store::read_motion_model(at("fitted.h5"));
  EXPECT_LT((follower_of(truth).coordinates[JointCoordinate::proximal] -
             follower_of(fitted).coordinates[JointCoordinate::proximal])
                .abs()
                .maxCoeff(),
            0.02);
}

// Lines without tension are left out; the strains of the table's other fibres stay theirs.
TEST(Followers, LinesWithoutTensionLeaveTheOtherFibresAsTheyAre)
{
  const test::Scratch scratch;
  const fs::path job = test::sesamoid_job(scratch, test::small_knee_job(scratch, "right"));
  const auto solved = [&](const char* tension) {
    return follower_of(test::solved(
        job, {"solver.method=equilibrium", "grid.varus=free", "grid.flexion={from=0,to=2,step=2}", tension}));
  };
  const store::FollowerRows pulled = solved("follower.0.tension_n=20"),
                            loose = solved("follower.0.tension_n=0");
  EXPECT_EQ(loose.ligaments->name, (std::vector<std::string>{"tendon1", "tendon2"}));
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_EQ(loose.ligaments->slack_length_mm[k], pulled.ligaments->slack_length_mm[3 + k]) << k;
}

// Each sample is the run of a job with its inputs, and the bands are those of the samples.
TEST(Followers, ASampleIsTheRunOfAJobWithItsInputs)
{
  const test::Scratch scratch;
  const fs::path job = test::sesamoid_job(scratch, test::small_knee_job(scratch, "right"));
  const std::vector<std::string> settings{"solver.method=equilibrium", "grid.varus=free",
                                          "grid.flexion={from=0,to=4,step=4}"};
  const std::string text = test::text_of(job);
  scratch.write("uncertain.toml", text + test::uncertain_sesamoid);
  const store::MotionModel model = test::solved(scratch.path() / "uncertain.toml", settings);
  ASSERT_TRUE(model.uncertainty);
  const store::UncertainMotion& motion = *model.uncertainty;
  EXPECT_THAT(
      motion.draw,
      testing::ElementsAre("load bead tension", "stiffness bead tendon",
                           "attachment bead moving tendon anterior", "attachment bead moving tendon proximal",
                           "attachment bead moving tendon right", "direction bead tendon"));
  ASSERT_EQ(motion.followers.size(), 1u);
  const store::UncertainFollower& bead = motion.followers[0];
  EXPECT_THAT(bead.n_solved, testing::ElementsAre(10, 10));
  for (const std::size_t s : {2u, 7u}) {
    SCOPED_TRACE(s);
    const double* drawn = motion.value.data() + 6 * s;
    // Attachments keep their strain in the scan.
    const fs::path other = scratch.write(
        "other.csv", std::regex_replace(test::text_of(scratch.path() / "bead.csv"), std::regex(",500,"),
                                        "," + shortest_decimal(500.0 * drawn[1]) + ","));
    for (const double z_mm : {18.0, 22.0})
      test::edit(other, "tibia,5,-12," + shortest_decimal(z_mm),
                 "tibia," + shortest_decimal(5.0 + drawn[2]) + "," + shortest_decimal(drawn[3] - 12.0) + "," +
                     shortest_decimal(z_mm + drawn[4]));
    std::vector<std::string> own = settings;
    own.push_back("follower.0.tension_n=" + shortest_decimal(20.0 + drawn[0]));
    own.push_back("follower.0.fibres=other.csv");
    own.push_back("follower.0.direction.0.rest_deg=" + shortest_decimal(drawn[5]));
    const store::FollowerRows alone = follower_of(test::solved(job, own));
    for (std::size_t i = 0; i < 2; ++i) {
      // The joint starts elsewhere: its equilibria agree within the solver's tolerance.
      EXPECT_NEAR(bead.translation_mm[3 * (2 * s + i) + 1],
                  alone.coordinates[JointCoordinate::proximal].data()[i], 0.05);
      EXPECT_NEAR(bead.rotation_deg[3 * (2 * s + i)], alone.coordinates[JointCoordinate::flexion].data()[i],
                  0.5);
    }
  }
  EXPECT_GT(bead.translation_band_mm[3 * 4 * 2 + 1] - bead.translation_band_mm[1], 0.1)
      << "the inputs change too little";
}

using FollowerCommands = test::CommandTest;

TEST_F(FollowerCommands, BandsAndPlansNameThem)
{
  const fs::path job = test::sesamoid_job(scratch_, test::small_knee_job(scratch_, "right"));
  scratch_.write("uncertain.toml", test::text_of(job) + test::uncertain_sesamoid);
  const std::string model = path("model.h5");
  succeed({"run", path("uncertain.toml"), "-o", model, "--progress", "none", "--set",
           "solver.method=equilibrium", "--set", "grid.varus=free", "--set",
           "grid.flexion={from=0,to=2,step=2}"});
  EXPECT_THAT(succeed({"bands", model}).out, testing::HasSubstr(",bead_proximal_p50_mm,"));
  EXPECT_THAT(succeed({"bands", model, "--table", "shares"}).out,
              testing::HasSubstr("\nbead_tilt,\"load bead tension\",2,"));
  EXPECT_THAT(succeed({"bands", model, "--table", "samples"}).out,
              testing::HasSubstr(",bead_status,bead_flexion_deg,"));
  const nlohmann::json plan = test::json_of(
      {"plan", scratch_
                   .write("study.toml",
                          "[campaign]\ntitle = \"Beads\"\n[[campaign.subject]]\nname = \"knee\"\njob = \"" +
                              job.filename().string() +
                              "\"\n[[campaign.method]]\nname = \"low\"\nset = { follower.0.tension_n = 10 }\n"
                              "[[campaign.method]]\nname = \"high\"\nset = { follower.0.tension_n = 30 }\n")
                   .string()});
  ASSERT_EQ(plan.at("cases").size(), 2u);
  EXPECT_EQ(plan.at("cases").at(1).at("name"), "knee_high");
}

// What `export` writes of a model is read again as measured frames, and a column with the other sign.
TEST_F(FollowerCommands, MeasuredFramesAreImported)
{
  const fs::path job = test::sesamoid_job(scratch_, test::small_knee_job(scratch_, "right"));
  const std::string model = path("model.h5"), frames = path("frames.h5");
  succeed({"run", job.string(), "-o", model, "--progress", "none", "--set", "solver.method=equilibrium"});
  succeed({"export", model, "--to", "csv", "-o", path("t.csv"), "--set", "raw", "--varus", "0"});
  succeed({"import", job.string(), "--motion", path("t.csv"), "-o", frames});
  const store::MotionModel solved = store::read_motion_model(model),
                           measured = store::read_motion_model(frames);
  const store::FollowerRows& bead = follower_of(measured);
  ASSERT_EQ(solved_share(bead), 1.0);
  EXPECT_EQ(bead.status.rows(), 7);
  for (Eigen::Index i = 0; i < 7; ++i)
    EXPECT_NEAR(bead.coordinates[JointCoordinate::proximal](i, 0),
                follower_of(solved).coordinates[JointCoordinate::proximal](i, 2), 1e-9)
        << i;
  EXPECT_EQ(measured.audits.at(0).followers.at(0).name, "bead");
  succeed({"import", job.string(), "--motion", path("t.csv"), "-o", path("other.h5"), "--follower-column",
           "bead.proximal=-follower_bead_proximal_mm"});
  EXPECT_NEAR(
      follower_of(store::read_motion_model(path("other.h5"))).coordinates[JointCoordinate::proximal](3, 0),
      -bead.coordinates[JointCoordinate::proximal](3, 0), 1e-9);
  // OpenSim's tables have them in rad or degrees and m.
  for (const std::string unit : {"rad", "degrees"}) {
    const std::string sto = path(unit + ".sto"), again = path(unit + ".h5");
    std::vector<std::string> to_sto{"export", model,   "--to", "sto",     "-o",
                                    sto,      "--set", "raw",  "--varus", "0"};
    if (unit == "degrees") to_sto.emplace_back("--degrees");
    succeed(to_sto);
    EXPECT_THAT(test::text_of(sto), testing::HasSubstr("\tfollower_bead_flexion_" + unit.substr(0, 3)));
    // Without a unit in the names that of the header holds.
    const std::regex units("(follower_bead_[a-z]+)_(rad|deg|m)");
    for (const std::string& text :
         {test::text_of(sto), std::regex_replace(test::text_of(sto), units, "$1")}) {
      scratch_.write("again.sto", text);
      succeed({"import", job.string(), "--motion", path("again.sto"), "-o", again, "--replace"});
      const store::MotionModel read = store::read_motion_model(again);
      for (std::size_t k = 0; k < n_joint_coordinates; ++k)
        EXPECT_LT((follower_of(read).coordinates[k] - bead.coordinates[k]).cwiseAbs().maxCoeff(), 1e-9)
            << unit << k;
    }
  }
  std::string table = test::text_of(path("t.csv"));
  table.replace(table.find("follower_bead_tilt_deg"), 22, "unknown_column_of_tilt");
  scratch_.write("part.csv", table);
  EXPECT_THAT(test::run_vrda({"import", job.string(), "--motion", path("part.csv"), "-o", path("part.h5")}),
              test::refuses({path("part.csv"), "", {"follower_bead_tilt"}, {"all six coordinates of bead"}}));
}

TEST_F(FollowerCommands, InfoTablesAndScenesShowIt)
{
  const fs::path job = test::sesamoid_job(scratch_, test::small_knee_job(scratch_, "right"));
  const std::string model = path("model.h5");
  succeed({"run", job.string(), "-o", model, "--progress", "none", "--set", "solver.method=equilibrium"});
  const nlohmann::json info = test::json_of({"info", model, "--json"});
  ASSERT_EQ(info["followers"].size(), 1u);
  EXPECT_EQ(info["followers"][0]["name"], "bead");
  EXPECT_EQ(info["followers"][0]["stable"], 35);
  EXPECT_TRUE(info["curves"].contains("follower_bead_flexion_deg"));
  EXPECT_THAT(succeed({"info", model}).out, testing::HasSubstr("bead follows: 35 of 35 attitudes solved"));
  succeed({"export", model, "--to", "csv", "-o", path("t.csv")});
  EXPECT_THAT(test::text_of(path("t.csv")), testing::HasSubstr("follower_bead_proximal_mm"));
  succeed({"export", model, "--to", "csv", "--full", "-o", path("full.csv")});
  EXPECT_THAT(test::text_of(path("full.csv")), testing::HasSubstr(",follower_bead_plausibility,"));
  const nlohmann::json compared =
      test::json_of({"compare", model, "--degrees", "1,2", "--refine", "1", "--json"});
  const nlohmann::json& bead = compared["degrees"][1]["followers"]["bead"];
  EXPECT_EQ(bead["surfaces"].size(), 6u);
  EXPECT_LT(bead["surfaces"]["proximal"]["rms"],
            compared["degrees"][0]["followers"]["bead"]["surfaces"]["proximal"]["rms"]);
  EXPECT_EQ(bead["at_grid"]["attitudes"], 35);
  EXPECT_THAT(succeed({"compare", model, "--degrees", "1", "--refine", "0"}).out,
              testing::HasSubstr("flexion deg  rotation deg"));
  succeed({"export", model, "--to", "gltf", "-o", path("t.glb")});
  EXPECT_THAT(test::text_of(path("t.glb")), testing::HasSubstr("tendon1"));
}

}  // namespace vrda::followers_app_test
