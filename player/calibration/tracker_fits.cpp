#include "calibration/tracker_fits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/rigid_body.hpp"
#include "calibration/least_squares.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {

namespace {

constexpr std::size_t least_poses = 20;
constexpr double least_spread_rad = rad_from_deg(10.0);
constexpr double most_rms_mm = 2.0;

/// Rms angle of the probe's directions from their mean, about the axis with the least rotation; for a cone
/// its half angle.
double spread_of(std::span<const Pose> X_tracker_probe)
{
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  for (const Pose& X : X_tracker_probe) mean += X.linear();
  mean /= static_cast<double>(X_tracker_probe.size());
  // Mean of (R_i - mean)^T (R_i - mean): its quadratic form in v is the mean square displacement of v.
  const Eigen::Matrix3d swing = Eigen::Matrix3d::Identity() - mean.transpose() * mean;
  const double least = principal_axes(swing).values[2];
  return std::asin(std::sqrt(std::clamp(least, 0.0, 1.0)));
}

/// Residuals A (tip, pivot) + b of all poses in probe axes: tip + R^T (t - pivot).
struct PivotProblem {
  Eigen::MatrixXd A;  ///< [3 n, 6]
  Eigen::VectorXd b;
};

PivotProblem pivot_problem(std::span<const Pose> X_tracker_probe)
{
  const auto n = static_cast<Eigen::Index>(X_tracker_probe.size());
  PivotProblem problem{Eigen::MatrixXd(3 * n, 6), Eigen::VectorXd(3 * n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Pose& X = X_tracker_probe[static_cast<std::size_t>(i)];
    problem.A.block<3, 3>(3 * i, 0).setIdentity();
    problem.A.block<3, 3>(3 * i, 3) = -X.linear().transpose();
    problem.b.segment<3>(3 * i) = X.linear().transpose() * X.translation();
  }
  return problem;
}

/// Covariance of tip and pivot for noise that is constant in probe axes. It is anisotropic: orientation noise
/// moves the tip across the shaft, not along it.
Eigen::MatrixXd covariance_of(const PivotProblem& problem, const Eigen::VectorXd& residuals,
                              const Eigen::MatrixXd& inverse)
{
  const Eigen::Index n = residuals.size() / 3;
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < n; ++i)
    noise += residuals.segment<3>(3 * i) * residuals.segment<3>(3 * i).transpose();
  noise /= static_cast<double>(n) - 2.0;  // 6 parameters in 3 coordinates
  Eigen::MatrixXd weighted(3 * n, 6);
  for (Eigen::Index i = 0; i < n; ++i) weighted.middleRows<3>(3 * i) = noise * problem.A.middleRows<3>(3 * i);
  return propagated(inverse, product(problem.A.transpose(), weighted));
}

}  // namespace

PivotFit fit_pivot(std::span<const Pose> X_tracker_probe, const std::string& file)
{
  const bench::FitErrorContext context{"", file};
  const std::size_t n = X_tracker_probe.size();
  if (n < least_poses)
    context.fail("probe", std::to_string(n) + " poses", std::to_string(least_poses) + " or more");
  PivotFit fit;
  fit.spread_rad = spread_of(X_tracker_probe);
  if (!(fit.spread_rad >= least_spread_rad)) {
    context.fail(
        "probe",
        bench::text(deg_from_rad(fit.spread_rad), 1, "deg") +
            " (rms) of rotation about the axis with the least rotation",
        bench::text(deg_from_rad(least_spread_rad), 0, "deg") +
            " or more; keep the tip fixed and tilt the probe in all directions over a range of 40 deg");
  }
  const PivotProblem problem = pivot_problem(X_tracker_probe);
  const Eigen::MatrixXd inverse = square(inverse_root_of(square(problem.A.transpose())));
  const Eigen::VectorXd found = -transformed(inverse, transformed(problem.A.transpose(), problem.b));
  const Eigen::VectorXd residuals = transformed(problem.A, found) + problem.b;
  fit.tip_probe_mm = found.head<3>();
  fit.pivot_tracker_mm = found.tail<3>();
  std::vector<double> residuals_mm;
  for (Eigen::Index i = 0; i < residuals.size(); i += 3)
    residuals_mm.push_back(residuals.segment<3>(i).norm());

  bench::Estimate& estimate = fit.estimate;
  estimate.names = {"probe.tip_x", "probe.tip_y", "probe.tip_z"};
  estimate.units = {"mm", "mm", "mm"};
  estimate.values = fit.tip_probe_mm;
  estimate.covariance = covariance_of(problem, residuals, inverse).topLeftCorner<3, 3>();
  estimate.dof = static_cast<double>(n) - 2.0;
  bench::set_residuals(estimate, residuals_mm, "mm");
  if (!(estimate.residual_rms <= most_rms_mm)) {
    context.fail(
        "probe", "a tip that moves by " + bench::text(estimate.residual_rms, 2, "mm") + " (rms)",
        bench::text(most_rms_mm, 0, "mm") + " at most; the tip slipped: put it in a small hole and repeat");
  }
  estimate.remarks.push_back("the probe rotated by " + bench::text(deg_from_rad(fit.spread_rad), 0, "deg") +
                             " (rms) about the axis with the least rotation (at least " +
                             short_decimal(deg_from_rad(least_spread_rad), 0) +
                             " required); its tip moved by " + bench::text(estimate.residual_rms, 2, "mm") +
                             " (rms)");
  return fit;
}

namespace {

constexpr std::size_t least_places = 10;
constexpr double least_sweep_mm = 50.0;
constexpr double most_rail_rms_mm = 2.0;
constexpr double rail_outlier_sd = 6.0, rail_outlier_mm = 1.0;
constexpr double least_apart_rad = rad_from_deg(45.0);
constexpr double most_stage_error = 0.02;

/// centre + s direction; the centre is the mean of the positions.
struct Line {
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, in the direction of the sweep
};

/// Line through a sweep, with residuals.
struct LineFit {
  Line line;
  std::vector<double> along_mm, off_mm;  ///< per position: s, and the distance from the line
  double along_sq_mm2 = 0.0;             ///< sum of squares
  double off_sq_mm2 = 0.0;               ///< sum of squares
  double dof = 0.0;                      ///< 2 n transverse coordinates minus the 4 parameters of a line
};

LineFit fit_line(const std::vector<Eigen::Vector3d>& points_mm)
{
  const double n = static_cast<double>(points_mm.size());
  LineFit fit;
  for (const Eigen::Vector3d& p : points_mm) fit.line.centre_mm += p / n;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points_mm)
    scatter += (p - fit.line.centre_mm) * (p - fit.line.centre_mm).transpose();
  fit.line.direction = principal_axes(scatter).vectors.col(0);
  double trend = 0.0;
  for (std::size_t k = 0; k < points_mm.size(); ++k)
    trend += (static_cast<double>(k) - 0.5 * (n - 1.0)) *
             fit.line.direction.dot(points_mm[k] - fit.line.centre_mm);
  if (trend < 0.0) fit.line.direction = -fit.line.direction;
  for (const Eigen::Vector3d& p : points_mm) {
    const Eigen::Vector3d from_centre = p - fit.line.centre_mm;
    fit.along_mm.push_back(fit.line.direction.dot(from_centre));
    fit.off_mm.push_back((from_centre - fit.along_mm.back() * fit.line.direction).norm());
    fit.along_sq_mm2 += fit.along_mm.back() * fit.along_mm.back();
    fit.off_sq_mm2 += fit.off_mm.back() * fit.off_mm.back();
  }
  fit.dof = 2.0 * n - 4.0;
  return fit;
}

bench::FitError refusal(Rail rail, const std::string& file, const std::string& found,
                        const std::string& wanted)
{
  return bench::FitError({file, rail == Rail::x ? "x_rail" : "z_rail", found, wanted},
                         {static_cast<std::size_t>(rail)});
}

/// Compares each position with the noise of the others, corrected for its leverage on the line.
void require_no_outlier(const LineFit& fit, Rail rail, const std::string& file)
{
  const double n = static_cast<double>(fit.off_mm.size());
  for (std::size_t k = 0; k < fit.off_mm.size(); ++k) {
    const double leverage = 1.0 / n + fit.along_mm[k] * fit.along_mm[k] / fit.along_sq_mm2;
    const double off_mm = fit.off_mm[k] / (1.0 - std::min(leverage, 0.99));
    const double others_mm2 = std::max(0.0, fit.off_sq_mm2 - fit.off_mm[k] * off_mm) / (fit.dof - 2.0);
    if (off_mm > rail_outlier_mm && off_mm > rail_outlier_sd * std::sqrt(others_mm2)) {
      throw refusal(
          rail, file,
          "position " + std::to_string(k + 1) + " " + bench::text(off_mm, 2, "mm") + " from the line",
          "positions within " + bench::text(rail_outlier_mm, 0, "mm") +
              "; sweep again with the marker always visible");
    }
  }
}

LineFit required_line(const RailSweep& sweep, Rail rail, const std::string& file)
{
  check(sweep.stage_mm.empty() || sweep.stage_mm.size() == sweep.p_tracker_mm.size(),
        "the stage value is known at all positions or none");
  const std::size_t n = sweep.p_tracker_mm.size();
  if (n < least_places)
    throw refusal(rail, file, std::to_string(n) + " positions", std::to_string(least_places) + " or more");
  for (const Eigen::Vector3d& p : sweep.p_tracker_mm) {
    if (!p.allFinite())
      throw refusal(rail, file, "a coordinate that is not a finite number", "coordinates in mm");
  }
  LineFit fit = fit_line(sweep.p_tracker_mm);
  const auto [least, most] = std::minmax_element(fit.along_mm.begin(), fit.along_mm.end());
  if (!(*most - *least >= least_sweep_mm)) {
    throw refusal(rail, file, "a sweep of " + bench::text(*most - *least, 1, "mm"),
                  bench::text(least_sweep_mm, 0, "mm") + " or more, preferably the whole rail");
  }
  require_no_outlier(fit, rail, file);
  const double rms_mm = std::sqrt(fit.off_sq_mm2 / static_cast<double>(n));
  if (!(rms_mm <= most_rail_rms_mm)) {
    throw refusal(rail, file, "positions " + bench::text(rms_mm, 2, "mm") + " (rms) from the best line",
                  bench::text(most_rail_rms_mm, 0, "mm") + " at most; move the marker only along the rail");
  }
  return fit;
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Pose table_pose(const Line& x_rail, const Line& z_rail)
{
  const Eigen::Vector3d u = x_rail.direction.normalized(), w = z_rail.direction.normalized();
  const Eigen::Vector3d z = (w - w.dot(u) * u).normalized();
  Pose X = Pose::Identity();
  X.linear() << u, z.cross(u), z;
  // The segment between the nearest points is orthogonal to both directions.
  const Eigen::Vector3d between = z_rail.centre_mm - x_rail.centre_mm;
  const double cos = u.dot(w);
  X.translation() = x_rail.centre_mm + u * ((between.dot(u) - cos * between.dot(w)) / (1.0 - cos * cos));
  return X;
}

/// Two unit vectors orthogonal to a line.
std::array<Eigen::Vector3d, 2> across(const Eigen::Vector3d& direction)
{
  const Eigen::Vector3d one = direction.unitOrthogonal();
  return {one, direction.cross(one)};
}

/// Covariance of the table pose from transverse errors of both lines, by central differences.
Eigen::Matrix<double, 6, 6> covariance_of(const LineFit& x_fit, const LineFit& z_fit, double noise_mm2)
{
  Eigen::Matrix<double, 6, 6> sum = Eigen::Matrix<double, 6, 6>::Zero();
  const std::array<const LineFit*, 2> fits = {&x_fit, &z_fit};
  for (std::size_t rail = 0; rail < fits.size(); ++rail) {
    const double n = static_cast<double>(fits[rail]->off_mm.size());
    const auto add = [&](const Eigen::Vector3d& centre_step, const Eigen::Vector3d& direction_step,
                         double step, double variance) {
      std::array<Pose, 2> ends;
      for (std::size_t end = 0; end < ends.size(); ++end) {
        std::array<Line, 2> lines = {x_fit.line, z_fit.line};
        const double by = end == 0 ? -step : step;
        lines[rail].centre_mm += by * centre_step;
        lines[rail].direction += by * direction_step;
        ends[end] = table_pose(lines[0], lines[1]);
      }
      Eigen::Matrix<double, 6, 1> change;
      change << ends[1].translation() - ends[0].translation(),
          bench::turn_of(ends[1].linear() * ends[0].linear().transpose());
      change /= 2.0 * step;
      sum += variance * change * change.transpose();
    };
    constexpr double step_mm = 1e-2, step_rad = 1e-5;
    for (const Eigen::Vector3d& side : across(fits[rail]->line.direction)) {
      add(side, Eigen::Vector3d::Zero(), step_mm, noise_mm2 / n);
      add(Eigen::Vector3d::Zero(), side, step_rad, noise_mm2 / fits[rail]->along_sq_mm2);
    }
  }
  return sum;
}

/// Marker displacement per encoder displacement (regression slope).
double stage_scale_of(const RailSweep& sweep, const LineFit& fit, const std::string& file)
{
  if (sweep.stage_mm.empty()) return 0.0;
  double mean_mm = 0.0, with_marker = 0.0, with_stage = 0.0, marker_sq = fit.along_sq_mm2;
  for (const double s : sweep.stage_mm) mean_mm += s / static_cast<double>(sweep.stage_mm.size());
  for (std::size_t k = 0; k < sweep.stage_mm.size(); ++k) {
    with_marker += (sweep.stage_mm[k] - mean_mm) * fit.along_mm[k];
    with_stage += (sweep.stage_mm[k] - mean_mm) * (sweep.stage_mm[k] - mean_mm);
  }
  // The inverse slope is checked first: for a constant encoder it is 0, not infinite.
  const double counted = with_marker / marker_sq;
  const double scale = with_stage > 0.0 ? with_marker / with_stage : 0.0;
  if (!(counted > 0.0)) {
    throw refusal(Rail::x, file,
                  "an encoder displacement of " + bench::text(counted, 3, "mm") + " per mm to the right",
                  "1; check the sign of stage_mm_per_count in the bench file, the encoder and that the sweep "
                  "was from left to right");
  }
  if (!(std::abs(scale - 1.0) <= most_stage_error)) {
    throw refusal(Rail::x, file,
                  "a marker displacement of " + bench::text(scale, 4, "mm") + " per mm of the encoder",
                  "1 to within 2 %; check stage_mm_per_count in the bench file");
  }
  return scale;
}

}  // namespace

void require_valid_rail(const RailSweep& sweep, Rail rail, const std::string& file)
{
  stage_scale_of(sweep, required_line(sweep, rail, file), file);
}

TableFit fit_table(const RailSweep& x_rail, const RailSweep& z_rail, const std::string& file)
{
  const LineFit x_fit = required_line(x_rail, Rail::x, file), z_fit = required_line(z_rail, Rail::z, file);
  TableFit fit;
  fit.rails_angle_rad = angle_between(x_fit.line.direction, z_fit.line.direction);
  if (!(std::min(fit.rails_angle_rad, pi - fit.rails_angle_rad) >= least_apart_rad)) {
    throw refusal(Rail::z, file,
                  "rails at an angle of " + bench::text(deg_from_rad(fit.rails_angle_rad), 1, "deg"),
                  "about 90 deg, at least 45 to 135; sweep the other rail");
  }
  fit.stage_scale = stage_scale_of(x_rail, x_fit, file);
  fit.X_tracker_table = table_pose(x_fit.line, z_fit.line);
  // Same tracker and marker on both rails, so one noise.
  const double dof = x_fit.dof + z_fit.dof;
  const double noise_mm2 = (x_fit.off_sq_mm2 + z_fit.off_sq_mm2) / dof;
  fit.rails_angle_sd_rad = std::sqrt(noise_mm2 * (1.0 / x_fit.along_sq_mm2 + 1.0 / z_fit.along_sq_mm2));

  fit.estimate = bench::pose_estimate("table", fit.X_tracker_table, covariance_of(x_fit, z_fit, noise_mm2));
  fit.estimate.dof = dof;
  std::vector<double> off_mm = x_fit.off_mm;
  off_mm.insert(off_mm.end(), z_fit.off_mm.begin(), z_fit.off_mm.end());
  bench::set_residuals(fit.estimate, off_mm, "mm");
  fit.estimate.remarks.push_back(
      "angle between the rails: " + bench::text(deg_from_rad(fit.rails_angle_rad), 3, "deg") + " (95 %: +-" +
      bench::text(deg_from_rad(bench::t_95(dof) * fit.rails_angle_sd_rad), 3, "deg") + ")");
  if (fit.stage_scale > 0.0)
    fit.estimate.remarks.push_back("marker displacement: " + bench::text(fit.stage_scale, 4, "mm") +
                                   " per mm of the encoder");
  return fit;
}

// Touched points of a model, and the subject's scale.

namespace {

constexpr std::size_t least_distances = 3;
constexpr double least_scale = 0.5, most_scale = 2.0;
constexpr double uneven_ratio = 1.05, uneven_rms_mm = 2.0;

void require_distances(std::span<const LandmarkDistance> distances, const bench::FitErrorContext& context)
{
  if (distances.size() < least_distances) {
    context.fail("landmarks", std::to_string(distances.size()) + " distances",
                 "three or more, to check that one scale fits all");
  }
  for (std::size_t k = 0; k < distances.size(); ++k) {
    const LandmarkDistance& d = distances[k];
    for (const double mm : {d.model_mm, d.subject_mm}) {
      const bool is_length = mm > 0.0 && std::isfinite(mm);
      if (!is_length) {
        context.fail(d.name,
                     bench::text(d.model_mm, 2, "mm") + " of the model, " +
                         bench::text(d.subject_mm, 2, "mm") + " of the subject",
                     "distances above 0", {k});
      }
    }
  }
}

std::string percent(double scale)
{
  return short_decimal(100.0 * scale, 1) + " %";
}

}  // namespace

ScaleFit fit_scale(std::span<const LandmarkDistance> distances, const std::string& file)
{
  const bench::FitErrorContext context{"", file};
  require_distances(distances, context);
  double with_subject = 0.0, with_model = 0.0;
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const LandmarkDistance& d : distances) {
    with_subject += d.model_mm * d.subject_mm;
    with_model += d.model_mm * d.model_mm;
    least = std::min(least, d.subject_mm / d.model_mm);
    most = std::max(most, d.subject_mm / d.model_mm);
  }
  ScaleFit fit;
  fit.scale = with_subject / with_model;
  if (!(fit.scale >= least_scale && fit.scale <= most_scale)) {
    context.fail("landmarks", "a scale of " + short_decimal(fit.scale, 3),
                 "0.5 to 2; check the unit (mm) and the landmarks of each distance");
  }
  std::vector<double> residuals_mm;
  for (const LandmarkDistance& d : distances) residuals_mm.push_back(d.subject_mm - fit.scale * d.model_mm);
  double sum_sq_mm2 = 0.0;
  for (const double residual_mm : residuals_mm) sum_sq_mm2 += residual_mm * residual_mm;
  bench::Estimate& estimate = fit.estimate;
  estimate.names = {"subject.scale"};
  estimate.units = {""};
  estimate.values = Eigen::VectorXd::Constant(1, fit.scale);
  estimate.dof = static_cast<double>(distances.size()) - 1.0;
  estimate.covariance = Eigen::MatrixXd::Constant(1, 1, sum_sq_mm2 / estimate.dof / with_model);
  bench::set_residuals(estimate, residuals_mm, "mm");
  fit.is_nonuniform = most > uneven_ratio * least && estimate.residual_rms > uneven_rms_mm;
  if (fit.is_nonuniform) {
    estimate.remarks.push_back("the distances require scales of " + percent(least) + " to " + percent(most) +
                               ": one scale does not fit; run the pipeline with the subject's bones");
  }
  return fit;
}

namespace {

constexpr std::size_t least_fiducials = 4;
constexpr double fiducial_outlier_sd = 5.0, fiducial_outlier_mm = 5.0;
/// If the mirrored fit is not worse by this factor, the points do not determine the side.
constexpr double mirror_factor = 1.5;

using Matrix6x6 = Eigen::Matrix<double, 6, 6>;

std::string mm_text(double mm)
{
  return bench::text(mm, 2, "mm");
}

/// Fiducials without targets: points of the model and touched positions.
struct Touched {
  std::vector<std::size_t> places;  ///< indices among the marks
  bench::RigidBody model;
  bench::MarkerRow body_mm;
};

Touched touched(std::span<const Fiducial> points, const bench::FitErrorContext& context)
{
  Touched result;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Fiducial& p = points[k];
    if (!p.p_model_mm.allFinite() || !p.p_body_mm.allFinite())
      context.fail(p.name, "a coordinate that is not a finite number", "coordinates in mm", {k});
    if (p.is_target) continue;
    result.places.push_back(k);
    result.body_mm.emplace_back(p.p_body_mm);
  }
  const std::size_t n = result.places.size();
  if (n < least_fiducials || n > static_cast<std::size_t>(bench::max_markers)) {
    context.fail(
        "fiducials", std::to_string(n) + " in the fit",
        std::to_string(least_fiducials) + " to " + std::to_string(bench::max_markers) + ", without targets");
  }
  result.model.markers_mm.resize(static_cast<Eigen::Index>(n), 3);
  Eigen::Index row = 0;
  for (const Fiducial& p : points) {
    if (!p.is_target) result.model.markers_mm.row(row++) = p.p_model_mm.transpose();
  }
  return result;
}

/// Fit without an outlier limit; require_no_outlier() checks outliers.
bench::PoseFit fit_of(const bench::RigidBody& model, const bench::MarkerRow& body_mm)
{
  bench::FitOptions options;
  options.outlier_mm = std::numeric_limits<double>::infinity();
  return bench::fit_pose(model, body_mm, options);
}

void require_spread(const bench::MarkerCloud& cloud, const char* where, const bench::FitErrorContext& context)
{
  if (!(cloud.spread_mm(1) >= bench::least_spread_mm)) {
    context.fail("fiducials",
                 "collinear " + std::string(where) + ": second singular value " + mm_text(cloud.spread_mm(1)),
                 mm_text(bench::least_spread_mm) + " or more; add a fiducial away from the line");
  }
  if (!(cloud.spread_mm(2) >= bench::least_spread_mm)) {
    context.fail("fiducials",
                 "coplanar " + std::string(where) + ": third singular value " + mm_text(cloud.spread_mm(2)) +
                     ", which a mirrored model fits as well",
                 mm_text(bench::least_spread_mm) + " or more; add a fiducial away from the plane");
  }
}

double mirrored_rms_mm(const Touched& points)
{
  bench::RigidBody mirrored = points.model;
  mirrored.markers_mm.col(2) *= -1.0;
  return fit_of(mirrored, points.body_mm).residual_rms_mm;
}

[[noreturn]] void refuse_side(double rms_mm, double mirrored_mm, const std::string& wanted,
                              const bench::FitErrorContext& context)
{
  context.fail("fiducials", "a fit to " + mm_text(rms_mm) + " (rms), mirrored to " + mm_text(mirrored_mm),
               wanted);
}

/// A fiducial compared with a fit to the others.
struct LeftOut {
  double error_mm = 0.0;  ///< length
  /// Standard deviation of a coordinate, from the noise of the others.
  double expected_mm = std::numeric_limits<double>::infinity();
  /// Residual rms of the others; infinite: they do not determine a pose.
  double others_mm = std::numeric_limits<double>::infinity();
};

std::vector<LeftOut> leave_one_out(const Touched& points)
{
  std::vector<LeftOut> result(points.places.size());
  for (std::size_t k = 0; k < result.size(); ++k) {
    bench::MarkerRow others = points.body_mm;
    others[k].reset();
    const Eigen::Vector3d p_model = points.model.markers_mm.row(static_cast<Eigen::Index>(k)).transpose();
    const bench::PoseFit fit = fit_of(points.model, others);
    if (fit.status != bench::FitStatus::fitted) continue;
    const double noise = bench::noise_mm(fit), target = bench::target_error_mm(fit.cloud, noise, p_model);
    result[k] = {(fit.X_tracker_body * p_model - *points.body_mm[k]).norm(),
                 std::sqrt(noise * noise + target * target / 3.0), fit.residual_rms_mm};
  }
  return result;
}

/// Only the fiducial whose removal leaves the best fit can be identified as an outlier.
void require_no_outlier(std::span<const Fiducial> marks, const Touched& points,
                        const std::vector<LeftOut>& out, const bench::FitErrorContext& context)
{
  const auto best = std::ranges::min_element(out, {}, &LeftOut::others_mm);
  const double least_mm = std::max(fiducial_outlier_mm, fiducial_outlier_sd * best->expected_mm);
  if (!(best->error_mm > least_mm)) return;
  const std::size_t place = points.places[static_cast<std::size_t>(best - out.begin())];
  context.fail(marks[place].name, mm_text(best->error_mm) + " from the position predicted by the others",
               mm_text(fiducial_outlier_mm) + " at most; touch it again", {place});
}

/// Standard deviation of a coordinate without the part that a scale of the model explains: the component of
/// the residuals r along the centred positions c; 3 n - 7 degrees of freedom.
double noise_of_any_size_mm(const Touched& points, const bench::PoseFit& fit)
{
  double sum_sq = 0.0, along = 0.0, length_sq = 0.0;
  for (std::size_t k = 0; k < points.places.size(); ++k) {
    const Eigen::Vector3d p_model = points.model.markers_mm.row(static_cast<Eigen::Index>(k)).transpose();
    const Eigen::Vector3d r = *points.body_mm[k] - fit.X_tracker_body * p_model;
    const Eigen::Vector3d c = fit.X_tracker_body.linear() * (p_model - fit.cloud.centre_mm);
    sum_sq += r.squaredNorm();
    along += r.dot(c);
    length_sq += c.squaredNorm();
  }
  const double remainder_sq = std::max(0.0, sum_sq - along * along / length_sq);
  return std::sqrt(remainder_sq / (3.0 * static_cast<double>(points.places.size()) - 7.0));
}

/// Covariance of translation and rotation vector in body axes. The rotation is about the points' centre, so
/// it moves the origin by centre x turn.
Matrix6x6 covariance_of(const bench::PoseFit& fit, double noise)
{
  const bench::PoseError error = bench::expected_error(fit.cloud, noise);
  const Eigen::Matrix3d axes_body = fit.X_tracker_body.linear() * fit.cloud.axes;
  const Eigen::Matrix3d turn = axes_body * error.turn_rad.cwiseAbs2().asDiagonal() * axes_body.transpose();
  const Eigen::Matrix3d cross = cross_matrix(fit.X_tracker_body.linear() * fit.cloud.centre_mm);
  const double centre_mm2 = error.centre_mm * error.centre_mm / 3.0;
  Matrix6x6 covariance;
  covariance << centre_mm2 * Eigen::Matrix3d::Identity() + cross * turn * cross.transpose(), cross * turn,
      turn * cross.transpose(), turn;
  return covariance;
}

/// Residual lengths at the targets or at the fiducials.
std::vector<double> residual_lengths(std::span<const Fiducial> points, const Pose& X_body_model,
                                     bool of_targets)
{
  std::vector<double> lengths;
  for (const Fiducial& p : points) {
    if (p.is_target == of_targets) lengths.push_back((X_body_model * p.p_model_mm - p.p_body_mm).norm());
  }
  return lengths;
}

/// Assumes the same touching noise at targets and fiducials.
double expected_target_rms(std::span<const Fiducial> points, const bench::PoseFit& fit)
{
  const double noise = bench::noise_mm(fit);
  std::vector<double> expected;
  for (const Fiducial& p : points) {
    if (p.is_target)
      expected.push_back(
          std::hypot(std::sqrt(3.0) * noise, bench::target_error_mm(fit.cloud, noise, p.p_model_mm)));
  }
  return bench::rms_of(expected);
}

void add_remarks(FiducialFit& fit, bool has_targets)
{
  std::vector<std::string>& remarks = fit.estimate.remarks;
  remarks.push_back("the fiducials fit to " + mm_text(fit.fiducial_rms_mm) + " (rms), leave-one-out " +
                    mm_text(fit.leave_one_out_rms_mm));
  if (!has_targets) {
    remarks.push_back("no targets: the error away from the fiducials is unknown");
    return;
  }
  remarks.push_back("the targets fit to " + mm_text(fit.target_rms_mm) + " (rms), expected " +
                    mm_text(fit.expected_target_rms_mm));
  if (fit.target_rms_mm > 2.0 * fit.expected_target_rms_mm && fit.target_rms_mm > 1.0)
    remarks.push_back(
        "the target error is more than twice the expected one: the model does not match the body");
}

}  // namespace

FiducialFit fit_fiducials(std::span<const Fiducial> points, const std::string& name, const std::string& file,
                          const FiducialOptions& options)
{
  const bench::FitErrorContext context{"", file};
  const Touched used = touched(points, context);
  bench::RigidBody as_touched = used.model;
  for (std::size_t k = 0; k < used.places.size(); ++k)
    as_touched.markers_mm.row(static_cast<Eigen::Index>(k)) = used.body_mm[k]->transpose();
  require_spread(bench::cloud_of(used.model, used.body_mm), "on the model", context);
  const bench::PoseFit pose = fit_of(used.model, used.body_mm);
  // A wrong side is checked before outliers, because it makes any point look like one. An undetermined side
  // is checked after them, because an outlier degrades every fit.
  const double rms_mm = pose.residual_rms_mm, mirrored_mm = mirrored_rms_mm(used);
  if (rms_mm > mirror_factor * mirrored_mm)
    refuse_side(rms_mm, mirrored_mm, "a model of the same side as the leg, and points in the requested order",
                context);
  const std::vector<LeftOut> out = leave_one_out(used);
  require_no_outlier(points, used, out, context);
  require_spread(bench::cloud_of(as_touched, used.body_mm), "as touched", context);
  if (!(mirrored_mm > mirror_factor * rms_mm))
    refuse_side(rms_mm, mirrored_mm,
                "a worse mirrored fit; touch the points again or add a fiducial away from their plane",
                context);

  FiducialFit fit;
  fit.X_body_model = pose.X_tracker_body;
  fit.fiducial_rms_mm = pose.residual_rms_mm;
  std::vector<double> residuals_mm = residual_lengths(points, fit.X_body_model, false);
  const std::vector<double> at_targets_mm = residual_lengths(points, fit.X_body_model, true);
  fit.target_rms_mm = bench::rms_of(at_targets_mm);
  fit.expected_target_rms_mm = expected_target_rms(points, pose);
  std::vector<double> left_out_mm;
  for (const LeftOut& each : out)
    if (!std::isinf(each.others_mm)) left_out_mm.push_back(each.error_mm);
  fit.leave_one_out_rms_mm = bench::rms_of(left_out_mm);
  const double noise = options.is_size_known ? bench::noise_mm(pose) : noise_of_any_size_mm(used, pose);
  fit.estimate = bench::pose_estimate(name, fit.X_body_model, covariance_of(pose, noise));
  fit.estimate.dof = 3.0 * static_cast<double>(used.places.size()) - (options.is_size_known ? 6.0 : 7.0);
  residuals_mm.insert(residuals_mm.end(), at_targets_mm.begin(), at_targets_mm.end());
  bench::set_residuals(fit.estimate, residuals_mm, "mm");
  add_remarks(fit, !at_targets_mm.empty());
  return fit;
}

FiducialFit mean_adjusted_pose(std::span<const Pose> adjusted, const std::string& name,
                               const std::string& file)
{
  const bench::FitErrorContext context{"", file};
  if (adjusted.size() < 2) {
    context.fail(name, std::to_string(adjusted.size()) + " adjusted poses",
                 "two or more, because their spread gives the uncertainty");
  }
  const double n = static_cast<double>(adjusted.size());
  FiducialFit fit;
  fit.X_body_model = adjusted.front();
  // Karcher mean of the rotations: one iteration suffices for rotations within about a degree, a dozen for
  // rotations within 90 degrees.
  constexpr int most_rounds = 50;
  constexpr double resolution_rad = 1e-14;
  for (int round = 0; round < most_rounds; ++round) {
    Eigen::Vector3d mean_turn = Eigen::Vector3d::Zero();
    for (const Pose& X : adjusted)
      mean_turn += bench::turn_of(X.linear() * fit.X_body_model.linear().transpose()) / n;
    fit.X_body_model.linear() = (bench::rotation_of(mean_turn) * fit.X_body_model.linear()).eval();
    if (mean_turn.norm() < resolution_rad) break;
  }
  fit.X_body_model.translation().setZero();
  for (const Pose& X : adjusted) fit.X_body_model.translation() += X.translation() / n;

  Matrix6x6 covariance = Matrix6x6::Zero();
  std::vector<double> off_mm;
  for (const Pose& X : adjusted) {
    Eigen::Matrix<double, 6, 1> off;
    off << X.translation() - fit.X_body_model.translation(),
        bench::turn_of(X.linear() * fit.X_body_model.linear().transpose());
    covariance += off * off.transpose() / (n * (n - 1.0));
    off_mm.push_back(off.head<3>().norm());
  }
  fit.estimate = bench::pose_estimate(name, fit.X_body_model, covariance);
  fit.estimate.dof = n - 1.0;
  bench::set_residuals(fit.estimate, off_mm, "mm");
  return fit;
}

}  // namespace vrda::calibration
