#include "calibration/eyepoint_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "coverage.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::viewport_fit_test {

using test::input_error;

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

}  // namespace vrda::calibration::viewport_fit_test
