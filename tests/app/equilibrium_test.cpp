// The equilibrium from job to motion model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "analysis/audit.hpp"
#include "app/scenes.hpp"
#include "run/run_output.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::equilibrium_test {

namespace fs = std::filesystem;
using testing::IsEmpty;

std::vector<std::string> words(const fs::path& job, const fs::path& output,
                               const std::vector<std::string>& more)
{
  std::vector<std::string> all{
      "run", job.string(), "-o", output.string(), "--quiet", "--set", "solver.method=equilibrium"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

store::MotionModel solved(const test::Scratch& scratch, const fs::path& job,
                          const std::vector<std::string>& more = {})
{
  static int n = 0;
  const fs::path output = scratch.path() / ("solved_" + std::to_string(n++) + ".h5");
  const test::Ended ended = test::run_vrda(words(job, output, more));
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(store::validate_hdf5(output.string()), IsEmpty());
  return store::read_motion_model(output.string());
}

const std::vector<std::string> free_varus{"--set", "grid.varus=free"};

// Half of the limit for gap and penetration, 1e-3 mm.
constexpr double touch_mm = 5e-4;

TEST(EquilibriumRun, WithVarusFreeBothSidesTouchAndShareThePush)
{
  const test::Scratch scratch;
  const store::MotionModel model = solved(scratch, test::small_knee_job(scratch, "right"), free_varus);
  ASSERT_EQ(model.status.cols(), 1);
  EXPECT_EQ(model.varus_deg, std::vector<double>{0.0});
  EXPECT_EQ(run::unsolved_fraction(model), 0.0) << run::status_line(model);
  ASSERT_TRUE(model.equilibrium);
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(model.contact_medial(i, 0), 1);
    EXPECT_EQ(model.contact_lateral(i, 0), 1);
    EXPECT_LT(model.gap_medial_mm(i, 0), touch_mm);
    EXPECT_LT(model.gap_lateral_mm(i, 0), touch_mm);
    EXPECT_NE(model.varus_solved_deg(i, 0), 0.0) << "the lateral dent is shallower";
    EXPECT_EQ(model.varus_solved_deg(i, 0), model.equilibrium->spine.varus_deg[static_cast<std::size_t>(i)]);
    EXPECT_LE(model.equilibrium->balance_residual_n(i, 0), 0.01 * 20.0);
    EXPECT_EQ(model.equilibrium->varus_moment_nmm(i, 0), 0.0);
    // Along Delta the two compartments carry the whole push.
    const auto y = static_cast<std::size_t>(3 * i + 1);
    const double borne_n = -model.equilibrium->force_medial_n[y] - model.equilibrium->force_lateral_n[y];
    EXPECT_NEAR(borne_n, 20.0, 0.01 * 20.0);
  }
  const analysis::AuditFigures measured = analysis::figures_of(analysis::audit(model, "raw", 1, 1));
  EXPECT_EQ(measured.n_overlapping, 0);
  EXPECT_EQ(measured.n_nothing_ahead, 0);
  EXPECT_LE(measured.largest_gap.value_mm, touch_mm);
}

TEST(EquilibriumRun, OverTheGridItGoesAsFarAlongDeltaAsTheSearch)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  const store::MotionModel exact = solved(scratch, job);
  const store::MotionModel searched = solved(scratch, job, {"--set", "solver.method=stability-search"});
  EXPECT_FALSE(searched.equilibrium);
  EXPECT_EQ(run::unsolved_fraction(exact), 0.0) << run::status_line(exact);
  const double resolution_mm = searched.contact_resolution_mm;
  EXPECT_TRUE((exact.ty_mm >= searched.ty_mm - resolution_mm).all())
      << (exact.ty_mm - searched.ty_mm).minCoeff();
  const analysis::AuditFigures measured = analysis::figures_of(analysis::audit(exact, "raw", 1, 1));
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
    std::vector<std::string> all{"--set", "solver.method=" + method,   "--set", "push.delta=" + delta,
                                 "--set", "limits.unsolved_fraction=1"};
    all.insert(all.end(), more.begin(), more.end());
    return solved(scratch, job, all);
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
      const std::vector<std::string> row{
          "--set", "grid.flexion={ from = " + flexion + ", to = " + flexion + ", step = 1 }"};
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

TEST(EquilibriumRun, ASidewaysLoadMovesTheJointItsOwnWayOnBothSides)
{
  const test::Scratch scratch;
  std::vector<double> shift_mm;
  for (const std::string side : {"right", "left"}) {
    const fs::path job = test::small_knee_job(scratch, side);
    const store::MotionModel plain = solved(scratch, job);
    const store::MotionModel pushed = solved(scratch, job, {"--set", "push.lateral_force_n=[8, 0]"});
    EXPECT_GT((pushed.tx_mm - plain.tx_mm).mean(), 0.1) << side;
    EXPECT_EQ(pushed.push.force_n.row(0), Eigen::RowVector3d(8, 20, 0));
    shift_mm.push_back((pushed.tx_mm - plain.tx_mm).mean());
  }
  EXPECT_EQ(shift_mm[0], shift_mm[1]);
}

TEST(EquilibriumRun, ItsTraceIsWholeMatchesTheModelAndChangesNothing)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  const fs::path plain = scratch.path() / "plain.h5";
  ASSERT_EQ(test::run_vrda(words(job, plain, {})).exit_code, 0);
  std::string bytes;
  for (const std::string threads : {"1", "2"}) {
    SCOPED_TRACE(threads);
    const fs::path traced = scratch.path() / ("traced" + threads + ".h5");
    const test::Ended ended = test::run_vrda(words(job, traced, {"--trace", "--threads", threads}));
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_EQ(test::read_bytes(plain), test::read_bytes(traced));
    const std::string file = store::trace_name(traced.string());
    EXPECT_EQ(test::run_vrda({"validate", file}).exit_code, 0);
    const store::Trace trace = store::read_trace(file);
    const store::MotionModel model = store::read_motion_model(traced.string());
    EXPECT_NO_THROW(store::require_trace_matches_model(trace, file, model, ""));
    EXPECT_EQ(trace.searches.node.size(), static_cast<std::size_t>(model.status.size()));
    EXPECT_GT(store::moves_in_contact(trace, 0).size(), 1U);
    if (bytes.empty()) bytes = test::read_bytes(file);
    EXPECT_EQ(test::read_bytes(file), bytes);
  }
}

}  // namespace vrda::equilibrium_test
