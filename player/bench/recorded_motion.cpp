#include "bench/recorded_motion.hpp"

#include <sstream>

#include "bench/body_tracker.hpp"
#include "core/units.hpp"
#include "settings/settings_text.hpp"

namespace vrda {
namespace {

std::string hundredths(double value)
{
  return rounded_text(value, 2);
}

}  // namespace

std::vector<TimedPose> recorded_motion(const Recording& recording, const BenchFile& bench, BodyRole role)
{
  std::vector<TimedPose> motion;
  const std::optional<BodySettings>& settings = bench.bodies[static_cast<std::size_t>(role)];
  if (!settings) return motion;
  BodyTracker tracker(*settings, first_tool_of(bench, role));
  ClockMap clock;
  const auto settle = [&] {
    if (!tracker.settle()) return;
    if (motion.empty() || tracker.seen_s() > motion.back().time_s)
      motion.push_back({tracker.seen_s(), tracker.last()});
  };
  for (const RecordedPicture& picture : recording.pictures) {
    for (const Sample& sample : picture.samples) {
      if (sample.kind != SampleKind::place || !tracker.has_tool(sample.source)) continue;
      if (tracker.has_come(sample.source)) settle();
      // As in BenchState, hidden samples do not update the clock map.
      const bool is_seen = static_cast<SeenState>(sample.state) == SeenState::seen;
      const double time_s = is_seen ? clock.time_s(sample.device_ns, sample.arrival_ns)
                                    : static_cast<double>(sample.arrival_ns) * 1e-9;
      tracker.take(sample, time_s);
    }
  }
  settle();
  return motion;
}

std::vector<BodyPrediction> recorded_predictions(const Recording& recording, const BenchFile& bench)
{
  std::vector<BodyPrediction> predictions;
  for (std::size_t role = 0; role < n_body_roles; ++role) {
    const std::vector<TimedPose> motion = recorded_motion(recording, bench, static_cast<BodyRole>(role));
    if (motion.size() < 2) continue;
    for (const double horizon_ms : {16.0, 33.0, 50.0}) {
      predictions.push_back(
          {static_cast<BodyRole>(role), horizon_ms, prediction_error(motion, horizon_ms / 1000.0)});
    }
  }
  return predictions;
}

std::string prediction_text(const std::vector<BodyPrediction>& predictions)
{
  std::ostringstream text;
  for (const BodyPrediction& p : predictions) {
    const PredictionError &mm = p.error.shift_mm, &turn = p.error.turn_rad;
    text << name_of(p.role) << " after " << rounded_text(p.horizon_ms, 2) << " ms: held "
         << hundredths(mm.held.rms) << " mm, " << hundredths(deg_from_rad(turn.held.rms))
         << " deg; predicted " << hundredths(mm.predicted.rms) << " mm, "
         << hundredths(deg_from_rad(turn.predicted.rms)) << " deg (root mean square; 95th percentile "
         << hundredths(mm.predicted.percentile_95) << " mm)\n";
  }
  return text.str();
}

}  // namespace vrda
