#include "geometry/bone_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace vrda::geometry {
namespace {

constexpr double farthest_pair_mm = 20.0;
constexpr double least_pair_cosine = 0.4;
constexpr double capped_mm = 5.0;
// mm^2 per point and squared relative deviation of a scale from the mean of the three: a deviation of 5 %
// costs as much as 0.13 mm on every point.
constexpr double anisotropy_weight_mm2 = 7.0;
// The same for deviations from the start's scales: cartilage determines its height better than its width.
const Eigen::Vector3d near_start_weight_mm2(100.0, 10.0, 100.0);
constexpr double known_share = 0.01;  // of the surface's weight
constexpr double doubtful_mm = 15.0;  // landmarks are located to about 5 mm

struct Pair {
  Eigen::Vector3d from_mm;  // template
  Eigen::Vector3d at_mm;    // template placed
  Eigen::Vector3d to_mm;    // subject
  Eigen::Vector3d normal;   // of the subject
  double distance_sq_mm2;
  double weight;
};

double weight_sum(const std::vector<Pair>& pairs)
{
  double sum = 0.0;
  for (const Pair& pair : pairs) sum += pair.weight;
  return sum;
}

// Three pairs a point, one along each axis.
void add_known(std::vector<Pair>& pairs, const std::vector<KnownPoint>& known, const BoneFit& fit)
{
  const double weight = known_share * weight_sum(pairs);
  for (const KnownPoint& point : known) {
    const Eigen::Vector3d at_mm = fit(point.template_mm);
    const double distance_sq_mm2 = (at_mm - point.subject_mm).squaredNorm();
    const double trust = 1.0 / (1.0 + distance_sq_mm2 / (doubtful_mm * doubtful_mm));
    for (Eigen::Index k = 0; k < 3; ++k)
      pairs.push_back({point.template_mm, at_mm, point.subject_mm, Eigen::Vector3d::Unit(k), distance_sq_mm2,
                       weight * trust * trust});
  }
}

// The direction to the nearest point of a surface is along its normal, except where the surface ends: 0
// there. The transition is gradual, since pairs that appear or disappear at once cause local optima.
double weight_at_border(const Eigen::Vector3d& off_mm, const Eigen::Vector3d& normal)
{
  constexpr double base_mm = 1.0, slope = 0.35;  // of facets and of noise
  const double across_mm = (off_mm - off_mm.dot(normal) * normal).norm();
  return std::clamp(2.0 - 2.0 * across_mm / (base_mm + slope * off_mm.norm()), 0.0, 1.0);
}

// None if stopped.
std::vector<Pair> all_pairs(const SurfacePoints& points, const NearestSurface& subject, const BoneFit& fit,
                            const BoneFitOptions& options)
{
  std::vector<Pair> pairs;
  for (Eigen::Index i = 0; i < points.positions_mm.rows(); ++i) {
    if (options.is_stopped && options.is_stopped()) return {};
    const Eigen::Vector3d from_mm = points.positions_mm.row(i), at_mm = fit(from_mm);
    const SurfacePoint nearest = subject.nearest(
        at_mm, {farthest_pair_mm, least_pair_cosine, fit.normal(points.normals.row(i).transpose())});
    if (nearest.triangle < 0) continue;
    const double weight = weight_at_border(at_mm - nearest.p_mm, subject.normal(nearest.triangle));
    if (weight == 0.0) continue;
    pairs.push_back({from_mm, at_mm, nearest.p_mm, subject.normal(nearest.triangle),
                     nearest.distance_mm * nearest.distance_mm, weight});
  }
  return pairs;
}

// The farthest of the pairs kept weigh little.
void keep_nearest(std::vector<Pair>& pairs, double kept)
{
  const auto n = static_cast<std::ptrdiff_t>(kept * static_cast<double>(pairs.size()));
  std::nth_element(pairs.begin(), pairs.begin() + n, pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.distance_sq_mm2 < b.distance_sq_mm2; });
  pairs.resize(static_cast<std::size_t>(n));
  double farthest_sq_mm2 = 0.0;
  for (const Pair& pair : pairs) farthest_sq_mm2 = std::max(farthest_sq_mm2, pair.distance_sq_mm2);
  for (Pair& pair : pairs)
    pair.weight *= farthest_sq_mm2 > 0.0 ? 1.0 - pair.distance_sq_mm2 / farthest_sq_mm2 : 1.0;
}

void set_residuals(BoneFit& fit, const SurfacePoints& points, const NearestSurface& subject,
                   const BoneFitOptions& options)
{
  std::vector<Pair> pairs = all_pairs(points, subject, fit, options);
  const auto n = static_cast<double>(points.positions_mm.rows());
  double sum = capped_mm * capped_mm * (n - static_cast<double>(pairs.size()));
  for (const Pair& pair : pairs) sum += std::min(pair.distance_sq_mm2, capped_mm * capped_mm);
  for (const KnownPoint& point : options.known) {
    const double off_sq_mm2 = (fit(point.template_mm) - point.subject_mm).squaredNorm();
    sum += known_share * n * std::min(off_sq_mm2, doubtful_mm * doubtful_mm);
  }
  fit.mismatch_mm = std::sqrt(sum / n);
  keep_nearest(pairs, options.kept);
  sum = 0.0;
  for (const Pair& pair : pairs) sum += pair.distance_sq_mm2;
  fit.residual_mm = std::sqrt(sum / static_cast<double>(pairs.size())) / fit.scale.mean();
}

Eigen::Matrix3d small_rotation(const Eigen::Vector3d& w_rad)
{
  const Eigen::Vector3d half = 0.5 * w_rad;
  return Eigen::Quaterniond(1.0, half.x(), half.y(), half.z()).normalized().toRotationMatrix();
}

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

Eigen::Index n_scales(ScaleFreedom freedom)
{
  return freedom == ScaleFreedom::held ? 0 : freedom == ScaleFreedom::similarity ? 1 : 3;
}

// Adds the prior on the scales, in units of the pairs' weight.
void add_prior(Matrix9d& H, Vector9d& g, double weight, const Eigen::Vector3d& scale, ScaleFreedom freedom,
               const Eigen::Vector3d& start)
{
  Eigen::Matrix3d curvature = weight * near_start_weight_mm2.asDiagonal().toDenseMatrix();
  if (freedom == ScaleFreedom::axes)
    curvature =
        weight * anisotropy_weight_mm2 * (Eigen::Matrix3d::Identity() - Eigen::Matrix3d::Constant(1.0 / 3.0));
  H.bottomRightCorner<3, 3>() += curvature;
  g.tail<3>() += curvature * (freedom == ScaleFreedom::axes ? scale : scale - start);
}

// One Gauss-Newton step; returns the length of the motion in mm and rad.
double advance(BoneFit& fit, const std::vector<Pair>& pairs, ScaleFreedom freedom,
               const Eigen::Vector3d& start)
{
  const bool has_axes = n_scales(freedom) == 3;
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  for (const Pair& pair : pairs) centre_mm += pair.at_mm;
  centre_mm /= static_cast<double>(pairs.size());
  Matrix9d H = Matrix9d::Zero();
  Vector9d g = Vector9d::Zero();
  for (const Pair& pair : pairs) {
    Vector9d slope = Vector9d::Zero();
    slope.head<3>() = (pair.at_mm - centre_mm).cross(pair.normal);
    slope.segment<3>(3) = pair.normal;
    const Eigen::Vector3d of_scale = (fit.R.transpose() * pair.normal).cwiseProduct(pair.from_mm);
    if (has_axes) slope.tail<3>() = of_scale;
    if (freedom == ScaleFreedom::similarity) slope[6] = of_scale.dot(fit.scale) / fit.scale.mean();
    const double off_mm = pair.normal.dot(pair.at_mm - pair.to_mm);
    H += pair.weight * slope * slope.transpose();
    g += pair.weight * off_mm * slope;
  }
  if (has_axes) add_prior(H, g, weight_sum(pairs), fit.scale, freedom, start);
  const Eigen::Index n = 6 + n_scales(freedom);
  // Keeps a bone of revolution solvable; a thousandth of a micrometre on a real one.
  H.diagonal().array() += 1e-9 * H.trace();
  const Eigen::VectorXd step = -H.topLeftCorner(n, n).ldlt().solve(g.head(n));
  const Eigen::Matrix3d turn = small_rotation(step.head<3>());
  fit.t_mm = turn * (fit.t_mm - centre_mm) + centre_mm + step.segment<3>(3);
  fit.R = turn * fit.R;
  if (has_axes) fit.scale += step.tail<3>();
  if (freedom == ScaleFreedom::similarity) fit.scale *= 1.0 + step[6] / fit.scale.mean();
  fit.scale = fit.scale.cwiseMax(0.5).cwiseMin(2.0);
  return step.norm();
}

void iterate(BoneFit& fit, const SurfacePoints& points, const NearestSurface& subject, ScaleFreedom freedom,
             const BoneFitOptions& options, int n)
{
  constexpr double smallest_step = 1e-5;
  const Eigen::Vector3d start = fit.scale;
  constexpr std::size_t fewest_pairs = 50;
  for (int i = 0; i < n; ++i) {
    std::vector<Pair> pairs = all_pairs(points, subject, fit, options);
    keep_nearest(pairs, options.kept);
    if (pairs.size() < fewest_pairs) break;
    add_known(pairs, options.known, fit);
    if (advance(fit, pairs, freedom, start) < smallest_step) break;
  }
}

// Every fourth point.
SurfacePoints quarter_of(const SurfacePoints& points)
{
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < points.positions_mm.rows(); i += 4) rows.push_back(i);
  return {points.positions_mm(rows, Eigen::all), points.normals(rows, Eigen::all)};
}

}  // namespace

BoneFit fit_bone(const SurfacePoints& template_points, const NearestSurface& subject,
                 const std::vector<BoneFit>& starts, const BoneFitOptions& options)
{
  const ScaleFreedom first =
      options.freedom == ScaleFreedom::axes ? ScaleFreedom::similarity : ScaleFreedom::held;
  const SurfacePoints few = quarter_of(template_points);
  std::vector<BoneFit> fits = starts;
  for (BoneFit& fit : fits) {
    iterate(fit, few, subject, first, options, 12);
    set_residuals(fit, few, subject, options);
  }
  BoneFit fit = *std::min_element(fits.begin(), fits.end(), [](const BoneFit& a, const BoneFit& b) {
    return a.mismatch_mm < b.mismatch_mm;
  });
  iterate(fit, template_points, subject, first, options, first == ScaleFreedom::held ? 60 : 15);
  if (n_scales(options.freedom) == 3) iterate(fit, template_points, subject, options.freedom, options, 40);
  set_residuals(fit, template_points, subject, options);
  return fit;
}

}  // namespace vrda::geometry
