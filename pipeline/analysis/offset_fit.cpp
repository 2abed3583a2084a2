#include "analysis/offset_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "geometry/gap_query.hpp"
#include "model/frames.hpp"

namespace vrda::analysis {
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
// Change of a gap per mm below which a frame gives no information: contact gives 1 or more.
constexpr double least_slope = 0.5;

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

double mean(const std::vector<double>& values)
{
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double median(std::vector<double> values)
{
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Values farther than three standard deviations from the median, by the median deviation, are moved there: a
// frame whose objects overlap sideways has a gap along Delta of centimetres.
std::vector<double> without_outliers(std::vector<double> values)
{
  constexpr double sd_by_deviation = 1.4826;  // of a normal distribution
  if (values.empty()) return values;
  const double centre = median(values);
  std::vector<double> deviation;
  for (const double value : values) deviation.push_back(std::abs(value - centre));
  const double reach = 3.0 * sd_by_deviation * median(deviation);
  for (double& value : values) value = std::clamp(value, centre - reach, centre + reach);
  return values;
}

double standard_error(const std::vector<double>& values)
{
  const double centre = mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - centre) * (value - centre);
  const auto n = static_cast<double>(values.size());
  return std::sqrt(sum / (n - 1.0) / n);
}

// The frames that have a gap which the offset changes.
struct Frames {
  double gap_sq = 0.0;
  std::vector<double> slope;      // change of the gap along Delta per mm of offset
  std::vector<double> change_mm;  // of the offset, for contact: the gap along its normal
};

Frames frames_at(const job::Case& job_case, const OffsetFitInput& input, double offset_mm)
{
  const std::vector<double> gaps = gaps_at_offset(job_case, input, offset_mm);
  const std::vector<double> thicker = gaps_at_offset(job_case, input, offset_mm + difference_mm);
  Frames frames;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const double slope = (thicker[i] - gaps[i]) / difference_mm;
    if (!(std::abs(slope) >= least_slope)) continue;  // also without a gap
    frames.gap_sq += gaps[i] * gaps[i];
    frames.slope.push_back(slope);
    frames.change_mm.push_back(-gaps[i] / slope);
  }
  frames.change_mm = without_outliers(std::move(frames.change_mm));
  return frames;
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

std::vector<double> gaps_at_offset(const job::Case& job_case, const OffsetFitInput& input, double offset_mm)
{
  const Mesh reference = with_offset(job_case.reference, input.reference, offset_mm);
  const Mesh moving = with_offset(job_case.moving, input.moving, offset_mm);
  SolverFrame frame = job_case.frame;
  std::optional<geometry::GapQuery> query;
  std::vector<double> gaps;
  for (const Pose& X : input.X_reference_moving) {
    const Eigen::Vector3d delta =
        job_case.is_push_fixed_in_reference
            ? Eigen::Vector3d((X.linear().transpose() * job_case.push_at_meshes.delta).normalized())
            : job_case.frame.delta;
    if (!query || frame.delta != delta) {
      frame.delta = delta;
      query.emplace(geometry::GapTree(solver_mesh(reference, frame)),
                    geometry::GapTree(solver_mesh(moving, frame)));
    }
    const solve::SolverPosition at = solve::solver_position(frame, X);
    gaps.push_back(query->gap_mm(at.attitude, at.pose));
  }
  return gaps;
}

OffsetFit fit_offset(const job::Case& job_case, const OffsetFitInput& input)
{
  OffsetFit fit;
  fit.offset_mm = first_offset_mm;
  fit.status = FitStatus::iteration_limit;
  Frames frames;
  double share = 1.0, last_step_mm = 0.0;  // halved at each reversal: gaps jump where contact moves
  for (int k = 0; k < most_iterations && fit.status == FitStatus::iteration_limit; ++k) {
    frames = frames_at(job_case, input, fit.offset_mm);
    fit.n_frames = static_cast<int>(frames.slope.size());
    if (fit.n_frames < 2) {
      fit.status = FitStatus::undetermined;
      break;
    }
    const double next_mm =
        std::clamp(fit.offset_mm + share * mean(frames.change_mm), least_offset_mm, largest_offset_mm);
    const double step_mm = next_mm - fit.offset_mm;
    if (step_mm * last_step_mm < 0.0) share *= 0.5;
    last_step_mm = step_mm;
    fit.offset_mm = next_mm;
    if (std::abs(step_mm) > settled_mm) continue;
    const bool is_inside = next_mm > least_offset_mm && next_mm < largest_offset_mm;
    fit.status = is_inside ? FitStatus::converged : FitStatus::at_limit;
  }
  fit.bare_gap_rms_mm = rms_of(gaps_at_offset(job_case, input, 0.0));
  if (fit.status == FitStatus::undetermined) return fit;
  fit.gap_rms_mm = std::sqrt(frames.gap_sq / fit.n_frames);
  fit.travel_per_mm = median(frames.slope);
  fit.standard_error_mm = standard_error(frames.change_mm);
  return fit;
}

}  // namespace vrda::analysis
