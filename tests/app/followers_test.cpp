// Bodies that follow the joint, from the job to the motion model and its readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "contact/contacts.hpp"
#include "core/text.hpp"
#include "job/thesis_files.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "support/meshes.hpp"

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
  const double rate = (patella.flexion_deg(3, 0) - patella.flexion_deg(0, 0)) / 90.0;
  EXPECT_GT(rate, 0.6);
  EXPECT_LT(rate, 0.9);
  EXPECT_LT(patella.proximal_mm(3, 0), -30.0);
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

using FollowerCommands = test::CommandTest;

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
  succeed({"export", model, "--to", "gltf", "-o", path("t.glb")});
  EXPECT_THAT(test::text_of(path("t.glb")), testing::HasSubstr("tendon1"));
}

}  // namespace vrda::followers_app_test
