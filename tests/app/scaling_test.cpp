// Runs of scaled joints: scaled results of the unscaled run against a new run.
#include <gmock/gmock.h>

#include <cmath>
#include <csignal>

#include "analysis/audit.hpp"
#include "app/scenes.hpp"
#include "core/text.hpp"
#include "run/run_output.hpp"
#include "solve/case_solver.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "store/trace.hpp"
#include "support/meshes.hpp"
#include "support/messages.hpp"

namespace vrda::scaling_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double factor = 1.07;

// Rounding of lengths up to 100 mm after some multiplications and rotations.
constexpr double rounding_mm = 1e-11;
constexpr double rounding_deg = 1e-10;

std::vector<std::string> words(const fs::path& job, const fs::path& output,
                               const std::vector<std::string>& settings)
{
  std::vector<std::string> all{"run", job.string(), "-o", output.string(), "--progress", "none", "--replace"};
  for (const std::string& setting : settings) all.insert(all.end(), {"--set", setting});
  return all;
}

struct Solved {
  store::MotionModel model;
  std::string said;
};

Solved solved(const fs::path& job, const std::vector<std::string>& settings)
{
  const fs::path output = job.parent_path() / "solved.h5";
  const test::Ended ended = test::run_vrda(words(job, output, settings));
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(store::validate_hdf5(output.string()), testing::IsEmpty());
  return {store::read_motion_model(output.string()), ended.err};
}

// For two surfaces with values in the same cells.
double largest_difference(const store::GridD& a, const store::GridD& b)
{
  EXPECT_TRUE((a.isNaN() == b.isNaN()).all());
  return (a - b).isNaN().select(0.0, (a - b).abs()).maxCoeff();
}

const std::string equilibrium = "solver.method=equilibrium", free_varus = "grid.varus=free";

void expect_scaled_cells(const store::MotionModel& got, const store::MotionModel& plain)
{
  EXPECT_TRUE((got.status == plain.status).all());
  EXPECT_TRUE((got.iterations == plain.iterations).all());
  EXPECT_TRUE((got.theta_deg.isNaN() || got.theta_deg == plain.theta_deg).all());
  EXPECT_LT(largest_difference(got.tx_mm, factor * plain.tx_mm), rounding_mm);
  EXPECT_LT(largest_difference(got.ty_mm, factor * plain.ty_mm), rounding_mm);
  EXPECT_LT(largest_difference(got.tz_mm, factor * plain.tz_mm), rounding_mm);
  EXPECT_LT(largest_difference(got.gap_mm[0], factor * plain.gap_mm[0]), rounding_mm);
  EXPECT_LT(largest_difference(got.clinical[JointCoordinate::varus], plain.clinical[JointCoordinate::varus]),
            rounding_deg);
  EXPECT_LT(
      largest_difference(got.clinical[JointCoordinate::internal], plain.clinical[JointCoordinate::internal]),
      rounding_deg);
  EXPECT_LT(largest_difference(got.clinical[JointCoordinate::proximal],
                               factor * plain.clinical[JointCoordinate::proximal]),
            rounding_mm);
  EXPECT_TRUE((got.is_in_contact[0] == plain.is_in_contact[0]).all());
  ASSERT_EQ(got.contacts.distance_mm.size(), plain.contacts.distance_mm.size());
  const Points wanted_mm = factor * plain.contacts.point_world_mm;
  EXPECT_LT((got.contacts.point_world_mm - wanted_mm).cwiseAbs().maxCoeff(), rounding_mm);
  EXPECT_EQ(got.contacts.normal_world, plain.contacts.normal_world);
  EXPECT_EQ(got.contacts.triangle_moving, plain.contacts.triangle_moving);
}

void expect_scaled_balance(const store::EquilibriumSurfaces& got, const store::EquilibriumSurfaces& plain)
{
  EXPECT_LT(largest_difference(got.energy_nmm, factor * plain.energy_nmm), 1e-9);
  EXPECT_LT(largest_difference(got.flexion_moment_nmm, factor * plain.flexion_moment_nmm), 1e-9);
  EXPECT_LT(largest_difference(got.worst_gap_mm, factor * plain.worst_gap_mm), rounding_mm);
  EXPECT_TRUE((got.balance_residual_n.isNaN() || got.balance_residual_n == plain.balance_residual_n).all());
  EXPECT_EQ(got.forces.along_delta_n, plain.forces.along_delta_n);
  EXPECT_EQ(got.spine.n_optima, plain.spine.n_optima);
  for (std::size_t i = 0; i < got.spine.ty_mm.size(); ++i)
    EXPECT_NEAR(got.spine.ty_mm[i], factor * plain.spine.ty_mm[i], rounding_mm);
}

TEST(ScaledRun, OfAJointHeldByContactIsTheUnscaledOneTimesTheFactor)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "left");
  for (const std::string method : {"equilibrium", "stability-search"}) {
    SCOPED_TRACE(method);
    const Solved plain = solved(job, {"solver.method=" + method});
    const Solved scaled = solved(job, {"solver.method=" + method, "scaling.factor=1.07"});
    EXPECT_FALSE(test::names_value(plain.said, "scaled"));
    EXPECT_THAT(scaled.said, test::reports("", {"scaled", "1.07", "shared"}));
    expect_scaled_cells(scaled.model, plain.model);
    EXPECT_EQ(scaled.model.contact_resolution_mm, factor * plain.model.contact_resolution_mm);
    EXPECT_TRUE(scaled.model.job.scaling.value().keeps_steps);
    // Gaps measured on the scaled meshes are scaled; the audit's measurements agree to 1e-6 mm.
    const analysis::AuditFigures before = analysis::figures_of(analysis::audit(plain.model, "raw", 1, 1));
    const analysis::AuditFigures after = analysis::figures_of(analysis::audit(scaled.model, "raw", 1, 1));
    EXPECT_EQ(after.n_overlapping, 0);
    EXPECT_NEAR(after.largest_gap.value_mm, factor * before.largest_gap.value_mm, 1e-6);
    EXPECT_LE(after.largest_gap.value_mm, scaled.model.contact_resolution_mm);
  }
}

TEST(ScaledRun, AFactorOfOneGivesTheSameModelButForItsJob)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  const store::MotionModel plain = solved(job, {equilibrium}).model;
  store::MotionModel one = solved(job, {equilibrium, "scaling.factor=1"}).model;
  EXPECT_TRUE(one.job.scaling.value().keeps_steps);
  EXPECT_NE(one.job.resolved, plain.job.resolved);
  one.job = plain.job;
  test::expect_equal(one, plain);
}

TEST(ScaledRun, ForcesStayAndEnergiesAndMomentsGrow)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  const std::vector<std::string> across{equilibrium, "push.point_mm=[2,0,-3]", "push.lateral_force_n=[1,1]"};
  const std::vector<std::string> at_points{
      equilibrium, "grid.flexion={from=0,to=4,step=2}",
      R"(push.load=[{ name = "drawer", frame = "moving", force_n = [3, 1, -2], point_mm = [2, -15, 4] }])",
      "push.line=[{ name = \"muscle\", tension_n = 6, reference_mm = [[5, 30, 0]], "
      "moving_mm = [[15, -20, 3]] }]"};
  for (const auto& [loads, varus] : {std::pair(across, "grid.varus=free"),
                                     {across, "grid.varus={from=-2,to=2,step=2}"},
                                     {at_points, "grid.varus=free"}}) {
    SCOPED_TRACE(testing::PrintToString(loads) + varus);
    std::vector<std::string> settings = loads;
    settings.emplace_back(varus);
    const store::MotionModel plain = solved(job, settings).model;
    settings.emplace_back("scaling.factor=1.07");
    const store::MotionModel scaled = solved(job, settings).model;
    expect_scaled_cells(scaled, plain);
    expect_scaled_balance(scaled.equilibrium.value(), plain.equilibrium.value());
    EXPECT_EQ(scaled.push.force_n, plain.push.force_n);
    EXPECT_LT((scaled.push.point_mm - factor * plain.push.point_mm).norm(), rounding_mm);
    if (loads != at_points) continue;
    EXPECT_EQ(scaled.push.loads->force_n, plain.push.loads->force_n);
    EXPECT_LT((scaled.push.loads->point_mm - factor * plain.push.loads->point_mm).norm(), rounding_mm);
    EXPECT_LT((scaled.push.lines->point_mm - factor * plain.push.lines->point_mm).norm(), rounding_mm);
  }
}

std::string wavefront(const Mesh& mesh)
{
  std::string text;
  for (const auto& p_mm : mesh.vertices_mm.rowwise()) {
    text += "v";
    for (const double coordinate_mm : p_mm) text += " " + shortest_decimal(coordinate_mm);
    text += "\n";
  }
  for (const auto& triangle : mesh.triangles.rowwise()) {
    text += "f";
    for (const std::int32_t vertex : triangle) text += " " + std::to_string(vertex + 1);
    text += "\n";
  }
  return text;
}

// Closed form: the pole of the ball is at 20 mm, the lower face of the plate at 30 mm; the gap of 10 mm
// scales with the factor for any rotation centre.
TEST(ScaledRun, ABallUnderAPlateRisesByTheFactor)
{
  const test::Scratch scratch;
  scratch.write("plate.obj", wavefront(test::box({0, 40, 0}, {60, 20, 60})));
  scratch.write("ball.obj", wavefront(test::ball(20)));
  const fs::path job = scratch.write("plate.toml", R"(joint = "other"
[frame]
origin = [3, -2, 5]
[[reference.component]]
name = "plate"
file = "plate.obj"
[[moving.component]]
name = "ball"
file = "ball.obj"
[grid]
flexion = { from = 0, to = 0, step = 1 }
varus = { from = 0, to = 0, step = 1 }
[smooth]
degrees = []
)");
  constexpr double tolerance_mm = 1e-4;  // solver.equilibrium.tolerance_mm
  for (const double s : {0.5, 1.0, 1.07, 3.0}) {
    SCOPED_TRACE(s);
    const store::MotionModel model = solved(job, {"scaling.factor=" + shortest_decimal(s)}).model;
    EXPECT_NEAR(model.ty_mm(0, 0), 10.0 * s, tolerance_mm * s);
    EXPECT_NEAR(model.X_reference_moving[7], 10.0 * s, tolerance_mm * s);
    // The ball's pole is 22 mm above the centre, which does not move.
    EXPECT_NEAR(bounding_box(model.moving.contact.mesh).max_mm.y(), -2.0 + 22.0 * s, rounding_mm);
    EXPECT_NEAR(model.contacts.point_world_mm(0, 1), 32.0 * s, tolerance_mm * s);
  }
}

// Results of a sweep without intermediate files.
solve::SweepResult swept(const job::Case& job_case)
{
  solve::CaseSolver solver(job_case, 1);
  return solve::sweep(
      solve::plan_of(job_case), [&](const solve::StepTask& task) { return solver(task); }, {}, 1);
}

struct Worst {
  double along_mm = 0.0, across_mm = 0.0, theta_rad = 0.0, energy_nmm = 0.0;
  int n = 0;
};

Worst difference(const solve::SweepResult& a, const solve::SweepResult& b)
{
  Worst worst;
  EXPECT_EQ(a.cells.size(), b.cells.size());
  for (std::size_t c = 0; c < a.cells.size(); ++c) {
    EXPECT_EQ(a.cells[c].status, b.cells[c].status);
    const Eigen::Vector3d d_mm = a.cells[c].pose.translation_mm - b.cells[c].pose.translation_mm;
    worst.along_mm = std::max(worst.along_mm, std::abs(d_mm.y()));
    worst.across_mm = std::max(worst.across_mm, std::hypot(d_mm.x(), d_mm.z()));
    worst.theta_rad =
        std::max(worst.theta_rad, std::abs(a.cells[c].pose.theta_rad - b.cells[c].pose.theta_rad));
    worst.energy_nmm =
        std::max(worst.energy_nmm, std::abs(a.cells[c].balance.energy_nmm - b.cells[c].balance.energy_nmm));
    worst.n += a.cells[c].status == StepStatus::stable ? 1 : 0;
  }
  return worst;
}

job::Case loaded(const fs::path& job, const std::vector<std::string>& settings)
{
  return job::load_case(job.string(), {"", settings});
}

// Both runs converge to solver.equilibrium.tolerance_mm, here for a joint 1.07 times as large.
constexpr double two_tolerances_mm = 2 * factor * 1e-4;
constexpr double lever_mm = 20.0;  // from Delta to either ball
constexpr double push_n = 20.0;

struct Nearness {
  int n_stable = 0;
  double across_mm = two_tolerances_mm;  // contact only: edges and corners constrain as stiffly
};

void expect_near(const solve::SweepResult& a, const solve::SweepResult& b, const Nearness& wanted)
{
  const Worst worst = difference(a, b);
  EXPECT_EQ(worst.n, wanted.n_stable);
  EXPECT_LT(worst.along_mm, two_tolerances_mm);
  EXPECT_LT(worst.across_mm, wanted.across_mm);
  EXPECT_LT(worst.theta_rad, wanted.across_mm / lever_mm);
  EXPECT_LT(worst.energy_nmm, two_tolerances_mm * push_n);
}

// Facets so steep to each other that contact alone holds the joint as stiffly across Delta as along it.
constexpr test::BallEdges sharp_edges{8, 12};

// The oracle: a new run on the scaled meshes.
TEST(ScaledRun, ScaledResultsAreThoseOfTheScaledMeshes)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right", sharp_edges);
  const auto expect_kept = [&](const std::vector<std::string>& settings, int n_stable) {
    const job::Case once = loaded(job, settings);
    ASSERT_EQ(once.steps_scale, factor);
    expect_near(solve::scaled(swept(once), factor), swept(job::scaled_to_subject(once)), {n_stable});
  };
  expect_kept({"scaling.factor=1.07", equilibrium}, 35);
  expect_kept({"scaling.factor=1.07", equilibrium, free_varus}, 7);
  // Steps as large as the joint: the search takes the same ones.
  expect_kept({"scaling.factor=1.07", "solver.method=stability-search"}, 35);
}

const std::string fibres = R"([[ligaments.fibre]]
name = "medial"
reference_mm = [0, 15, -40]
moving_mm = [0, -15, -30]
stiffness_n = 300
reference_strain = 0.02
[[ligaments.fibre]]
name = "lateral"
reference_mm = [5, 15, 40]
moving_mm = [0, -15, 30]
stiffness_n = 200
slack_length_mm = 30
)";

// Fibres with the same strain and stiffness have the same tension: a new run of a joint with ligaments gives
// the scaled poses under the same forces without moment.
TEST(ScaledRun, FibresScaledEvenlyHoldTheScaledPose)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  test::edit(job, "[grid]", fibres + "[grid]");
  const job::Case plain = loaded(job, {equilibrium}),
                  repeated = loaded(job, {equilibrium, "scaling.factor=1.07"});
  ASSERT_FALSE(repeated.scaling.value().keeps_steps);
  // Across Delta the energy is smooth: 2 / 50 and 2 / 90 per mm of dents under 20 N, at least 0.4 N/mm.
  const double across_mm = std::sqrt(2.0 * two_tolerances_mm * push_n / 0.4);
  expect_near(solve::scaled(swept(plain), factor), swept(repeated), {35, across_mm});
}

TEST(ScaledRun, ANewRunIsSaidToBeOneAndIsSound)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  const Solved wider = solved(job, {equilibrium, "scaling.factor=[1.1,1,0.95]"});
  EXPECT_THAT(wider.said, test::reports("", {"[1.1, 1, 0.95]", "new run", "factors"}));
  EXPECT_FALSE(wider.model.job.scaling.value().keeps_steps);
  EXPECT_EQ(run::unsolved_fraction(wider.model), 0.0);
  const analysis::AuditFigures measured = analysis::figures_of(analysis::audit(wider.model, "raw", 1, 1));
  EXPECT_EQ(measured.n_overlapping, 0);
  EXPECT_LE(measured.largest_gap.value_mm, 1e-3);  // the limit of an equilibrium
  EXPECT_THAT(solved(job, {equilibrium, "scaling.factor=1.1", "push.moment_nmm=5"}).said,
              test::reports("", {"1.1", "new run", "moment"}));
}

TEST(ScaledRun, OneKeyServesEverySizeThatKeepsTheSteps)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  scratch.write("marks.csv", "name,ax,ay,az,bx,by,bz,subject_mm\na,0,0,0,80,0,0,85.6\n");
  const auto key = [&](std::vector<std::string> settings) {
    settings.push_back(equilibrium);
    return solve::fingerprint_of(loaded(job, settings));
  };
  const std::string unscaled = key({});
  EXPECT_EQ(key({"scaling.factor=1"}), unscaled);
  EXPECT_EQ(key({"scaling.factor=1.07"}), unscaled);
  EXPECT_EQ(key({"scaling.factor=[1.1,1.1,1.1]"}), unscaled);
  EXPECT_EQ(key({"scaling.landmarks=marks.csv"}), unscaled);
  EXPECT_NE(key({"scaling.factor=[1.1,1,1]"}), unscaled);
  const std::string moment = "push.moment_nmm=5";
  for (const std::string& load :
       {moment, std::string(R"(push.load=[{ name = "twist", moment_nmm = [0, 5, 0] }])")})
    EXPECT_NE(key({"scaling.factor=1.07", load}), key({load})) << load;
  const std::string of_marks = key({"scaling.landmarks=marks.csv", moment});
  scratch.write("marks.csv", "name,ax,ay,az,bx,by,bz,subject_mm\na,0,0,0,80,0,0,85.7\n");
  EXPECT_NE(key({"scaling.landmarks=marks.csv", moment}), of_marks);
}

TEST(ScaledRun, ARunInterruptedAtOneSizeGoesOnAtAnother)
{
  const test::Scratch scratch;
  const fs::path job = test::longer_knee_job(scratch);
  const fs::path output = scratch.path() / "knee.h5", whole = scratch.path() / "whole.h5";
  const std::string journal = output.string() + ".journal";
  const std::vector<std::string> larger{"scaling.factor=1.1"};
  ASSERT_EQ(test::run_vrda(words(job, whole, larger)).exit_code, 0);
  {
    test::Process process(test::vrda(words(job, output, {})));
    test::wait_for_bytes(process, journal, 6000);
    process.send(SIGTERM);
    ASSERT_EQ(process.wait().exit_code, 4);
  }
  const std::string start = output.string() + ".start.h5";
  EXPECT_FALSE(store::read_motion_model(start).job.scaling);
  {
    // During the run the start file has the joint at its scaled size.
    test::Process process(test::vrda(words(job, output, larger)));
    test::wait_for_bytes(process, journal, fs::file_size(journal) + 2000);
    process.send(SIGTERM);
    ASSERT_EQ(process.wait().exit_code, 4);
    EXPECT_EQ(store::read_motion_model(start).job.scaling.value().factor.x(), 1.1);
  }
  const test::Ended last = test::run_vrda(words(job, output, larger));
  EXPECT_EQ(last.exit_code, 0);
  EXPECT_THAT(last.err, test::reports("resuming", journal));
  EXPECT_EQ(test::sha256_of_file(output), test::sha256_of_file(whole));
}

TEST(ScaledRun, ItsTraceEndsAtItsPoses)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "left");
  const fs::path output = scratch.path() / "knee.h5";
  std::vector<std::string> traced = words(job, output, {"scaling.factor=1.07"});
  traced.emplace_back("--trace");
  ASSERT_EQ(test::run_vrda(traced).exit_code, 0);
  const store::Trace trace = store::read_trace(store::trace_name(output.string()));
  EXPECT_NO_THROW(
      store::require_trace_matches_model(trace, "trace", store::read_motion_model(output.string()), "model"));
  EXPECT_EQ(trace.translation_resolution_mm, factor * 0.1);
}

TEST(ScaledRun, CheckAndInfoShowHowTheLandmarksFit)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  // s = 25.9 / 25, as in the tests of the fit.
  scratch.write("marks.csv",
                "name,ax,ay,az,bx,by,bz,subject_mm\nepicondyles,0,0,0,30,0,0,33\nshaft,0,0,0,0,40,0,40\n");
  const std::string setting = "scaling.landmarks=marks.csv";
  const test::Ended check = test::run_vrda({"check", job.string(), "--set", setting});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  const auto row = testing::AllOf(test::reports("scaling", {"1.036", "0.048", "2", "1.70 mm"}),
                                  test::reports("", {"epicondyles", "30.00", "31.08", "33.00", "+1.92"}),
                                  test::reports("", {"shaft", "40.00", "41.44", "40.00", "-1.44"}));
  EXPECT_THAT(check.out, row);
  EXPECT_THAT(check.out, test::reports("", {"uniform", "shared"}));
  EXPECT_THAT(test::run_vrda({"check", job.string(), "--json", "--set", setting}).out,
              testing::AllOf(HasSubstr("\"keeps_steps\": true"), HasSubstr("\"residual_rms_mm\": 1.69")));
  solved(job, {setting});
  const std::string output = (job.parent_path() / "solved.h5").string();
  const std::string info = test::run_vrda({"info", output}).out;
  EXPECT_THAT(info, row);
  EXPECT_THAT(info, test::reports("", {"factor 1", "scaled"}));
  EXPECT_THAT(test::run_vrda({"info", output, "--json"}).out, HasSubstr("\"standard_error\": 0.04"));
}

}  // namespace vrda::scaling_test
