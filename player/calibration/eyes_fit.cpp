#include "calibration/eyes_fit.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/rigid_body.hpp"
#include "calibration/least_squares.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

/// Order of the prior numbers of the eyes, as in the estimate.
enum Known : Eigen::Index {
  left_distance,
  right_distance,
  ipd,
  depth_apart,
  height_apart,
  left_sight_x,
  left_sight_y,
  right_sight_x,
  right_sight_y,
  left_optics,                     // k1, k2, centre_x, centre_y, pixel_aspect
  right_optics = left_optics + 5,  // the same
  n_known = right_optics + 5
};

constexpr Eigen::Index n_pose = 6;  // shift (mm), turn (rad) about the fixed axes

Eigen::VectorXd known_of(const view::EyePair& eyes)
{
  const Eigen::Vector3d apart = eyes.left.position_head_mm - eyes.right.position_head_mm;
  Eigen::VectorXd known(+n_known);
  known << eyes.left.distance_px, eyes.right.distance_px, -apart.x(), apart.z(), apart.y(),
      eyes.left.sight_px, eyes.right.sight_px, Eigen::VectorXd::Zero(10);
  for (const Known optics : {left_optics, right_optics}) {
    const view::Eye& eye = optics == left_optics ? eyes.left : eyes.right;
    known.segment<5>(optics) << eye.distortion.k1, eye.distortion.k2, eye.distortion.centre_px,
        eye.pixel_aspect;
  }
  return known;
}

view::EyePair eyes_of(const view::EyePair& like, const Eigen::VectorXd& known)
{
  view::EyePair eyes = like;
  const Eigen::Vector3d half_apart =
      0.5 * Eigen::Vector3d(-known[ipd], known[height_apart], known[depth_apart]);
  const auto set = [&](view::Eye& eye, Known distance, Known sight, Known optics) {
    eye.distance_px = known[distance];
    eye.sight_px = known.segment<2>(sight);
    eye.distortion.k1 = known[optics];
    eye.distortion.k2 = known[optics + 1];
    eye.distortion.centre_px = known.segment<2>(optics + 2);
    eye.pixel_aspect = eye.distortion.pixel_aspect = known[optics + 4];
  };
  set(eyes.left, left_distance, left_sight_x, left_optics);
  set(eyes.right, right_distance, right_sight_x, right_optics);
  eyes.left.position_head_mm = half_apart;
  eyes.right.position_head_mm = -half_apart;
  return eyes;
}

Eigen::MatrixXd covariance_of(const EyesPrior& prior)
{
  // columns: left distance, depth, right distance, depth; z increases with depth
  Eigen::Matrix<double, 3, 4> of_eyepoints = Eigen::Matrix<double, 3, 4>::Zero();
  of_eyepoints(0, 0) = of_eyepoints(1, 2) = of_eyepoints(2, 1) = 1.0;
  of_eyepoints(2, 3) = -1.0;
  const Eigen::MatrixXd eyepoints = propagated(of_eyepoints, prior.eyepoint_covariance);
  const std::array<Eigen::Index, 3> at = {left_distance, right_distance, depth_apart};
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n_known, n_known);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      covariance(at[i], at[j]) = eyepoints(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }
  covariance(ipd, ipd) = prior.ipd_sd_mm * prior.ipd_sd_mm;
  covariance(height_apart, height_apart) = prior.height_difference_sd_mm * prior.height_difference_sd_mm;
  covariance.diagonal().segment<4>(left_sight_x).setConstant(prior.sight_sd_px * prior.sight_sd_px);
  const std::array<Known, 2> optics = {left_optics, right_optics};
  for (std::size_t eye = 0; eye < 2; ++eye) {
    const Eigen::MatrixXd& known = prior.distortion_covariance[eye];
    if (known.size() == 0) continue;
    covariance.block<5, 5>(optics[eye], optics[eye]) = known;
    const auto first = static_cast<Eigen::Index>(2 * eye);
    const Eigen::MatrixXd shared =
        product(product(of_eyepoints.middleCols<2>(first), prior.eyepoint_distortion_jacobian[eye]), known);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto row = shared.row(static_cast<Eigen::Index>(i));
      covariance.block<1, 5>(at[i], optics[eye]) = row;
      covariance.block<5, 1>(optics[eye], at[i]) = row.transpose();
    }
  }
  return covariance;
}

/// Clamps a point to at least 1 mm in front of the eye; iterates may be behind it.
Eigen::Vector3d before_eye(const view::Eye& eye, const Eigen::Vector3d& p_head_mm)
{
  constexpr double nearest_mm = 1.0;
  return {p_head_mm.x(), p_head_mm.y(), std::min(p_head_mm.z(), eye.position_head_mm.z() - nearest_mm)};
}

struct EyesProblem {
  std::span<const BullseyeMark> marks;
  const EyesPrior& prior;
  Eigen::VectorXd known;  ///< [n_known] prior mean
  Eigen::MatrixXd L;      ///< deviation from the prior mean = L z, z of unit variance
};

const view::Eye& eye_of(const view::EyePair& eyes, const BullseyeMark& mark)
{
  return mark.is_right ? eyes.right : eyes.left;
}

/// Current estimate: pose and numbers of the eyes, noise of the marks.
struct EyesGuess {
  Pose X_carrier_eyes;
  Eigen::VectorXd z;  ///< normalised deviation from the prior
  double noise_px = initial_noise_px;
};

view::EyePair eyes_of(const EyesProblem& problem, const Eigen::VectorXd& z)
{
  return eyes_of(problem.prior.eyes, problem.known + transformed(problem.L, z));
}

/// Tracker noise of each mark on the screen, px, root mean square of both coordinates.
Eigen::VectorXd tracker_sds_px(const EyesProblem& problem, const EyesGuess& guess)
{
  constexpr double step_mm = 0.5;  // optics and perspective are linear over this step
  const view::EyePair eyes = eyes_of(problem, guess.z);
  const Pose X_eyes_carrier = guess.X_carrier_eyes.inverse();
  Eigen::VectorXd sds(static_cast<Eigen::Index>(problem.marks.size()));
  for (Eigen::Index i = 0; i < sds.size(); ++i) {
    const BullseyeMark& mark = problem.marks[static_cast<std::size_t>(i)];
    const view::Eye& eye = eye_of(eyes, mark);
    const Eigen::Vector3d p_head_mm = X_eyes_carrier * mark.p_carrier_mm;
    double sum_sq = 0.0;  // (px / mm)^2
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = step_mm * Eigen::Vector3d::Unit(axis);
      sum_sq += (view::drawn_px(eye, before_eye(eye, p_head_mm + step)) -
                 view::drawn_px(eye, before_eye(eye, p_head_mm - step)))
                    .squaredNorm() /
                (4.0 * step_mm * step_mm);
    }
    sds[i] = mark.p_sd_mm * std::sqrt(0.5 * sum_sq);
  }
  return sds;
}

/// Residuals of the marks in units of their standard deviations, then of the prior.
Eigen::VectorXd residuals(const EyesProblem& problem, const Pose& X_start, const Eigen::VectorXd& sds_px,
                          const Eigen::VectorXd& x)
{
  const Eigen::VectorXd z = x.tail(x.size() - n_pose);
  const view::EyePair eyes = eyes_of(problem, z);
  const Pose X_eyes_carrier = bench::moved(X_start, x.head<n_pose>()).inverse();
  const auto n = static_cast<Eigen::Index>(problem.marks.size());
  Eigen::VectorXd r(2 * n + z.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const BullseyeMark& mark = problem.marks[static_cast<std::size_t>(i)];
    const view::Eye& eye = eye_of(eyes, mark);
    const Eigen::Vector3d p_head_mm = before_eye(eye, X_eyes_carrier * mark.p_carrier_mm);
    r.segment<2>(2 * i) = (view::drawn_px(eye, p_head_mm) - mark.drawn_px) / sds_px[i];
  }
  r.tail(z.size()) = z;
  return r;
}

/// Start pose: minimises the distances of the markers from the lines of sight of their marks. Unlike
/// distances on the screen, these have no singularity.
Pose start_of(const EyesProblem& problem, const Pose& X_guess)
{
  const view::EyePair& eyes = problem.prior.eyes;
  const auto n = static_cast<Eigen::Index>(problem.marks.size());
  Eigen::Matrix2Xd tangents(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const BullseyeMark& mark = problem.marks[static_cast<std::size_t>(i)];
    const view::Eye& eye = eye_of(eyes, mark);
    const Eigen::Vector2d aside = view::shown_px(eye.distortion, mark.drawn_px) - eye.sight_px;
    tangents.col(i) = Eigen::Vector2d(aside.x(), -eye.pixel_aspect * aside.y()) / eye.distance_px;
  }
  FitProblem least;
  least.start = Eigen::VectorXd::Zero(n_pose);
  least.scale.resize(n_pose);
  least.scale << 10.0, 10.0, 10.0, 0.1, 0.1, 0.1;
  least.residuals = [&](const Eigen::VectorXd& x) {
    const Pose X_eyes_carrier = bench::moved(X_guess, x).inverse();
    Eigen::VectorXd r(2 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const BullseyeMark& mark = problem.marks[static_cast<std::size_t>(i)];
      const Eigen::Vector3d p = X_eyes_carrier * mark.p_carrier_mm - eye_of(eyes, mark).position_head_mm;
      r.segment<2>(2 * i) = p.head<2>() + p.z() * tangents.col(i);
    }
    return r;
  };
  return bench::moved(X_guess, fit_least_squares(least).x);
}

/// Alignment noise for which the weighted sum of squares equals the degrees of freedom.
double noise_px_of(const Eigen::VectorXd& residual_px, const Eigen::VectorXd& tracker_px, double dof)
{
  const auto excess = [&](double noise_px) {
    double sum = -dof;
    for (Eigen::Index i = 0; i < tracker_px.size(); ++i) {
      sum +=
          residual_px.segment<2>(2 * i).squaredNorm() / (noise_px * noise_px + tracker_px[i] * tracker_px[i]);
    }
    return sum;
  };
  double low = minimum_noise_px, high = minimum_noise_px;
  while (excess(high) > 0.0) high *= 2.0;
  if (high == low) return low;
  constexpr int n_halvings = 40;
  for (int i = 0; i < n_halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0.0 ? low : high) = middle;
  }
  return high;
}

struct EyesSolution : MarksFit {
  EyesGuess guess;
};

/// Repeats the fit, each time weighted with the noise estimated by the previous one.
EyesSolution solve_eyes(const EyesProblem& problem, const Pose& X_guess)
{
  constexpr int n_rounds = 4;
  const auto n = static_cast<Eigen::Index>(problem.marks.size());
  EyesSolution solution;
  solution.guess = {start_of(problem, X_guess), Eigen::VectorXd::Zero(problem.L.cols()), initial_noise_px};
  FitProblem least;
  // Difference steps are 1e-6 of the scale: 1e-4 mm, 1e-6 rad, 1e-4 of a standard deviation. Drawn positions
  // have a rounding error of 1e-12 px, which matters for smaller steps and small noise.
  constexpr double scale = 100.0;
  least.scale = Eigen::VectorXd::Constant(n_pose + problem.L.cols(), scale);
  least.scale.segment<3>(3).setConstant(0.01 * scale);
  for (int round = 0; round < n_rounds; ++round) {
    EyesGuess& guess = solution.guess;
    const Eigen::VectorXd tracker_px = tracker_sds_px(problem, guess);
    solution.sds_px = (tracker_px.array().square() + guess.noise_px * guess.noise_px).sqrt();
    least.start = Eigen::VectorXd::Zero(least.scale.size());
    least.start.tail(guess.z.size()) = guess.z;
    const Pose X_start = guess.X_carrier_eyes;
    least.residuals = [&](const Eigen::VectorXd& x) {
      return residuals(problem, X_start, solution.sds_px, x);
    };
    solution.fit = fit_least_squares(least);
    guess.X_carrier_eyes = bench::moved(X_start, solution.fit.x.head<n_pose>());
    guess.z = solution.fit.x.tail(guess.z.size());
    if (solution.fit.status != LeastSquaresStatus::converged || round + 1 == n_rounds) break;
    Eigen::VectorXd residual_px = solution.fit.residuals.head(2 * n);
    for (Eigen::Index i = 0; i < n; ++i) residual_px.segment<2>(2 * i) *= solution.sds_px[i];
    guess.noise_px = noise_px_of(residual_px, tracker_px, noise_dof(solution.fit, n));
  }
  return solution;
}

void require_marks(std::span<const BullseyeMark> marks, const bench::FitErrorContext& context)
{
  constexpr std::ptrdiff_t fewest = 6;
  for (const bool is_right : {false, true}) {
    const std::ptrdiff_t n = std::ranges::count(marks, is_right, &BullseyeMark::is_right);
    if (n >= fewest) continue;
    context.fail(is_right ? ": right eye" : ": left eye", std::to_string(n) + " aligned bull's-eyes",
                 "6 or more for each eye");
  }
}

double extent(const Eigen::VectorXd& along)
{
  return along.maxCoeff() - along.minCoeff();
}

/// Positions at one depth do not separate translation from rotation; positions on a line leave the rotation
/// about it undetermined.
void require_spread(std::span<const BullseyeMark> marks, const Pose& X_guess,
                    const bench::FitErrorContext& context)
{
  constexpr double least_mm = 50.0;
  Eigen::MatrixX3d p(marks.size(), 3);
  for (std::size_t i = 0; i < marks.size(); ++i)
    p.row(static_cast<Eigen::Index>(i)) = (X_guess.inverse() * marks[i].p_carrier_mm).transpose();
  const auto require = [&](double found_mm, const std::string& how, const std::string& wanted) {
    if (found_mm < least_mm)
      context.fail(": marker positions", how + " (" + bench::text(found_mm, 0, "mm") + ")", wanted);
  };
  const Eigen::MatrixX3d from_mean = p.rowwise() - p.colwise().mean();
  const Eigen::MatrixXd scatter = square(from_mean.transpose());
  const Eigen::MatrixXd axes = principal_axes(scatter).vectors,
                        across = principal_axes(scatter.topLeftCorner(2, 2)).vectors;
  const double depth_mm = extent(p.col(2));
  const double across_mm = extent(transformed(from_mean.leftCols<2>(), across.col(0)));
  const double off_line_mm = extent(transformed(from_mean, axes.col(1)));
  require(depth_mm, "all at one depth", "nearer and further positions, 50 mm apart or more");
  require(across_mm, "all straight ahead", "positions to the left and to the right, 50 mm apart or more");
  require(off_line_mm, "all on a line", "positions 50 mm or more away from the line");
}

/// ": bull's-eye 3 of the left eye"
std::string field_of(std::span<const BullseyeMark> marks, std::size_t mark)
{
  const bool is_right = marks[mark].is_right;
  const auto before = std::ranges::count(marks.first(mark), is_right, &BullseyeMark::is_right);
  return ": bull's-eye " + std::to_string(before + 1) + " of the " + (is_right ? "right" : "left") + " eye";
}

bench::Estimate estimate_of(const EyesProblem& problem, const EyesSolution& solution, const std::string& name)
{
  const Eigen::MatrixXd& C = solution.fit.covariance;
  bench::Estimate estimate =
      bench::pose_estimate(name, solution.guess.X_carrier_eyes, C.topLeftCorner<n_pose, n_pose>());
  for (const char* known : {"left.distance", "right.distance", "ipd", "depth_apart", "height_apart",
                            "left.sight_x", "left.sight_y", "right.sight_x", "right.sight_y"}) {
    estimate.names.emplace_back(known);
  }
  estimate.units.insert(estimate.units.end(), {"px", "px", "mm", "mm", "mm", "px", "px", "px", "px"});
  for (const std::string eye : {"left", "right"}) {
    for (const char* number : {".k1", ".k2", ".centre_x", ".centre_y", ".pixel_aspect"}) {
      estimate.names.push_back(eye + number);
    }
    estimate.units.insert(estimate.units.end(), {"", "", "px", "px", ""});
  }
  Eigen::VectorXd values(n_pose + n_known);
  values << estimate.values, problem.known + transformed(problem.L, solution.guess.z);
  estimate.values = values;
  // Maps the unknowns (pose in mm and rad, z) to the reported numbers (degrees, prior numbers).
  Eigen::MatrixXd to_numbers = Eigen::MatrixXd::Zero(n_pose + n_known, C.rows());
  to_numbers.topLeftCorner<n_pose, n_pose>().setIdentity();
  to_numbers.diagonal().segment<3>(3).setConstant(deg_from_rad(1.0));
  to_numbers.bottomRightCorner(n_known, problem.L.cols()) = problem.L;
  estimate.covariance = propagated(to_numbers, C);
  estimate.dof = interval_dof(solution.fit, solution.n(), to_numbers);
  bench::set_residuals(estimate, solution.residuals_px(), "px");
  return estimate;
}

}  // namespace

EyesFit fit_eyes(std::span<const BullseyeMark> marks, const EyesPrior& prior, const Pose& X_start,
                 const std::string& name, const std::string& file)
{
  const bench::FitErrorContext context{name, file};
  require_marks(marks, context);
  require_spread(marks, X_start, context);
  const EyesProblem problem{marks, prior, known_of(prior.eyes), root_of(covariance_of(prior))};
  const EyesSolution solution = solve_eyes(problem, X_start);
  require_converged(solution.fit, "", "a bull's-eye fit",
                    "bull's-eyes aligned with the tracked marker at different positions", context);
  refuse_outlier(
      solution, {6.0, 4.0, "align this one again"}, [&](std::size_t mark) { return field_of(marks, mark); },
      context);
  EyesFit result;
  result.X_carrier_eyes = solution.guess.X_carrier_eyes;
  result.eyes = eyes_of(problem, solution.guess.z);
  result.noise_px = solution.guess.noise_px;
  result.estimate = estimate_of(problem, solution, name);
  result.estimate.remarks.push_back("bull's-eyes scatter by " + bench::text(result.noise_px, 2, "px"));
  return result;
}

// A first pose of the eyes in the head's frame, from bullseye marks: the start of the fit.

namespace {

/// Line of sight of a mark, in the frame of the eyes.
struct Sight {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();   ///< unit
  Eigen::Matrix3d across = Eigen::Matrix3d::Zero();  ///< projects onto the plane across the line
  Eigen::Vector3d p_carrier_mm = Eigen::Vector3d::Zero();
};

std::vector<Sight> sights_of(std::span<const BullseyeMark> marks, const view::EyePair& eyes)
{
  std::vector<Sight> sights;
  for (const BullseyeMark& mark : marks) {
    const view::Eye& eye = mark.is_right ? eyes.right : eyes.left;
    const Eigen::Vector2d off_px = view::shown_px(eye.distortion, mark.drawn_px) - eye.sight_px;
    Sight sight;
    sight.from_mm = eye.position_head_mm;
    sight.along = Eigen::Vector3d(off_px.x(), -eye.pixel_aspect * off_px.y(), -eye.distance_px).normalized();
    sight.across = Eigen::Matrix3d::Identity() - sight.along * sight.along.transpose();
    sight.p_carrier_mm = mark.p_carrier_mm;
    sights.push_back(sight);
  }
  return sights;
}

struct PoseCandidate {
  Pose X_eyes_carrier = Pose::Identity();
  double error_mm2 = std::numeric_limits<double>::infinity();
  bool is_in_front = false;
};

/// Sets the least-squares translation for the rotation of X_eyes_carrier.
void set_translation(const std::vector<Sight>& sights, const Eigen::Matrix3d& inverse, Pose& X_eyes_carrier)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Sight& s : sights) sum += s.across * (s.from_mm - X_eyes_carrier.linear() * s.p_carrier_mm);
  X_eyes_carrier.translation() = inverse * sum;
}

PoseCandidate iterate_from(const std::vector<Sight>& sights, const Eigen::Matrix3d& turn, int n_iterations)
{
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
  for (const Sight& s : sights) {
    sum += s.across;
    mean_mm += s.p_carrier_mm / static_cast<double>(sights.size());
  }
  const Eigen::Matrix3d inverse = sum.inverse();
  PoseCandidate candidate;
  Pose& X = candidate.X_eyes_carrier;
  X.linear() = turn;
  set_translation(sights, inverse, X);
  for (int iteration = 0; iteration < n_iterations; ++iteration) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    for (const Sight& s : sights) {
      const Eigen::Vector3d on_sight_mm = s.from_mm + s.along * s.along.dot(X * s.p_carrier_mm - s.from_mm);
      H += on_sight_mm * (s.p_carrier_mm - mean_mm).transpose();
    }
    X.linear() = bench::nearest_rotation(H);
    set_translation(sights, inverse, X);
  }
  candidate.error_mm2 = 0.0;
  candidate.is_in_front = true;
  for (const Sight& s : sights) {
    const Eigen::Vector3d ray = X * s.p_carrier_mm - s.from_mm;
    candidate.error_mm2 += (s.across * ray).squaredNorm();
    candidate.is_in_front = candidate.is_in_front && s.along.dot(ray) > 0.0;
  }
  return candidate;
}

/// The 24 rotations that map a cube onto itself.
std::vector<Eigen::Matrix3d> cube_rotations()
{
  std::vector<Eigen::Matrix3d> turns;
  for (const int x : {0, 1, 2}) {
    for (const int y : {0, 1, 2}) {
      for (int signs = 0; x != y && signs < 4; ++signs) {
        const Eigen::Vector3d first = (signs % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(x);
        const Eigen::Vector3d second = (signs / 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(y);
        Eigen::Matrix3d turn;
        turn << first, second, first.cross(second);
        turns.push_back(turn);
      }
    }
  }
  return turns;
}

}  // namespace

Pose initial_eye_pose(std::span<const BullseyeMark> marks, const view::EyePair& eyes)
{
  constexpr std::size_t least_marks = 3;
  if (marks.size() < least_marks) return Pose::Identity();
  const std::vector<Sight> sights = sights_of(marks, eyes);
  // A few iterations from each rotation select the best one, which is then refined.
  constexpr int n_selecting = 20, n_refining = 200;
  PoseCandidate best;
  for (const Eigen::Matrix3d& turn : cube_rotations()) {
    const PoseCandidate candidate = iterate_from(sights, turn, n_selecting);
    const bool is_better = candidate.is_in_front == best.is_in_front ? candidate.error_mm2 < best.error_mm2
                                                                     : candidate.is_in_front;
    if (is_better) best = candidate;
  }
  return iterate_from(sights, best.X_eyes_carrier.linear(), n_refining).X_eyes_carrier.inverse();
}

}  // namespace vrda::calibration
