#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "tracking/prediction.hpp"

namespace vrda {
namespace {

/// Calls `compare(i, j, s, time_s)` for each sample i whose horizon lies within the series: time_s, which is
/// the share s of the way from sample j to the next.
template <typename Series, typename Compare>
void for_each_horizon(const Series& series, double horizon_s, Compare compare)
{
  std::size_t j = 0;
  for (std::size_t i = 0; i < series.size(); ++i) {
    check(i == 0 || series[i].time_s > series[i - 1].time_s, "the times of a series ascend");
    const double time_s = series[i].time_s + horizon_s;
    while (j + 1 < series.size() && series[j + 1].time_s < time_s) ++j;
    if (j + 1 == series.size()) return;
    compare(i, j, (time_s - series[j].time_s) / (series[j + 1].time_s - series[j].time_s), time_s);
  }
}

struct Errors {
  std::vector<double> held, predicted;
  PredictionError summary() const { return {summary_of(held), summary_of(predicted)}; }
};

void add_errors(Errors& shift_mm, Errors& turn_rad, const Pose& X_then, const std::array<Pose, 2>& said)
{
  const Pose X_held = X_then.inverse() * said[0];
  const Pose X_predicted = X_then.inverse() * said[1];
  shift_mm.held.push_back(X_held.translation().norm());
  shift_mm.predicted.push_back(X_predicted.translation().norm());
  turn_rad.held.push_back(turn_of(X_held.linear()).norm());
  turn_rad.predicted.push_back(turn_of(X_predicted.linear()).norm());
}

}  // namespace

ErrorSummary summary_of(std::vector<double> errors)
{
  ErrorSummary summary;
  summary.n = errors.size();
  if (errors.empty()) return summary;
  double sum_sq = 0.0;
  for (const double error : errors) sum_sq += error * error;
  summary.rms = std::sqrt(sum_sq / static_cast<double>(errors.size()));
  std::sort(errors.begin(), errors.end());
  const std::size_t n_within = (95 * errors.size() + 99) / 100;
  summary.percentile_95 = errors[n_within - 1];
  return summary;
}

PlacePredictionError prediction_error(std::span<const TimedPose> series, double horizon_s,
                                      const PredictionOptions& options)
{
  PlacePredictor predictor(options);
  Errors shift_mm, turn_rad;
  for_each_horizon(series, horizon_s, [&](std::size_t i, std::size_t j, double s, double time_s) {
    predictor.add(series[i]);
    const Pose X_then = between(series[j].X, series[j + 1].X, s);
    add_errors(shift_mm, turn_rad, X_then, {series[i].X, predictor.at(time_s)});
  });
  return {shift_mm.summary(), turn_rad.summary()};
}

AnglesPredictionError prediction_error(std::span<const TimedAngles> series, double horizon_s,
                                       const PredictionOptions& options)
{
  AnglesPredictor predictor(options);
  Errors flexion_rad, varus_rad;
  for_each_horizon(series, horizon_s, [&](std::size_t i, std::size_t j, double s, double time_s) {
    predictor.add(series[i]);
    const LegAngles predicted = predictor.at(time_s);
    const LegAngles &now = series[i].angles, &from = series[j].angles, &to = series[j + 1].angles;
    const double flexion = from.flexion_rad + s * (to.flexion_rad - from.flexion_rad);
    const double varus = from.varus_rad + s * (to.varus_rad - from.varus_rad);
    flexion_rad.held.push_back(std::abs(now.flexion_rad - flexion));
    flexion_rad.predicted.push_back(std::abs(predicted.flexion_rad - flexion));
    varus_rad.held.push_back(std::abs(now.varus_rad - varus));
    varus_rad.predicted.push_back(std::abs(predicted.varus_rad - varus));
  });
  return {flexion_rad.summary(), varus_rad.summary()};
}

}  // namespace vrda
