#include "bench/recorded_motion.hpp"

#include <sstream>

#include "bench/body_tracker.hpp"
#include "core/units.hpp"
#include "settings/settings_text.hpp"

namespace vrda::bench {
namespace {

std::string hundredths(double value)
{
  return settings::rounded_text(value, 2);
}

}  // namespace

std::vector<tracking::TimedPose> recorded_motion(const recording::Recording& recording,
                                                 const bench_files::BenchFile& bench,
                                                 bench_files::BodyRole role)
{
  std::vector<tracking::TimedPose> motion;
  TrackedBodies bodies(bench);
  if (!bodies[role]) return motion;
  const BodyTracker& own = *bodies[role];
  const auto end_message = [&](BodyTracker& tracker) {
    if (!tracker.end_message() || &tracker != &own) return;
    if (motion.empty() || own.seen_s() > motion.back().time_s) motion.push_back({own.seen_s(), own.last()});
  };
  for (const recording::RecordedFrame& picture : recording.frames) {
    for (const devices::Sample& sample : picture.samples) {
      if (sample.kind == devices::SampleKind::tool_pose) bodies.take(sample, end_message);
    }
  }
  end_message(*bodies[role]);
  return motion;
}

std::vector<BodyPrediction> recorded_predictions(const recording::Recording& recording,
                                                 const bench_files::BenchFile& bench)
{
  std::vector<BodyPrediction> predictions;
  for (std::size_t role = 0; role < bench_files::n_body_roles; ++role) {
    const std::vector<tracking::TimedPose> motion =
        recorded_motion(recording, bench, static_cast<bench_files::BodyRole>(role));
    if (motion.size() < 2) continue;
    for (const double horizon_ms : {16.0, 33.0, 50.0}) {
      predictions.push_back({static_cast<bench_files::BodyRole>(role), horizon_ms,
                             tracking::prediction_error(motion, horizon_ms / 1000.0)});
    }
  }
  return predictions;
}

std::string prediction_text(const std::vector<BodyPrediction>& predictions)
{
  std::ostringstream text;
  for (const BodyPrediction& p : predictions) {
    const tracking::PredictionError &mm = p.error.shift_mm, &turn = p.error.turn_rad;
    text << bench_files::name_of(p.role) << " after " << settings::rounded_text(p.horizon_ms, 2)
         << " ms: held " << hundredths(mm.held.rms) << " mm, " << hundredths(deg_from_rad(turn.held.rms))
         << " deg; predicted " << hundredths(mm.predicted.rms) << " mm, "
         << hundredths(deg_from_rad(turn.predicted.rms)) << " deg (root mean square; 95th percentile "
         << hundredths(mm.predicted.percentile_95) << " mm)\n";
  }
  return text.str();
}

}  // namespace vrda::bench
