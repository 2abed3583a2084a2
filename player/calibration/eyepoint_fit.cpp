#include "calibration/eyepoint_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <boost/math/statistics/univariate_statistics.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bench/rigid_body.hpp"
#include "calibration/least_squares.hpp"
#include "core/text.hpp"

namespace vrda::calibration {
namespace {

constexpr double outlier_sd = 5.0, outlier_px = 3.0;

std::string name_of(const RectangleMark& mark, std::size_t k)
{
  return "mark " + std::to_string(k + 1) + ", the rectangle of " + bench::text(mark.width_mm, 1, "mm") +
         " at " + bench::text(mark.depth_mm, 1, "mm");
}

/// A mark after the optics.
struct SeenWidth {
  double width_mm = 0.0, depth_mm = 0.0;
  double left_px = 0.0, right_px = 0.0;  ///< displayed columns relative to the optical axis
  double noise_gain = std::sqrt(2.0);    ///< noise of the width divided by the noise of a drawn side
};

double px_of(const SeenWidth& seen)
{
  return seen.right_px - seen.left_px;
}

/// Displayed columns per drawn column.
double magnification(const view::Distortion& distortion, const Eigen::Vector2d& drawn)
{
  constexpr double step_px = 0.5;
  const Eigen::Vector2d step(step_px, 0.0);
  return (view::shown_px(distortion, drawn + step).x() - view::shown_px(distortion, drawn - step).x()) /
         (2.0 * step_px);
}

SeenWidth seen_of(const RectangleMark& mark, const view::Eye& eye)
{
  SeenWidth seen;
  seen.width_mm = mark.width_mm;
  seen.depth_mm = mark.depth_mm;
  seen.left_px = view::shown_px(eye.distortion, mark.left_drawn_px).x() - eye.sight_px.x();
  seen.right_px = view::shown_px(eye.distortion, mark.right_drawn_px).x() - eye.sight_px.x();
  seen.noise_gain = std::hypot(magnification(eye.distortion, mark.left_drawn_px),
                               magnification(eye.distortion, mark.right_drawn_px));
  return seen;
}

std::vector<SeenWidth> seen_of(std::span<const RectangleMark> marks, const view::Eye& eye)
{
  std::vector<SeenWidth> seen;
  seen.reserve(marks.size());
  for (const RectangleMark& mark : marks) seen.push_back(seen_of(mark, eye));
  return seen;
}

/// The mark as seen with the optical axis rotated by `turn_rad` about the vertical.
SeenWidth turned(const SeenWidth& seen, double turn_rad, double distance_px)
{
  SeenWidth result = seen;
  result.left_px = distance_px * std::tan(std::atan(seen.left_px / distance_px) + turn_rad);
  result.right_px = distance_px * std::tan(std::atan(seen.right_px / distance_px) + turn_rad);
  return result;
}

/// Gradient of the width in px with respect to distance and depth.
Eigen::Vector2d slope_of(double width_mm, double depth_mm, const Eyepoint& about)
{
  const double from_eye_mm = about.depth_mm + depth_mm;
  return {width_mm / from_eye_mm, -about.distance_px * width_mm / (from_eye_mm * from_eye_mm)};
}

double residual_px(const SeenWidth& seen, const Eyepoint& eyepoint)
{
  return px_of(seen) - eyepoint.distance_px * seen.width_mm / (eyepoint.depth_mm + seen.depth_mm);
}

Eigen::Matrix2d information_of(std::span<const SeenWidth> seen, const Eyepoint& about)
{
  Eigen::Matrix2d N = Eigen::Matrix2d::Zero();
  for (const SeenWidth& s : seen) {
    const Eigen::Vector2d slope = slope_of(s.width_mm, s.depth_mm, about) / s.noise_gain;
    N += slope * slope.transpose();
  }
  return N;
}

/// Inverse of a 2 x 2 matrix, unless it is singular.
std::optional<Eigen::Matrix2d> inverse_of(const Eigen::Matrix2d& N)
{
  // For columns of length 1 the determinant is the squared sine between them; 1e-12 is rounding error.
  constexpr double least_sine_sq = 1e-12;
  if (!(N.determinant() > least_sine_sq * N(0, 0) * N(1, 1))) return std::nullopt;
  return N.inverse();
}

/// Start value from X (E + Z) = d L, which is linear in d and E but biased by the noise in X.
std::optional<Eyepoint> linear_start(std::span<const SeenWidth> seen)
{
  Eigen::Matrix2d N = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (const SeenWidth& s : seen) {
    const Eigen::Vector2d row(s.width_mm, -px_of(s));
    N += row * row.transpose();
    b += row * (px_of(s) * s.depth_mm);
  }
  const std::optional<Eigen::Matrix2d> inverse = inverse_of(N);
  if (!inverse) return std::nullopt;
  const Eigen::Vector2d found = *inverse * b;
  return Eyepoint{found(0), found(1)};
}

bool is_in_front(const Eyepoint& eyepoint, std::span<const SeenWidth> seen)
{
  const auto in_front = [&](const SeenWidth& s) { return eyepoint.depth_mm + s.depth_mm > 0.0; };
  return eyepoint.distance_px > 0.0 && std::ranges::all_of(seen, in_front);
}

/// Least squares of the widths in px for distance and depth; undetermined if the marks have no eyepoint
/// behind which they lie.
LeastSquares solve_eyepoint(std::span<const SeenWidth> seen)
{
  LeastSquares none;
  none.status = LeastSquaresStatus::undetermined;
  const std::optional<Eyepoint> start = linear_start(seen);
  if (!start || !is_in_front(*start, seen)) return none;
  FitProblem problem;
  problem.start = Eigen::Vector2d(start->distance_px, start->depth_mm);
  problem.scale = Eigen::Vector2d(100.0, 100.0);
  problem.residuals = [&](const Eigen::VectorXd& x) {
    const Eyepoint at{x[0], x[1]};
    Eigen::VectorXd r = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(seen.size()),
                                                  std::numeric_limits<double>::infinity());
    if (!is_in_front(at, seen)) return r;
    for (Eigen::Index k = 0; k < r.size(); ++k) {
      const SeenWidth& s = seen[static_cast<std::size_t>(k)];
      r[k] = residual_px(s, at) / s.noise_gain;
    }
    return r;
  };
  return fit_least_squares(problem);
}

void require_marks(std::span<const RectangleMark> marks, std::span<const SeenWidth> seen,
                   const bench::FitErrorContext& context)
{
  if (marks.size() < bench::least_rectangle_marks) {
    context.fail("", std::to_string(marks.size()) + " marks of rectangles",
                 std::to_string(bench::least_rectangle_marks) + " or more, at two depths at least");
  }
  double nearest_mm = std::numeric_limits<double>::infinity(), furthest_mm = -nearest_mm;
  for (std::size_t k = 0; k < marks.size(); ++k) {
    const bool is_rectangle =
        marks[k].width_mm > 0.0 && std::isfinite(marks[k].width_mm) && std::isfinite(marks[k].depth_mm);
    if (!is_rectangle) context.fail("", name_of(marks[k], k), "a width above 0 and a finite depth", {k});
    if (!(px_of(seen[k]) > 0.0) || !std::isfinite(px_of(seen[k]))) {
      context.fail("",
                   name_of(marks[k], k) + ": crossed or equal sides, " +
                       bench::text(px_of(seen[k]), 1, "px") + " apart",
                   "the left line left of the right one; align it again", {k});
    }
    nearest_mm = std::min(nearest_mm, marks[k].depth_mm);
    furthest_mm = std::max(furthest_mm, marks[k].depth_mm);
  }
  if (furthest_mm - nearest_mm < bench::least_depth_range_mm) {
    context.fail("",
                 "rectangles at equal depths, " + bench::text(furthest_mm - nearest_mm, 1, "mm") + " apart",
                 "different depths; add a rectangle 150 mm or more behind");
  }
}

/// Compares each mark with the fit to the others, in units of their noise.
void require_no_outlier(std::span<const RectangleMark> marks, std::span<const SeenWidth> seen,
                        const bench::FitErrorContext& context)
{
  if (marks.size() < bench::least_rectangle_marks + 1)
    return;  // two marks leave no degree of freedom for the noise
  for (std::size_t k = 0; k < marks.size(); ++k) {
    std::vector<SeenWidth> others(seen.begin(), seen.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const LeastSquares fit = solve_eyepoint(others);
    if (fit.status != LeastSquaresStatus::converged || !(fit.x[1] + seen[k].depth_mm > 0.0)) continue;
    const Eyepoint eyepoint{fit.x[0], fit.x[1]};
    const double dof = static_cast<double>(others.size()) - 2.0;
    const double noise_px2 = fit.residuals.squaredNorm() / dof;
    const Eigen::Vector2d slope = slope_of(seen[k].width_mm, seen[k].depth_mm, eyepoint);
    const double spread_px2 = noise_px2 * (seen[k].noise_gain * seen[k].noise_gain +
                                           slope.dot(fit.covariance.topLeftCorner<2, 2>() * slope));
    const double off_px = std::abs(residual_px(seen[k], eyepoint));
    // The noise of few marks may be too small by chance: the limit grows with Student's t.
    const double t_ratio = bench::t_95(dof) / bench::t_95(std::numeric_limits<double>::infinity());
    if (off_px > outlier_px && off_px > t_ratio * outlier_sd * std::sqrt(spread_px2)) {
      context.fail("",
                   name_of(marks[k], k) + ": " + bench::text(off_px, 1, "px") +
                       " from the width predicted by the others",
                   bench::text(outlier_px, 1, "px") + " at most; align it again", {k});
    }
  }
}

/// Proposes a rectangle behind the others that makes the depth accurate enough.
std::string suggested_rectangle(std::span<const SeenWidth> seen, const Eyepoint& about, double noise_px,
                                double most_sd_mm)
{
  double widest_px = 0.0, furthest_mm = -std::numeric_limits<double>::infinity();
  for (const SeenWidth& s : seen) {
    widest_px = std::max(widest_px, px_of(s));
    furthest_mm = std::max(furthest_mm, s.depth_mm);
  }
  constexpr double step_mm = 50.0, most_behind_mm = 1500.0;
  constexpr int repeats = 3;
  for (double behind_mm = step_mm; behind_mm <= most_behind_mm; behind_mm += step_mm) {
    SeenWidth extra;
    extra.depth_mm = furthest_mm + behind_mm;
    extra.width_mm = widest_px * (about.depth_mm + extra.depth_mm) / about.distance_px;
    std::vector<SeenWidth> with_extra(seen.begin(), seen.end());
    with_extra.insert(with_extra.end(), repeats, extra);
    const std::optional<Eigen::Matrix2d> inverse = inverse_of(information_of(with_extra, about));
    if (inverse && noise_px * std::sqrt((*inverse)(1, 1)) < most_sd_mm) {
      return "add a rectangle about " + bench::text(extra.width_mm, 0, "mm") + " wide at " +
             bench::text(extra.depth_mm, 0, "mm") + " and mark it three times";
    }
  }
  return "add rectangles further behind, and repeat all marks";
}

using Slope = Eigen::Matrix<double, 2, 5>;

/// Derivative of the fit with respect to a given number; `seen_with(step)` returns the marks with that number
/// changed by `step`.
template <typename SeenWith>
Eigen::Vector2d sensitivity(SeenWith seen_with, double step, const Eigen::Vector2d& nominal)
{
  const auto solved = [&](double by) {
    const std::vector<SeenWidth> seen = seen_with(by);
    const LeastSquares fit = solve_eyepoint(seen);
    return fit.status == LeastSquaresStatus::converged ? Eigen::Vector2d(fit.x) : nominal;
  };
  return (solved(step) - solved(-step)) / (2.0 * step);
}

/// With respect to k1, k2, the centre and the pixel aspect.
Slope slope_by_distortion(std::span<const RectangleMark> marks, const view::Eye& eye,
                          const Eigen::Vector2d& nominal)
{
  constexpr std::array<double, 5> steps = {1e-4, 1e-4, 0.1, 0.1, 1e-4};
  Slope slope;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const auto seen_with = [&](double step) {
      view::Eye changed = eye;
      view::Distortion& d = changed.distortion;
      const std::array<double*, 5> numbers = {&d.k1, &d.k2, &d.centre_px.x(), &d.centre_px.y(),
                                              &d.pixel_aspect};
      *numbers[k] += step;
      return seen_of(marks, changed);
    };
    slope.col(static_cast<Eigen::Index>(k)) = sensitivity(seen_with, steps[k], nominal);
  }
  return slope;
}

/// Covariance from the given uncertainties: alignment and distortion.
Eigen::Matrix2d given_covariance(std::span<const RectangleMark> marks, const view::Eye& eye,
                                 const EyepointOptions& options, const Slope& by_distortion,
                                 const Eigen::Vector2d& nominal)
{
  constexpr double turn_step_rad = 1e-4;
  const std::vector<SeenWidth> seen = seen_of(marks, eye);
  const auto turned_by = [&](double turn_rad) {
    std::vector<SeenWidth> result = seen;
    for (SeenWidth& s : result) s = turned(s, turn_rad, nominal[0]);
    return result;
  };
  const Eigen::Vector2d by_turn = sensitivity(turned_by, turn_step_rad, nominal);
  Eigen::Matrix2d covariance =
      options.alignment_sd_rad * options.alignment_sd_rad * by_turn * by_turn.transpose();
  if (options.distortion_covariance.size() > 0) {
    check(options.distortion_covariance.rows() == 5 && options.distortion_covariance.cols() == 5,
          "a distortion's covariance is of five numbers");
    covariance += propagated(by_distortion, options.distortion_covariance);
  }
  return covariance;
}

}  // namespace

EyepointFit fit_eyepoint(std::span<const RectangleMark> marks, const view::Eye& eye,
                         const EyepointOptions& options, const std::string& name, const std::string& file)
{
  const bench::FitErrorContext context{name, file};
  const std::vector<SeenWidth> seen = seen_of(marks, eye);
  require_marks(marks, seen, context);
  require_no_outlier(marks, seen, context);
  const LeastSquares solved = solve_eyepoint(seen);
  if (solved.status != LeastSquaresStatus::converged) {
    context.fail("",
                 solved.status == LeastSquaresStatus::undetermined
                     ? "widths that do not decrease with depth"
                     : std::string("an eyepoint fit with status: ") + name_of(solved.status),
                 "a larger range of depths; add a rectangle 150 mm or more behind");
  }
  EyepointFit fit;
  fit.eyepoint = {solved.x[0], solved.x[1]};
  const double dof = static_cast<double>(marks.size()) - 2.0;
  fit.noise_px = std::sqrt(solved.residuals.squaredNorm() / dof);
  const Eigen::Matrix2d by_noise = fit.noise_px * fit.noise_px * solved.covariance;
  const double depth_sd_mm = std::sqrt(by_noise(1, 1));
  if (!(depth_sd_mm <= options.max_depth_sd_mm)) {
    context.fail("",
                 "a range of depths that determines the eye's depth to " + bench::text(depth_sd_mm, 1, "mm") +
                     " (standard deviation)",
                 bench::text(options.max_depth_sd_mm, 1, "mm") + " or less: " +
                     suggested_rectangle(seen, fit.eyepoint, fit.noise_px, options.max_depth_sd_mm));
  }
  bench::Estimate& estimate = fit.estimate;
  estimate.names = {name + ".distance", name + ".depth"};
  estimate.units = {"px", "mm"};
  estimate.values = solved.x;
  if (options.distortion_covariance.size() > 0)
    fit.distortion_jacobian = slope_by_distortion(marks, eye, solved.x);
  estimate.covariance = by_noise + given_covariance(marks, eye, options, fit.distortion_jacobian, solved.x);
  // Given variances have infinite degrees of freedom (Welch and Satterthwaite); the number with the larger
  // share of estimated noise decides.
  const Eigen::Vector2d share = by_noise.diagonal().cwiseQuotient(
      estimate.covariance.diagonal().cwiseMax(std::numeric_limits<double>::min()));
  const double most_share = std::max(share.maxCoeff(), 1e-3);
  estimate.dof = dof / (most_share * most_share);
  std::vector<double> residuals_px;
  residuals_px.reserve(seen.size());
  for (const SeenWidth& s : seen) residuals_px.push_back(residual_px(s, fit.eyepoint));
  bench::set_residuals(estimate, residuals_px, "px");
  estimate.remarks.push_back(name + " eye: " + bench::text(fit.eyepoint.depth_mm, 1, "mm") +
                             " in front of the first rectangle's plane, 95 %: +-" +
                             bench::text(bench::half_width_95(estimate, 1), 1, "mm") + "; noise of a side " +
                             bench::text(fit.noise_px, 2, "px"));
  return fit;
}

Eigen::Vector2d expected_eyepoint_sd(std::span<const RectangleMark> rectangles, const Eyepoint& about,
                                     double noise_px)
{
  std::vector<SeenWidth> seen;
  for (const RectangleMark& r : rectangles) seen.push_back({r.width_mm, r.depth_mm});
  const std::optional<Eigen::Matrix2d> inverse = inverse_of(information_of(seen, about));
  if (!inverse) return Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  return noise_px * inverse->diagonal().cwiseSqrt();
}

// Inter-pupillary distance from the rectangles that each eye aligned.

namespace {

/// Centres of the rectangles relative to one eye's optical axis (positive: right), and their derivatives with
/// respect to the given numbers: distance and depth of the eyepoint, optical axis.
struct Middles {
  Eigen::VectorXd right_mm, noise_mm2;
  Eigen::Matrix<double, Eigen::Dynamic, 3> by_known;  ///< derivative by distance, depth and axis
  Eigen::Matrix3d known = Eigen::Matrix3d::Zero();    ///< covariance of the three
};

Middles middles_of(const EyeRectangles& seen, double sight_sd_px)
{
  const auto n = static_cast<Eigen::Index>(seen.marks.size());
  Middles middles;
  middles.right_mm.resize(n);
  middles.noise_mm2.resize(n);
  middles.by_known.resize(n, 3);
  const double distance_px = seen.fit.eyepoint.distance_px;
  for (Eigen::Index k = 0; k < n; ++k) {
    const RectangleMark& mark = seen.marks[static_cast<std::size_t>(k)];
    const double middle_px = 0.5 * (view::shown_px(seen.eye.distortion, mark.left_drawn_px).x() +
                                    view::shown_px(seen.eye.distortion, mark.right_drawn_px).x()) -
                             seen.eye.sight_px.x();
    const double mm_by_px = (seen.fit.eyepoint.depth_mm + mark.depth_mm) / distance_px;
    middles.right_mm(k) = middle_px * mm_by_px;
    middles.noise_mm2(k) =
        0.5 * seen.fit.noise_px * seen.fit.noise_px * mm_by_px * mm_by_px;  // mean of two sides
    middles.by_known.row(k) << -middles.right_mm(k) / distance_px, middle_px / distance_px, -mm_by_px;
  }
  middles.known.topLeftCorner<2, 2>() = seen.fit.estimate.covariance;
  middles.known(2, 2) = sight_sd_px * sight_sd_px;
  return middles;
}

}  // namespace

// A centre is a_left to the right of the left optical axis and a_right to the right of the right one; the
// inter-pupillary distance is a_left - a_right for any position of the rectangle. An axis error s adds
// s (E + Z) / d, which grows with depth, so all rectangles enter one generalised least squares fit.
PupilDistance pupil_distance(const EyeRectangles& left, const EyeRectangles& right, double sight_sd_px)
{
  check(left.marks.size() == right.marks.size() && !left.marks.empty(),
        "both eyes have marks of the same rectangles");
  for (std::size_t k = 0; k < left.marks.size(); ++k)
    check(left.marks[k].width_mm == right.marks[k].width_mm &&
              left.marks[k].depth_mm == right.marks[k].depth_mm,
          "both eyes have marks of the same rectangles");
  const Middles l = middles_of(left, sight_sd_px);
  const Middles r = middles_of(right, sight_sd_px);
  Eigen::MatrixXd V = propagated(l.by_known, l.known) + propagated(r.by_known, r.known);
  // sd_mm has no degrees of freedom, so the noise of t_ratio marks is enlarged by the ratio of Student's t.
  const double dof = std::max(1.0, static_cast<double>(left.marks.size() + right.marks.size()) - 4.0);
  const double t_ratio = bench::t_95(dof) / bench::t_95(std::numeric_limits<double>::infinity());
  V.diagonal() += t_ratio * t_ratio * (l.noise_mm2 + r.noise_mm2);
  // Keeps V invertible without noise and with known eyepoints; a nanometre is negligible otherwise.
  constexpr double regularisation_mm2 = 1e-12;
  V.diagonal().array() += regularisation_mm2;
  const Eigen::VectorXd weights = V.ldlt().solve(Eigen::VectorXd::Ones(V.rows()));
  PupilDistance result;
  result.ipd_mm = weights.dot(l.right_mm - r.right_mm) / weights.sum();
  result.sd_mm = 1.0 / std::sqrt(weights.sum());
  return result;
}

double depth_error_mm(double depth_mm, double drawn_ipd_mm, double true_ipd_mm)
{
  check(drawn_ipd_mm > 0.0, "the eyes drawn for are apart");
  // The lines of sight converge as for eyes `drawn_ipd_mm` apart.
  return depth_mm * (true_ipd_mm / drawn_ipd_mm - 1.0);
}

namespace {

constexpr double furthest_reading_px = 5.0;
constexpr int least_side_px = 16;

std::string px_text(double px)
{
  return bench::text(px, 2, "px");
}

double mean(const std::vector<double>& values)
{
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Indices of an edge's readings among all marks.
std::vector<std::size_t> marks_of(Edge edge, const ViewportMarks& marks)
{
  std::size_t first = 0;
  for (std::size_t before = 0; before < static_cast<std::size_t>(edge); ++before)
    first += marks.line_px[before].size();
  std::vector<std::size_t> indices(marks.line_px[static_cast<std::size_t>(edge)].size());
  std::iota(indices.begin(), indices.end(), first);
  return indices;
}

void require_readings(const ViewportMarks& marks, Edge edge, const bench::FitErrorContext& context)
{
  const std::string field = std::string(".") + name_of(edge);
  const std::vector<double>& readings = marks.line_px[static_cast<std::size_t>(edge)];
  const std::vector<std::size_t> indices = marks_of(edge, marks);
  if (readings.empty()) context.fail(field, "no readings", "one or more; scan this edge");
  for (std::size_t k = 0; k < readings.size(); ++k) {
    if (!std::isfinite(readings[k]))
      context.fail(field, "a reading that is not a finite number", "px", {indices[k]});
    if (readings.size() == 1) break;
    std::vector<double> others = readings;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const double about_px = boost::math::statistics::median(others);
    if (std::abs(readings[k] - about_px) > furthest_reading_px) {
      context.fail(field,
                   "reading " + std::to_string(k + 1) + " at " + px_text(readings[k]) +
                       ", the others at about " + px_text(about_px),
                   "readings within " + px_text(furthest_reading_px) + " of each other; scan it again",
                   {indices[k]});
    }
  }
}

/// Borders between pixels (left, right, top, bottom) with their variances.
struct Borders {
  Eigen::Vector4d at_px = Eigen::Vector4d::Zero();
  Eigen::Vector4d variance_px2 = Eigen::Vector4d::Zero();
  double dof = 0.0;
  std::vector<double> residuals_px;
};

Borders borders_of(const ViewportMarks& marks)
{
  Borders borders;
  double sum_sq_px2 = 0.0;
  for (std::size_t edge = 0; edge < n_edges; ++edge) {
    // The centre of the first pixel that is at least half visible is on average half a pixel inside the
    // border, so its outer side is the border. The same holds for the last pixel.
    const bool is_last =
        edge == static_cast<std::size_t>(Edge::right) || edge == static_cast<std::size_t>(Edge::bottom);
    const double at_px = mean(marks.line_px[edge]);
    borders.at_px(static_cast<Eigen::Index>(edge)) = at_px + (is_last ? 1.0 : 0.0);
    for (const double reading : marks.line_px[edge]) {
      borders.residuals_px.push_back(reading - at_px);
      sum_sq_px2 += (reading - at_px) * (reading - at_px);
    }
  }
  // Rounding to whole pixels adds 1/12 px^2. If the readings scatter, their variance includes it and it
  // averages out; the remainder does not depend on the number of repeats.
  constexpr double rounding_px2 = 1.0 / 12.0;
  borders.dof = static_cast<double>(borders.residuals_px.size()) - static_cast<double>(n_edges);
  const double noise_px2 = borders.dof > 0.0 ? sum_sq_px2 / borders.dof : 0.0;
  const double stays_px2 = std::max(0.0, rounding_px2 - noise_px2);
  for (std::size_t edge = 0; edge < n_edges; ++edge) {
    borders.variance_px2(static_cast<Eigen::Index>(edge)) =
        stays_px2 + noise_px2 / static_cast<double>(marks.line_px[edge].size());
  }
  if (borders.dof == 0.0) borders.dof = std::numeric_limits<double>::infinity();
  return borders;
}

void require_order(const Eigen::Vector4d& at_px, const ViewportMarks& marks,
                   const bench::FitErrorContext& context)
{
  for (const Edge edge : {Edge::left, Edge::top}) {
    const Edge opposite = edge == Edge::left ? Edge::right : Edge::bottom;
    const double low_px = at_px(static_cast<int>(edge)), high_px = at_px(static_cast<int>(opposite));
    const std::string field = std::string(".") + name_of(edge);
    if (!(low_px < high_px)) {
      context.fail(
          field,
          "crossed edges: at " + px_text(low_px) + ", and " + name_of(opposite) + " at " + px_text(high_px),
          std::string(name_of(edge)) + " before " + name_of(opposite), marks_of(edge, marks));
    }
    if (high_px - low_px < least_side_px) {
      context.fail(field, px_text(high_px - low_px) + " up to " + name_of(opposite),
                   std::to_string(least_side_px) + " px or more", marks_of(edge, marks));
    }
  }
}

void require_within(const Eigen::Vector4d& at_px, const view::Viewport& window, const ViewportMarks& marks,
                    const bench::FitErrorContext& context)
{
  const std::array<double, n_edges> border_px = {
      static_cast<double>(window.x), static_cast<double>(window.x + window.width),
      static_cast<double>(window.y), static_cast<double>(window.y + window.height)};
  for (std::size_t edge = 0; edge < n_edges; ++edge) {
    const bool is_last = edge % 2 == 1;
    const double beyond_px =
        (at_px(static_cast<Eigen::Index>(edge)) - border_px[edge]) * (is_last ? 1.0 : -1.0);
    // An edge that rounds to the window's border is inside.
    if (beyond_px < 0.5) continue;
    context.fail(std::string(".") + name_of(static_cast<Edge>(edge)),
                 px_text(beyond_px) + " outside the eye's window", "an edge inside the window",
                 marks_of(static_cast<Edge>(edge), marks));
  }
}

void require_size(const ViewportMarks& marks, const bench::FitErrorContext& context)
{
  const std::size_t n_readings = marks_of(Edge::bottom, marks).back() + 1;
  const bool is_size = marks.screen_mm.allFinite() && marks.screen_mm.minCoeff() > 0.0;
  if (!is_size) {
    context.fail(
        ".screen", short_decimal(marks.screen_mm.x(), 2) + " x " + bench::text(marks.screen_mm.y(), 2, "mm"),
        "width and height of the visible part above 0, measured with a ruler", {n_readings, n_readings + 1});
  }
  if (!(marks.screen_sd_mm >= 0.0) || !std::isfinite(marks.screen_sd_mm))
    context.fail(".screen_sd", bench::text(marks.screen_sd_mm, 3, "mm"), "0 mm or more");
}

/// The aspect's variance is mostly the ruler's, which is known. This factor scales its variance and
/// covariances so that bench::t_95 with the readings' degrees of freedom gives the interval with its own ones
/// (Welch and Satterthwaite: dof divided by the squared share of the readings).
double aspect_scale(double dof, double readings_share)
{
  constexpr double most_dof = 1e9;  // as good as infinite
  const double own_dof = std::min(most_dof, dof / (readings_share * readings_share));
  return bench::t_95(own_dof) / bench::t_95(std::min(most_dof, dof));
}

bench::Estimate estimate_of(const Borders& borders, const ViewportMarks& marks, const std::string& name)
{
  const double width_px = borders.at_px(1) - borders.at_px(0),
               height_px = borders.at_px(3) - borders.at_px(2);
  const double pixel_aspect = (marks.screen_mm.y() / height_px) / (marks.screen_mm.x() / width_px);
  bench::Estimate estimate;
  for (const Edge edge : {Edge::left, Edge::right, Edge::top, Edge::bottom})
    estimate.names.push_back(name + ".edge_" + name_of(edge));
  estimate.names.push_back(name + ".pixel_aspect");
  estimate.units = {"px", "px", "px", "px", ""};
  estimate.values.resize(5);
  estimate.values << borders.at_px, pixel_aspect;
  estimate.dof = borders.dof;
  bench::set_residuals(estimate, borders.residuals_px, "px");

  Eigen::Vector4d by_border = {-1.0 / width_px, 1.0 / width_px, 1.0 / height_px, -1.0 / height_px};
  by_border *= pixel_aspect;
  const Eigen::Vector4d with_border = borders.variance_px2.cwiseProduct(by_border);
  const double by_marks = by_border.dot(with_border);
  const double by_ruler = pixel_aspect * pixel_aspect * marks.screen_sd_mm * marks.screen_sd_mm *
                          marks.screen_mm.cwiseAbs2().cwiseInverse().sum();
  const double scale = aspect_scale(borders.dof, by_marks / (by_marks + by_ruler));
  estimate.covariance = Eigen::MatrixXd::Zero(5, 5);
  estimate.covariance.diagonal().head<4>() = borders.variance_px2;
  estimate.covariance.block<4, 1>(0, 4) = scale * with_border;
  estimate.covariance.block<1, 4>(4, 0) = scale * with_border.transpose();
  estimate.covariance(4, 4) = scale * scale * (by_marks + by_ruler);
  return estimate;
}

}  // namespace

const char* name_of(Edge edge)
{
  return std::array{"left", "right", "top", "bottom"}.at(static_cast<std::size_t>(edge));
}

bench::Estimate fit_viewport(const ViewportMarks& marks, const view::Viewport& window,
                             const std::string& name, const std::string& file)
{
  const bench::FitErrorContext context{name, file};
  for (std::size_t edge = 0; edge < n_edges; ++edge)
    require_readings(marks, static_cast<Edge>(edge), context);
  require_size(marks, context);
  const Borders borders = borders_of(marks);
  require_order(borders.at_px, marks, context);
  require_within(borders.at_px, window, marks, context);
  return estimate_of(borders, marks, name);
}

}  // namespace vrda::calibration
