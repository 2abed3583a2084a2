// Loads and lines of a job, from the job to the motion model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::loads_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::IsEmpty;
using testing::Not;

// Rounding of poses of some 10 mm, which the solver's arithmetic multiplies.
constexpr double rounding_mm = 1e-9;

std::string text_of(const Eigen::Vector3d& v)
{
  return "[" + shortest_decimal(v.x()) + ", " + shortest_decimal(v.y()) + ", " + shortest_decimal(v.z()) +
         "]";
}

/// How a joint differs from the one on which the loads below are defined: by a rotation or a reflection.
struct Placement {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();

  std::string vector(const Eigen::Vector3d& v) const { return text_of(R * v); }
  std::string axial(const Eigen::Vector3d& v) const { return text_of(R.determinant() * (R * v)); }
};

std::vector<std::string> settings(const Placement& at, const std::string& varus)
{
  const std::string loads =
      "push.load=[{ name = \"drawer\", frame = \"moving\", force_n = " + at.vector({3, 1, -2}) +
      ", point_mm = " + at.vector({2, -15, 4}) +
      " }, { name = \"twist\", frame = \"reference\", moment_nmm = " + at.axial({5, 4, -10}) +
      " }, { name = \"weight\", force_n = { flexion_deg = [0, 4], value = [" + at.vector({0, 2, 1}) + ", " +
      at.vector({1, 4, 0}) + "] }, point_mm = " + at.vector({0, -20, 0}) + " }]";
  const std::string lines = "push.line=[{ name = \"muscle\", tension_n = 6, reference_mm = [" +
                            at.vector({0, 60, 5}) + ", " + at.vector({5, 30, 0}) + "], moving_mm = [" +
                            at.vector({15, -20, 3}) + "] }]";
  return {"solver.method=equilibrium", "grid.flexion={ from = 0, to = 4, step = 2 }", "grid.varus=" + varus,
          loads, lines};
}

store::MotionModel solved(const test::Scratch& scratch, const fs::path& job,
                          const std::vector<std::string>& sets)
{
  static int n = 0;
  const fs::path output = scratch.path() / ("solved_" + std::to_string(n++) + ".h5");
  std::vector<std::string> words{"run", job.string(), "-o", output.string(), "--quiet"};
  for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
  const test::Ended ended = test::run_vrda(words);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(store::validate_hdf5(output.string()), IsEmpty());
  return store::read_motion_model(output.string());
}

void expect_same(const store::GridD& a, const store::GridD& b, double tolerance)
{
  EXPECT_LT((a - b).abs().maxCoeff(), tolerance);
}

const std::vector<std::string> varus_rules{"free", "{ from = -1, to = 1, step = 1 }"};

// Meshes, Delta and loads rotated by a quarter turn about Z give the same record in rotated coordinates.
TEST(LoadedRun, RotatingDeltaAndEverythingWithItChangesNothing)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  Placement turned;
  turned.R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  for (const std::string& varus : varus_rules) {
    SCOPED_TRACE(varus);
    std::vector<std::string> sets = settings({}, varus);
    sets.emplace_back("push.lateral_force_n=[2, -1]");
    const store::MotionModel plain = solved(scratch, job, sets);
    ASSERT_EQ((plain.status == 0).count(), plain.status.size());
    sets = settings(turned, varus);
    for (const char* set :
         {"push.lateral_force_n=[2, -1]", "push.delta=[-1, 0, 0]", "frame.anterior=-Y", "frame.proximal=+X",
          "frame.right=+Z", "moving.initial.translation_mm=[20, 1, 0]"})
      sets.emplace_back(set);
    const store::MotionModel rotated = solved(scratch, job, sets);
    ASSERT_EQ((rotated.status == 0).count(), rotated.status.size());
    expect_same(rotated.tx_mm, -plain.ty_mm, rounding_mm);
    expect_same(rotated.ty_mm, plain.tx_mm, rounding_mm);
    expect_same(rotated.tz_mm, plain.tz_mm, rounding_mm);
    expect_same(rotated.theta_deg, plain.theta_deg, rounding_mm);
    expect_same(rotated.varus_solved_deg, plain.varus_solved_deg, rounding_mm);
    const store::EquilibriumSurfaces &a = rotated.equilibrium.value(), &b = plain.equilibrium.value();
    expect_same(a.energy_nmm, b.energy_nmm, 1e-6);
    expect_same(a.flexion_moment_nmm, b.flexion_moment_nmm, 1e-4);
    expect_same(a.varus_moment_nmm, b.varus_moment_nmm, 1e-4);
    EXPECT_EQ(a.forces.along_delta_n.size(), b.forces.along_delta_n.size());
    EXPECT_LT((rotated.push.force_n.row(0) - Eigen::RowVector3d(-20, 2, -1)).norm(), 1e-12);
    EXPECT_TRUE(store::has_turned_axes(rotated));
    EXPECT_FALSE(store::has_turned_axes(plain));
  }
}

TEST(LoadedRun, AMirroredJointUnderMirroredLoadsIsMirrored)
{
  const test::Scratch scratch;
  Placement mirrored;
  mirrored.R = Eigen::Vector3d(1, 1, -1).asDiagonal();
  for (const std::string& varus : varus_rules) {
    SCOPED_TRACE(varus);
    const store::MotionModel right =
        solved(scratch, test::small_knee_job(scratch, "right"), settings({}, varus));
    const store::MotionModel left =
        solved(scratch, test::small_knee_job(scratch, "left"), settings(mirrored, varus));
    ASSERT_EQ((right.status == 0).count(), right.status.size());
    EXPECT_TRUE((left.tx_mm == right.tx_mm).all());
    EXPECT_TRUE((left.ty_mm == right.ty_mm).all());
    EXPECT_TRUE((left.tz_mm == -right.tz_mm).all());
    EXPECT_TRUE((left.theta_deg == right.theta_deg).all());
    EXPECT_TRUE((left.equilibrium->flexion_moment_nmm == right.equilibrium->flexion_moment_nmm).all());
  }
}

TEST(LoadedRun, ItsLoadsAreInTheFileAndMatter)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  const std::vector<std::string> plain_sets{"solver.method=equilibrium",
                                            "grid.flexion={ from = 0, to = 4, step = 2 }", "grid.varus=free"};
  const store::MotionModel plain = solved(scratch, job, plain_sets);
  EXPECT_FALSE(plain.push.loads || plain.push.lines);
  const store::MotionModel model = solved(scratch, job, settings({}, "free"));
  ASSERT_TRUE(model.push.loads && model.push.lines);
  const store::LoadRows& loads = *model.push.loads;
  EXPECT_THAT(loads.name, testing::ElementsAre("drawer", "twist", "weight"));
  EXPECT_THAT(loads.frame, testing::ElementsAre(2, 1, 0));
  EXPECT_EQ(loads.point_mm.row(0), Eigen::RowVector3d(2, -15, 4));
  // The row of 2 degrees, half-way in the table of the third load.
  EXPECT_THAT(std::vector<double>(loads.force_n.begin() + 15, loads.force_n.begin() + 18),
              testing::Pointwise(testing::DoubleNear(1e-12), {0.5, 3.0, 0.5}));
  EXPECT_EQ(loads.moment_nmm[4], 4.0);
  const store::LineRows& lines = *model.push.lines;
  EXPECT_THAT(lines.tension_n, testing::ElementsAre(6, 6, 6));
  EXPECT_THAT(lines.point_line, testing::ElementsAre(0, 0, 0));
  EXPECT_THAT(lines.point_body, testing::ElementsAre(0, 0, 1));
  EXPECT_EQ(lines.point_mm.row(1), Eigen::RowVector3d(5, 30, 0));
  EXPECT_GT((model.tx_mm - plain.tx_mm).abs().maxCoeff(), 0.1);
  EXPECT_LT(model.equilibrium->balance_residual_n.maxCoeff(), 0.2);  // a hundredth of the push
}

// Forces at points and lines scale with the joint, moments do not.
TEST(LoadedRun, ForcesAndLinesKeepTheStepsOfAScaledJoint)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  constexpr double factor = 1.07;
  const std::vector<std::string> sets{
      "solver.method=equilibrium", "grid.flexion={ from = 0, to = 4, step = 2 }", "grid.varus=free",
      "push.load=[{ name = \"drawer\", frame = \"moving\", force_n = [3, 1, -2], point_mm = [2, -15, 4] }]",
      "push.line=[{ name = \"muscle\", tension_n = 6, reference_mm = [[5, 30, 0]], moving_mm = [[15, -20, "
      "3]] }]"};
  const store::MotionModel plain = solved(scratch, job, sets);
  std::vector<std::string> larger = sets;
  larger.emplace_back("scaling.factor=1.07");
  const store::MotionModel scaled = solved(scratch, job, larger);
  EXPECT_TRUE(scaled.job.scaling.value().keeps_steps);
  expect_same(scaled.tx_mm, factor * plain.tx_mm, rounding_mm);
  expect_same(scaled.equilibrium->flexion_moment_nmm, factor * plain.equilibrium->flexion_moment_nmm, 1e-9);
  EXPECT_LT((scaled.push.loads->point_mm - factor * plain.push.loads->point_mm).norm(), rounding_mm);
  EXPECT_LT((scaled.push.lines->point_mm - factor * plain.push.lines->point_mm).norm(), rounding_mm);
  EXPECT_EQ(scaled.push.loads->force_n, plain.push.loads->force_n);
  larger[3] = "push.load=[{ name = \"twist\", moment_nmm = [0, 5, 0] }]";
  EXPECT_FALSE(solved(scratch, job, larger).job.scaling.value().keeps_steps);
}

TEST(LoadedRun, CheckListsLoadsAndASearchSaysThatItIgnoresThem)
{
  const test::Scratch scratch;
  const fs::path job = test::small_job(scratch);
  const auto check = [&](const std::vector<std::string>& sets, const std::vector<std::string>& more) {
    std::vector<std::string> words{"check", job.string()};
    words.insert(words.end(), more.begin(), more.end());
    for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
    const test::Ended ended = test::run_vrda(words);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended.out;
  };
  std::vector<std::string> sets = settings({}, varus_rules[1]);
  EXPECT_THAT(check(sets, {}),
              AllOf(test::reports("", {"drawer", "moving"}), test::reports("", {"tension", "6 N"}),
                    test::reports("", {"[15 -20 3]"})));
  const nlohmann::json json = nlohmann::json::parse(check(sets, {"--json"}));
  EXPECT_EQ(json.at("push").at("loads").at(0).at("frame"), "moving");
  EXPECT_EQ(json.at("push").at("lines").at(0).at("reference_mm").size(), 2U);
  sets[0] = "solver.method=stability-search";
  EXPECT_THAT(check(sets, {}), AllOf(test::warns("push.load"), test::warns("push.line")));
  const std::vector<std::string> lateral{"solver.method=equilibrium", "push.lateral_force_n=[2, 0]"};
  EXPECT_THAT(check(lateral, {}), Not(test::warns("push.lateral_force_n")));
  std::vector<std::string> across = lateral;
  across.emplace_back("push.delta=[0.1, 1, 0]");
  EXPECT_THAT(check(across, {}), test::warns("push.lateral_force_n"));
  const std::string picture = (scratch.path() / "a.png").string(),
                    other = (scratch.path() / "b.png").string();
  check({"solver.method=equilibrium"}, {"--picture", picture});
  check({"solver.method=equilibrium", settings({}, "free")[4]}, {"--picture", other});
  EXPECT_NE(test::read_bytes(picture), test::read_bytes(other));
}

TEST(LoadedRun, InfoHasTheJointsOwnAnglesWhereAxesAreTurned)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right"), file = scratch.path() / "turned.h5";
  ASSERT_EQ(test::run_vrda({"run", job.string(), "-o", file.string(), "--quiet", "--set",
                            "push.delta=[0.3, 1, 0.1]", "--set", "solver.method=equilibrium", "--set",
                            "limits.unsolved_fraction=1"})
                .exit_code,
            0);
  const test::Ended text = test::run_vrda({"info", file.string()});
  const nlohmann::json json = nlohmann::json::parse(test::run_vrda({"info", file.string(), "--json"}).out);
  EXPECT_EQ(json.at("axes_are_turned"), true);
  const store::MotionModel model = store::read_motion_model(file.string());
  double most_deg = -1e9;
  for (Eigen::Index k = 0; k < model.status.size(); ++k) {
    const double varus_deg = model.clinical.varus_deg.data()[k];
    most_deg = varus_deg > most_deg ? varus_deg : most_deg;  // NaN where not stable
  }
  EXPECT_EQ(json.at("clinical").at("varus_deg").at("max").get<double>(), most_deg);
  EXPECT_GT(std::abs(most_deg - model.varus_deg.back()), 0.1);
  EXPECT_THAT(text.out, test::reports("", "internal_rotation_deg"));
  const fs::path series = scratch.path() / "series.pvd";
  const test::Ended ended =
      test::run_vrda({"export", file.string(), "--to", "vtk", "--set", "raw", "-o", series.string()});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(test::read_bytes(scratch.path() / "series" / "series_0000.vtp"),
              testing::HasSubstr("attitude_flexion_deg"));
}

}  // namespace vrda::loads_test
