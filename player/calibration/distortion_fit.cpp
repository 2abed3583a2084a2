#include "calibration/distortion_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/rigid_body.hpp"
#include "calibration/least_squares.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

/// Order of the unknowns. The aspect is in standard deviations of its prior, so that it may be known exactly.
enum Number : Eigen::Index { k1, k2, centre_x, centre_y, aspect_sds, at_x, at_y, spacing, turn, n_numbers };

struct GridProblem {
  std::span<const GridMark> marks;
  const view::Eye& eye;
  const AspectPrior& aspect;
};

view::Distortion distortion_at(const GridProblem& problem, const Eigen::VectorXd& x)
{
  return distortion_of(problem.eye, x.head<4>(), problem.aspect.value + problem.aspect.sd * x[aspect_sds]);
}

/// Residuals of the marks in units of `noise_px`, of the aspect prior and, if `is_held`, of the centre prior.
Eigen::VectorXd residuals(const GridProblem& problem, double noise_px, bool is_held, const Eigen::VectorXd& x)
{
  const auto n = static_cast<Eigen::Index>(problem.marks.size());
  const view::Distortion distortion = distortion_at(problem, x);
  const GridPose grid = grid_of(x.segment<4>(at_x));
  Eigen::VectorXd r(2 * n + (is_held ? 3 : 1));
  for (Eigen::Index i = 0; i < n; ++i) {
    const GridMark& mark = problem.marks[static_cast<std::size_t>(i)];
    const Eigen::Vector2d shown = shown_px(grid, distortion.pixel_aspect, mark.node);
    r.segment<2>(2 * i) = (view::drawn_px(distortion, shown) - mark.drawn_px) / noise_px;
  }
  r[2 * n] = x[aspect_sds];
  if (is_held)
    r.tail<2>() = (distortion.centre_px - view::middle_px(problem.eye.visible)) / centre_prior_sd_px;
  return r;
}

/// Start without distortion; grid from an affine map of the nodes onto the marks.
Eigen::VectorXd start_of(const GridProblem& problem)
{
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> b = Eigen::Matrix<double, 3, 2>::Zero();
  for (const GridMark& mark : problem.marks) {
    const Eigen::Vector3d node = mark.node.homogeneous();
    N += node * node.transpose();
    b += node * mark.drawn_px.transpose();
  }
  const Eigen::Matrix<double, 3, 2> affine = N.inverse() * b;
  const double aspect = problem.aspect.value;
  const Eigen::Vector2d along(0.5 * (affine(0, 0) - aspect * affine(1, 1)),
                              -0.5 * (aspect * affine(0, 1) + affine(1, 0)));
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n_numbers);
  x.segment<2>(centre_x) = view::middle_px(problem.eye.visible);
  x.segment<2>(at_x) = affine.row(2).transpose();
  x[spacing] = along.norm();
  x[turn] = arc_tangent2(along.y(), along.x());
  return x;
}

struct GridFit {
  LeastSquares fit;
  double noise_px = initial_noise_px;  ///< noise that weighted the marks
};

/// Repeats the fit, each time weighted with the noise estimated by the previous one.
GridFit weighted_fit(const GridProblem& problem, const GridFit& before, bool is_held)
{
  constexpr int n_rounds = 3;
  const auto n = static_cast<Eigen::Index>(problem.marks.size());
  FitProblem least;
  least.start = before.fit.x;
  least.scale.resize(n_numbers);
  least.scale << 0.1, 0.1, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 0.1;
  GridFit now = before;
  for (int round = 0; round < n_rounds; ++round) {
    const double noise_px = now.noise_px;
    least.residuals = [&](const Eigen::VectorXd& x) { return residuals(problem, noise_px, is_held, x); };
    now.fit = fit_least_squares(least);
    if (now.fit.status != LeastSquaresStatus::converged || round + 1 == n_rounds) break;
    const double square_sum = now.fit.residuals.head(2 * n).squaredNorm();
    now.noise_px = std::max(noise_px * std::sqrt(square_sum / noise_dof(now.fit, n)), minimum_noise_px);
    least.start = now.fit.x;
  }
  return now;
}

/// Root mean square distance of points from their best line.
double spread_about_line(std::span<const GridMark> marks, Eigen::Vector2d GridMark::*point)
{
  const auto n = static_cast<double>(marks.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const GridMark& mark : marks) mean += mark.*point / n;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const GridMark& mark : marks) scatter += (mark.*point - mean) * (mark.*point - mean).transpose() / n;
  return std::sqrt(std::max(0.0, principal_axes(scatter).values[1]));
}

void require_spread(std::span<const GridMark> marks, const bench::FitErrorContext& context)
{
  if (marks.size() < bench::least_grid_marks) {
    context.fail(".distortion", std::to_string(marks.size()) + " marked nodes",
                 std::to_string(bench::least_grid_marks) + " or more, distributed over the visible part");
  }
  constexpr double least_nodes = 0.25, least_px = 5.0;  // two neighbouring rows spread by half a node
  if (spread_about_line(marks, &GridMark::node) < least_nodes ||
      spread_about_line(marks, &GridMark::drawn_px) < least_px) {
    context.fail(".distortion", "collinear marks",
                 "nodes of several rows and columns, distributed over the visible part");
  }
}

std::string field_of(const Eigen::Vector2d& node)
{
  return ".distortion: node (" + short_decimal(node.x(), 2) + ", " + short_decimal(node.y(), 2) + ")";
}

void require_unfolded(const view::Distortion& distortion, const view::Eye& eye,
                      const bench::FitErrorContext& context)
{
  const double furthest_px = view::furthest_radius_px(distortion, eye.visible);
  const double fold_px = view::fold_radius_px(distortion);
  if (fold_px > furthest_px) return;
  context.fail(".distortion",
               "k1 " + short_decimal(distortion.k1, 4) + ", k2 " + short_decimal(distortion.k2, 4) +
                   ", a distortion that folds at a radius of " + bench::text(fold_px, 0, "px"),
               "a monotonic distortion up to " + bench::text(furthest_px, 0, "px") +
                   "; add marks near the corners of the visible part");
}

/// Largest error of the pre-distortion mesh followed by the optics, sampled at centres of mesh triangles.
double inverse_error_px(const view::Distortion& distortion, const view::Eye& eye)
{
  view::Eye drawn_for = eye;
  drawn_for.distortion = distortion;
  drawn_for.pixel_aspect = distortion.pixel_aspect;
  const view::ShownBox box = view::shown_box(drawn_for);
  const view::WarpMesh mesh = view::warp_mesh(drawn_for, box);
  // 7 is prime, so the samples include all rows, columns and both triangles of a cell.
  constexpr std::size_t stride = 3 * 7;
  double largest_sq = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += stride) {
    Eigen::Vector2d drawn = Eigen::Vector2d::Zero(), texture_uv = Eigen::Vector2d::Zero();
    for (std::size_t corner = t; corner < t + 3; ++corner) {
      const view::WarpVertex& vertex = mesh.vertices[mesh.triangles[corner]];
      drawn += Eigen::Vector2d(vertex.x_px, vertex.y_px) / 3.0;
      texture_uv += Eigen::Vector2d(vertex.u, vertex.v) / 3.0;
    }
    const Eigen::Vector2d wanted_px = box.low_px + texture_uv.cwiseProduct(box.high_px - box.low_px);
    largest_sq = std::max(largest_sq, (view::drawn_px(distortion, wanted_px) - drawn).squaredNorm());
  }
  return std::sqrt(largest_sq);
}

bench::Estimate estimate_of(const view::Distortion& d, const Eigen::MatrixXd& covariance,
                            const std::string& name)
{
  bench::Estimate estimate;
  estimate.names = {name + ".k1", name + ".k2", name + ".centre_x", name + ".centre_y",
                    name + ".pixel_aspect"};
  estimate.units = {"", "", "px", "px", ""};
  estimate.values.resize(5);
  estimate.values << d.k1, d.k2, d.centre_px, d.pixel_aspect;
  estimate.covariance = covariance;
  return estimate;
}

/// Root mean square difference of two distortions, on a lattice of points of the visible part.
double rms_difference_px(const view::Distortion& a, const view::Distortion& b, const view::Eye& eye)
{
  constexpr int n = 21;
  const view::Viewport& v = eye.visible;
  double sum_sq = 0.0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector2d p(v.x + v.width * (i / (n - 1.0)), v.y + v.height * (j / (n - 1.0)));
      sum_sq += (view::shown_px(a, p) - view::shown_px(b, p)).squaredNorm();
    }
  }
  return std::sqrt(sum_sq / (n * n));
}

/// `what`: the things whose scatter is the noise.
void add_remarks(DistortionFit& fit, const view::Eye& eye, const std::string& what, const std::string& name)
{
  std::vector<std::string>& remarks = fit.estimate.remarks;
  fit.inverse_error_px = inverse_error_px(fit.distortion, eye);
  remarks.push_back(name + ": the " + what + " scatter by " + bench::text(fit.noise_px, 2, "px"));
  remarks.push_back(name + ": pre-distortion and optics together leave an error of at most " +
                    bench::text(fit.inverse_error_px, 3, "px"));
  if (fit.has_centre_prior)
    remarks.push_back(name +
                      ": the distortion is too small to determine its centre; the centre of the visible part "
                      "is used");
}

DistortionFit result_of(const GridProblem& problem, const MarksFit& found, const std::string& name)
{
  DistortionFit result;
  result.distortion = distortion_at(problem, found.fit.x);
  result.grid = grid_of(found.fit.x.segment<4>(at_x));
  Eigen::MatrixXd covariance = found.fit.covariance.topLeftCorner<5, 5>();
  covariance.row(aspect_sds) *= problem.aspect.sd;
  covariance.col(aspect_sds) *= problem.aspect.sd;
  result.estimate = estimate_of(result.distortion, covariance, name);
  result.estimate.dof = noise_dof(found.fit, found.n());
  bench::set_residuals(result.estimate, found.residuals_px(), "px");
  result.noise_px = found.sds_px[0];
  return result;
}

/// Above this the centre counts as undetermined.
constexpr double most_centre_sd_px = 20.0;

bool is_centre_determined(const GridFit& fit)
{
  const Eigen::MatrixXd& covariance = fit.fit.covariance;
  return fit.fit.status == LeastSquaresStatus::converged &&
         std::max(covariance(centre_x, centre_x), covariance(centre_y, centre_y)) <
             most_centre_sd_px * most_centre_sd_px;
}

/// Jacobian of the drawn node positions with respect to the eight parameters and, last column, the aspect.
Eigen::MatrixXd node_jacobian(const AdjustedGrids& adjusted, const view::Eye& eye, const GridValues& numbers,
                              double aspect)
{
  const auto drawn = [&](const GridValues& v, double a) {
    const view::Distortion distortion = distortion_of(eye, v.head<4>(), a);
    const GridPose grid = grid_of(v.tail<4>());
    Eigen::VectorXd px(2 * adjusted.columns * adjusted.rows);
    Eigen::Index at = 0;
    for (const Eigen::Vector2d& node : grid_nodes(adjusted.columns, adjusted.rows)) {
      px.segment<2>(at) = view::drawn_px(distortion, shown_px(grid, a, node));
      at += 2;
    }
    return px;
  };
  // Central differences; the truncation error is about 1e-6.
  constexpr double step_k = 1e-4, step_px = 1e-2, step_rad = 1e-5, step_aspect = 1e-5;
  GridValues steps;
  steps << step_k, step_k, step_px, step_px, step_px, step_px, step_px, step_rad;
  Eigen::MatrixXd J(2 * adjusted.columns * adjusted.rows, 9);
  for (Eigen::Index k = 0; k < 8; ++k) {
    const GridValues step = steps[k] * GridValues::Unit(k);
    J.col(k) = (drawn(numbers + step, aspect) - drawn(numbers - step, aspect)) / (2.0 * steps[k]);
  }
  J.col(8) =
      (drawn(numbers, aspect + step_aspect) - drawn(numbers, aspect - step_aspect)) / (2.0 * step_aspect);
  return J;
}

/// Larger variance of the two coordinates of the centre; infinite if undetermined.
double centre_variance(const Eigen::MatrixXd& N, double variance)
{
  const Eigen::MatrixXd root = inverse_root_of(N);
  if (root.cols() < N.cols()) return std::numeric_limits<double>::infinity();
  return variance * root.middleRows<2>(centre_x).rowwise().squaredNorm().maxCoeff();
}

}  // namespace

std::vector<Eigen::Vector2d> grid_nodes(int columns, int rows)
{
  std::vector<Eigen::Vector2d> nodes;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      nodes.emplace_back(column - 0.5 * (columns - 1), row - 0.5 * (rows - 1));
  }
  return nodes;
}

view::Distortion distortion_of(const view::Eye& eye, const Eigen::Vector4d& values, double aspect)
{
  return {values[0], values[1], values.tail<2>(), 0.5 * eye.window.width, aspect};
}

GridPose grid_of(const Eigen::Vector4d& values)
{
  return {values.head<2>(), values[2], values[3]};
}

Eigen::Vector2d shown_px(const GridPose& grid, double pixel_aspect, const Eigen::Vector2d& node)
{
  const SinCos turned = sin_cos(grid.turn_rad);
  const double right = turned.cos * node.x() - turned.sin * node.y();
  const double up = turned.sin * node.x() + turned.cos * node.y();
  return grid.origin_px + grid.spacing_px * Eigen::Vector2d(right, -up / pixel_aspect);
}

DistortionFit fit_distortion(std::span<const GridMark> marks, const view::Eye& eye, const AspectPrior& aspect,
                             const std::string& name, const std::string& file)
{
  const bench::FitErrorContext context{name, file};
  require_spread(marks, context);
  const GridProblem problem{marks, eye, aspect};
  GridFit start;
  start.fit.x = start_of(problem);
  // Without distortion the centre is undetermined, so the free fit starts from the fit with the prior.
  const GridFit held = weighted_fit(problem, start, true);
  const GridFit free = weighted_fit(problem, held, false);
  const bool is_held = !is_centre_determined(free);
  const GridFit& best = is_held ? held : free;
  require_converged(best.fit, ".distortion", "a grid fit",
                    "marks on the requested nodes, distributed over the visible part", context);
  const MarksFit found{best.fit,
                       Eigen::VectorXd::Constant(static_cast<Eigen::Index>(marks.size()), best.noise_px)};
  refuse_outlier(
      found, {6.0, 3.0, "mark this node again"}, [&](std::size_t mark) { return field_of(marks[mark].node); },
      context);
  DistortionFit result = result_of(problem, found, name);
  require_unfolded(result.distortion, eye, context);
  result.has_centre_prior = is_held;
  add_remarks(result, eye, "grid's marks", name);
  return result;
}

DistortionFit mean_distortion(const AdjustedGrids& adjusted, const view::Eye& eye, const AspectPrior& aspect,
                              const std::string& name, const std::string& file)
{
  const bench::FitErrorContext context{name, file};
  if (adjusted.values.size() < 2) {
    context.fail(".distortion", std::to_string(adjusted.values.size()) + " adjusted grid",
                 "two or more, because their spread gives the uncertainty");
  }
  const auto n = static_cast<double>(adjusted.values.size());
  GridValues mean = GridValues::Zero();
  for (const GridValues& v : adjusted.values) mean += v / n;
  const Eigen::MatrixXd J = node_jacobian(adjusted, eye, mean, aspect.value);
  const Eigen::MatrixXd by_numbers = J.leftCols<8>();
  Eigen::MatrixXd N = square(by_numbers.transpose());
  double square_sum = 0.0;
  for (const GridValues& v : adjusted.values) square_sum += transformed(by_numbers, v - mean).squaredNorm();
  const double dof = 8.0 * (n - 1.0);

  DistortionFit result;
  result.noise_px = std::max(std::sqrt(square_sum / dof), minimum_noise_px);
  const double variance = result.noise_px * result.noise_px / n;
  result.has_centre_prior = !(centre_variance(N, variance) < most_centre_sd_px * most_centre_sd_px);
  if (result.has_centre_prior) {
    mean.segment<2>(centre_x) = view::middle_px(eye.visible);
    N.diagonal().segment<2>(centre_x).array() += variance / (centre_prior_sd_px * centre_prior_sd_px);
  }
  const Eigen::MatrixXd inverse = square(inverse_root_of(N));
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
  covariance.topLeftCorner<4, 4>() = variance * inverse.topLeftCorner<4, 4>();
  // The aspect is given, not measured by the spread, so its contribution to an interval must be 1.96 standard
  // deviations. `by_aspect` is the common change of all parameters per aspect error.
  Eigen::Matrix<double, 5, 1> by_aspect;
  const Eigen::VectorXd by_node = transformed(by_numbers.transpose(), J.col(8));
  by_aspect << -transformed(inverse, by_node).head<4>(), 1.0;
  by_aspect *= aspect.sd * bench::t_95(std::numeric_limits<double>::infinity()) / bench::t_95(dof);
  covariance += by_aspect * by_aspect.transpose();

  result.distortion = distortion_of(eye, mean.head<4>(), aspect.value);
  result.grid = grid_of(mean.tail<4>());
  require_unfolded(result.distortion, eye, context);
  result.estimate = estimate_of(result.distortion, covariance, name);
  result.estimate.dof = dof;
  std::vector<double> apart_px;
  for (const GridValues& v : adjusted.values) {
    const view::Distortion one = distortion_of(eye, v.head<4>(), aspect.value);
    apart_px.push_back(rms_difference_px(one, result.distortion, eye));
  }
  bench::set_residuals(result.estimate, apart_px, "px");
  add_remarks(result, eye, "adjusted grids", name);
  return result;
}

}  // namespace vrda::calibration
