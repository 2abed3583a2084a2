// Warnings of `vrda run` about implausible stable poses: meshes with opposite winding, plates balanced on an
// edge.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "app/scenes.hpp"
#include "core/units.hpp"
#include "support/meshes.hpp"
#include "support/messages.hpp"

namespace vrda::implausible_poses_test {

using ::testing::Not;

std::string wavefront_text(const Mesh& mesh)
{
  std::ostringstream text;
  text.precision(17);
  text << "# made by a test\n";
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v)
    text << "v " << mesh.vertices_mm(v, 0) << ' ' << mesh.vertices_mm(v, 1) << ' ' << mesh.vertices_mm(v, 2)
         << '\n';
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    text << "f " << mesh.triangles(t, 0) + 1 << ' ' << mesh.triangles(t, 1) + 1 << ' '
         << mesh.triangles(t, 2) + 1 << '\n';
  return text.str();
}

/// A sheet that faces down except for a square in its middle, which has no facing pair from below.
Mesh sheet_wound_against_itself(double size_mm, double square_mm)
{
  Mesh mesh = test::sheet(size_mm, 12);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k) middle += mesh.vertices_mm.row(mesh.triangles(t, k)) / 3.0;
    const bool is_in_square = 2.0 * std::max(std::abs(middle.x()), std::abs(middle.z())) < square_mm;
    if (!is_in_square) std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
  }
  return mesh;
}

std::string job_of(const test::Scratch& scratch, const Mesh& reference, const Mesh& moving,
                   const std::string& start_mm)
{
  scratch.write("reference.obj", wavefront_text(reference));
  scratch.write("moving.obj", wavefront_text(moving));
  return scratch.write("job.toml", R"(title = "Two meshes"
joint = "other"
side = "right"
[reference]
name = "reference"
[[reference.component]]
name = "reference"
file = "reference.obj"
[moving]
name = "moving"
initial = { translation_mm = )" + start_mm +
                                       R"(, theta_deg = 0 }
[[moving.component]]
name = "moving"
file = "moving.obj"
[grid]
flexion = { from = 0, to = 5, step = 5 }
varus = { from = -5, to = 5, step = 5 }
[limits]
unsolved_fraction = 0.9
[smooth]
degrees = []
)");
}

nlohmann::json info_of(const std::string& file)
{
  return test::json_of({"info", file});
}

TEST(ImplausiblePoses, ABallThroughASheetThatIsWoundAgainstItselfIsOverlappingAndUnsolved)
{
  const test::Scratch scratch;
  const std::string job =
      job_of(scratch, sheet_wound_against_itself(60, 20), test::ball(15), "[0.5, -30, 0.3]");
  EXPECT_THAT(test::run_vrda({"check", job}).err + test::run_vrda({"check", job}).out,
              test::warns("", "inconsistent winding"));
  const std::string output = scratch.path() / "out.h5";
  const test::Ended run = test::run_vrda({"run", job, "-o", output});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(run.err, test::warns("limits.unsolved_fraction", "1.000000"));
  const nlohmann::json info = info_of(output);
  EXPECT_EQ(info["status"], nlohmann::json({{"overlapping", 6}}));
  EXPECT_EQ(info["remeasured"]["overlapping_attitudes"], 0);
  EXPECT_EQ(test::run_vrda({"validate", output}).exit_code, 0);
}

TEST(ImplausiblePoses, PlatesBesideEachOtherHaveNothingAheadAndTheRunSaysWhere)
{
  const test::Scratch scratch;
  const std::string job = job_of(scratch, test::box({-15, 0, 0}, {30, 10, 30}),
                                 test::box({15, 0, 0}, {30, 10, 30}), "[0, -60, 0]");
  const std::string output = scratch.path() / "out.h5";
  const test::Ended run = test::run_vrda({"run", job, "-o", output});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, test::warns("/plausibility", "nothing_ahead"));
  const nlohmann::json doubtful = info_of(output)["doubtful"];
  ASSERT_FALSE(doubtful.empty());
  EXPECT_EQ(doubtful[0]["plausibility"], "nothing_ahead");
  EXPECT_THAT(test::run_vrda({"info", output}).out, test::reports("", "nothing_ahead"));
  // The merge of shards gives the same file, and a repeated command warns again.
  const std::string parts = scratch.path() / "parts.h5";
  for (const char* shard : {"1/2", "2/2"})
    ASSERT_EQ(test::run_vrda({"run", job, "--shard", shard, "-o", parts}).exit_code, 0);
  EXPECT_THAT(test::run_vrda({"merge", "-o", parts}).err, test::warns("/plausibility", "nothing_ahead"));
  EXPECT_EQ(test::sha256_of_file(parts), test::sha256_of_file(output));
}

TEST(ImplausiblePoses, ARidgeHeldOnARidgeByFibresIsNotDoubted)
{
  // Two prisms with flanks of 17 degrees; the fibres at both sides are stiffer than the push is unstable.
  Mesh prism = test::box({0, 0, 0}, {30, 30, 30});
  const Eigen::AngleAxisd quarter(pi / 4.0, Eigen::Vector3d::UnitZ());
  prism.vertices_mm = (prism.vertices_mm * quarter.toRotationMatrix().transpose()).eval();
  prism.vertices_mm.col(1) *= 0.3;
  const double ridge_mm = 0.3 * 15.0 * std::sqrt(2.0);
  const test::Scratch scratch;
  const std::string job = job_of(scratch, prism, prism, "[0.5, -30, 0]");
  std::string fibres =
      "name,bundle,reference_x_mm,reference_y_mm,reference_z_mm,moving_x_mm,moving_y_mm,moving_z_mm,"
      "stiffness_n,slack_length_mm\n";
  for (const char* side : {"-40", "40"}) {
    for (const char* along : {"-10", "10"})
      fibres += std::string("f") + side + along + ",f," + side + "," + std::to_string(-2.0 * ridge_mm) + "," +
                along + ",0,0," + along + ",50000,39\n";
  }
  scratch.write("fibres.csv", fibres);
  const std::string output = scratch.path() / "out.h5";
  const test::Ended run =
      test::run_vrda({"run", job, "-o", output, "--set", "ligaments.fibres=\"fibres.csv\"", "--set",
                      "grid.flexion={from=0, to=0, step=1}", "--set", "grid.varus={from=0, to=0, step=1}"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, test::reports("1 attitudes", {"1", "stable"}));
  EXPECT_THAT(run.err, Not(test::warns("/plausibility")));
}

// Two barrels on one axis that end 15 degrees from their lowest points, in a trough: beyond 15 degrees of
// flexion their border carries.
TEST(ImplausiblePoses, FarPastTheFirstContactAtABorderTheRunIsIncomplete)
{
  constexpr double radius_mm = 20.0;
  Mesh barrels = test::sheet(40, 40), trough = test::sheet(60, 24);
  barrels.triangles.col(1).swap(barrels.triangles.col(2));
  for (Eigen::Index v = 0; v < barrels.vertices_mm.rows(); ++v) {
    const double angle = barrels.vertices_mm(v, 0) / 20.0 * rad_from_deg(15.0);
    barrels.vertices_mm(v, 0) = radius_mm * std::sin(angle);
    barrels.vertices_mm(v, 1) =
        -radius_mm * std::cos(angle) + std::pow(std::abs(barrels.vertices_mm(v, 2)) - 12.0, 2) / 60.0;
  }
  for (Eigen::Index v = 0; v < trough.vertices_mm.rows(); ++v)
    trough.vertices_mm(v, 1) = std::pow(trough.vertices_mm(v, 0), 2) / 80.0;
  const test::Scratch scratch;
  const std::string job = job_of(scratch, barrels, trough, "[0.5, -40, 0]");
  const auto run_to = [&](const char* last_deg) {
    const std::string grid = std::string("grid.flexion={from=0, to=") + last_deg + ", step=5}";
    return test::run_vrda({"run", job, "-o", (scratch.path() / "out.h5").string(), "--replace", "--set", grid,
                           "--set", "grid.varus={from=0, to=0, step=1}", "--set",
                           "limits.unsolved_fraction=0"});
  };
  const test::Ended near = run_to("25");
  EXPECT_EQ(near.exit_code, 0) << near.err;
  EXPECT_THAT(near.err, test::warns("/plausibility", "3 border_contact"));
  const test::Ended far = run_to("35");
  EXPECT_EQ(far.exit_code, 3) << far.err;
  EXPECT_THAT(far.err, test::warns("/plausibility", "2 border_contact more than 10 degrees"));
  EXPECT_THAT(far.err, test::warns("limits.unsolved_fraction", "0.250000"));
}

TEST(ImplausiblePoses, ABallInADishIsNotDoubted)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch);
  const std::string output = scratch.path() / "out.h5";
  const test::Ended run = test::run_vrda({"run", job, "-o", output});
  EXPECT_THAT(run.err, Not(test::warns("/plausibility")));
  EXPECT_TRUE(info_of(output)["doubtful"].empty());
}

}  // namespace vrda::implausible_poses_test
