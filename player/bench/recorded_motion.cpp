#include "bench/recorded_motion.hpp"

#include <algorithm>
#include <sstream>

#include "core/units.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {
namespace {

std::string hundredths(double value)
{
  return show::rounded_text(value, 2);
}

}  // namespace

MotionCollector::MotionCollector(const bench::BenchFile& bench) : bodies_(bench) {}

void MotionCollector::end_message(BodyTracker& tracker)
{
  if (!tracker.end_message()) return;
  for (std::size_t role = 0; role < motions_.size(); ++role) {
    std::vector<bench::TimedPose>& motion = motions_[role];
    const std::optional<BodyTracker>& own = bodies_[static_cast<bench::BodyRole>(role)];
    if (!own || &*own != &tracker || motion.size() == most_poses) continue;
    if (motion.empty() || tracker.seen_s() > motion.back().time_s)
      motion.push_back({tracker.seen_s(), tracker.last()});
  }
}

void MotionCollector::take(const bench::RecordedFrame& frame)
{
  for (const bench::Sample& sample : frame.samples) {
    if (sample.kind == bench::SampleKind::tool_pose)
      bodies_.take(sample, [this](BodyTracker& tracker) { end_message(tracker); });
  }
}

bool MotionCollector::is_full() const
{
  return std::ranges::any_of(
      motions_, [](const std::vector<bench::TimedPose>& motion) { return motion.size() == most_poses; });
}

const std::vector<bench::TimedPose>& MotionCollector::motion(bench::BodyRole role)
{
  if (std::optional<BodyTracker>& own = bodies_[role]) end_message(*own);
  return motions_[static_cast<std::size_t>(role)];
}

std::vector<bench::TimedPose> recorded_motion(const bench::Recording& recording,
                                                 const bench::BenchFile& bench,
                                                 bench::BodyRole role)
{
  MotionCollector collector(bench);
  for (const bench::RecordedFrame& frame : recording.frames) collector.take(frame);
  return collector.motion(role);
}

std::vector<BodyPrediction> predictions_of(MotionCollector& collector)
{
  std::vector<BodyPrediction> predictions;
  for (std::size_t role = 0; role < bench::n_body_roles; ++role) {
    const std::vector<bench::TimedPose>& motion =
        collector.motion(static_cast<bench::BodyRole>(role));
    if (motion.size() < 2) continue;
    for (const double horizon_ms : {16.0, 33.0, 50.0}) {
      predictions.push_back({static_cast<bench::BodyRole>(role), horizon_ms,
                             bench::prediction_error(motion, horizon_ms / 1000.0)});
    }
  }
  return predictions;
}

std::vector<BodyPrediction> recorded_predictions(const bench::Recording& recording,
                                                 const bench::BenchFile& bench)
{
  MotionCollector collector(bench);
  for (const bench::RecordedFrame& frame : recording.frames) collector.take(frame);
  return predictions_of(collector);
}

std::string prediction_text(const std::vector<BodyPrediction>& predictions)
{
  std::ostringstream text;
  for (const BodyPrediction& p : predictions) {
    const bench::PredictionError &mm = p.error.shift_mm, &turn = p.error.turn_rad;
    text << bench::name_of(p.role) << " after " << show::rounded_text(p.horizon_ms, 2)
         << " ms: held " << hundredths(mm.held.rms) << " mm, " << hundredths(deg_from_rad(turn.held.rms))
         << " deg; predicted " << hundredths(mm.predicted.rms) << " mm, "
         << hundredths(deg_from_rad(turn.predicted.rms)) << " deg (root mean square; 95th percentile "
         << hundredths(mm.predicted.percentile_95) << " mm)\n";
  }
  return text.str();
}

}  // namespace vrda::bench
