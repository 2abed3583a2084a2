// A tracked body's marker positions from frames in which the markers were seen.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "bench/body_pose.hpp"
#include "bench/rigid_body.hpp"

namespace vrda::bench {
namespace {

/// Current estimate of the shape; markers not yet known are excluded.
struct Shape {
  RigidBody body;
  std::vector<bool> is_known;
};

/// The markers of a frame that are known in the shape.
MarkerRow known_part(const Shape& shape, const MarkerRow& frame)
{
  MarkerRow part = frame;
  for (std::size_t k = 0; k < part.size(); ++k) {
    if (!shape.is_known[k]) part[k].reset();
  }
  return part;
}

/// Disables outlier rejection while the shape is estimated.
FitOptions options_without_outliers(const BodyOptions& options)
{
  FitOptions fit;
  fit.least_spread_mm = options.least_spread_mm;
  fit.outlier_mm = std::numeric_limits<double>::infinity();
  return fit;
}

int n_seen(const MarkerRow& row)
{
  return static_cast<int>(std::ranges::count_if(row, [](const auto& p) { return p.has_value(); }));
}

RigidBody body_of(const MarkerRow& row)
{
  RigidBody body;
  body.markers_mm = Points::Zero(static_cast<Eigen::Index>(row.size()), 3);
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (row[k]) body.markers_mm.row(static_cast<Eigen::Index>(k)) = row[k]->transpose();
  }
  return body;
}

/// Rounded to a micrometre.
std::string number_of(double length_mm)
{
  return shortest_decimal(std::round(length_mm * 1000.0) / 1000.0);
}

std::string text_of(const MarkerCloud& cloud)
{
  return std::to_string(cloud.n) + " markers, second singular value " + number_of(cloud.spread_mm(1)) + " mm";
}

void require_frames(const std::vector<MarkerRow>& frames, const std::string& file)
{
  if (frames.empty()) throw FitError({file, "frames", "none", "one or more"});
  const std::size_t n = frames.front().size();
  if (n < 3 || n > static_cast<std::size_t>(max_markers)) {
    throw FitError({file, "markers", std::to_string(n), "3 to " + std::to_string(max_markers)});
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string field = "frame " + std::to_string(i + 1);
    if (frames[i].size() != n) {
      throw FitError({file, field, std::to_string(frames[i].size()) + " markers", std::to_string(n)});
    }
    for (const auto& marker : frames[i]) {
      if (marker && !(marker->cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < farthest_mm)) {
        throw FitError({file, field, "a coordinate not finite or above 1 km", "mm"});
      }
    }
  }
}

/// The frame with the most visible markers among those that are not collinear; the first of equals.
Shape first_shape(const std::vector<MarkerRow>& frames, const std::string& file, const BodyOptions& options)
{
  const MarkerRow* best = nullptr;
  MarkerCloud widest;
  for (const MarkerRow& frame : frames) {
    const MarkerCloud cloud = cloud_of(body_of(frame), frame);
    if (cloud.n >= 3 && (widest.n < 3 || cloud.spread_mm(1) > widest.spread_mm(1))) widest = cloud;
    if (cloud.n < 3 || cloud.spread_mm(1) < options.least_spread_mm) continue;
    if (!best || cloud.n > n_seen(*best)) best = &frame;
  }
  if (!best && widest.n < 3) {
    throw FitError({file, "markers", "no frame with three visible markers", "three or more in a frame"});
  }
  if (!best) {
    throw FitError({file, "markers", "collinear: at best " + text_of(widest),
                    "a second singular value of " + number_of(options.least_spread_mm) + " mm or more"});
  }
  Shape shape{body_of(*best), {}};
  for (const auto& marker : *best) shape.is_known.push_back(marker.has_value());
  return shape;
}

std::vector<PoseFit> fits_of(const std::vector<MarkerRow>& frames, const Shape& shape,
                             const FitOptions& options)
{
  std::vector<PoseFit> fits;
  fits.reserve(frames.size());
  for (const MarkerRow& frame : frames)
    fits.push_back(fit_pose(shape.body, known_part(shape, frame), options));
  return fits;
}

/// Mean position of each marker over the fitted frames.
Shape mean_shape(const std::vector<MarkerRow>& frames, const std::vector<PoseFit>& fits, const Shape& before)
{
  Shape shape = before;
  for (std::size_t k = 0; k < shape.is_known.size(); ++k) {
    Eigen::Vector3d sum_mm = Eigen::Vector3d::Zero();
    int n = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (!frames[i][k] || fits[i].status != FitStatus::fitted) continue;
      sum_mm += fits[i].X_tracker_body.inverse() * *frames[i][k];
      ++n;
    }
    if (n == 0) continue;
    shape.body.markers_mm.row(static_cast<Eigen::Index>(k)) = sum_mm.transpose() / n;
    shape.is_known[k] = true;
  }
  return shape;
}

double largest_step_mm(const Shape& before, const Shape& after)
{
  double largest = 0.0;
  for (Eigen::Index k = 0; k < after.body.markers_mm.rows(); ++k) {
    if (before.is_known[static_cast<std::size_t>(k)] != after.is_known[static_cast<std::size_t>(k)])
      return std::numeric_limits<double>::infinity();
    largest = std::max(largest, (after.body.markers_mm.row(k) - before.body.markers_mm.row(k)).norm());
  }
  return largest;
}

void require_all_known(const Shape& shape, const std::vector<MarkerRow>& frames, const std::string& file)
{
  for (std::size_t k = 0; k < shape.is_known.size(); ++k) {
    if (shape.is_known[k]) continue;
    const auto n = std::ranges::count_if(frames, [&](const MarkerRow& f) { return f[k].has_value(); });
    throw FitError({file, "marker " + std::to_string(k + 1),
                    "seen in " + std::to_string(n) + " frames, never with three known, not collinear",
                    "a frame that shows it with three known markers"},
                   {k});
  }
}

/// X first to second marker, Y towards the first that is at least half as far from that line as the furthest.
Pose own_frame(const RigidBody& body, const std::string& file)
{
  const Points& p = body.markers_mm;
  const Eigen::Vector3d first = p.row(0).transpose();
  const Eigen::Vector3d along = p.row(1).transpose() - first;
  // If two markers coincide, noise would determine the axis.
  if (along.norm() < least_spread_mm) {
    throw FitError({file, "markers 1 and 2", number_of(along.norm()) + " mm apart",
                    number_of(least_spread_mm) + " mm or more, or given coordinates of the markers"},
                   {0, 1});
  }
  const Eigen::Vector3d x = along.normalized();
  std::vector<Eigen::Vector3d> across;
  double furthest_mm = 0.0;
  for (Eigen::Index k = 0; k < p.rows(); ++k) {
    const Eigen::Vector3d from_first = p.row(k).transpose() - first;
    across.emplace_back(from_first - x.dot(from_first) * x);
    furthest_mm = std::max(furthest_mm, across.back().norm());
  }
  const auto third =
      std::ranges::find_if(across, [&](const Eigen::Vector3d& v) { return v.norm() >= 0.5 * furthest_mm; });
  Pose X_shape_body = Pose::Identity();
  const Eigen::Vector3d y = third->normalized();
  X_shape_body.linear() << x, y, x.cross(y);
  X_shape_body.translation() = p.colwise().mean().transpose();
  return X_shape_body;
}

/// Transforms the shape to the requested frame; returns the RMS distance from given coordinates.
double move_to_frame(RigidBody& body, const std::string& file, const BodyOptions& options)
{
  Pose X_body_shape = Pose::Identity();
  double wanted_rms_mm = 0.0;
  if (options.given_mm.empty()) {
    X_body_shape = own_frame(body, file).inverse();
  } else {
    if (options.given_mm.size() != static_cast<std::size_t>(body.markers_mm.rows())) {
      throw FitError({file, "coordinates wanted",
                      "of " + std::to_string(options.given_mm.size()) + " markers",
                      "an entry for each of " + std::to_string(body.markers_mm.rows())});
    }
    const PoseFit fit = fit_pose(body, options.given_mm, options_without_outliers(options));
    if (fit.status != FitStatus::fitted) {
      throw FitError({file, "coordinates wanted", text_of(fit.cloud), "three or more, not collinear"});
    }
    X_body_shape = fit.X_tracker_body;
    wanted_rms_mm = fit.residual_rms_mm;
  }
  for (Eigen::Index k = 0; k < body.markers_mm.rows(); ++k) {
    const Eigen::Vector3d p_shape = body.markers_mm.row(k).transpose();
    body.markers_mm.row(k) = (X_body_shape * p_shape).transpose();
  }
  return wanted_rms_mm;
}

void add_residuals(BuiltBody& built, const std::vector<MarkerRow>& frames, const std::vector<PoseFit>& fits)
{
  built.markers.resize(frames.front().size());
  std::vector<double> sum_sq_mm2(built.markers.size(), 0.0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool is_used = fits[i].status == FitStatus::fitted;
    (is_used ? built.n_frames : built.n_refused) += 1;
    if (!is_used) continue;
    for (std::size_t k = 0; k < built.markers.size(); ++k) {
      if (!frames[i][k]) continue;
      const Eigen::Vector3d p_body = built.body.markers_mm.row(static_cast<Eigen::Index>(k)).transpose();
      sum_sq_mm2[k] += (*frames[i][k] - fits[i].X_tracker_body * p_body).squaredNorm();
      ++built.markers[k].n_frames;
    }
  }
  double all_sq_mm2 = 0.0;
  int n_all = 0;
  for (std::size_t k = 0; k < built.markers.size(); ++k) {
    BuiltMarker& marker = built.markers[k];
    marker.residual_rms_mm = std::sqrt(sum_sq_mm2[k] / marker.n_frames);
    all_sq_mm2 += sum_sq_mm2[k];
    n_all += marker.n_frames;
  }
  built.residual_rms_mm = std::sqrt(all_sq_mm2 / n_all);
}

}  // namespace

BuiltBody build_body(const std::vector<MarkerRow>& frames, const std::string& file,
                     const BodyOptions& options)
{
  require_frames(frames, file);
  const FitOptions fit = options_without_outliers(options);
  Shape shape = first_shape(frames, file, options);
  BuiltBody built;
  for (int iteration = 0; iteration < options.most_iterations; ++iteration) {
    const Shape next = mean_shape(frames, fits_of(frames, shape, fit), shape);
    const double step_mm = largest_step_mm(shape, next);
    shape = next;
    if (step_mm > options.tolerance_mm) continue;
    built.status = BuildStatus::converged;
    break;
  }
  require_all_known(shape, frames, file);
  built.body = shape.body;
  built.given_rms_mm = move_to_frame(built.body, file, options);
  add_residuals(built, frames, fits_of(frames, {built.body, shape.is_known}, fit));
  return built;
}

}  // namespace vrda::bench
