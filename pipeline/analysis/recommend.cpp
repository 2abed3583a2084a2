#include "analysis/recommend.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "core/units.hpp"
#include "analysis/huber.hpp"

namespace vrda::analysis {
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
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
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

const char* name_of(Fault fault)
{
  switch (fault) {
    case Fault::none:
      return "none";
    case Fault::not_measurable:
      return "not_measurable";
    case Fault::unpredicted:
      return "unpredicted";
    case Fault::jump:
      return "jump";
    case Fault::no_contact:
      return "no_contact";
    case Fault::overlap:
      return "overlap";
    case Fault::gap:
      return "gap";
    case Fault::rough:
      return "rough";
  }
  throw InternalError("a fault has a name");
}

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
bool is_saturated(const analysis::SmoothFit& fit, const LeftOut& left_out)
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
    least = std::min(least, analysis::robust_scale(Eigen::Map<const Eigen::VectorXd>(
                                errors.data(), static_cast<Eigen::Index>(errors.size()))));
  }
  return std::max(least_limit, analysis::huber_constant * least / perceptible_unit(surface));
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

std::vector<std::vector<double>> left_out_errors(const std::vector<analysis::SmoothFit>& fits,
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

}  // namespace vrda::analysis
