#include "compare/compare.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/left_out.hpp"
#include "compare/perceptible.hpp"
#include "compare/roughness.hpp"
#include "core/error.hpp"

namespace vrda {
namespace {

constexpr std::size_t n_lengths = 3;  ///< tx, ty and tz come first; the others are angles

std::vector<SurfaceRow> surface_rows(const SmoothedSet& set, const AxisRanges& ranges)
{
  std::vector<SurfaceRow> rows;
  for (const SmoothedSurface& s : set.surfaces) {
    rows.push_back({s.name,
                    s.n_cells,
                    s.condition_number,
                    {s.rms, s.largest_residual, s.leave_one_out_rms, roughness(set, s, ranges)}});
  }
  return rows;
}

/// Residual of the translation at a cell, mm; what recontact moves is taken off.
Eigen::Vector3d translation_residual(const SmoothFit& fit, Eigen::Index i, Eigen::Index j)
{
  return {fit.residual[0](i, j), fit.residual[1](i, j), fit.residual[2](i, j)};
}

ErrorMeasures translation_of(const SmoothFit& fit, const std::vector<SurfaceRow>& rows)
{
  const auto together = [&](double ErrorMeasures::*measure) {
    double sum_sq = 0.0;
    for (std::size_t s = 0; s < n_lengths; ++s) sum_sq += rows[s].errors.*measure * rows[s].errors.*measure;
    return std::sqrt(sum_sq);
  };
  ErrorMeasures length{together(&ErrorMeasures::rms), 0.0, together(&ErrorMeasures::leave_one_out),
                       together(&ErrorMeasures::roughness)};
  for (Eigen::Index i = 0; i < fit.residual[0].rows(); ++i) {
    for (Eigen::Index j = 0; j < fit.residual[0].cols(); ++j) {
      const double norm_mm = translation_residual(fit, i, j).norm();
      if (norm_mm > length.largest) length.largest = norm_mm;  // false of NaN
    }
  }
  return length;
}

/// Of the pose shown at cell (i, j).
bool is_perceptible(const MotionModel& model, const SmoothFit& fit, Eigen::Index i, Eigen::Index j)
{
  Eigen::Vector3d off_mm = translation_residual(fit, i, j);
  // Nothing in the way: nothing to move to.
  if (fit.set.recontact_mm && !std::isnan((*fit.set.recontact_mm)(i, j)))
    off_mm -= (*fit.set.recontact_mm)(i, j) * model.push.delta.row(i).transpose();
  if (off_mm.norm() > perceptible_mm) return true;
  for (std::size_t s = n_lengths; s < fit.residual.size(); ++s) {
    if (std::abs(fit.residual[s](i, j)) > perceptible_deg) return true;  // false of NaN
  }
  return false;
}

double perceptible_share(const MotionModel& model, const SmoothFit& fit)
{
  int n_cells = 0, n_perceptible = 0;
  for (Eigen::Index i = 0; i < fit.residual[0].rows(); ++i) {
    for (Eigen::Index j = 0; j < fit.residual[0].cols(); ++j) {
      if (std::isnan(fit.residual[0](i, j))) continue;
      ++n_cells;
      n_perceptible += is_perceptible(model, fit, i, j) ? 1 : 0;
    }
  }
  return static_cast<double>(n_perceptible) / static_cast<double>(n_cells);
}

/// `model` holds nothing smoothed yet; it gets the set, so that the audit finds its motion.
DegreeRow row_of(MotionModel& model, SmoothFit& fit, const CompareOptions& options)
{
  if (options.recontact) fit.set.recontact_mm = options.recontact(model, fit.set);
  DegreeRow row;
  row.surfaces = surface_rows(fit.set, axis_ranges(model.flexion_deg, model.varus_deg));
  row.translation = translation_of(fit, row.surfaces);
  row.is_converged =
      std::find(fit.is_converged.begin(), fit.is_converged.end(), false) == fit.is_converged.end();
  row.perceptible_share = perceptible_share(model, fit);
  row.set = fit.set;
  if (!options.audit) return row;
  model.smoothed = {fit.set};
  const std::string motion =
      "degree_" + std::to_string(fit.set.degree) + (options.recontact ? "_recontacted" : "");
  row.faults = faults_of(model, options.audit(model, motion));
  model.smoothed.clear();
  return row;
}

void require_rising(const std::vector<int>& degrees)
{
  check(!degrees.empty(), "compare needs a degree");
  for (std::size_t k = 1; k < degrees.size(); ++k) check(degrees[k - 1] < degrees[k], "degrees rise");
}

}  // namespace

Comparison compare(const MotionModel& model, const CompareOptions& options)
{
  require_rising(options.degrees);
  const SmoothInput input = smooth_input(model, options.name);
  const int carried = largest_degree(input, options.degrees.back());
  Comparison comparison;
  std::vector<SmoothFit> fits;
  for (const int degree : options.degrees) {
    // The lowest is tried in any case: it says what is wrong.
    if (degree > carried && degree != options.degrees.front()) {
      comparison.degrees_not_carried.push_back(degree);
    } else {
      fits.push_back(smooth_fit(input, degree, options.smooth));
    }
  }
  MotionModel bare = model;
  bare.smoothed.clear();
  for (SmoothFit& fit : fits) comparison.rows.push_back(row_of(bare, fit, options));
  comparison.recommendation = recommend(degree_errors(fits));
  return comparison;
}

}  // namespace vrda
