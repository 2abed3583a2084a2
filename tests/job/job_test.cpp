#include "job/job.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>

#include "job/mesh_text.hpp"
#include "support/real_knees.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::job_test {

using test::refuses;
using testing::ElementsAre;
using testing::HasSubstr;

job::Job job_of(const std::string& text, const std::vector<std::string>& overrides = {})
{
  const test::Scratch scratch;
  return job::read_job(scratch.write("knee.toml", text).string(), overrides);
}

InputError::Facts facts_of_job(const std::string& text, const std::vector<std::string>& overrides = {})
{
  return test::input_error([&] { job_of(text, overrides); });
}

TEST(Job, defaults)
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
  ASSERT_TRUE(job.medial && job.lateral);
  EXPECT_EQ(job.medial->half_space, "left");
  EXPECT_EQ(job.lateral->half_space, "right");
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

TEST(Job, every_key)
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
  EXPECT_THAT(job.lateral->components, ElementsAre("c"));
  EXPECT_THAT(job.smooth_degrees, ElementsAre(2, 4));
  EXPECT_FALSE(job.smooth_recontact);
  EXPECT_TRUE(job.smooth_robust);
  EXPECT_EQ(job.unsolved_fraction, 0.25);
}

TEST(Job, ranges)
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

TEST(Job, resolved_twice)
{
  for (const std::string& text : {test::small_job(), std::string(every_key)}) {
    const std::string resolved = job_of(text).resolved_text;
    EXPECT_EQ(job_of(resolved).resolved_text, resolved);
  }
}

TEST(JobErrors, ThePlayersPart)
{
  const auto facts_of_player = [](const std::string& text) {
    return facts_of_job(test::small_job("", "[player]\n" + text));
  };
  EXPECT_EQ(facts_of_player("display_px = [1280, 0]").field, "player.display_px.1");
  EXPECT_EQ(facts_of_player("zoom = 0").field, "player.zoom");
  EXPECT_EQ(facts_of_player("render = \"solid\"").field, "player.render");
  EXPECT_EQ(facts_of_player("[[player.view]]\nshift_mm = [0, 0, 0]").field, "player.view.0.number");
  EXPECT_THAT(facts_of_player("[[player.view]]\nnumber = 1\n[[player.view]]\nnumber = 1"),
              refuses({.field = "player.view.1.number", .found = "1"}));
}

TEST(Job, equal_jobs)
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

TEST(Job, generated_side)
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
  EXPECT_EQ(job.medial->half_space, "right");
}

struct BadJob {
  const char* text;  // replaces or follows the small job's tables
  std::string field;
  std::string found = {};
  std::string wanted = {};
};

void expect_refused(const BadJob& row)
{
  SCOPED_TRACE(row.text);
  const InputError::Facts facts = facts_of_job(test::small_job("", row.text));
  EXPECT_THAT(facts, refuses({"knee.toml", row.field, row.found, row.wanted}));
}

TEST(JobErrors, UnknownKeysNameTheNearestKnownOne)
{
  expect_refused({"[grid]\nvraus = \"free\"", "grid.vraus", "", "\"grid.varus\""});
  expect_refused({"[sovler]\nmethod = \"equilibrium\"", "sovler", "", "\"solver\""});
  expect_refused({"[solver]\nmax_steps = 5", "solver.max_steps", "", "\"solver.search.max_steps\""});
  expect_refused({"[[moving.component]]\nname = \"x\"\nfiles = \"x.stl\"", "moving.component.1.files", "",
                  "\"moving.component.file\""});
  expect_refused({"[grid]\nflexion = { form = 1 }", "grid.flexion.form", "", "\"grid.flexion.from\""});
}

TEST(JobErrors, RangesAndSteps)
{
  expect_refused({"[grid]\nflexion = { step = 0 }", "grid.flexion.step", "0"});
  expect_refused({"[grid]\nvarus = { step = 0.0 }", "grid.varus.step", "0"});
  expect_refused({"[grid]\nflexion = { from = 90, to = 0 }", "grid.flexion", "90"});
  expect_refused({"[grid]\nvarus = { step = -1 }", "grid.varus", "-10"});
  expect_refused({"[grid]\nflexion = { step = 1e-7 }", "grid.flexion.step", "1e-07", "1000000"});
  expect_refused(
      {"[grid]\nflexion = { step = 0.01 }\nvarus = { step = 0.01 }", "grid", "18011001", "1000000"});
  expect_refused({"[grid]\nvarus = 3", "grid.varus", "3", "\"free\""});
  expect_refused({"[grid]\nflexion = []", "grid.flexion", "[]"});
}

TEST(JobErrors, TypesAndWords)
{
  expect_refused({"[solver]\nmethod = \"magic\"", "solver.method", "\"magic\"", "\"equilibrium\""});
  expect_refused({"[solver.search]\ntranslation_resolution_mm = 2", "solver.search.translation_resolution_mm",
                  "2", "1"});
  expect_refused(
      {"[solver.search]\nrotation_resolution_deg = 3", "solver.search.rotation_resolution_deg", "3", "1"});
  expect_refused({"[frame]\norigin = [1, 2]", "frame.origin", "[1, 2]"});
  expect_refused({"[frame]\norigin = [1, 2, \"3\"]", "frame.origin.2", "\"3\""});
  expect_refused({"[smooth]\ndegrees = [6, 6]", "smooth.degrees", "[6, 6]"});
  expect_refused({"[compartments]\nmedial = { half_space = \"left\" }", "compartments.lateral", "nothing",
                  "half_space"});
  expect_refused({"[compartments]\nmedial = {}\nlateral = {}", "compartments.lateral", "{}", "half_space"});
}

TEST(JobErrors, PushAndLigaments)
{
  expect_refused({"[push]\ndelta = [0, 0, 0]", "push.delta", "[0, 0, 0]"});
  expect_refused({"[push]\ndelta = \"up\"", "push.delta", "\"up\""});
  expect_refused({"[push]\nforce_n = 0", "push.force_n", "0", "0"});
  expect_refused(
      {"[push]\nforce_n = { flexion_deg = [0, 0], value = [1, 2] }", "push.force_n.flexion_deg", "[0, 0]"});
  expect_refused({"[push]\nforce_n = { flexion_deg = [0, 9], value = [1] }", "push.force_n.value", "1", "2"});
  expect_refused({"[push]\nmoment_nmm = { flexion_deg = [0] }", "push.moment_nmm.value", "nothing"});
  expect_refused({"[ligaments]\nwraps = \"w.json\"", "ligaments", "neither"});
  expect_refused(
      {"[ligaments]\nfibres = \"f.csv\"\n[[ligaments.fibre]]\nname = \"x\"\nreference_mm = "
       "[0,0,0]\nmoving_mm = [0,0,0]\nstiffness_n = 1\nslack_length_mm = 1",
       "ligaments", "both"});
  expect_refused(
      {"[ligaments]\n[[ligaments.fibre]]\nname = \"x\"", "ligaments.fibre.0.reference_mm", "nothing"});
}

TEST(JobErrors, Components)
{
  expect_refused({"[[moving.component]]\nname = \"x\"", "moving.component.1", "neither"});
  expect_refused(
      {"[[moving.component]]\nname = \"x\"\nfile = \"x.stl\"\ngenerate = { shape = \"knee\", part = "
       "\"femur\" }",
       "moving.component.1", "both"});
  expect_refused(
      {"[[moving.component]]\nname = \"lower\"\nfile = \"x.stl\"", "moving.component.1.name", "\"lower\""});
  expect_refused({"[[moving.component]]\nfile = \"x.stl\"", "moving.component.1.name", "nothing"});
  expect_refused({"[[moving.component]]\nname = \"x\"\ngenerate = { shape = \"knee\" }",
                  "moving.component.1.generate.part", "nothing"});
  expect_refused(
      {"[[moving.component]]\nname = \"x\"\ngenerate = { shape = \"knee\", part = \"femur\", resolution = "
       "[1] }",
       "moving.component.1.generate.resolution", "[1]"});
  EXPECT_THAT(facts_of_job("[[reference.component]]\nname = \"a\"\nfile = \"a.stl\"\n"),
              refuses({.field = "moving", .found = "nothing"}));
  EXPECT_THAT(facts_of_job(test::small_job(), {"moving.component.0.contact=false"}),
              refuses({.field = "moving.component", .wanted = "contact = true"}));
}

TEST(JobErrors, AnOverrideIsBlamedForWhatItGives)
{
  EXPECT_THAT(facts_of_job(test::small_job(), {"grid.flexion.step=0"}),
              refuses({"--set", "grid.flexion.step"}));
}

TEST(JobErrors, TheMessageReadsAsOneSentence)
{
  const test::Scratch scratch;
  const std::string file =
      scratch.write("knee.toml", test::small_job("", "[grid]\nflexion = { step = 0 }")).string();
  EXPECT_THAT([&] { job::read_job(file); },
              testing::ThrowsMessage<InputError>(HasSubstr(
                  "knee.toml: line 10, grid.flexion.step: found 0, wanted a step that is not zero")));
}

TEST(JobErrors, MissingFilesAndFolders)
{
  const test::Scratch scratch;
  const std::string missing = (scratch.path() / "none.toml").string();
  EXPECT_THAT(test::input_error([&] { job::read_job(missing); }), refuses({missing, "", "no file"}));
  const std::string folder = scratch.path().string();
  EXPECT_THAT(test::input_error([&] { job::read_job(folder); }), refuses({folder, "", "folder"}));
}

TEST(Jobs, every_job)
{
  int n_jobs = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(test::source_directory() / "jobs")) {
    // Not jobs: campaigns (tests/app/campaign_test.cpp), lights (tests/player/scene) and benches
    // (tests/player/bench_files).
    const std::string name = entry.path().filename().string();
    const bool is_other = std::ranges::any_of(std::array{"campaign", "lights", "bench"},
                                              [&](const char* kind) { return name.starts_with(kind); });
    if (!name.ends_with(".toml") || is_other) continue;
    SCOPED_TRACE(entry.path().string());
    const job::Job job = job::read_job(entry.path().string());
    EXPECT_FALSE(job.title.empty());
    ++n_jobs;
  }
  EXPECT_GE(n_jobs, 11);
}

TEST(Job, campaign)
{
  const std::string campaign = "[campaign]\n[[campaign.method]]\nname = \"a\"\n";
  const job::Job job = job_of(test::small_job("", campaign));
  EXPECT_TRUE(job.has_campaign);
  EXPECT_EQ(job.resolved_text, job_of(test::small_job()).resolved_text);
  EXPECT_EQ(facts_of_job(test::small_job("", campaign + "sett = {}\n")).field, "campaign.method.0.sett");
  EXPECT_EQ(facts_of_job(campaign).field, "reference");
}

}  // namespace vrda::job_test
