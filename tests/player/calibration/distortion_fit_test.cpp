#include "calibration/distortion_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "coverage.hpp"
#include "noise.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::distortion_fit_test {

/// Accuracy of warp_mesh() at the midpoints of its edges.
constexpr double mesh_px = 0.02;

using test::Coverage;
using test::input_error;
using test::Noise;
using testing::HasSubstr;

const std::string file = "calibration.toml";

/// Half of 1280 x 480, mostly visible.
view::Eye bench_eye()
{
  view::Eye eye;
  eye.window = {640, 0, 640, 480};
  eye.visible = {658, 14, 600, 450};
  return eye;
}

Eigen::Vector2d middle_px()
{
  return {658 + 300, 14 + 225};
}

struct Truth {
  view::Distortion distortion;
  GridPose grid;
};

Truth sample_truth()
{
  return {{0.12, 0.02, middle_px() + Eigen::Vector2d(4.0, -3.0), 320.0, 1.02},
          {middle_px() + Eigen::Vector2d(7.0, 5.0), 82.0, rad_from_deg(1.5)}};
}

/// 7 columns, 5 rows.
std::vector<GridMark> marks_of(const Truth& truth, double noise_px, Noise& noise)
{
  std::vector<GridMark> marks;
  for (int row = -2; row <= 2; ++row) {
    for (int column = -3; column <= 3; ++column) {
      GridMark mark;
      mark.node = Eigen::Vector2d(column, row);
      mark.drawn_px =
          view::drawn_px(truth.distortion,
                         calibration::shown_px(truth.grid, truth.distortion.pixel_aspect, mark.node)) +
          noise_px * Eigen::Vector2d(noise.normals(2));
      marks.push_back(mark);
    }
  }
  return marks;
}

DistortionFit fitted(const std::vector<GridMark>& marks, const AspectPrior& aspect = {1.02, 0.001})
{
  return calibration::fit_distortion(marks, bench_eye(), aspect, "left", file);
}

Eigen::VectorXd numbers_of(const view::Distortion& d)
{
  Eigen::VectorXd numbers(5);
  numbers << d.k1, d.k2, d.centre_px, d.pixel_aspect;
  return numbers;
}

TEST(GridPlaces, RowsGoUpwardsAndTurnsCounterClockwise)
{
  const GridPose upright{{100, 50}, 20, 0.0};
  EXPECT_LT((calibration::shown_px(upright, 1.0, {2, 1}) - Eigen::Vector2d(140, 30)).norm(), 1e-12);
  EXPECT_LT((calibration::shown_px(upright, 2.0, {2, 1}) - Eigen::Vector2d(140, 40)).norm(), 1e-12);
  const GridPose turned{{100, 50}, 20, rad_from_deg(90)};  // rotates right to up
  EXPECT_LT((calibration::shown_px(turned, 2.0, {1, 0}) - Eigen::Vector2d(100, 40)).norm(), 1e-12);
}

TEST(DistortionFits, MarksWithoutNoiseGiveTheOpticsBack)
{
  Noise none(1);
  for (const double k1 : {0.25, 0.12, -0.1}) {
    SCOPED_TRACE(k1);
    Truth truth = sample_truth();
    truth.distortion.k1 = k1;
    // The prior of the aspect has an error, which the marks correct.
    const DistortionFit fit = fitted(marks_of(truth, 0.0, none), {1.021, 0.001});
    EXPECT_FALSE(fit.has_centre_prior);
    EXPECT_LT((numbers_of(fit.distortion) - numbers_of(truth.distortion)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_EQ(fit.distortion.unit_px, 320.0);
    EXPECT_LT((fit.grid.origin_px - truth.grid.origin_px).norm(), 1e-6);
    EXPECT_NEAR(fit.grid.spacing_px, truth.grid.spacing_px, 1e-6);
    EXPECT_NEAR(fit.grid.turn_rad, truth.grid.turn_rad, 1e-6);
    EXPECT_LT(fit.inverse_error_px, mesh_px);
    EXPECT_EQ(fit.estimate.names[2], "left.centre_x");
    EXPECT_EQ(fit.estimate.units[2], "px");
    EXPECT_EQ(fit.estimate.values, numbers_of(fit.distortion));
    EXPECT_EQ(fit.estimate.residuals.size(), 35U);
  }
}

TEST(DistortionFits, AnAspectThatIsKnownStays)
{
  Noise noise(2);
  const DistortionFit fit = fitted(marks_of(sample_truth(), 0.5, noise), {1.02, 0.0});
  EXPECT_EQ(fit.distortion.pixel_aspect, 1.02);
  EXPECT_EQ(fit.estimate.covariance(4, 4), 0.0);
}

/// Translating the picture in the frame buffer translates the result.
TEST(DistortionFits, MovingThePictureMovesTheCentre)
{
  Noise noise(3);
  const Eigen::Vector2d by(64, 32);
  std::vector<GridMark> marks = marks_of(sample_truth(), 0.5, noise);
  const DistortionFit here = fitted(marks);
  for (GridMark& mark : marks) mark.drawn_px += by;
  view::Eye eye = bench_eye();
  eye.window.x += 64;
  eye.visible.x += 64;
  eye.window.y += 32;
  eye.visible.y += 32;
  const DistortionFit there = calibration::fit_distortion(marks, eye, {1.02, 0.001}, "left", file);
  constexpr double solver_tolerance = 1e-6;
  EXPECT_LT((there.distortion.centre_px - here.distortion.centre_px - by).norm(), solver_tolerance);
  EXPECT_NEAR(there.distortion.k1, here.distortion.k1, solver_tolerance);
  EXPECT_NEAR(there.estimate.residual_rms, here.estimate.residual_rms, solver_tolerance);
}

TEST(DistortionFits, WithoutDistortionTheCentreIsHeldAndItsIntervalIsHonest)
{
  Coverage coverage;
  int n_held = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Noise noise(seed);
    Truth truth = sample_truth();
    truth.distortion.k1 = 0.003 * noise.normal();
    truth.distortion.k2 = 0.0;
    truth.distortion.centre_px = middle_px() + centre_prior_sd_px * Eigen::Vector2d(noise.normals(2));
    truth.distortion.pixel_aspect = 1.02 + 0.001 * noise.normal();
    const DistortionFit fit = fitted(marks_of(truth, 0.5, noise));
    n_held += fit.has_centre_prior ? 1 : 0;
    coverage.add(fit.estimate, numbers_of(fit.distortion) - numbers_of(truth.distortion));
  }
  EXPECT_GE(n_held, 150);
  coverage.expect_honest();
}

TEST(DistortionFits, MarksThatAreNotEnoughAreRefused)
{
  Noise noise(5);
  const std::vector<GridMark> marks = marks_of(sample_truth(), 0.5, noise);
  const auto refused = [&](const std::vector<GridMark>& some) { return input_error([&] { fitted(some); }); };
  EXPECT_THAT(refused({marks.begin(), marks.begin() + 11}), test::refuses({file, "left.distortion", "11"}));
  std::vector<GridMark> row;
  for (int repeat = 0; repeat < 2; ++repeat) row.insert(row.end(), marks.begin() + 14, marks.begin() + 21);
  EXPECT_THAT(refused(row), test::refuses({.field = "left.distortion", .found = "collinear"}));
  std::vector<GridMark> one_place = marks;
  for (GridMark& mark : one_place) mark.drawn_px = middle_px();
  EXPECT_THAT(refused(one_place), test::refuses({.field = "left.distortion", .found = "collinear"}));
  // Four repeated nodes have a large spread but do not determine the distortion.
  std::vector<GridMark> corners;
  for (int repeat = 0; repeat < 3; ++repeat) {
    for (const std::size_t i : {0U, 6U, 28U, 34U}) corners.push_back(marks[i]);
  }
  EXPECT_THAT(refused(corners), test::refuses({.field = "left.distortion", .wanted = "visible"}));
}

TEST(DistortionFits, OpticsThatFoldAreRefused)
{
  Truth truth = sample_truth();
  truth.distortion.k1 = -0.28;  // folds at 349 px, the corners are 375 px away
  truth.distortion.k2 = 0.0;
  truth.grid.spacing_px = 50.0;
  Noise noise(6);
  EXPECT_THAT(input_error([&] { fitted(marks_of(truth, 0.1, noise)); }),
              test::refuses({.field = "left.distortion", .found = "folds"}));
}

GridValues values_of(const DistortionFit& fit)
{
  return {fit.distortion.k1, fit.distortion.k2, fit.distortion.centre_px, fit.grid};
}

/// Grid of an operator who matches all nodes as well as the eight numbers allow, for the drawn aspect.
AdjustedGrids adjusted_grids(int n, const Truth& truth, double drawn_aspect, Noise& noise)
{
  AdjustedGrids grids{{}, 7, 5};
  for (int i = 0; i < n; ++i)
    grids.values.push_back(values_of(fitted(marks_of(truth, 0.5, noise), {drawn_aspect, 0.0})));
  return grids;
}

DistortionFit mean_of(const AdjustedGrids& grids, const AspectPrior& aspect = {1.02, 0.001})
{
  return calibration::mean_distortion(grids, bench_eye(), aspect, "left", file);
}

/// Two grids that differ only by a rotation: noise^2 = 2 (turn * spacing)^2 sum |node|^2 / 8, because nodes
/// move perpendicular to the radius. Without distortion and with square pixels drawn and displayed positions
/// are equal.
TEST(AdjustedGrids, TheirMeanAndTheirNoiseMatchTheClosedForm)
{
  GridValues a;
  a.centre_px = middle_px();
  a.grid = {middle_px(), 80.0, 0.01};
  GridValues b = a;
  constexpr double turn_rad = 1e-3;
  a.grid.turn_rad -= turn_rad;
  b.grid.turn_rad += turn_rad;
  const DistortionFit fit = mean_of({{a, b}, 7, 5}, {1.0, 0.001});
  double nodes_sq = 0.0;
  for (int row = -2; row <= 2; ++row) {
    for (int column = -3; column <= 3; ++column) nodes_sq += row * row + column * column;
  }
  EXPECT_NEAR(fit.noise_px, turn_rad * 80.0 * std::sqrt(2.0 * nodes_sq / 8.0), 1e-6);
  EXPECT_EQ(fit.estimate.dof, 8.0);
  EXPECT_NEAR(fit.grid.turn_rad, 0.01, 1e-15);
  EXPECT_EQ(fit.grid.spacing_px, 80.0);
  // The centre is undetermined.
  EXPECT_TRUE(fit.has_centre_prior);
  EXPECT_EQ(fit.distortion.centre_px, middle_px());
  EXPECT_NEAR(fit.estimate.covariance(2, 2), centre_prior_sd_px * centre_prior_sd_px, 1e-6);
  EXPECT_THAT(fit.estimate.remarks.back(), HasSubstr("centre"));
}

TEST(AdjustedGrids, OneIsNotEnoughAndFoldsAreRefused)
{
  Noise noise(7);
  AdjustedGrids grids = adjusted_grids(1, sample_truth(), 1.02, noise);
  EXPECT_THAT(input_error([&] { mean_of(grids); }),
              test::refuses({.field = "left.distortion", .found = "1"}));
  grids = adjusted_grids(3, sample_truth(), 1.02, noise);
  for (GridValues& grid : grids.values) {
    grid.k1 = -0.3;
    grid.k2 = 0.0;
  }
  EXPECT_THAT(input_error([&] { mean_of(grids); }),
              test::refuses({.field = "left.distortion", .found = "folds"}));
}

}  // namespace vrda::calibration::distortion_fit_test
