// Inter-pupillary distance from the rectangles that each eye aligned.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/eyepoint_fit.hpp"
#include "calibration/linear_algebra.hpp"
#include "core/error.hpp"

namespace vrda::calibration {
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

}  // namespace vrda::calibration
