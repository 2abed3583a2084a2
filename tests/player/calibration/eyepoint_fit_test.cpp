#include "calibration/eyepoint_fit.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/units.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::eyepoint_fit_test {

using test::input_error;

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

}  // namespace vrda::calibration::eyepoint_fit_test
