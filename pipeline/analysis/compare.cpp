#include "analysis/compare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "analysis/recommend.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda::analysis {
namespace {

bool is_stable(const store::MotionModel& model, Eigen::Index i, Eigen::Index j)
{
  return model.status(i, j) == status_stable;
}

/// True if the one, two or four cells around attitude (i, j) of the refined grid are solved.
bool is_surrounded(const store::MotionModel& model, Eigen::Index i, Eigen::Index j, Eigen::Index refine)
{
  for (const Eigen::Index row : {i / refine, (i + refine - 1) / refine}) {
    for (const Eigen::Index column : {j / refine, (j + refine - 1) / refine}) {
      if (!is_stable(model, row, column)) return false;
    }
  }
  return true;
}

/// Maximum that ignores NaN.
void update_largest(double& largest, double value)
{
  if (std::isnan(largest) || value > largest) largest = value;
}

void include(AuditTotals& faults, store::AuditState state, double gap_mm, double penetration_mm)
{
  if (state == store::AuditState::no_pose) return;
  ++faults.n_attitudes;
  if (state == store::AuditState::overlapping) ++faults.n_overlapping;
  if (state == store::AuditState::nothing_ahead) ++faults.n_nothing_ahead;
  update_largest(faults.largest_penetration_mm, penetration_mm);
  update_largest(faults.largest_gap_mm, gap_mm);
}

}  // namespace

MotionAuditTotals motion_audit_totals(const store::MotionModel& model, const store::AuditSet& audit)
{
  const auto refine = static_cast<Eigen::Index>(audit.refine);
  check(refine >= 1 && audit.state.rows() == (model.status.rows() - 1) * refine + 1 &&
            audit.state.cols() == (model.status.cols() - 1) * refine + 1,
        "an audit of a smoothed motion refines the grid of the model");
  MotionAuditTotals result;
  for (AuditTotals* faults : {&result.at_grid, &result.between})
    faults->largest_penetration_mm = faults->largest_gap_mm = nan;
  for (Eigen::Index i = 0; i < audit.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < audit.state.cols(); ++j) {
      if (!is_surrounded(model, i, j, refine)) continue;
      const bool is_of_grid = i % refine == 0 && j % refine == 0;
      include(is_of_grid ? result.at_grid : result.between, static_cast<store::AuditState>(audit.state(i, j)),
              audit.gap_mm(i, j), audit.penetration_mm(i, j));
    }
  }
  return result;
}

namespace {

/// Coefficient (i, j) of P_i(u) P_j(v).
using Series = Eigen::MatrixXd;

/// d/du: P'_n = (2n - 1) P_{n-1} + (2n - 5) P_{n-3} + ...
Series derivative_by_rows(const Series& series)
{
  Series derivative = Series::Zero(series.rows(), series.cols());
  for (Eigen::Index n = 1; n < series.rows(); ++n) {
    for (Eigen::Index k = n - 1; k >= 0; k -= 2) {
      for (Eigen::Index j = 0; j < series.cols(); ++j)
        derivative(k, j) += static_cast<double>(2 * k + 1) * series(n, j);
    }
  }
  return derivative;
}

Series derivative_by_columns(const Series& series)
{
  return derivative_by_rows(series.transpose()).transpose();
}

/// Mean of the square over [-1, 1]^2: that of P_i is 1 / (2i + 1).
double mean_square(const Series& series)
{
  double sum = 0.0;
  for (Eigen::Index i = 0; i < series.rows(); ++i) {
    for (Eigen::Index j = 0; j < series.cols(); ++j)
      sum += series(i, j) * series(i, j) / static_cast<double>((2 * i + 1) * (2 * j + 1));
  }
  return sum;
}

Series series_of(const store::SmoothedSet& set, const store::SmoothedSurface& surface)
{
  check(static_cast<Eigen::Index>(surface.coefficients.size()) == set.exponents.rows(),
        "one coefficient per term");
  Series series = Series::Zero(set.degree + 1, set.degree + 1);
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k)
    series(set.exponents(k, 0), set.exponents(k, 1)) = surface.coefficients[static_cast<std::size_t>(k)];
  return series;
}

/// du/dx; 0 where the axis has one value.
double slope(const store::AxisRange& range)
{
  return range.first_deg == range.last_deg ? 0.0 : 2.0 / (range.last_deg - range.first_deg);
}

}  // namespace

double roughness(const store::SmoothedSet& set, const store::SmoothedSurface& surface,
                 const store::AxisRanges& ranges)
{
  const Series series = series_of(set, surface);
  const double f = slope(ranges.flexion), w = slope(ranges.varus);
  const Series by_flexion = derivative_by_rows(series) * f, by_varus = derivative_by_columns(series) * w;
  return std::sqrt(mean_square(derivative_by_rows(by_flexion) * f) +
                   2.0 * mean_square(derivative_by_columns(by_flexion) * w) +
                   mean_square(derivative_by_columns(by_varus) * w));
}

double flexion_roughness(const store::SmoothedSet& set, const store::SmoothedSurface& surface,
                         const store::AxisRanges& ranges)
{
  const double f = slope(ranges.flexion);
  return std::sqrt(mean_square(derivative_by_rows(derivative_by_rows(series_of(set, surface)) * f) * f));
}

namespace {

constexpr std::size_t n_lengths = 3;  ///< tx, ty and tz come first; the others are angles

std::vector<SurfaceRow> surface_rows(const store::SmoothedSet& set, const store::AxisRanges& ranges)
{
  std::vector<SurfaceRow> rows;
  for (const store::SmoothedSurface& s : set.surfaces) {
    rows.push_back({s.name,
                    s.n_cells,
                    s.condition_number,
                    {s.rms, s.largest_residual, s.leave_one_out_rms, roughness(set, s, ranges)}});
  }
  return rows;
}

/// Residual of the translation at a cell, mm, before recontact.
Eigen::Vector3d translation_residual(const analysis::SmoothFit& fit, Eigen::Index i, Eigen::Index j)
{
  return {fit.residual[0](i, j), fit.residual[1](i, j), fit.residual[2](i, j)};
}

ErrorMeasures translation_of(const analysis::SmoothFit& fit, const std::vector<SurfaceRow>& rows)
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
      if (norm_mm > length.largest) length.largest = norm_mm;  // false for NaN
    }
  }
  return length;
}

/// Whether the error of the displayed pose at cell (i, j) is perceptible.
bool is_perceptible(const store::MotionModel& model, const analysis::SmoothFit& fit, Eigen::Index i,
                    Eigen::Index j)
{
  Eigen::Vector3d error_mm = translation_residual(fit, i, j);
  // NaN: no contact ahead, no travel.
  if (fit.set.recontact_mm && !std::isnan((*fit.set.recontact_mm)(i, j)))
    error_mm -= (*fit.set.recontact_mm)(i, j) * model.push.delta.row(i).transpose();
  if (error_mm.norm() > perceptible_mm) return true;
  for (std::size_t s = n_lengths; s < fit.residual.size(); ++s) {
    if (std::abs(fit.residual[s](i, j)) > perceptible_unit(s)) return true;  // false for NaN
  }
  return false;
}

double perceptible_share(const store::MotionModel& model, const analysis::SmoothFit& fit)
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

double second_difference(const store::SmoothedSet& set, const store::AxisRanges& ranges)
{
  double sum_sq = 0.0;
  for (std::size_t s = 0; s < set.surfaces.size(); ++s) {
    const double one = flexion_roughness(set, set.surfaces[s], ranges) / perceptible_unit(s);
    sum_sq += one * one;
  }
  return std::sqrt(sum_sq);
}

/// Index of the fit with the smallest leave-one-out error; the first if no cell can be omitted.
std::size_t best_fit(const std::vector<analysis::SmoothFit>& fits)
{
  std::vector<std::vector<store::GridD>> left_out;
  for (const analysis::SmoothFit& fit : fits) left_out.push_back(fit.leave_one_out);
  const std::vector<std::vector<double>> errors_sq = left_out_errors(fits, left_out);
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < fits.size(); ++k) {
    const double sum = std::accumulate(errors_sq[k].begin(), errors_sq[k].end(), 0.0);
    if (errors_sq[k].empty() || sum >= least) continue;
    least = sum;
    best = k;
  }
  return best;
}

RawEvidence raw_evidence(const analysis::SmoothInput& input, const analysis::SmoothFit& fit)
{
  RawEvidence raw;
  raw.block_size = correlated_block(fit);
  const store::GridI numbers =
      analysis::block_numbers(input.status.rows(), input.status.cols(), raw.block_size);
  for (Eigen::Index k = 0; k < numbers.size(); ++k)
    if (!std::isnan(fit.residual[0].data()[k])) raw.block.push_back(numbers.data()[k]);
  raw.variance = raw_variance(fit);
  raw.jump = largest_jump(input.flexion_deg, fit);
  return raw;
}

Recommendation recommendation_of(const analysis::SmoothInput& input, const std::vector<analysis::SmoothFit>& fits,
                                 const std::vector<DegreeRow>& rows)
{
  const RawEvidence raw = raw_evidence(input, fits[best_fit(fits)]);
  std::vector<std::vector<store::GridD>> left_out;
  for (const analysis::SmoothFit& fit : fits)
    left_out.push_back(analysis::leave_blocks_out(input, fit, raw.block_size));
  const std::vector<std::vector<double>> errors_sq = left_out_errors(fits, left_out);
  std::vector<DegreeEvidence> degrees;
  for (std::size_t k = 0; k < fits.size(); ++k)
    degrees.push_back({fits[k].set.degree, errors_sq[k], rows[k].second_difference, rows[k].contact});
  return recommend(degrees, raw);
}

/// `model` must have no smoothed sets; it temporarily holds the set for the audit.
DegreeRow row_of(store::MotionModel& model, analysis::SmoothFit& fit, const CompareOptions& options)
{
  if (options.recontact) fit.set.recontact_mm = options.recontact(model, fit.set);
  DegreeRow row;
  row.surfaces = surface_rows(fit.set, store::axis_ranges(model.flexion_deg, model.varus_deg));
  row.translation = translation_of(fit, row.surfaces);
  row.is_converged =
      std::find(fit.is_converged.begin(), fit.is_converged.end(), false) == fit.is_converged.end();
  row.perceptible_share = perceptible_share(model, fit);
  row.set = fit.set;
  row.second_difference = second_difference(fit.set, store::axis_ranges(model.flexion_deg, model.varus_deg));
  if (options.contact) row.contact = options.contact(model, fit.set);
  if (!options.audit) return row;
  model.smoothed = {fit.set};
  const std::string motion =
      "degree_" + std::to_string(fit.set.degree) + (options.recontact ? "_recontacted" : "");
  row.audit_totals = motion_audit_totals(model, options.audit(model, motion));
  model.smoothed.clear();
  return row;
}

void require_ascending(const std::vector<int>& degrees)
{
  check(!degrees.empty(), "compare needs a degree");
  for (std::size_t k = 1; k < degrees.size(); ++k) check(degrees[k - 1] < degrees[k], "degrees ascend");
}

}  // namespace

Comparison compare(const store::MotionModel& model, const CompareOptions& options)
{
  require_ascending(options.degrees);
  const analysis::SmoothInput input = analysis::smooth_input(model, options.name);
  const int largest = analysis::largest_degree(input, options.degrees.back());
  Comparison comparison;
  std::vector<analysis::SmoothFit> fits;
  for (const int degree : options.degrees) {
    // The lowest is always tried, since its error names the cause.
    if (degree > largest && degree != options.degrees.front()) {
      comparison.undetermined_degrees.push_back(degree);
    } else {
      fits.push_back(analysis::smooth_fit(input, degree, options.smooth));
    }
  }
  store::MotionModel bare = model;
  bare.smoothed.clear();
  for (analysis::SmoothFit& fit : fits) comparison.rows.push_back(row_of(bare, fit, options));
  comparison.recommendation = recommendation_of(input, fits, comparison.rows);
  return comparison;
}

}  // namespace vrda::analysis
