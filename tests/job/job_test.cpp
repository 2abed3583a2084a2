// [coordinates] and [frames]: roles and values by row.
// [push]: loads, lines, and the lateral force across Delta.
#include <gmock/gmock.h>

#include <cmath>
#include <tuple>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/job_parts.hpp"
#include "job/mesh_text.hpp"
#include "job/thesis_files.hpp"
#include "support/real_knees.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::job_test {

using testing::ElementsAre;
using testing::HasSubstr;

job::Job job_of(const std::string& text, const std::vector<std::string>& overrides = {})
{
  const test::Scratch scratch;
  return job::read_job(scratch.write("knee.toml", text).string(), overrides);
}

TEST(Job, DefaultsAreThoseOfTheSpecification)
{
  const job::Job job = job_of(test::small_job());
  EXPECT_EQ(job.joint, "knee");
  EXPECT_EQ(job.side, Side::right);
  EXPECT_EQ(job.frame.unit, "mm");
  EXPECT_EQ(job.initial.translation_mm, Eigen::Vector3d(0, -20, 0));
  EXPECT_EQ(job.grid.flexion_deg.size(), 91U);
  EXPECT_EQ(job.grid.varus_deg.size(), 21U);
  EXPECT_EQ(job.grid.flexion_deg.back(), 90.0);
  EXPECT_EQ(job.grid.varus_deg.front(), -10.0);
  EXPECT_EQ(job.method, job::SolverMethod::equilibrium);
  // The defaults of the schema and of the options structs agree.
  const SearchOptions own;
  EXPECT_EQ(job.search.approach_step_mm, own.approach_step_mm);
  EXPECT_EQ(job.search.translation_step_mm, own.translation_step_mm);
  EXPECT_EQ(job.search.translation_resolution_mm, own.translation_resolution_mm);
  EXPECT_EQ(job.search.rotation_step_rad, own.rotation_step_rad);
  EXPECT_EQ(job.search.rotation_resolution_rad, own.rotation_resolution_rad);
  EXPECT_EQ(job.search.points, own.points);
  EXPECT_EQ(job.search.normals, own.normals);
  EXPECT_EQ(job.search.max_steps, own.max_steps);
  EXPECT_EQ(job.equilibrium.tolerance_mm, EquilibriumOptions{}.tolerance_mm);
  EXPECT_EQ(job.equilibrium.max_iterations, EquilibriumOptions{}.max_iterations);
  EXPECT_EQ(job.push.force_n.value(0, 0), 20.0);
  EXPECT_FALSE(job.ligaments.has_value());
  EXPECT_THAT(job.smooth_degrees, ElementsAre(6));
  EXPECT_TRUE(job.smooth_recontact);
  EXPECT_FALSE(job.smooth_robust);
  EXPECT_EQ(job.unsolved_fraction, 0.0);
  ASSERT_TRUE(job.compartments);
  EXPECT_EQ(job.compartments->at(0).half_space, "left");
  EXPECT_EQ(job.compartments->at(1).half_space, "right");
}

const char* const every_key = R"(
title = "All"
joint = "other"
side = "left"
[frame]
unit = "cm"
anterior = "-Y"
proximal = "+Z"
right = "-X"
origin = [1, 2, 3]
align = { rotation_deg = [180, 90, 0], translation_mm = [4, 5, 6] }
[reference]
name = "femur"
[[reference.component]]
name = "a"
file = "a.stl"
material = "cartilage"
winding = "inward"
[[reference.component]]
name = "b"
generate = { shape = "knee", part = "femur", resolution = 2, side = "left" }
contact = false
[moving]
name = "tibmen"
initial = { translation_mm = [1, -30, 2], theta_deg = 180 }
[[moving.component]]
name = "c"
file = "c.ply"
[push]
delta = [0, 3, 4]
force_n = { flexion_deg = [0, 90], value = [20, 40] }
lateral_force_n = [1, 2]
moment_nmm = { flexion_deg = [0, 30, 60], value = [0, 5, 0] }
point_mm = [0, 0, 1]
[grid]
flexion = { from = 0, to = 1, step = 0.25 }
varus = { from = 4, to = -4, step = -4 }
[solver]
method = "stability-search"
[solver.search]
approach_step_mm = 6
translation_step_mm = 2
translation_resolution_mm = 0.2
rotation_step_deg = 180e-2
rotation_resolution_deg = 0.18
points = "triangle-centre"
normals = "reference"
max_steps = 7
[solver.equilibrium]
tolerance_mm = 1e-3
max_iterations = 9
[ligaments]
wraps = "wraps.json"
transition_strain = 0.03
[[ligaments.fibre]]
name = "ACL"
reference_mm = [1, 2, 3]
moving_mm = [4, 5, 6]
stiffness_n = 100
slack_length_mm = 30
bundle = "am"
wrap = "Capsule"
[compartments]
medial = { half_space = "right" }
lateral = { components = ["c"] }
[smooth]
degrees = [2, 4]
recontact = false
robust = true
[limits]
unsolved_fraction = 0.25
[player]
display_px = [1280, 1024]
zoom = 2
render = "wire"
[[player.view]]
number = 3
shift_mm = [1, 2, 3]
)";

TEST(Job, EveryKeyArrivesInInternalUnits)
{
  const job::Job job = job_of(every_key);
  EXPECT_EQ(job.title, "All");
  EXPECT_EQ(job.joint, "other");
  EXPECT_EQ(job.side, Side::left);
  EXPECT_EQ(job.frame.origin_native, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(job.frame.align_rotation_rad, Eigen::Vector3d(pi, pi / 2, 0));
  EXPECT_EQ(job.frame.align_translation_mm, Eigen::Vector3d(4, 5, 6));
  ASSERT_EQ(job.reference.components.size(), 2U);
  EXPECT_EQ(job.reference.components[0].winding, job::Winding::inward);
  EXPECT_EQ(job.reference.components[0].material, "cartilage");
  EXPECT_FALSE(job.reference.components[1].has_contact);
  ASSERT_TRUE(job.reference.components[1].generate.has_value());
  EXPECT_EQ(job.reference.components[1].generate->numbers.at("resolution"), 2.0);
  EXPECT_EQ(job.reference.components[1].generate->words.at("side"), "left");
  EXPECT_EQ(job.initial.translation_mm, Eigen::Vector3d(1, -30, 2));
  EXPECT_EQ(job.initial.theta_rad, pi);
  EXPECT_EQ(job.push.delta.value.row(0), Eigen::RowVector3d(0, 0.6, 0.8));
  EXPECT_EQ(job.push.force_n.flexion_rad.at(1), pi / 2);
  EXPECT_EQ(job.push.force_n.value(1, 0), 40.0);
  EXPECT_EQ(job.push.lateral_force_n.value.row(0), Eigen::RowVector2d(1, 2));
  EXPECT_EQ(job.push.moment_nmm.value.rows(), 3);
  EXPECT_THAT(job.grid.flexion_deg, ElementsAre(0, 0.25, 0.5, 0.75, 1));
  EXPECT_THAT(job.grid.varus_deg, ElementsAre(4, 0, -4));
  EXPECT_EQ(job.search.rotation_step_rad, rad_from_deg(1.8));
  EXPECT_EQ(job.search.points, ContactPoints::triangle_centre);
  EXPECT_EQ(job.search.normals, ContactNormals::reference);
  EXPECT_EQ(job.search.max_steps, 7);
  EXPECT_EQ(job.equilibrium.max_iterations, 9);
  ASSERT_TRUE(job.ligaments.has_value());
  EXPECT_EQ(job.ligaments->fibres.at(0).moving_native_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(job.ligaments->fibres.at(0).bundle, "am");
  EXPECT_EQ(job.ligaments->fibres.at(0).slack_length_mm, 30.0);
  EXPECT_FALSE(job.ligaments->fibres.at(0).reference_strain.has_value());
  EXPECT_EQ(job.ligaments->transition_strain, 0.03);
  EXPECT_THAT(job.compartments->at(1).components, ElementsAre("c"));
  EXPECT_THAT(job.smooth_degrees, ElementsAre(2, 4));
  EXPECT_FALSE(job.smooth_recontact);
  EXPECT_TRUE(job.smooth_robust);
  EXPECT_EQ(job.unsolved_fraction, 0.25);
}

TEST(Job, ARangeEndsAtItsLastWholeStepAndMayBeOneAngle)
{
  EXPECT_THAT(
      job_of(test::small_job("", "[grid]\nflexion = { from = 0, to = 10, step = 4 }")).grid.flexion_deg,
      ElementsAre(0, 4, 8));
  EXPECT_THAT(job_of(test::small_job("", "[grid]\nflexion = { from = 5, to = 5 }")).grid.flexion_deg,
              ElementsAre(5));
  // 0.1 is not a binary fraction; three steps must still reach 0.3.
  EXPECT_EQ(job_of(test::small_job("", "[grid]\nflexion = { from = 0, to = 0.3, step = 0.1 }"))
                .grid.flexion_deg.size(),
            4U);
}

TEST(Job, AResolvedJobIsAJobAndResolvesToItself)
{
  for (const std::string& text : {test::small_job(), std::string(every_key)}) {
    const std::string resolved = job_of(text).resolved_text;
    EXPECT_EQ(job_of(resolved).resolved_text, resolved);
  }
}

TEST(Job, EqualJobsGiveEqualText)
{
  const std::string plain = job_of(test::small_job()).resolved_text;
  // Explicit defaults, another order, other notations of the same numbers, overrides, comments.
  EXPECT_EQ(job_of(test::small_job("side = \"right\" # as ever\njoint = \"knee\"\n")).resolved_text, plain);
  EXPECT_EQ(
      job_of(test::small_job("", "[grid]\nvarus = { step = 1.0, to = 1e1, from = -10 }\n")).resolved_text,
      plain);
  EXPECT_EQ(job_of(test::small_job("", "[limits]\nunsolved_fraction = -0.0\n")).resolved_text, plain);
  EXPECT_EQ(job_of(test::small_job("side = \"left\"\n"), {"side=right"}).resolved_text, plain);
  EXPECT_EQ(
      job_of(
          test::small_job(
              "",
              "[compartments]\nlateral = { half_space = \"right\" }\nmedial = { half_space = \"left\" }\n"))
          .resolved_text,
      plain);
  EXPECT_NE(job_of(test::small_job(), {"side=left"}).resolved_text, plain);
  EXPECT_THAT(plain, testing::Not(HasSubstr("knee.toml")));
}

TEST(Job, AGeneratedKneeTakesTheJobsSideUnlessItHasItsOwn)
{
  const std::string text = R"(
[[reference.component]]
name = "femur"
generate = { shape = "knee", part = "femur" }
[[moving.component]]
name = "tibia"
generate = { shape = "knee", part = "tibia", side = "right" }
)";
  const job::Job job = job_of(text, {"side=left"});
  EXPECT_EQ(job.reference.components[0].generate->words.at("side"), "left");
  EXPECT_EQ(job.moving.components[0].generate->words.at("side"), "right");
  EXPECT_EQ(job.compartments->at(0).half_space, "right");
}

TEST(Job, ACampaignIsCheckedAndLeftOutOfTheResolvedJob)
{
  const std::string campaign = "[campaign]\n[[campaign.method]]\nname = \"a\"\n";
  const job::Job job = job_of(test::small_job("", campaign));
  EXPECT_TRUE(job.has_campaign);
  EXPECT_EQ(job.resolved_text, job_of(test::small_job()).resolved_text);
}

using testing::Not;

const std::string models = "MODEL 0 femur\nMODEL 1 tibmen\n";

job::Job converted(const std::string& text, const std::string& unit = "m")
{
  const test::Scratch scratch;
  const job::KeywordConfiguration configuration =
      job::parse_configuration({"k.cfg", text}, job::mm_per_unit(unit));
  const std::string toml = job::job_text(configuration, {"a \"title\"", "k.cfg", "../models", unit});
  return job::read_job(scratch.write("k.toml", toml).string());
}

TEST(JobText, settings)
{
  const job::Job job = converted(models +
                                 "INITIAL_POSITION 1 0.001 -0.02 0.003\nINITIAL_MOTION 1 0 0.004 0\n"
                                 "CONTACT_RESOLUTION 0.0002\nMODELING_RESOLUTION 0.002\n"
                                 "ORIENTATION_RESOLUTION 0.3\nORIENTATION_STEP 3\n"
                                 "ANGLE_RANGE 0 0 90 2\nANGLE_RANGE 1 15 -15\n");
  EXPECT_EQ(job.title, "a \"title\"");
  EXPECT_EQ(job.side, Side::left);
  EXPECT_EQ(job.reference.components.front().file, "../models/femur.obj");
  EXPECT_EQ(job.moving.name, "tibmen");
  EXPECT_EQ(job.initial.translation_mm, Eigen::Vector3d(3, -20, -1));
  EXPECT_EQ(job.push.delta.value.row(0), Eigen::RowVector3d(0, 1, 0));
  EXPECT_EQ(job.search.approach_step_mm, 4.0);
  EXPECT_EQ(job.search.translation_step_mm, 2.0);
  EXPECT_EQ(job.search.translation_resolution_mm, 0.2);
  EXPECT_EQ(job.search.rotation_step_rad, rad_from_deg(3.0));
  EXPECT_EQ(job.search.rotation_resolution_rad, rad_from_deg(0.3));
  EXPECT_EQ(job.grid.flexion_deg.size(), 46u);
  EXPECT_EQ(job.grid.varus_deg.front(), 15.0);
  EXPECT_EQ(job.grid.varus_deg.size(), 31u);
  EXPECT_THAT(job.resolved_text, Not(HasSubstr("player")));
}

TEST(JobText, directions)
{
  const job::Job left = converted(models + "INITIAL_MOTION 1 0.002 0 0\nINITIAL_ORIENTATION 1 30 0 0\n");
  EXPECT_EQ(left.push.delta.value.row(0), Eigen::RowVector3d(0, 0, -1));
  EXPECT_EQ(left.initial.theta_rad, rad_from_deg(-30.0));
  const job::Job down = converted(models + "INITIAL_MOTION 1 0 -0.002 0\nINITIAL_ORIENTATION 1 0 30 0\n");
  EXPECT_EQ(down.push.delta.value.row(0), Eigen::RowVector3d(0, -1, 0));
  EXPECT_EQ(down.initial.theta_rad, rad_from_deg(30.0));
}

TEST(JobText, several_models)
{
  const job::Job job = converted("MODEL 0 Femur\nMODEL 1 Tibia\nMODEL 1 Medmen\nMODEL 1 Latmen\n");
  ASSERT_EQ(job.moving.components.size(), 3u);
  EXPECT_EQ(job.moving.name, "Tibia");
  EXPECT_EQ(job.moving.components[2].file, "../models/Latmen.obj");
}

TEST(JobText, views)
{
  const job::Job job = converted(models +
                                 "SHIFT_MODEL 2 -0.1 0 0.05\nORIENTATION_MODEL 2 0 90 0\n"
                                 "ORIENTATION_MODEL 0 10 0 0\nDISPLAY 1280 1024\nZOOM 2.5\nRENDER wire\n");
  EXPECT_THAT(job.resolved_text,
              HasSubstr("[player]\ndisplay_px = [1280, 1024]\nzoom = 2.5\nrender = \"wire\"\n"));
  EXPECT_THAT(job.resolved_text,
              HasSubstr("number = 0\nshift_mm = [0, 0, 0]\norientation_deg = [10, 0, 0]\n"));
  EXPECT_THAT(job.resolved_text,
              HasSubstr("number = 2\nshift_mm = [-100, 0, 50]\norientation_deg = [0, 90, 0]\n"));
}

constexpr const char* motion =
    "# measured\n"
    "time_s,flexion_deg,internal_deg,ant_mm\n"
    "0.0,10,1,0.5\n"
    "0.1,5,2,0.7\n"
    "0.2,20,-1,\n";

job::Job job_with(const std::string& settings, const std::vector<std::string>& overrides = {})
{
  return job::parse_job("job.toml", test::small_job() + settings, overrides);
}

job::LoadedCoordinates loaded(const std::string& settings, const std::string& table = motion)
{
  const test::Scratch scratch;
  scratch.write("motion.csv", table);
  const job::Job job = job_with(settings);
  EXPECT_TRUE(job.coordinates.has_value());
  return job::load_coordinates(job, *job.coordinates, scratch.path().string());
}

constexpr const char* frames = "[frames]\nfile = \"motion.csv\"\n[coordinates]\n";

TEST(Coordinates, grid)
{
  const job::Job grid = job_with("[grid]\nflexion = { from = 0, to = 90, step = 5 }\nvarus = \"free\"\n");
  const job::Job same =
      job_with("[coordinates]\nflexion = { from = 0, to = 90, step = 5 }\nvarus = \"free\"\n");
  EXPECT_FALSE(same.coordinates);
  EXPECT_EQ(same.grid.flexion_deg, grid.grid.flexion_deg);
  EXPECT_TRUE(same.is_varus_free);
  const job::Job both = job_with(
      "[coordinates]\nflexion = { from = 0, to = 9, step = 3 }\nvarus = { from = -2, to = 2, step = 1 }\n");
  EXPECT_FALSE(both.coordinates);
  EXPECT_THAT(both.grid.varus_deg, ElementsAre(-2, -1, 0, 1, 2));
}

TEST(Coordinates, frames)
{
  const job::LoadedCoordinates c =
      loaded(std::string(frames) +
             "flexion = { column = \"flexion_deg\" }\ninternal = { column = \"internal_deg\" }\n"
             "proximal = -3.5\n");
  EXPECT_EQ(c.rows.key_name, "time_s");
  EXPECT_THAT(c.rows.key, ElementsAre(0.0, 0.1, 0.2));
  EXPECT_THAT(c.grid.flexion_deg, ElementsAre(10.0, 5.0, 20.0));
  EXPECT_THAT(c.grid.varus_deg, ElementsAre(0.0));
  ASSERT_EQ(c.rows.rows.size(), 3U);
  EXPECT_EQ(c.rows.rows[1](0), rad_from_deg(5.0));
  EXPECT_EQ(c.rows.rows[2](2), rad_from_deg(-1.0));
  EXPECT_EQ(c.rows.rows[0](4), -3.5);
  for (const Eigen::Index free : {1, 3, 5}) EXPECT_TRUE(std::isnan(c.rows.rows[0](free)));
  EXPECT_EQ(c.rows.role[0], CoordinateRole::given);
  EXPECT_EQ(c.rows.role[1], CoordinateRole::free);
  ASSERT_EQ(c.inputs.size(), 1U);
  EXPECT_EQ(c.inputs[0].name, "motion.csv");
}

TEST(Coordinates, over_driving)
{
  const std::string push = "[push]\nforce_n = { driving = [-2, 2], value = [100, 300] }\n";
  const job::LoadedCoordinates c =
      loaded(push +
             "[coordinates]\nflexion = \"free\"\nanterior = { from = -2, to = 2, step = 2 }\n"
             "internal = { driving = [-2, 0, 1], value = [4, 8, 10] }\n");
  ASSERT_EQ(c.rows.rows.size(), 3U);
  for (const auto& [row, internal_deg, force_n] :
       {std::tuple(0, 4.0, 100.0), {1, 8.0, 200.0}, {2, 10.0, 300.0}}) {
    const auto i = static_cast<std::size_t>(row);
    EXPECT_EQ(c.rows.rows[i](2), rad_from_deg(internal_deg)) << row;
    EXPECT_NEAR(job::push_at(c.push, Eigen::Vector3d::UnitY(), 0.0, i).force_n.y(), force_n, 1e-12) << row;
  }
  // Over a driving flexion it is the table over flexion.
  const job::Job over = job_with(push),
                 flexion = job_with("[push]\nforce_n = { flexion_deg = [-2, 2], value = [100, 300] }\n");
  EXPECT_EQ(over.push.force_n.flexion_rad, flexion.push.force_n.flexion_rad);
  EXPECT_FALSE(over.push.force_n.is_over_driving);
}

TEST(Coordinates, LoadsMayComeFromColumnsOfTheFrames)
{
  const std::string push =
      "[push]\nforce_n = { columns = [\"push_n\"] }\n[[push.load]]\nname = \"implant\"\nframe = \"moving\"\n"
      "force_n = { columns = [\"fx\", \"push_n\", \"fz\"] }\n";
  const std::string roles = std::string(frames) + "flexion = { column = \"flexion_deg\" }\n";
  const std::string table = "frame,flexion_deg,push_n,fx,fz\n1,0,20,1,2\n2,5,30,3,4\n";
  const job::LoadedCoordinates c = loaded(push + roles, table);
  EXPECT_EQ(c.push.force_n.value(1, 0), 30.0);
  EXPECT_EQ(c.push.loads.at(0).force_n.value(1, 2), 4.0);
  EXPECT_EQ(c.push.loads.at(0).force_n.value(0, 1), 20.0);
}

TEST(Coordinates, linear_table)
{
  const job::LoadedCoordinates c = loaded(
      "[coordinates]\nflexion = { from = 0, to = 30, step = 15 }\n"
      "internal = { file = \"motion.csv\", column = \"internal_deg\" }\n"
      "anterior = { flexion_deg = [0, 30], value = [2, 5] }\n",
      "flexion_deg,internal_deg\n0,0\n10,4\n40,7\n");
  EXPECT_FALSE(c.rows.is_sequence());
  ASSERT_EQ(c.path_flexion_deg.size(), 31U);  // steps of at most 1 degree
  EXPECT_NEAR(c.rows.rows[5](2), rad_from_deg(2.0), 1e-15);
  EXPECT_NEAR(c.rows.rows[25](2), rad_from_deg(5.5), 1e-15);
  EXPECT_NEAR(c.rows.rows[10](3), 3.0, 1e-14);
  EXPECT_EQ(c.rows.rows[15](0), rad_from_deg(15.0));
}

TEST(Coordinates, sequence)
{
  const job::LoadedCoordinates c =
      loaded("[coordinates]\nflexion = 30\ninternal = { from = -10, to = 10, step = 5 }\n");
  EXPECT_EQ(c.rows.key_name, "internal_deg");
  EXPECT_THAT(c.rows.key, ElementsAre(-10, -5, 0, 5, 10));
  EXPECT_THAT(c.grid.flexion_deg, testing::Each(testing::DoubleNear(30.0, 1e-13)));
  EXPECT_EQ(c.rows.rows[3](2), rad_from_deg(5.0));
}

TEST(Coordinates, one_frame)
{
  const job::LoadedCoordinates c = loaded("[coordinates]\nvarus = \"free\"\n");
  EXPECT_EQ(c.rows.key_name, "frame");
  ASSERT_EQ(c.rows.rows.size(), 1U);
  EXPECT_TRUE(c.rows.rows[0].array().isNaN().all());
}

TEST(Coordinates, two_driven)
{
  const job::LoadedCoordinates c = loaded(
      "[coordinates]\nflexion = { from = 0, to = 4, step = 2 }\nvarus = { from = -1, to = 1, step = 1 }\n"
      "internal = 5\n");
  EXPECT_THAT(c.grid.varus_deg, ElementsAre(-1, 0, 1));
  EXPECT_TRUE(std::isnan(c.rows.rows[0](1)));  // the grid's column
  EXPECT_EQ(c.rows.role[1], CoordinateRole::driven);
}

using test::refuses;

job::Job job_with_push(const std::string& push)
{
  return job::parse_job("knee.toml", test::small_job("", push));
}

const char* const loads_and_lines = R"(
[[push.load]]
name = "drawer"
frame = "moving"
force_n = { flexion_deg = [0, 90], value = [[10, 0, 0], [30, 0, -4]] }
moment_nmm = [1, 2, 3]
point_mm = [4, 5, 6]
[[push.load]]
name = "weight"
moment_nmm = [0, 0, 7]
[[push.line]]
name = "quadriceps"
tension_n = { flexion_deg = [30, 60], value = [0, 300] }
reference_mm = [[1, 2, 3], [4, 5, 6]]
moving_mm = [[7, 8, 9]]
)";

TEST(PushJob, over_flexion)
{
  const job::PushJob push = job_with_push(loads_and_lines).push;
  ASSERT_EQ(push.loads.size(), 2U);
  EXPECT_EQ(push.loads[0].at.name, "drawer");
  EXPECT_EQ(push.loads[0].at.frame, BodyIndex::moving);
  EXPECT_EQ(push.loads[0].at.point_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(push.loads[1].at.frame, BodyIndex::world);
  ASSERT_EQ(push.lines.size(), 1U);
  EXPECT_EQ(push.lines[0].path.reference_mm.at(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(push.lines[0].path.moving_mm.at(0), Eigen::Vector3d(7, 8, 9));
  const job::Push at = job::push_at(push, Eigen::Vector3d::UnitY(), rad_from_deg(45));
  EXPECT_LT((at.load_force_n.at(0) - Eigen::Vector3d(20, 0, -2)).norm(), 1e-12);
  EXPECT_EQ(at.load_moment_nmm.at(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(at.load_force_n.at(1), Eigen::Vector3d(0, 0, 0));
  EXPECT_NEAR(at.line_tension_n.at(0), 150, 1e-12);
}

job::Push pushed(const Eigen::Vector3d& delta)
{
  static const job::PushJob push = job_with_push("[push]\nforce_n = 10\nlateral_force_n = [3, -4]\n").push;
  return job::push_at(push, delta, 0.0);
}

TEST(PushJob, lateral_force)
{
  EXPECT_EQ(pushed(Eigen::Vector3d::UnitY()).force_n, Eigen::Vector3d(3, 10, -4));
  for (const Eigen::Vector3d& given : {Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(1, 2, -3),
                                       Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0, 1)}) {
    const Eigen::Vector3d delta = given.normalized();
    const Eigen::Vector3d force_n = pushed(delta).force_n;
    EXPECT_NEAR(force_n.dot(delta), 10, 1e-12);
    EXPECT_NEAR(force_n.norm(), std::sqrt(125.0), 1e-12);
  }
  // With Delta backwards the first axis is proximal.
  EXPECT_LT((pushed({-1, 0, 0}).force_n - Eigen::Vector3d(-10, 3, -4)).norm(), 1e-12);
}

TEST(PushJob, continuous_axes)
{
  Eigen::Vector3d before = pushed(Eigen::Vector3d::UnitY()).force_n;
  // Round to 170 degrees from +Y; only -Y itself is singular.
  for (double angle = 0.0; angle < rad_from_deg(170); angle += 1e-3) {
    const Eigen::Vector3d force_n =
        pushed({0.6 * std::sin(angle), std::cos(angle), 0.8 * std::sin(angle)}).force_n;
    EXPECT_LT((force_n - before).norm(), 20 * 1e-3);
    before = force_n;
  }
}

TEST(PushJob, left_joint)
{
  const Eigen::Vector3d delta = Eigen::Vector3d(0.2, 0.9, 0.4).normalized(), mirror(1, 1, -1);
  const job::PushJob right = job_with_push("[push]\nlateral_force_n = [3, -4]\n").push;
  const job::PushJob left = job_with_push("[push]\nlateral_force_n = [3, 4]\n").push;
  EXPECT_LT((job::push_at(right, delta, 0).force_n -
             mirror.cwiseProduct(job::push_at(left, mirror.cwiseProduct(delta), 0).force_n))
                .norm(),
            1e-12);
}

}  // namespace vrda::job_test
