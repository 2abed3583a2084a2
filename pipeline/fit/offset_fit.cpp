#include "fit/offset_fit.hpp"

#include <algorithm>
#include <cmath>

#include "core/solver_position.hpp"
#include "proximity/gap_query.hpp"

namespace vrda::fit {
namespace {

// The limits of offset_mm in schemas/job.schema.json.
constexpr double least_offset_mm = 0.0, largest_offset_mm = 10.0;
// Of cartilage on both sides of a joint: the start.
constexpr double first_offset_mm = 1.0;
// Step of the differences: far above the rounding of a gap, far below the size of a facet.
constexpr double difference_mm = 1e-3;
// Steps below this end the iteration; facets make the gaps piecewise smooth.
constexpr double settled_mm = 1e-6;
constexpr int most_iterations = 50;
// Mean square of the change of a gap per mm below which the motion gives no information: contact gives 1 or
// more.
constexpr double least_slope_sq = 1e-4;

Mesh with_offset(const Body& body, const std::vector<std::int32_t>& components, double mm)
{
  Mesh mesh = body.contact.mesh;
  mesh.offset_mm.resize(body.contact.component.size(), 0.0);
  for (std::size_t t = 0; t < mesh.offset_mm.size(); ++t) {
    if (std::find(components.begin(), components.end(), body.contact.component[t]) != components.end())
      mesh.offset_mm[t] = mm;
  }
  return mesh;
}

// Sums over the frames that have a gap.
struct Sums {
  int n = 0;
  double gap_sq = 0.0, slope = 0.0, slope_sq = 0.0, product = 0.0;
};

Sums sums_at(const load::Case& job_case, const OffsetQuestion& question, double offset_mm)
{
  const std::vector<double> gaps = gaps_at_offset(job_case, question, offset_mm);
  const std::vector<double> thicker = gaps_at_offset(job_case, question, offset_mm + difference_mm);
  Sums sums;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (std::isnan(gaps[i]) || std::isnan(thicker[i])) continue;
    const double slope = (thicker[i] - gaps[i]) / difference_mm;
    ++sums.n;
    sums.gap_sq += gaps[i] * gaps[i];
    sums.slope += slope;
    sums.slope_sq += slope * slope;
    sums.product += slope * gaps[i];
  }
  return sums;
}

double rms_of(const std::vector<double>& gaps)
{
  double sum = 0.0;
  int n = 0;
  for (const double gap : gaps) {
    if (std::isnan(gap)) continue;
    sum += gap * gap;
    ++n;
  }
  return n > 0 ? std::sqrt(sum / n) : nan;
}

}  // namespace

const char* name_of(FitStatus status)
{
  switch (status) {
    case FitStatus::converged:
      return "converged";
    case FitStatus::at_limit:
      return "at_limit";
    case FitStatus::undetermined:
      return "undetermined";
    case FitStatus::not_smooth:
      return "not_smooth";
    case FitStatus::iteration_limit:
      break;
  }
  return "iteration_limit";
}

std::vector<double> gaps_at_offset(const load::Case& job_case, const OffsetQuestion& question,
                                   double offset_mm)
{
  proximity::GapQuery query{
      proximity::GapTree(
          solver_mesh(with_offset(job_case.reference, question.reference, offset_mm), job_case.frame)),
      proximity::GapTree(
          solver_mesh(with_offset(job_case.moving, question.moving, offset_mm), job_case.frame))};
  std::vector<double> gaps;
  for (const Pose& X : question.X_reference_moving) {
    const SolverPosition at = solver_position(job_case.frame, X);
    query.set_attitude(at.attitude);
    const double travel_mm = query.travel_mm(at.pose);
    gaps.push_back(std::isfinite(travel_mm) ? travel_mm : nan);
  }
  return gaps;
}

OffsetFit fit_offset(const load::Case& job_case, const OffsetQuestion& question)
{
  OffsetFit fit;
  fit.offset_mm = first_offset_mm;
  fit.status = FitStatus::iteration_limit;
  Sums sums;
  for (int k = 0; k < most_iterations && fit.status == FitStatus::iteration_limit; ++k) {
    sums = sums_at(job_case, question, fit.offset_mm);
    fit.n_frames = sums.n;
    if (sums.n < 2 || sums.slope_sq < least_slope_sq * sums.n) {
      fit.status = FitStatus::undetermined;
      break;
    }
    const double next_mm =
        std::clamp(fit.offset_mm - sums.product / sums.slope_sq, least_offset_mm, largest_offset_mm);
    const double step_mm = next_mm - fit.offset_mm;
    fit.offset_mm = next_mm;
    if (std::abs(step_mm) > settled_mm) continue;
    const bool is_inside = next_mm > least_offset_mm && next_mm < largest_offset_mm;
    fit.status = is_inside ? FitStatus::converged : FitStatus::at_limit;
  }
  fit.bare_gap_rms_mm = rms_of(gaps_at_offset(job_case, question, 0.0));
  if (fit.status == FitStatus::undetermined) return fit;
  fit.gap_rms_mm = std::sqrt(sums.gap_sq / sums.n);
  fit.travel_per_mm = sums.slope / sums.n;
  fit.standard_error_mm = std::sqrt(sums.gap_sq / (sums.n - 1) / sums.slope_sq);
  return fit;
}

}  // namespace vrda::fit
