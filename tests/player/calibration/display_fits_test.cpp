#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <cmath>

#include "calibration/distortion_fit.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "core/units.hpp"
#include "player/calibration/fit_support.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::display_fits_test {

/// Accuracy of warp_mesh() at the midpoints of its edges.
constexpr double mesh_px = 0.02;

using test::Coverage, test::input_error, test::Noise, testing::HasSubstr;

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
  GridValues values;
  values << fit.distortion.k1, fit.distortion.k2, fit.distortion.centre_px, fit.grid.origin_px,
      fit.grid.spacing_px, fit.grid.turn_rad;
  return values;
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
  a << 0.0, 0.0, middle_px(), middle_px(), 80.0, 0.01;
  GridValues b = a;
  constexpr double turn_rad = 1e-3;
  a[7] -= turn_rad;
  b[7] += turn_rad;
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
  for (GridValues& grid : grids.values) grid.head<2>() << -0.3, 0.0;
  EXPECT_THAT(input_error([&] { mean_of(grids); }),
              test::refuses({.field = "left.distortion", .found = "folds"}));
}

struct Rectangle {
  double width_mm = 0.0, depth_mm = 0.0;
};
const std::array<Rectangle, 4> bench_rectangles = {{{150, 0}, {200, 150}, {250, 300}, {300, 450}}};

view::Eye sample_eye(double x_mm)
{
  view::Eye eye;
  eye.window = eye.visible = {0, 0, 640, 480};
  eye.distance_px = 880.0;
  eye.sight_px = {322.0, 238.0};
  eye.position_head_mm = {x_mm, 0.0, 750.0};  // plane of the first rectangle: z = 0
  eye.distortion = {0.06, 0.01, {318.0, 241.0}, 320.0, 1.0};
  return eye;
}

struct Hand {
  double noise_px = 0.5;  ///< standard deviation of a side
  int repeats = 3;
  double turn_rad = 0.0;   ///< rotation of the optical axis about the vertical
  double middle_mm = 4.0;  ///< horizontal position of the rectangles
};

/// Marks of an operator with the given noise, for the true `eye`.
std::vector<RectangleMark> marks_of(const view::Eye& eye, const Hand& hand, std::mt19937_64& random)
{
  std::normal_distribution<double> noise(0.0, hand.noise_px > 0.0 ? hand.noise_px : 1.0);
  std::vector<RectangleMark> marks;
  for (const Rectangle& r : bench_rectangles) {
    for (int k = 0; k < hand.repeats; ++k) {
      RectangleMark mark = {r.width_mm, r.depth_mm, {}, {}};
      for (const double side : {-0.5, 0.5}) {
        const double x_mm = hand.middle_mm + side * r.width_mm - eye.position_head_mm.x();
        const double away_mm = eye.position_head_mm.z() + r.depth_mm;
        const double column = eye.distance_px * std::tan(std::atan2(x_mm, away_mm) - hand.turn_rad);
        Eigen::Vector2d drawn = view::drawn_px(eye.distortion, {eye.sight_px.x() + column, eye.sight_px.y()});
        if (hand.noise_px > 0.0) drawn.x() += noise(random);
        (side < 0.0 ? mark.left_drawn_px : mark.right_drawn_px) = drawn;
      }
      marks.push_back(mark);
    }
  }
  return marks;
}

TEST(Eyepoint, NearDepthsAreIllConditionedAsWeKnow)
{
  // Width noise of 0.5 px, rectangles of 150 mm at 0.75 and 0.85 m. The depth of the first is X2 Z / (X1 -
  // X2): 27.4 mm from the noise of both widths, 29 mm from the noise of the difference alone.
  const std::array<RectangleMark, 2> rectangles = {{{150.0, 0.0, {}, {}}, {150.0, 100.0, {}, {}}}};
  const Eigen::Vector2d sd =
      calibration::expected_eyepoint_sd(rectangles, {880.0, 750.0}, 0.5 / std::sqrt(2.0));
  const double X1 = 176.0, X2 = 880.0 * 150.0 / 850.0, apart_sq = (X1 - X2) * (X1 - X2);
  EXPECT_NEAR(sd(1), 0.5 * 100.0 * std::hypot(X1, X2) / apart_sq, 1e-6);
  EXPECT_NEAR(sd(1), 29.0, 2.0);
  EXPECT_TRUE(std::isinf(calibration::expected_eyepoint_sd({rectangles.data(), 1}, {880.0, 750.0}, 0.5)(1)));
}

TEST(EyepointFit, RoundTripWithoutNoiseAgreesWithTwoRectangles)
{
  std::mt19937_64 random(61);
  const view::Eye eye = sample_eye(-32.0);
  Hand hand;
  hand.noise_px = 0.0;
  const std::vector<RectangleMark> marks = marks_of(eye, hand, random);
  const EyepointFit fit = calibration::fit_eyepoint(marks, eye, {}, "left", "marks");
  constexpr double rounding = 1e-7;  // 1e-12 px amplified by the condition of the fit
  EXPECT_NEAR(fit.eyepoint.distance_px, 880.0, rounding);
  EXPECT_NEAR(fit.eyepoint.depth_mm, 750.0, rounding);
  EXPECT_EQ(fit.estimate.names[1], "left.depth");
  const auto width_px = [&](const RectangleMark& m) {
    return view::shown_px(eye.distortion, m.right_drawn_px).x() -
           view::shown_px(eye.distortion, m.left_drawn_px).x();
  };
  // Figure 24 of the thesis: X_i = d L_i / (E + Z_i) of two rectangles.
  const RectangleMark &first = marks.front(), &last = marks.back();
  const double X1 = width_px(first), X2 = width_px(last);
  const double distance_px =
      X1 * X2 * (last.depth_mm - first.depth_mm) / (X1 * last.width_mm - X2 * first.width_mm);
  EXPECT_NEAR(fit.eyepoint.distance_px, distance_px, rounding);
  EXPECT_NEAR(fit.eyepoint.depth_mm, first.width_mm * distance_px / X1 - first.depth_mm, rounding);
}

InputError::Facts refusal(const std::vector<RectangleMark>& marks, double most_sd_mm = 15.0)
{
  EyepointOptions options;
  options.max_depth_sd_mm = most_sd_mm;
  return input_error([&] { calibration::fit_eyepoint(marks, sample_eye(-32.0), options, "left", "marks"); });
}

TEST(EyepointFit, RefusesMarksThatDoNotDetermineTheDepthAndNamesThoseToAdd)
{
  std::mt19937_64 random(64);
  const view::Eye eye = sample_eye(-32.0);
  std::vector<RectangleMark> marks = marks_of(eye, {}, random);
  EXPECT_THAT(refusal({marks[0], marks[4]}), test::refuses({.field = "left", .found = "2"}));
  const std::vector<RectangleMark> one_depth(marks.begin(), marks.begin() + 3);
  EXPECT_THAT(refusal(one_depth), test::refuses({.field = "left", .found = "depths", .wanted = "rectangle"}));
  const std::vector<RectangleMark> near(marks.begin(), marks.begin() + 6);
  EXPECT_THAT(refusal(near, 5.0), test::refuses({.field = "left", .found = "deviation"}));
}

TEST(EyepointFit, RefusesWidthsThatGrowWithDepth)
{
  std::mt19937_64 random(66);
  std::vector<RectangleMark> marks = marks_of(sample_eye(-32.0), {}, random);
  for (RectangleMark& mark : marks) mark.depth_mm = -mark.depth_mm;
  EXPECT_FALSE(refusal(marks).wanted.empty());
}

/// Marks of a person with eyes at -32 and +32 mm, with axis errors `sight_error_px` (left, right).
std::array<EyeRectangles, 2> seen_by_two(const Hand& hand, const Eigen::Vector2d& sight_error_px,
                                         std::mt19937_64& random)
{
  std::array<EyeRectangles, 2> both;
  for (std::size_t k = 0; k < both.size(); ++k) {
    const view::Eye truth = sample_eye(k == 0 ? -32.0 : 32.0);
    both[k].marks = marks_of(truth, hand, random);
    both[k].eye = truth;
    both[k].eye.sight_px.x() += sight_error_px(static_cast<Eigen::Index>(k));
    both[k].fit =
        calibration::fit_eyepoint(both[k].marks, both[k].eye, {}, k == 0 ? "left" : "right", "marks");
  }
  return both;
}

TEST(PupilDistance, RoundTripWithoutNoise)
{
  std::mt19937_64 random(67);
  Hand hand;
  hand.noise_px = 0.0;
  const std::array<EyeRectangles, 2> both = seen_by_two(hand, Eigen::Vector2d::Zero(), random);
  EXPECT_NEAR(pupil_distance(both[0], both[1], 3.0).ipd_mm, 64.0, 1e-6);
}

TEST(PupilDistance, AWrongOneIsSeenAsAWrongDepth)
{
  EXPECT_DOUBLE_EQ(depth_error_mm(800.0, 64.0, 64.0), 0.0);
  EXPECT_DOUBLE_EQ(depth_error_mm(800.0, 64.0, 66.0), 25.0);
  EXPECT_LT(depth_error_mm(800.0, 66.0, 64.0), 0.0);
}

const view::Viewport window = {640, 512, 640, 480};

struct TrueView {
  double left = 660.3, right = 1260.8, top = 520.2, bottom = 975.6;
  Eigen::Vector2d screen_mm = {300.0, 236.7};
};

/// First or last line that is at least half visible; the noise moves the border before rounding.
ViewportMarks readings_of(const TrueView& view, double noise_px, int repeats, std::mt19937_64& random)
{
  std::normal_distribution<double> noise(0.0, 1.0);
  ViewportMarks marks;
  marks.screen_mm = view.screen_mm + marks.screen_sd_mm * Eigen::Vector2d(noise(random), noise(random));
  for (int k = 0; k < repeats; ++k) {
    marks.line_px[0].push_back(std::ceil(view.left + noise_px * noise(random) - 0.5));
    marks.line_px[1].push_back(std::floor(view.right + noise_px * noise(random) - 0.5));
    marks.line_px[2].push_back(std::ceil(view.top + noise_px * noise(random) - 0.5));
    marks.line_px[3].push_back(std::floor(view.bottom + noise_px * noise(random) - 0.5));
  }
  return marks;
}

double aspect_of(const TrueView& view)
{
  return view.screen_mm.y() / (view.bottom - view.top) / (view.screen_mm.x() / (view.right - view.left));
}

ViewportMarks good_marks()
{
  std::mt19937_64 random(11);
  return readings_of({}, 0.5, 4, random);
}

TEST(ViewportFit, WholePixelsAreFoundExactly)
{
  ViewportMarks marks;
  // Columns 650 to 1249 are visible, so the borders are 650 and 1250.
  marks.line_px = {{{650, 650}, {1249, 1249}, {520, 520}, {969, 969}}};
  marks.screen_mm = {300.0, 225.0};
  const bench::Estimate fit = calibration::fit_viewport(marks, window, "left", "marks");
  EXPECT_EQ(fit.values.head<4>(), Eigen::Vector4d(650, 1250, 520, 970));
  EXPECT_DOUBLE_EQ(fit.values[4], 1.0);
  EXPECT_EQ(fit.names[1], "left.edge_right");
  // Equal readings still have the rounding error.
  EXPECT_DOUBLE_EQ(fit.covariance(0, 0), 1.0 / 12.0);
}

TEST(ViewportFit, IntervalsAreHonestWhateverTheNoiseOfTheHand)
{
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (const double noise_px : {0.3, 0.5, 1.0}) {
    SCOPED_TRACE(noise_px);
    test::Coverage coverage;
    for (int bench = 0; bench < 1000; ++bench) {
      TrueView view;
      view.left += part(random);
      view.right += part(random);
      view.top += part(random);
      view.bottom += part(random);
      const bench::Estimate fit =
          calibration::fit_viewport(readings_of(view, noise_px, 4, random), window, "left", "marks");
      Eigen::VectorXd truth(5);
      truth << view.left, view.right, view.top, view.bottom, aspect_of(view);
      coverage.add(fit, fit.values - truth);
      EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(fit.covariance).info(), Eigen::Success);
    }
    coverage.expect_honest();
  }
}

TEST(ViewportFit, MovingTheWindowMovesTheEdges)
{
  ViewportMarks moved = good_marks();
  for (std::size_t edge = 0; edge < n_edges; ++edge) {
    for (double& reading : moved.line_px[edge]) reading -= edge < 2 ? 640 : 512;
  }
  const bench::Estimate at = calibration::fit_viewport(good_marks(), window, "left", "marks");
  const bench::Estimate there = calibration::fit_viewport(moved, {0, 0, 640, 480}, "left", "marks");
  constexpr double rounding = 1e-12;
  Eigen::VectorXd expected = at.values;
  expected.head<4>() -= Eigen::Vector4d(640, 640, 512, 512);
  EXPECT_TRUE(there.values.isApprox(expected, rounding));
  EXPECT_TRUE(there.covariance.isApprox(at.covariance, rounding));
}

InputError::Facts refusal(const ViewportMarks& marks)
{
  return input_error([&] { calibration::fit_viewport(marks, window, "left", "marks"); });
}

TEST(ViewportFit, RefusesByEdge)
{
  ViewportMarks none = good_marks();
  none.line_px[3].clear();
  EXPECT_THAT(refusal(none), test::refuses({.field = "left.bottom", .found = "no readings"}));

  ViewportMarks crossed = good_marks();
  std::swap(crossed.line_px[0], crossed.line_px[1]);
  EXPECT_THAT(refusal(crossed), test::refuses({.field = "left.left", .found = "crossed"}));

  ViewportMarks beyond = good_marks();
  for (double& reading : beyond.line_px[1]) reading += 40.0;
  EXPECT_THAT(refusal(beyond), test::refuses({.field = "left.right", .found = "outside"}));

  ViewportMarks narrow = good_marks();
  narrow.line_px[1] = {670.0, 670.0};
  EXPECT_THAT(refusal(narrow), test::refuses({.field = "left.left", .wanted = "16"}));

  ViewportMarks slip = good_marks();
  slip.line_px[2][1] += 7.0;
  EXPECT_THAT(refusal(slip), test::refuses({.field = "left.top", .found = "2"}));

  ViewportMarks no_number = good_marks();
  no_number.line_px[2][1] = std::nan("");
  EXPECT_EQ(refusal(no_number).field, "left.top");
}

TEST(ViewportFit, RefusesInvalidSizes)
{
  for (const double width_mm : {0.0, -300.0, std::nan("")}) {
    ViewportMarks marks = good_marks();
    marks.screen_mm.x() = width_mm;
    EXPECT_EQ(refusal(marks).field, "left.screen");
  }
  ViewportMarks marks = good_marks();
  marks.screen_sd_mm = -1.0;
  EXPECT_EQ(refusal(marks).field, "left.screen_sd");
}

}  // namespace vrda::calibration::display_fits_test
