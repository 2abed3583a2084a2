#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calibration/least_squares.hpp"
#include "calibration/tracker_fits.hpp"
#include "core/units.hpp"
#include "player/bench/moves.hpp"
#include "player/calibration/fit_support.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::tracker_fits_test {

using test::input_error, test::place_error;

/// True bench: nearly orthogonal rails at different heights.
struct Bench {
  Pose X_tracker_table = Pose::Identity();
  double apart_rad = rad_from_deg(89.8);
  double height_mm = 35.0;  ///< height of the second rail
  double noise_mm = 0.1;
  int n = 200;
  double length_mm = 400.0;
};

struct Sweeps {
  RailSweep x, z;
};

Sweeps sweeps_of(const Bench& bench, std::mt19937_64& random)
{
  Sweeps sweeps;
  const Eigen::Vector3d z_direction(std::cos(bench.apart_rad), 0.0, std::sin(bench.apart_rad));
  for (int k = 0; k < bench.n; ++k) {
    const double share = static_cast<double>(k) / (bench.n - 1);
    const double x_mm = (share - 0.3) * bench.length_mm;
    const Eigen::Vector3d on_z =
        Eigen::Vector3d(0.0, bench.height_mm, 0.0) + (100.0 + share * bench.length_mm) * z_direction;
    sweeps.x.p_tracker_mm.emplace_back(bench.X_tracker_table * Eigen::Vector3d(x_mm, 0.0, 0.0) +
                                       test::noise_of(random, bench.noise_mm));
    sweeps.x.stage_mm.push_back(x_mm + 17.0);
    sweeps.z.p_tracker_mm.emplace_back(bench.X_tracker_table * on_z + test::noise_of(random, bench.noise_mm));
  }
  return sweeps;
}

TEST(TableFit, RoundTripWithoutNoise)
{
  std::mt19937_64 random(41);
  Bench bench;
  bench.noise_mm = 0.0;
  bench.X_tracker_table = test::random_pose(random);
  const Sweeps sweeps = sweeps_of(bench, random);
  const TableFit fit = fit_table(sweeps.x, sweeps.z, "marks");
  constexpr double rounding = 1e-9;
  EXPECT_LT(place_error(fit.X_tracker_table, bench.X_tracker_table).norm(), rounding);
  EXPECT_NEAR(fit.rails_angle_rad, bench.apart_rad, rounding);
  EXPECT_NEAR(fit.stage_scale, 1.0, rounding);
  EXPECT_NEAR(fit.X_tracker_table.linear().determinant(), 1.0, rounding);
  EXPECT_EQ(fit.estimate.names.front(), "table.shift_x");
  EXPECT_NE(fit.estimate.remarks.front().find(" 89.8"), std::string::npos);
}

TEST(TableFit, MovingTheTrackerMovesTheTable)
{
  std::mt19937_64 random(43);
  const Pose X_moved = test::random_pose(random);
  const Sweeps sweeps = sweeps_of({}, random);
  Sweeps moved = sweeps;
  for (RailSweep* sweep : {&moved.x, &moved.z}) {
    for (Eigen::Vector3d& p : sweep->p_tracker_mm) p = X_moved * p;
  }
  const TableFit fit = fit_table(sweeps.x, sweeps.z, "marks"), there = fit_table(moved.x, moved.z, "marks");
  constexpr double rounding = 1e-9;
  EXPECT_LT(place_error(there.X_tracker_table, X_moved * fit.X_tracker_table).norm(), rounding);
  Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(6, 6);
  turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = X_moved.linear();
  constexpr double differences = 1e-5;  // central differences with a step of 1e-5
  const Eigen::MatrixXd expected = propagated(turned, fit.estimate.covariance);
  EXPECT_LT((there.estimate.covariance - expected).norm(), differences * expected.norm());
}

InputError::Facts refusal(const Sweeps& sweeps)
{
  return input_error([&] { fit_table(sweeps.x, sweeps.z, "marks"); });
}

TEST(TableFit, RefusesInvalidSweeps)
{
  std::mt19937_64 random(45);
  Bench few;
  few.n = 9;
  EXPECT_THAT(refusal(sweeps_of(few, random)), test::refuses({.field = "x_rail", .found = "9"}));
  Bench still;
  still.length_mm = 45.0;
  EXPECT_THAT(refusal(sweeps_of(still, random)), test::refuses({.field = "x_rail", .found = "sweep"}));
  Sweeps bent = sweeps_of({}, random);
  for (std::size_t k = 0; k < bent.z.p_tracker_mm.size(); ++k)
    bent.z.p_tracker_mm[k].y() += 12.0 * std::sin(pi * static_cast<double>(k) / 200.0);
  EXPECT_THAT(refusal(bent), test::refuses({.field = "z_rail", .found = "rms"}));
  Sweeps nowhere = sweeps_of({}, random);
  nowhere.x.p_tracker_mm[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(nowhere).field, "x_rail");
}

TEST(TableFit, RefusesAnOutlierByItsPlace)
{
  std::mt19937_64 random(46);
  for (const int n : {10, 200}) {
    Bench bench;
    bench.n = n;
    for (const std::size_t k : {std::size_t{0}, std::size_t{6}}) {
      Sweeps sweeps = sweeps_of(bench, random);
      sweeps.x.p_tracker_mm[k].y() += 8.0;
      EXPECT_THAT(refusal(sweeps),
                  test::refuses({.field = "x_rail", .found = "position " + std::to_string(k + 1)}));
    }
  }
}

TEST(TableFit, RefusesAnEncoderThatCountsOtherwise)
{
  std::mt19937_64 random(48);
  for (const double scale : {-1.0, 0.0, 0.96, 1.04}) {
    SCOPED_TRACE(scale);
    Sweeps sweeps = sweeps_of({}, random);
    for (double& s : sweeps.x.stage_mm) s *= scale;
    EXPECT_THAT(refusal(sweeps), test::refuses({.field = "x_rail", .wanted = "stage_mm_per_count"}));
  }
  Sweeps unknown = sweeps_of({}, random);
  unknown.x.stage_mm.clear();
  EXPECT_EQ(fit_table(unknown.x, unknown.z, "marks").stage_scale, 0.0);
}

const Eigen::Vector3d true_tip_mm(3.0, -172.0, 12.0);
const Eigen::Vector3d true_pivot_mm(120.0, 40.0, -1500.0);

struct Sweep {
  int n = 300;
  double tilt_rad = rad_from_deg(35.0);
  double position_mm = 0.1, turn_rad = rad_from_deg(0.03);
  double slip_mm = 0.0;
};

/// Tilted in all directions, and rotated about the shaft by the same amount.
std::vector<Pose> poses_of(const Sweep& sweep, std::mt19937_64& random,
                           const Pose& X_moved = Pose::Identity())
{
  std::vector<Pose> poses;
  for (int k = 0; k < sweep.n; ++k) {
    const double around = 2.0 * pi * 7.3 * k / sweep.n, out = sweep.tilt_rad * std::sqrt((k + 0.5) / sweep.n);
    Pose X = Pose::Identity();
    X.linear() = bench::rotation_of({out * std::cos(around), 0.0, out * std::sin(around)}) *
                 bench::rotation_of({0.0, out * std::sin(3.1 * around), 0.0});
    const Eigen::Vector3d slip = sweep.slip_mm * std::sin(around) * Eigen::Vector3d::UnitX();
    X.translation() = true_pivot_mm + slip - X.linear() * true_tip_mm;
    X = X_moved * X;
    X.linear() = (bench::rotation_of(test::noise_of(random, sweep.turn_rad)) * X.linear()).eval();
    X.translation() += test::noise_of(random, sweep.position_mm);
    poses.push_back(X);
  }
  return poses;
}

Sweep without_noise()
{
  Sweep sweep;
  sweep.position_mm = sweep.turn_rad = 0.0;
  return sweep;
}

TEST(PivotFit, RoundTripWithoutNoise)
{
  std::mt19937_64 random(31);
  const PivotFit fit = calibration::fit_pivot(poses_of(without_noise(), random), "marks");
  constexpr double rounding_mm = 1e-9;
  EXPECT_LT((fit.tip_probe_mm - true_tip_mm).norm(), rounding_mm);
  EXPECT_LT((fit.pivot_tracker_mm - true_pivot_mm).norm(), rounding_mm);
  EXPECT_LT(fit.estimate.residual_rms, rounding_mm);
}

TEST(PivotFit, MovingTheTrackerLeavesTheTipAndMovesThePivot)
{
  std::mt19937_64 random(32);
  const Pose X_moved = test::random_pose(random);
  std::vector<Pose> poses = poses_of({}, random), moved;
  moved.reserve(poses.size());
  for (const Pose& X : poses) moved.push_back(X_moved * X);
  const PivotFit fit = calibration::fit_pivot(poses, "marks"), there = calibration::fit_pivot(moved, "marks");
  constexpr double rounding_mm = 1e-9;
  EXPECT_LT((there.tip_probe_mm - fit.tip_probe_mm).norm(), rounding_mm);
  EXPECT_LT((there.pivot_tracker_mm - X_moved * fit.pivot_tracker_mm).norm(), rounding_mm);
  EXPECT_TRUE(there.estimate.covariance.isApprox(fit.estimate.covariance, rounding_mm));
}

TEST(PivotFit, ASpreadIsTheHalfAngleOfACone)
{
  // Poses on a cone of 30 degrees, with full rotation about the shaft: the shaft's direction varies least.
  std::vector<Pose> poses;
  const double half_rad = rad_from_deg(30.0);
  for (int k = 0; k < 36; ++k) {
    for (int turn = 0; turn < 4; ++turn) {
      const double around = 2.0 * pi * k / 36.0;
      Pose X = Pose::Identity();
      X.linear() = bench::rotation_of({half_rad * std::cos(around), 0.0, half_rad * std::sin(around)}) *
                   bench::rotation_of({0.0, 0.5 * pi * turn, 0.0});
      X.translation() = -(X.linear() * true_tip_mm);
      poses.push_back(X);
    }
  }
  EXPECT_NEAR(calibration::fit_pivot(poses, "marks").spread_rad, half_rad, 1e-9);
}

TEST(PivotFit, Refuses)
{
  std::mt19937_64 random(34);
  const auto refusal = [&](const Sweep& sweep) {
    return input_error([&] { calibration::fit_pivot(poses_of(sweep, random), "marks"); });
  };
  Sweep few;
  few.n = 19;
  EXPECT_THAT(refusal(few), test::refuses({.field = "probe", .found = "19"}));
  Sweep still;
  still.tilt_rad = 0.0;
  EXPECT_TRUE(refusal(still).found.starts_with("0 deg (rms)")) << refusal(still).found;
  Sweep little;
  little.tilt_rad = rad_from_deg(8.0);
  EXPECT_THAT(refusal(little), test::refuses({.field = "probe", .wanted = "tilt"}));
  Sweep slipped;
  slipped.slip_mm = 6.0;
  EXPECT_THAT(refusal(slipped), test::refuses({.field = "probe", .wanted = "slipped"}));
  EXPECT_EQ(refusal(slipped).field, "probe");
}

/// Knee with six fiducials and two targets.
std::vector<Fiducial> knee_points()
{
  return {{"lateral epicondyle", {0, 20, 42}, {}, false},
          {"medial epicondyle", {-2, 18, -44}, {}, false},
          {"patella", {48, 5, 2}, {}, false},
          {"tubercle", {35, -60, 4}, {}, false},
          {"fibular head", {-20, -45, 45}, {}, false},
          {"thigh", {25, 110, 10}, {}, false},
          {"shank", {28, -120, -8}, {}, true},
          {"joint line", {30, -5, 38}, {}, true}};
}

std::vector<Fiducial> touched_at(std::vector<Fiducial> points, const Pose& X_body_model, double noise_mm,
                                 std::mt19937_64& random)
{
  for (Fiducial& p : points) p.p_body_mm = X_body_model * p.p_model_mm + test::noise_of(random, noise_mm);
  return points;
}

TEST(FiducialFit, RoundTripWithoutNoise)
{
  std::mt19937_64 random(51);
  const Pose X_body_model = test::random_pose(random);
  const FiducialFit fit =
      calibration::fit_fiducials(touched_at(knee_points(), X_body_model, 0.0, random), "leg", "marks");
  constexpr double rounding = 1e-9;
  EXPECT_LT(place_error(fit.X_body_model, X_body_model).norm(), rounding);
  EXPECT_LT(fit.fiducial_rms_mm + fit.target_rms_mm + fit.leave_one_out_rms_mm, rounding);
  EXPECT_EQ(fit.estimate.residuals.size(), knee_points().size());
  EXPECT_EQ(fit.estimate.names[0], "leg.shift_x");
}

TEST(FiducialFit, MovingTheBodysFrameMovesTheModel)
{
  std::mt19937_64 random(52);
  const std::vector<Fiducial> points = touched_at(knee_points(), test::random_pose(random), 0.5, random);
  const Pose X_moved = test::random_pose(random);
  std::vector<Fiducial> moved = points;
  for (Fiducial& p : moved) p.p_body_mm = X_moved * p.p_body_mm;
  const FiducialFit fit = calibration::fit_fiducials(points, "leg", "marks"),
                    there = calibration::fit_fiducials(moved, "leg", "marks");
  constexpr double rounding = 1e-9;
  EXPECT_LT(place_error(there.X_body_model, X_moved * fit.X_body_model).norm(), rounding);
  EXPECT_NEAR(there.target_rms_mm, fit.target_rms_mm, rounding);
  EXPECT_NEAR(there.leave_one_out_rms_mm, fit.leave_one_out_rms_mm, rounding);
}

TEST(FiducialFit, IntervalsAreHonestAndTargetsAsBadAsExpected)
{
  std::mt19937_64 random(53);
  test::Coverage coverage;
  double target_sq = 0.0, expected_sq = 0.0, fiducial_sq = 0.0;
  constexpr int n = 800;
  for (int set = 0; set < n; ++set) {
    const Pose X_body_model = test::random_pose(random);
    const FiducialFit fit =
        calibration::fit_fiducials(touched_at(knee_points(), X_body_model, 0.3, random), "leg", "marks");
    coverage.add(fit.estimate, place_error(fit.X_body_model, X_body_model));
    target_sq += fit.target_rms_mm * fit.target_rms_mm / n;
    expected_sq += fit.expected_target_rms_mm * fit.expected_target_rms_mm / n;
    fiducial_sq += fit.fiducial_rms_mm * fit.fiducial_rms_mm / n;
  }
  coverage.expect_honest();
  // Per set 6 target coordinates and 12 degrees of freedom of the noise: relative errors of the mean squares
  // sqrt(2 / 6 / 800) and sqrt(2 / 12 / 800), together 2.5 %; four times that.
  EXPECT_NEAR(target_sq / expected_sq, 1.0, 0.1);
  // Fiducial registration error: 3 (1 - 2 / n) variances of a coordinate. Source: Fitzpatrick (1998).
  EXPECT_NEAR(fiducial_sq / (3.0 * 0.09 * (1.0 - 2.0 / 6.0)), 1.0, 0.1);
}

InputError::Facts refusal(const std::vector<Fiducial>& points)
{
  return input_error([&] { calibration::fit_fiducials(points, "leg", "marks"); });
}

TEST(FiducialFit, RefusesSetsThatDoNotDetermineThePose)
{
  std::mt19937_64 random(54);
  const Pose X = test::random_pose(random);
  std::vector<Fiducial> few = touched_at(knee_points(), X, 0.1, random);
  for (std::size_t k = 0; k < 3; ++k) few[k].is_target = true;
  EXPECT_EQ(refusal(few).found.front(), '3');
  std::vector<Fiducial> line = knee_points();
  for (std::size_t k = 0; k < line.size(); ++k)
    line[k].p_model_mm = {1.0, 20.0 * static_cast<double>(k), 0.1};
  EXPECT_THAT(refusal(touched_at(line, X, 0.1, random)),
              test::refuses({.field = "fiducials", .found = "collinear"}));
  std::vector<Fiducial> plane = knee_points();
  for (Fiducial& p : plane) p.p_model_mm.x() = 0.3 * p.p_model_mm.y();
  EXPECT_THAT(refusal(touched_at(plane, X, 0.1, random)),
              test::refuses({.field = "fiducials", .found = "coplanar", .wanted = "plane"}));
  std::vector<Fiducial> one_place = touched_at(knee_points(), X, 0.1, random);
  for (Fiducial& p : one_place) p.p_body_mm = {1.0, 2.0, 3.0};
  EXPECT_THAT(refusal(one_place), test::refuses({.field = "fiducials", .found = "touched"}));
  std::vector<Fiducial> nowhere = touched_at(knee_points(), X, 0.1, random);
  nowhere[4].p_body_mm.z() = std::nan("");
  EXPECT_EQ(refusal(nowhere).field, "fibular head");
}

TEST(FiducialFit, RefusesTheOtherSide)
{
  std::mt19937_64 random(55);
  std::vector<Fiducial> points = touched_at(knee_points(), test::random_pose(random), 0.3, random);
  for (Fiducial& p : points) p.p_model_mm.z() *= -1.0;
  EXPECT_THAT(refusal(points), test::refuses({.field = "fiducials", .found = "mirrored"}));
}

TEST(FiducialFit, RefusesASetThatFitsItsMirrorImageAsWell)
{
  // 2.5 mm off a plane (singular value 5.6 mm) with 3 mm of noise: the side is undetermined.
  std::mt19937_64 random(56);
  std::vector<Fiducial> flat = knee_points();
  for (std::size_t k = 0; k < flat.size(); ++k) flat[k].p_model_mm.x() = k % 2 == 0 ? 2.5 : -2.5;
  int n_refused = 0;
  constexpr int n = 50;
  for (int set = 0; set < n; ++set) {
    const std::vector<Fiducial> points = touched_at(flat, test::random_pose(random), 3.0, random);
    try {
      calibration::fit_fiducials(points, "leg", "marks");
    } catch (const InputError& error) {
      n_refused += error.facts().found.find("mirrored") != std::string::npos ? 1 : 0;
    }
  }
  EXPECT_GT(n_refused, n / 2);
}

TEST(FiducialFit, SaysWhenTargetsAreWorseThanTouchingExplains)
{
  std::mt19937_64 random(58);
  std::vector<Fiducial> points = touched_at(knee_points(), test::random_pose(random), 0.1, random);
  points.back().p_body_mm.x() += 6.0;
  const FiducialFit fit = calibration::fit_fiducials(points, "leg", "marks");
  EXPECT_GT(fit.target_rms_mm, 4.0);
  EXPECT_NE(fit.estimate.remarks.back().find("twice"), std::string::npos);
}

TEST(MeanPlace, OfTwoIsHalfwayAndOfOneIsRefused)
{
  std::mt19937_64 random(60);
  const Pose first = test::random_pose(random);
  Pose second = first;
  second.linear() = bench::rotation_of({0.2, -0.1, 0.3}) * first.linear();
  second.translation() += Eigen::Vector3d(1.0, 2.0, 3.0);
  const std::vector<Pose> adjusted = {first, second};
  const FiducialFit fit = calibration::mean_adjusted_pose(adjusted, "leg", "marks");
  Pose half = first;
  half.linear() = bench::rotation_of({0.1, -0.05, 0.15}) * first.linear();
  half.translation() += Eigen::Vector3d(0.5, 1.0, 1.5);
  EXPECT_LT(place_error(fit.X_body_model, half).norm(), 1e-10);
  EXPECT_EQ(input_error([&] {
              calibration::mean_adjusted_pose({adjusted.data(), 1}, "leg", "marks");
            }).field,
            "leg");
}

std::vector<LandmarkDistance> distances_of(double scale)
{
  std::vector<LandmarkDistance> distances = {
      {"condyles", 85.0, 0.0}, {"plateau", 78.0, 0.0}, {"thigh", 410.0, 0.0}, {"shank", 370.0, 0.0}};
  for (LandmarkDistance& d : distances) d.subject_mm = scale * d.model_mm;
  return distances;
}

TEST(ScaleFit, ExactDistancesGiveTheirScale)
{
  const ScaleFit fit = fit_scale(distances_of(0.92), "marks");
  EXPECT_NEAR(fit.scale, 0.92, 1e-15);
  EXPECT_FALSE(fit.is_nonuniform);
  EXPECT_NEAR(fit.estimate.residual_rms, 0.0, 1e-12);
  EXPECT_EQ(fit.estimate.names.front(), "subject.scale");
  EXPECT_EQ(fit.estimate.dof, 3.0);
}

TEST(ScaleFit, UnevenDistancesAreCalledSo)
{
  std::vector<LandmarkDistance> distances = distances_of(1.0);
  for (LandmarkDistance& d : distances) d.subject_mm *= d.model_mm > 100.0 ? 1.06 : 0.95;
  const ScaleFit fit = fit_scale(distances, "marks");
  EXPECT_TRUE(fit.is_nonuniform);
  ASSERT_EQ(fit.estimate.remarks.size(), 1U);
  EXPECT_NE(fit.estimate.remarks[0].find("95 % to 106 %"), std::string::npos) << fit.estimate.remarks[0];
}

TEST(ScaleFit, Refuses)
{
  const auto refusal = [](const std::vector<LandmarkDistance>& distances) {
    return input_error([&] { fit_scale(distances, "marks"); });
  };
  std::vector<LandmarkDistance> few = distances_of(1.0);
  few.resize(2);
  EXPECT_THAT(refusal(few), test::refuses({.field = "landmarks", .found = "2"}));
  std::vector<LandmarkDistance> zero = distances_of(1.0);
  zero[1].subject_mm = 0.0;
  EXPECT_EQ(refusal(zero).field, "plateau");
  EXPECT_THAT(refusal(distances_of(0.45)), test::refuses({.field = "landmarks", .found = "0.45"}));
  EXPECT_EQ(refusal(distances_of(10.0)).field, "landmarks");
}

}  // namespace vrda::calibration::tracker_fits_test
