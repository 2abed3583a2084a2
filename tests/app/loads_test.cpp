// What holds and loads a joint, from the job to the motion model: equilibrium, loads, lines, roles of
// coordinates.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "analysis/audit.hpp"
#include "app/scenes.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "run/run_output.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::loads_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::Not;

// Half of the limit for gap and penetration, 1e-3 mm.
constexpr double touch_mm = 5e-4;

TEST(EquilibriumRun, WithVarusFreeBothSidesTouchAndShareThePush)
{
  const test::Scratch scratch;
  const store::MotionModel model =
      test::solved(test::small_knee_job(scratch, "right"), {"solver.method=equilibrium", "grid.varus=free"});
  ASSERT_EQ(model.status.cols(), 1);
  EXPECT_EQ(model.varus_deg, std::vector<double>{0.0});
  EXPECT_EQ(run::unsolved_fraction(model), 0.0) << run::status_line(model);
  ASSERT_TRUE(model.equilibrium);
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(model.is_in_contact[0](i, 0), 1);
    EXPECT_EQ(model.is_in_contact[1](i, 0), 1);
    EXPECT_LT(model.gap_mm[0](i, 0), touch_mm);
    EXPECT_LT(model.gap_mm[1](i, 0), touch_mm);
    EXPECT_NE(model.varus_solved_deg(i, 0), 0.0) << "the lateral dent is shallower";
    EXPECT_EQ(model.varus_solved_deg(i, 0), model.equilibrium->spine.varus_deg[static_cast<std::size_t>(i)]);
    EXPECT_LE(model.equilibrium->balance_residual_n(i, 0), 0.01 * 20.0);
    EXPECT_EQ(model.equilibrium->varus_moment_nmm(i, 0), 0.0);
    // Along Delta the two compartments carry the whole push.
    const auto y = static_cast<std::size_t>(3 * i + 1);
    const double borne_n = -model.equilibrium->force_n[0][y] - model.equilibrium->force_n[1][y];
    EXPECT_NEAR(borne_n, 20.0, 0.01 * 20.0);
  }
  const analysis::AuditFigures measured = analysis::figures_of(analysis::audit(model, "raw", 1, 1));
  EXPECT_EQ(measured.n_overlapping, 0);
  EXPECT_EQ(measured.n_nothing_ahead, 0);
  EXPECT_LE(measured.largest_gap.value_mm, touch_mm);
}

std::string digits(const Eigen::RowVector3d& v)
{
  std::array<char, 100> text{};
  std::snprintf(text.data(), text.size(), "[%.17g, %.17g, %.17g]", v.x(), v.y(), v.z());
  return text.data();
}

// A Delta over flexion gives at each flexion the result of a run with that constant Delta and the same seed.
TEST(EquilibriumRun, APushThatTurnsOverFlexionIsOneDirectionAtEach)
{
  constexpr double rounding_mm = 1e-9;  // the direction is normalised again
  const test::Scratch scratch;
  const fs::path job = test::small_job(scratch);
  const std::string table = "{ flexion_deg = [0, 4], value = [[0, 1, 0], [0.1, 1, 0.05]] }";
  const auto solve = [&](const std::string& method, const std::string& delta,
                         const std::vector<std::string>& more) {
    std::vector<std::string> all{"solver.method=" + method, "push.delta=" + delta,
                                 "limits.unsolved_fraction=1"};
    all.insert(all.end(), more.begin(), more.end());
    return test::solved(job, all);
  };
  for (const std::string method : {"equilibrium", "stability-search"}) {
    SCOPED_TRACE(method);
    const store::MotionModel turning = solve(method, table, {});
    ASSERT_EQ(turning.push.delta.rows(), 3);
    EXPECT_EQ(turning.delta, Eigen::Vector3d::UnitY());
    const analysis::AuditFigures measured = analysis::figures_of(analysis::audit(turning, "raw", 1, 1));
    EXPECT_EQ(measured.n_overlapping, 0);
    EXPECT_EQ(measured.n_nothing_ahead, 0);
    EXPECT_LE(measured.largest_gap.value_mm, turning.contact_resolution_mm);
    for (Eigen::Index i = 0; i < 3; ++i) {
      SCOPED_TRACE(i);
      const std::string flexion = std::to_string(2 * i);
      const std::vector<std::string> row{"grid.flexion={ from = " + flexion + ", to = " + flexion +
                                         ", step = 1 }"};
      const store::MotionModel of_table = solve(method, table, row);
      const store::MotionModel of_one = solve(method, digits(turning.push.delta.row(i)), row);
      EXPECT_TRUE((of_table.status == of_one.status).all());
      EXPECT_GT((of_table.status == 0).count(), 3);
      const auto differs = [](const store::GridD& a, const store::GridD& b) {
        return (a - b).isNaN().select(0.0, (a - b).abs()).maxCoeff();
      };
      EXPECT_LT(differs(of_table.tx_mm, of_one.tx_mm), rounding_mm);
      EXPECT_LT(differs(of_table.ty_mm, of_one.ty_mm), rounding_mm);
      EXPECT_LT(differs(of_table.theta_deg, of_one.theta_deg), rounding_mm);
    }
  }
}

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
    const store::MotionModel plain = test::solved(job, sets);
    ASSERT_EQ((plain.status == 0).count(), plain.status.size());
    sets = settings(turned, varus);
    for (const char* set :
         {"push.lateral_force_n=[2, -1]", "push.delta=[-1, 0, 0]", "frame.anterior=-Y", "frame.proximal=+X",
          "frame.right=+Z", "moving.initial.translation_mm=[20, 1, 0]"})
      sets.emplace_back(set);
    const store::MotionModel rotated = test::solved(job, sets);
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
        test::solved(test::small_knee_job(scratch, "right"), settings({}, varus));
    const store::MotionModel left =
        test::solved(test::small_knee_job(scratch, "left"), settings(mirrored, varus));
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
  const store::MotionModel plain = test::solved(job, plain_sets);
  EXPECT_FALSE(plain.push.loads || plain.push.lines);
  const store::MotionModel model = test::solved(job, settings({}, "free"));
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
  const nlohmann::json json = test::json_of({"info", file.string()});
  EXPECT_EQ(json.at("axes_are_turned"), true);
  const store::MotionModel model = store::read_motion_model(file.string());
  double most_deg = -1e9;
  for (Eigen::Index k = 0; k < model.status.size(); ++k) {
    const double varus_deg = model.clinical[JointCoordinate::varus].data()[k];
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

// Up and down again: flexion neither ascends nor is unique.
constexpr const char* motion =
    "time_s,flexion_deg,internal_deg,lat_mm\n"
    "0.0,0,0.5,0.1\n"
    "0.1,2,0.2,0.0\n"
    "0.2,4,-0.4,-0.1\n"
    "0.3,2,-0.1,0.0\n"
    "0.5,1,0.3,0.2\n";

class CoordinateRun : public testing::Test {
 protected:
  // The knee of two balls with `settings` instead of its grid.
  fs::path job(const std::string& settings, const std::string& method = "equilibrium")
  {
    const fs::path file = test::small_knee_job(scratch_, "right");
    std::string text = test::text_of(file);
    const std::size_t grid = text.find("[grid]"), after = text.find("\n[", grid);
    text = text.substr(0, grid) + settings + (after == std::string::npos ? "" : text.substr(after));
    const std::string search = "method = \"stability-search\"";
    text.replace(text.find(search), search.size(), "method = \"" + method + "\"");
    scratch_.write("motion.csv", motion);
    return scratch_.write("knee.toml", text);
  }

  test::Scratch scratch_;
};

constexpr const char* frames =
    "[frames]\nfile = \"motion.csv\"\n[coordinates]\nflexion = { column = \"flexion_deg\" }\n"
    "internal = { column = \"internal_deg\" }\n";

TEST_F(CoordinateRun, GivenCoordinatesOfFramesAreKept)
{
  const store::MotionModel model = test::solved(job(frames));
  ASSERT_TRUE(model.frames);
  EXPECT_EQ(model.frames->key_name, "time_s");
  EXPECT_THAT(model.frames->key, ElementsAre(0.0, 0.1, 0.2, 0.3, 0.5));
  ASSERT_EQ((model.status == 0).count(), 5);
  const std::vector<double> flexion{0, 2, 4, 2, 1}, internal{0.5, 0.2, -0.4, -0.1, 0.3};
  for (Eigen::Index i = 0; i < 5; ++i) {
    // Conversion to radians and back.
    EXPECT_NEAR(model.clinical[JointCoordinate::flexion](i, 0), flexion[static_cast<std::size_t>(i)], 1e-12);
    EXPECT_NEAR(model.clinical[JointCoordinate::internal](i, 0), internal[static_cast<std::size_t>(i)],
                1e-12);
    EXPECT_LT(std::max(model.gap_mm[0](i, 0), model.gap_mm[1](i, 0)), 1e-4);  // both balls bear
  }
  ASSERT_TRUE(model.coordinates);
  EXPECT_THAT(model.coordinates->role, ElementsAre(1, 2, 1, 2, 2, 2));
  EXPECT_THAT(std::vector<std::int8_t>(model.coordinates->determined.begin(),
                                       model.coordinates->determined.begin() + 6),
              ElementsAre(-1, 1, -1, 1, 1, 1));
  EXPECT_TRUE(std::isnan(model.coordinates->holding_moment_nmm[1]));
  EXPECT_FALSE(std::isnan(model.coordinates->holding_moment_nmm[2]));
}

TEST_F(CoordinateRun, FramesOfOneFlexionAreThoseOfTheGrid)
{
  const store::MotionModel sequence = test::solved(
      job("[frames]\nfile = \"motion.csv\"\n[coordinates]\nflexion = { column = \"flexion_deg\" }\n"));
  const store::MotionModel grid =
      test::solved(job("[coordinates]\nflexion = { from = 0, to = 4, step = 1 }\nvarus = \"free\"\n"));
  ASSERT_FALSE(grid.frames);
  const std::vector<Eigen::Index> row{0, 2, 4, 2, 1};
  for (Eigen::Index i = 0; i < 5; ++i) {
    const Eigen::Index k = row[static_cast<std::size_t>(i)];
    // Both end within the tolerance of 1e-4 mm of height, on facets of some 5 mm.
    EXPECT_NEAR(sequence.ty_mm(i, 0), grid.ty_mm(k, 0), 2e-4);
    EXPECT_NEAR(sequence.varus_solved_deg(i, 0), grid.varus_solved_deg(k, 0), 1e-2);
  }
}

TEST_F(CoordinateRun, OneDrivenRotationMakesASequence)
{
  const store::MotionModel model =
      test::solved(job("[coordinates]\nflexion = 2\ninternal = { from = -2, to = 2, step = 1 }\n"));
  ASSERT_TRUE(model.frames);
  EXPECT_EQ(model.frames->key_name, "internal_deg");
  for (Eigen::Index i = 0; i < 5; ++i)
    EXPECT_NEAR(model.clinical[JointCoordinate::internal](i, 0), static_cast<double>(i - 2), 1e-12);
}

TEST_F(CoordinateRun, AHeightThatOverlapsIsANamedStatus)
{
  const store::MotionModel free = test::solved(job(frames));
  const double bearing = free.clinical[JointCoordinate::proximal](0, 0);
  const auto with_height = [&](double height_mm) {
    return std::string(frames) + "varus = 0\nproximal = " + std::to_string(height_mm) + "\n";
  };
  const store::MotionModel high = test::solved(job(with_height(bearing + 3.0)), {}, 3);
  EXPECT_EQ((high.status == static_cast<std::int8_t>(StepStatus::no_clearance)).count(), 5);
  const store::MotionModel low = test::solved(job(with_height(bearing - 3.0)));
  EXPECT_EQ((low.status == 0).count(), 5);
  EXPECT_NEAR(low.clinical[JointCoordinate::proximal](2, 0), bearing - 3.0, 1e-6);  // six decimals in the job
}

TEST_F(CoordinateRun, TheSearchKeepsWhatIsGiven)
{
  const std::string roles = "varus = 1\nlateral = { column = \"lat_mm\" }\n";
  const store::MotionModel model = test::solved(job(frames + roles, "stability-search"));
  ASSERT_EQ((model.status == 0).count(), 5);
  const std::vector<double> lateral{0.1, 0.0, -0.1, 0.0, 0.2};
  for (Eigen::Index i = 0; i < 5; ++i) {
    EXPECT_NEAR(model.clinical[JointCoordinate::varus](i, 0), 1.0, 1e-12);
    EXPECT_NEAR(model.clinical[JointCoordinate::lateral](i, 0), lateral[static_cast<std::size_t>(i)], 2e-3);
  }
}

}  // namespace vrda::loads_test
