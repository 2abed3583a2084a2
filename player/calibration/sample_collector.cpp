#include "calibration/sample_collector.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "bench/screw.hpp"

namespace vrda::calibration {
namespace {

double rounded(double value, double parts)
{
  const double number = std::round(value * parts) / parts;
  // Avoids "-0" in files.
  return number == 0.0 ? 0.0 : number;
}

void add_position(std::vector<double>& row, const bench::ToolPose& place)
{
  for (const double x : place.position_mm) row.push_back(rounded_mm(x));
}

void add_place(std::vector<double>& row, const bench::ToolPose& place)
{
  add_position(row, place);
  for (const double x : place.rotation) row.push_back(rounded(x, 1e8));
}

bool is_finite(const bench::ToolPose& place)
{
  const auto finite = [](double x) { return std::isfinite(x); };
  return std::all_of(std::begin(place.position_mm), std::end(place.position_mm), finite) &&
         std::all_of(std::begin(place.rotation), std::end(place.rotation), finite);
}

}  // namespace

double rounded_mm(double value)
{
  return rounded(value, 1e5);
}

SampleCollector::SampleCollector(const BenchFile& bench) : bench_(bench), trackers_(bench) {}

void SampleCollector::begin(const Task& task, const std::optional<BodyRole>& role)
{
  const std::vector<std::string>& tools = bench_.tracker->tools;
  const auto found = std::ranges::find(tools, task.tool);
  check(found != tools.end(), "the tool of a task is a tool of the tracker");
  tool_ = static_cast<std::size_t>(found - tools.begin());
  kind_ = task.kind;
  role_ = role;
  rows_.clear();
  thigh_before_.reset();
  thigh_.reset();
  shank_.reset();
  is_taking_ = true;
}

void SampleCollector::zero_stage()
{
  stage_mm_ = 0.0;
  is_stage_zeroed_ = true;
}

bool SampleCollector::take(const bench::Sample& sample)
{
  switch (sample.kind) {
    case bench::SampleKind::stage:
      stage_mm_ = rounded_mm(bench_.stage_mm_per_count * sample.count);
      is_stage_zeroed_ = (sample.state & bench::stage_zeroed) != 0;
      return false;
    case bench::SampleKind::link:
      if (static_cast<bench::LinkState>(sample.state) == bench::LinkState::up) return false;
      if (static_cast<bench::DeviceId>(sample.source) == bench::DeviceId::board) stage_mm_.reset();
      if (static_cast<bench::DeviceId>(sample.source) == bench::DeviceId::tracker) trackers_.disconnect();
      return false;
    case bench::SampleKind::tool_pose:
      return take_place(sample);
    case bench::SampleKind::potentiometer:
    case bench::SampleKind::offset:
      return false;
  }
  return false;
}

const bench::BodyTracker* SampleCollector::fresh_body(double time_s)
{
  bench::BodyTracker& tracker = *trackers_[*role_];
  tracker.end_message();
  const double oldest_s = bench_.tracker->stale_after_ms / 1000.0;
  return tracker.is_live() && std::abs(time_s - tracker.seen_s()) <= oldest_s ? &tracker : nullptr;
}

void SampleCollector::end_message(bench::BodyTracker& tracker)
{
  if (!tracker.end_message() || kind_ != TaskKind::bend) return;
  const auto is_of = [&](BodyRole role) { return trackers_[role] && &*trackers_[role] == &tracker; };
  const bench::TimedPose pose{tracker.seen_s(), tracker.last()};
  if (is_of(BodyRole::femur)) {
    thigh_before_ = thigh_;
    thigh_ = pose;
  } else if (is_of(BodyRole::tibia)) {
    shank_ = pose;
  }
}

/// Adds the shank's pose with that of the thigh at its time: the leg moves, so poses of different messages are
/// interpolated.
bool SampleCollector::take_leg()
{
  constexpr double same_s = 1e-4;
  if (!shank_ || !thigh_ || thigh_->time_s < shank_->time_s - same_s) return false;
  Pose X_tracker_thigh = thigh_->X;
  if (thigh_->time_s > shank_->time_s + same_s) {
    const double oldest_s = bench_.tracker->stale_after_ms / 1000.0;
    const bool is_between = thigh_before_ && thigh_before_->time_s <= shank_->time_s + same_s &&
                            thigh_->time_s - thigh_before_->time_s <= oldest_s;
    if (!is_between) {
      shank_.reset();
      return false;
    }
    X_tracker_thigh = bench::between(
        thigh_before_->X, thigh_->X,
        (shank_->time_s - thigh_before_->time_s) / (thigh_->time_s - thigh_before_->time_s));
  }
  std::vector<double> row;
  add_place(row, bench::place_of(X_tracker_thigh));
  add_place(row, bench::place_of(shank_->X));
  rows_.push_back(std::move(row));
  shank_.reset();
  return true;
}

bool SampleCollector::take_place(const bench::Sample& sample)
{
  const bool is_seen = sample.is(bench::ToolVisibility::seen) && is_finite(sample.tool_pose);
  const double time_s = trackers_.take(sample, [this](bench::BodyTracker& tracker) { end_message(tracker); });
  if (is_taking_ && kind_ == TaskKind::bend) return take_leg();
  if (!is_taking_ || !is_seen || sample.source != tool_) return false;
  std::vector<double> row;
  if (kind_ == TaskKind::bullseye) {
    add_position(row, sample.tool_pose);
  } else {
    add_place(row, sample.tool_pose);
  }
  if (role_) {
    const bench::BodyTracker* body = fresh_body(time_s);
    if (body == nullptr) return false;
    add_place(row, bench::place_of(body->last()));
  }
  if (kind_ == TaskKind::sweep && stage_mm_) row.push_back(*stage_mm_);
  rows_.push_back(std::move(row));
  return true;
}

}  // namespace vrda::calibration
