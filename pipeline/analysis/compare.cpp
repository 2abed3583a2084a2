#include "analysis/compare.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <utility>

#include "core/text.hpp"

namespace vrda::analysis {
namespace {

/// Blocks of an axis, so that their spread is known and polynomials do not extrapolate far.
constexpr Eigen::Index least_blocks = 4;

double raw_value(const SmoothFit& fit, std::size_t surface, Eigen::Index i, Eigen::Index j)
{
  return fit.residual[surface](i, j) + fit.set.surfaces[surface].values(i, j);
}

/// Length of the step of the pose from flexion i to i + 1; NaN if a translation is missing. An angle that is
/// not fitted there does not count.
double step_length(const SmoothFit& fit, Eigen::Index i, Eigen::Index j)
{
  double sum_sq = 0.0;
  for (std::size_t s = 0; s < fit.residual.size(); ++s) {
    const double step = (raw_value(fit, s, i + 1, j) - raw_value(fit, s, i, j)) / perceptible_unit(s);
    if (s < 3 || !std::isnan(step)) sum_sq += step * step;
  }
  return std::sqrt(sum_sq);
}

std::optional<double> median(std::vector<double> values)
{
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<double> median_excess(const SmoothFit& fit, Eigen::Index i)
{
  std::vector<double> excess;
  for (Eigen::Index j = 0; j < fit.residual[0].cols(); ++j) {
    const double before = step_length(fit, i - 1, j), here = step_length(fit, i, j),
                 after = step_length(fit, i + 1, j);
    if (!std::isnan(before + here + after)) excess.push_back(here - std::max(before, after));
  }
  return median(std::move(excess));
}

/// Smallest lag along an axis with (di, dj) of length 1 at which residuals are uncorrelated.
Eigen::Index correlation_length(const SmoothFit& fit, Eigen::Index di, Eigen::Index dj)
{
  const Eigen::Index rows = fit.residual[0].rows(), columns = fit.residual[0].cols();
  const Eigen::Index n_axis = di > 0 ? rows : columns;
  double sum_sq = 0.0;
  for (std::size_t s = 0; s < fit.residual.size(); ++s) {
    for (const double r : fit.residual[s].reshaped())
      sum_sq += std::isnan(r) ? 0.0 : r * r / (perceptible_unit(s) * perceptible_unit(s));
  }
  const auto n_cells = static_cast<double>((!fit.residual[0].isNaN()).count());
  for (Eigen::Index lag = 1; lag < n_axis; ++lag) {
    double products = 0.0, n_pairs = 0.0;
    for (std::size_t s = 0; s < fit.residual.size(); ++s) {
      const store::GridD& r = fit.residual[s];
      for (Eigen::Index i = 0; i + lag * di < rows; ++i) {
        for (Eigen::Index j = 0; j + lag * dj < columns; ++j) {
          const double product =
              r(i, j) * r(i + lag * di, j + lag * dj) / (perceptible_unit(s) * perceptible_unit(s));
          if (std::isnan(product)) continue;
          products += product;
          n_pairs += s == 0 ? 1.0 : 0.0;
        }
      }
    }
    if (n_pairs == 0.0 || sum_sq <= rounding_sq * n_cells) return lag;
    if (products / n_pairs * n_cells / sum_sq < 2.0 / std::sqrt(n_pairs)) return lag;
  }
  return n_axis;
}

Eigen::Index block_length(Eigen::Index correlation_length, Eigen::Index n_axis)
{
  return std::min(2 * correlation_length - 1, std::max<Eigen::Index>(1, n_axis / least_blocks));
}

}  // namespace

RawJump largest_jump(const std::vector<double>& flexion_deg, const SmoothFit& fit)
{
  RawJump largest;
  for (Eigen::Index i = 1; i + 2 < fit.residual[0].rows(); ++i) {
    const std::optional<double> excess = median_excess(fit, i);
    const auto row = static_cast<std::size_t>(i);
    if (excess && *excess > largest.size) largest = {*excess, flexion_deg[row], flexion_deg[row + 1]};
  }
  return largest;
}

RawJump raw_jump(const store::MotionModel& model)
{
  if (model.frames || !(model.status == status_stable).any()) return {};
  // Any degree has the raw values; a constant is determined by a single cell.
  return largest_jump(model.flexion_deg, smooth_fit(smooth_input(model, model.title), 0));
}

std::string jump_text(const RawJump& jump)
{
  return printed(
      "the raw motion jumps by %.3g times the perceptible error between flexion %.3g and %.3g degrees",
      jump.size, jump.from_deg, jump.to_deg);
}

double raw_variance(const SmoothFit& fit)
{
  double sum_sq = 0.0;
  for (std::size_t s = 0; s < fit.residual.size(); ++s) {
    std::vector<double> values;
    double mean = 0.0;
    for (Eigen::Index i = 0; i < fit.residual[s].rows(); ++i) {
      for (Eigen::Index j = 0; j < fit.residual[s].cols(); ++j) {
        if (std::isnan(fit.residual[s](i, j))) continue;
        values.push_back(raw_value(fit, s, i, j) / perceptible_unit(s));
        mean += values.back();
      }
    }
    mean /= static_cast<double>(values.size());
    for (const double value : values) sum_sq += (value - mean) * (value - mean);
  }
  return sum_sq / static_cast<double>((!fit.residual[0].isNaN()).count());
}

BlockSize correlated_block(const SmoothFit& fit)
{
  return {block_length(correlation_length(fit, 1, 0), fit.residual[0].rows()),
          block_length(correlation_length(fit, 0, 1), fit.residual[0].cols())};
}

namespace {

constexpr double standard_errors = 2.0;
/// Below, a polynomial misses more of the raw motion than it predicts.
constexpr double least_predicted = 0.5;

double mean(const std::vector<double>& values)
{
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<double> at_least_rounding(std::vector<double> errors_sq)
{
  for (double& error_sq : errors_sq) error_sq = std::max(error_sq, rounding_sq);
  return errors_sq;
}

/// Standard error of the mean of `values`, whose blocks are independent (cluster sums).
double standard_error(const std::vector<double>& values, const std::vector<std::int32_t>& block)
{
  const double centre = mean(values);
  std::vector<double> sums(static_cast<std::size_t>(*std::max_element(block.begin(), block.end())) + 1, 0.0);
  std::vector<bool> is_used(sums.size(), false);
  for (std::size_t c = 0; c < values.size(); ++c) {
    sums[static_cast<std::size_t>(block[c])] += values[c] - centre;
    is_used[static_cast<std::size_t>(block[c])] = true;
  }
  const auto n = static_cast<double>(std::count(is_used.begin(), is_used.end(), true));
  if (n < 2.0) return 0.0;
  const double sum_sq = std::inner_product(sums.begin(), sums.end(), sums.begin(), 0.0);
  return std::sqrt(sum_sq * n / (n - 1.0)) / static_cast<double>(values.size());
}

void compare_with_best(RankedDegree& ranked, const std::vector<double>& best_sq,
                       const DegreeEvidence& evidence, const RawEvidence& raw)
{
  if (evidence.left_out_sq.empty()) return;
  check(evidence.left_out_sq.size() == best_sq.size() && raw.block.size() == best_sq.size(),
        "every degree has the same cells");
  std::vector<double> difference = at_least_rounding(evidence.left_out_sq);
  for (std::size_t c = 0; c < difference.size(); ++c) difference[c] -= best_sq[c];
  ranked.excess_sq = mean(difference);
  ranked.standard_error = standard_error(difference, raw.block);
  ranked.is_within = ranked.excess_sq <= standard_errors * ranked.standard_error;
}

Fault contact_fault(const std::vector<DegreeEvidence>& degrees, const DegreeEvidence& evidence)
{
  if (!evidence.contact) return Fault::none;
  const ContactFigures& c = *evidence.contact;
  int most_poses = 1;
  for (const DegreeEvidence& other : degrees)
    most_poses = std::max(most_poses, other.contact ? other.contact->n_poses : 0);
  if (c.n_poses < most_poses) return Fault::no_contact;
  if (c.largest_overlap_mm > perceptible_mm) return Fault::overlap;
  return c.largest_gap_mm > perceptible_mm ? Fault::gap : Fault::none;
}

Fault fault_of(const std::vector<DegreeEvidence>& degrees, const DegreeEvidence& evidence, double error,
               const RawEvidence& raw)
{
  if (std::isnan(error)) return Fault::not_measurable;
  if (error > 1.0 && error * error > (1.0 - least_predicted) * raw.variance) return Fault::unpredicted;
  if (raw.jump.size > largest_raw_jump) return Fault::jump;
  const Fault contact = contact_fault(degrees, evidence);
  if (contact != Fault::none) return contact;
  return evidence.second_difference > 1.0 ? Fault::rough : Fault::none;
}

std::string text_of(double number)
{
  return rounded_text(number, 3);
}

std::string fault_text(Fault fault, const DegreeEvidence& evidence, double error, const RawEvidence& raw)
{
  const auto mm = [](double length_mm) { return text_of(length_mm) + " mm"; };
  switch (fault) {
    case Fault::none:
      return "";
    case Fault::not_measurable:
      return "a block of attitudes cannot be left out";
    case Fault::unpredicted:
      return "errors of left-out attitudes are " + text_of(error) +
             " times the perceptible error (RMS), and the motion itself varies by " +
             text_of(std::sqrt(raw.variance)) + " times: less than half of its variance is predicted" +
             (raw.jump.size > largest_raw_jump ? "; also, " + jump_text(raw.jump) : "");
    case Fault::jump:
      return jump_text(raw.jump) + ", which no polynomial follows";
    case Fault::no_contact:
      return "only " + std::to_string(evidence.contact->n_poses) + " poses have contact";
    case Fault::overlap:
      return "moved into contact, it overlaps by " + mm(evidence.contact->largest_overlap_mm);
    case Fault::gap:
      return "moved into contact, it has a gap of " + mm(evidence.contact->largest_gap_mm);
    case Fault::rough:
      return "its second difference over one degree of flexion is " + text_of(evidence.second_difference) +
             " times the perceptible error (RMS)";
  }
  throw InternalError("a fault has a text");
}

/// The comparison with the degree below the chosen one.
std::string why_not_lower(const Recommendation& r, std::size_t chosen)
{
  if (chosen == 0) return "; no lower degree was compared";
  const RankedDegree& lower = r.ranked[chosen - 1];
  if (lower.fault != Fault::none)
    return "; degree " + std::to_string(lower.degree) + " is " + name_of(lower.fault);
  // Without spread the difference is the same in every block.
  if (lower.standard_error == 0.0)
    return "; degree " + std::to_string(lower.degree) + " is worse at every cell";
  return "; degree " + std::to_string(lower.degree) + " (" + text_of(lower.error) + ") is " +
         text_of(lower.excess_sq / lower.standard_error) + " standard errors worse";
}

std::string excluded_text(const Recommendation& r, std::size_t chosen)
{
  std::string text;
  for (std::size_t k = chosen + 1; k < r.ranked.size(); ++k) {
    if (r.ranked[k].fault != Fault::none)
      text += (text.empty() ? "; excluded: degree " : ", ") + std::to_string(r.ranked[k].degree) + " (" +
              name_of(r.ranked[k].fault) + ")";
  }
  return text;
}

std::string contact_text(const DegreeEvidence& evidence)
{
  if (!evidence.contact) return "; contact is not measured";
  const ContactFigures& c = *evidence.contact;
  return "; moved into contact, its largest gap is " + text_of(c.largest_gap_mm) +
         " mm and its largest overlap " + text_of(c.largest_overlap_mm) + " mm" +
         (c.n_lifted_off > 0
              ? ", " + std::to_string(c.n_lifted_off) + " poses lift a side off as the raw motion does"
              : "");
}

std::string reason_of(const Recommendation& r, std::size_t chosen, std::size_t best)
{
  std::string reason = "degree " + std::to_string(r.degree) + ": ";
  const std::string error = text_of(r.ranked[chosen].error) + " times the perceptible error";
  if (chosen == best) {
    reason += "smallest error of left-out attitudes (" + error +
              "), and no lower degree is within two paired standard errors";
  } else {
    reason += "lowest degree whose error of left-out attitudes (" + error +
              ") is within two paired standard errors of the best (" + text_of(r.ranked[best].error) +
              ", degree " + std::to_string(r.best_degree) + ")";
  }
  reason += why_not_lower(r, chosen) + excluded_text(r, chosen);
  if (chosen + 1 == r.ranked.size() && chosen > 0)
    reason += "; the error still decreases at the highest compared degree";
  return reason;
}

/// Index of the smallest error; of those without a fault if `is_faultless`. The size without any.
std::size_t smallest_error(const std::vector<RankedDegree>& ranked, bool is_faultless)
{
  std::size_t best = ranked.size();
  for (std::size_t k = 0; k < ranked.size(); ++k) {
    if (std::isnan(ranked[k].error) || (is_faultless && ranked[k].fault != Fault::none)) continue;
    if (best == ranked.size() || ranked[k].error < ranked[best].error) best = k;
  }
  return best;
}

}  // namespace

Recommendation recommend(const std::vector<DegreeEvidence>& degrees, const RawEvidence& raw)
{
  Recommendation r;
  r.block_size = raw.block_size;
  for (std::size_t k = 0; k < degrees.size(); ++k) {
    check(k == 0 || degrees[k - 1].degree < degrees[k].degree, "degrees ascend");
    const std::vector<double>& errors_sq = degrees[k].left_out_sq;
    const double error = errors_sq.empty() ? nan : std::sqrt(mean(at_least_rounding(errors_sq)));
    const Fault fault = fault_of(degrees, degrees[k], error, raw);
    r.ranked.push_back(
        {degrees[k].degree, error, nan, nan, false, fault, fault_text(fault, degrees[k], error, raw)});
  }
  std::size_t best = smallest_error(r.ranked, true);
  const bool is_any_good = best < r.ranked.size();
  if (!is_any_good) best = smallest_error(r.ranked, false);
  if (best == r.ranked.size()) {
    r.fault = Fault::not_measurable;
    r.reason = "for every degree " + r.ranked.front().fault_reason;
    return r;
  }
  r.best_degree = r.ranked[best].degree;
  const std::vector<double> best_sq = at_least_rounding(degrees[best].left_out_sq);
  for (std::size_t k = 0; k < degrees.size(); ++k) compare_with_best(r.ranked[k], best_sq, degrees[k], raw);
  if (!is_any_good) {
    r.fault = r.ranked[best].fault;
    r.reason = "of the best, degree " + std::to_string(r.best_degree) + ", " + r.ranked[best].fault_reason;
    return r;
  }
  const auto chosen = std::find_if(r.ranked.begin(), r.ranked.end(), [](const RankedDegree& d) {
    return d.is_within && d.fault == Fault::none;
  });
  const auto k = static_cast<std::size_t>(chosen - r.ranked.begin());
  r.degree = chosen->degree;
  r.reason = reason_of(r, k, best) + contact_text(degrees[k]);
  return r;
}

namespace {

/// Lower bound of the Huber limit, in perceptible units: the scale of exact data is rounding, and no error
/// would count.
constexpr double least_limit = 1e-3;

using LeftOut = std::vector<store::GridD>;  ///< by surface

/// True if a fitted cell cannot be omitted.
bool is_saturated(const SmoothFit& fit, const LeftOut& left_out)
{
  for (std::size_t s = 0; s < left_out.size(); ++s) {
    if ((left_out[s].isNaN() != fit.residual[s].isNaN()).any()) return true;
  }
  return false;
}

/// Error above which the loss is linear: huber_constant times the smallest scale of any fit, in perceptible
/// units.
double huber_limit(const std::vector<const LeftOut*>& fits, std::size_t surface)
{
  double least = std::numeric_limits<double>::infinity();
  for (const LeftOut* fit : fits) {
    std::vector<double> errors;
    for (const double error : (*fit)[surface].reshaped<Eigen::RowMajor>()) {
      if (!std::isnan(error)) errors.push_back(error);
    }
    least = std::min(least, robust_scale(Eigen::Map<const Eigen::VectorXd>(
                                errors.data(), static_cast<Eigen::Index>(errors.size()))));
  }
  return std::max(least_limit, huber_constant * least / perceptible_unit(surface));
}

/// Square of the error; above `limit` the tangent of the square.
double loss(double error, double limit)
{
  const double size = std::abs(error);
  return size <= limit ? size * size : limit * (2.0 * size - limit);
}

/// 1 for cells where every fit has this surface.
store::GridB cells_of_all(const std::vector<const LeftOut*>& fits, std::size_t surface)
{
  store::GridB is_of_all =
      store::GridB::Ones((*fits.front())[surface].rows(), (*fits.front())[surface].cols());
  for (const LeftOut* fit : fits) is_of_all = is_of_all * (!(*fit)[surface].isNaN()).cast<std::int8_t>();
  return is_of_all;
}

/// Adds the losses of one surface to the cells (those fitted in translation, in grid order).
void add_losses(std::vector<double>& errors_sq, const LeftOut& left_out, std::size_t surface,
                const store::GridB& is_of_all, double limit)
{
  std::size_t cell = 0;
  for (Eigen::Index k = 0; k < is_of_all.size(); ++k) {
    if (std::isnan(left_out[0].data()[k])) continue;
    if (is_of_all.data()[k] == 1)
      errors_sq[cell] += loss(left_out[surface].data()[k] / perceptible_unit(surface), limit);
    ++cell;
  }
}

}  // namespace

std::vector<std::vector<double>> left_out_errors(const std::vector<SmoothFit>& fits,
                                                 const std::vector<LeftOut>& left_out)
{
  std::vector<std::vector<double>> all(fits.size());
  std::vector<const LeftOut*> usable;
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (is_saturated(fits[k], left_out[k])) continue;
    usable.push_back(&left_out[k]);
    all[k].assign(static_cast<std::size_t>((!fits[k].residual[0].isNaN()).count()), 0.0);
  }
  if (usable.empty()) return all;
  for (std::size_t s = 0; s < usable.front()->size(); ++s) {
    const store::GridB is_of_all = cells_of_all(usable, s);
    const double limit =
        fits.front().set.is_robust ? huber_limit(usable, s) : std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < fits.size(); ++k) {
      if (!all[k].empty()) add_losses(all[k], left_out[k], s, is_of_all, limit);
    }
  }
  return all;
}

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

namespace {

template <typename Audit>
MotionAuditTotals totals_of(const store::MotionModel& model, const store::AuditSet& axes, const Audit& audit)
{
  const auto refine = static_cast<Eigen::Index>(axes.refine);
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

}  // namespace

MotionAuditTotals motion_audit_totals(const store::MotionModel& model, const store::AuditSet& audit)
{
  return totals_of(model, audit, audit);
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

std::vector<SurfaceRow> surface_rows(const store::SmoothedSet& set,
                                     const std::vector<store::SmoothedSurface>& surfaces,
                                     const store::AxisRanges& ranges)
{
  std::vector<SurfaceRow> rows;
  for (const store::SmoothedSurface& s : surfaces) {
    rows.push_back({s.name,
                    s.n_cells,
                    s.condition_number,
                    {s.rms, s.largest_residual, s.leave_one_out_rms, roughness(set, s, ranges)}});
  }
  return rows;
}

/// Residual of the translation at a cell, mm, before recontact.
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
      if (norm_mm > length.largest) length.largest = norm_mm;  // false for NaN
    }
  }
  return length;
}

/// Whether the error of the displayed pose at cell (i, j) is perceptible.
bool is_perceptible(const store::MotionModel& model, const SmoothFit& fit, Eigen::Index i, Eigen::Index j)
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

double perceptible_share(const store::MotionModel& model, const SmoothFit& fit)
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
std::size_t best_fit(const std::vector<SmoothFit>& fits)
{
  std::vector<std::vector<store::GridD>> left_out;
  for (const SmoothFit& fit : fits) left_out.push_back(fit.leave_one_out);
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

RawEvidence raw_evidence(const SmoothInput& input, const SmoothFit& fit)
{
  RawEvidence raw;
  raw.block_size = correlated_block(fit);
  const store::GridI numbers = block_numbers(input.status.rows(), input.status.cols(), raw.block_size);
  for (Eigen::Index k = 0; k < numbers.size(); ++k)
    if (!std::isnan(fit.residual[0].data()[k])) raw.block.push_back(numbers.data()[k]);
  raw.variance = raw_variance(fit);
  raw.jump = largest_jump(input.flexion_deg, fit);
  return raw;
}

Recommendation recommendation_of(const SmoothInput& input, const std::vector<SmoothFit>& fits,
                                 const std::vector<DegreeRow>& rows)
{
  const RawEvidence raw = raw_evidence(input, fits[best_fit(fits)]);
  std::vector<std::vector<store::GridD>> left_out;
  for (const SmoothFit& fit : fits) left_out.push_back(leave_blocks_out(input, fit, raw.block_size));
  const std::vector<std::vector<double>> errors_sq = left_out_errors(fits, left_out);
  std::vector<DegreeEvidence> degrees;
  for (std::size_t k = 0; k < fits.size(); ++k)
    degrees.push_back({fits[k].set.degree, errors_sq[k], rows[k].second_difference, rows[k].contact});
  return recommend(degrees, raw);
}

/// `model` must have no smoothed sets; it temporarily holds the set for the audit.
DegreeRow row_of(store::MotionModel& model, SmoothFit& fit, const CompareOptions& options)
{
  if (options.recontact) options.recontact(model, fit.set);
  const store::AxisRanges ranges = store::axis_ranges(model.flexion_deg, model.varus_deg);
  DegreeRow row;
  row.surfaces = surface_rows(fit.set, fit.set.surfaces, ranges);
  for (const store::SmoothedFollower& follower : fit.set.followers)
    row.followers.push_back({follower.name, surface_rows(fit.set, follower.surfaces, ranges), {}});
  row.translation = translation_of(fit, row.surfaces);
  row.is_converged =
      std::find(fit.is_converged.begin(), fit.is_converged.end(), false) == fit.is_converged.end();
  row.perceptible_share = perceptible_share(model, fit);
  row.set = fit.set;
  row.second_difference = second_difference(fit.set, ranges);
  if (options.contact) row.contact = options.contact(model, fit.set);
  if (!options.audit) return row;
  model.smoothed = {fit.set};
  const std::string motion =
      "degree_" + std::to_string(fit.set.degree) + (options.recontact ? "_recontacted" : "");
  const bool has_compartments = std::exchange(model.has_compartments, false);  // the totals have none
  const store::AuditSet audit = options.audit(model, motion);
  model.has_compartments = has_compartments;
  row.audit_totals = motion_audit_totals(model, audit);
  for (FollowerRow& follower : row.followers) {
    for (const store::FollowerAudit& own : audit.followers)
      if (own.name == follower.name) follower.audit_totals = totals_of(model, audit, own);
  }
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
  const SmoothInput input = smooth_input(model, options.name);
  const int largest = largest_degree(input, options.degrees.back());
  Comparison comparison;
  std::vector<SmoothFit> fits;
  for (const int degree : options.degrees) {
    // The lowest is always tried, since its error names the cause.
    if (degree > largest && degree != options.degrees.front()) {
      comparison.undetermined_degrees.push_back(degree);
    } else {
      fits.push_back(smooth_fit(input, degree, options.smooth));
    }
  }
  store::MotionModel bare = model;
  bare.smoothed.clear();
  for (SmoothFit& fit : fits) comparison.rows.push_back(row_of(bare, fit, options));
  comparison.recommendation = recommendation_of(input, fits, comparison.rows);
  return comparison;
}

}  // namespace vrda::analysis
