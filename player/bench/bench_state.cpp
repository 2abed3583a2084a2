#include "bench/bench_state.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

constexpr double most_count = 1023.0;
/// Parameter steps per full travel of the potentiometer.
constexpr double steps_a_turn = 200.0;
/// In counts: stable within the converter's last bit at rest, fast when turned.
constexpr OneEuroOptions potentiometer_options{1.0, 0.05, 2.0};
/// Counts; at rest, noise and the last of 10 bits move the filtered count by at most one.
constexpr double turned_counts = 2.0;
/// Three time constants of the filter at rest (0.16 s).
constexpr double settles_s = 0.5;

double seconds(std::int64_t ns)
{
  return static_cast<double>(ns) * s_per_ns;
}

bool is_angle_of_leg(std::size_t parameter)
{
  const std::string& name = parameters()[parameter].name;
  return name == "flexion" || name == "varus";
}

OneEuroOptions angle_filter(const FilterSettings& settings)
{
  // The file has Hz per degree/s, the filter uses Hz per rad/s.
  return {settings.least_cutoff_hz, settings.slope * deg_from_rad(1.0), default_angle_filter.speed_cutoff_hz};
}

}  // namespace

bool is_live(const BenchFrame& frame)
{
  const auto is_fine = [](const InputMark& mark) { return !mark.is_used || mark.is_live; };
  return std::all_of(frame.bodies.begin(), frame.bodies.end(), is_fine) && is_fine(frame.stage) &&
         is_fine(frame.potentiometer);
}

BenchState::BenchState(const BenchFile& bench, const Calibration& calibration, const Motion& motion,
                       const SolverFrame& frame)
    : bench_(bench),
      motion_(motion),
      frame_of_model_(frame),
      potentiometer_filter_(potentiometer_options),
      is_filtered_(bench.filter.is_on),
      filter_(angle_filter(bench.filter))
{
  values_.calibration = calibration;
  values_.prediction_ms = bench.prediction_ms;
  values_.flexion_deg = deg_from_rad(motion.first_flexion_rad());
  values_.varus_deg = deg_from_rad(motion.balanced_varus_rad(motion.first_flexion_rad()));
  for (std::size_t role = 0; role < n_body_roles; ++role) {
    if (bench.bodies[role])
      trackers_[role].emplace(*bench.bodies[role], first_tool_of(bench, static_cast<BodyRole>(role)));
  }
  if (!bench.potentiometer.empty() && bench.potentiometer != "selected")
    driven_ = parameter_named(bench.potentiometer);
  std::size_t first = 0;
  while (!is_used(first, bench)) ++first;
  select(first);
}

BodyTracker* BenchState::body(BodyRole role)
{
  std::optional<BodyTracker>& tracker = trackers_[static_cast<std::size_t>(role)];
  return tracker ? &*tracker : nullptr;
}

const PoseFit* BenchState::fit(BodyRole role) const
{
  const std::optional<BodyTracker>& tracker = trackers_[static_cast<std::size_t>(role)];
  return tracker && tracker->has_markers() ? &tracker->fit() : nullptr;
}

void BenchState::select(std::size_t parameter)
{
  check(parameter < parameters().size(), "the selected parameter is in the list");
  selected_ = parameter;
  start_count_.reset();
  if (potentiometer_.was_seen) start_count_ = rest_count_ = potentiometer_count_;
  turning_until_s_ = 0.0;
  start_value_ = value_of(values_, driven_.value_or(parameter));
}

void BenchState::take(const Sample& sample)
{
  switch (sample.kind) {
    case SampleKind::place:
      take_place(sample);
      break;
    case SampleKind::potentiometer:
      take_potentiometer(sample);
      break;
    case SampleKind::stage:
      take_stage(sample);
      break;
    case SampleKind::link:
      take_link(sample);
      break;
  }
}

void BenchState::take_place(const Sample& sample)
{
  const bool is_seen = static_cast<SeenState>(sample.state) == SeenState::seen;
  const double time_s =
      is_seen ? tracker_clock_.time_s(sample.device_ns, sample.arrival_ns) : seconds(sample.arrival_ns);
  for (std::optional<BodyTracker>& tracker : trackers_) {
    if (!tracker || !tracker->has_tool(sample.source)) continue;
    // Several messages may arrive between two frames.
    if (tracker->has_come(sample.source)) settle();
    tracker->take(sample, time_s);
  }
  if (!is_seen) return;
  newest_arrival_ns_ = sample.arrival_ns;
  ++n_samples_;
}

void BenchState::take_link(const Sample& sample)
{
  if (static_cast<LinkState>(sample.state) == LinkState::up) return;
  if (static_cast<DeviceId>(sample.source) == DeviceId::tracker) {
    for (std::optional<BodyTracker>& tracker : trackers_) {
      if (tracker) tracker->lose();
    }
  } else {
    stage_.is_live = potentiometer_.is_live = false;
    stage_.is_heard = potentiometer_.is_heard = false;
  }
}

void BenchState::take_stage(const Sample& sample)
{
  // After a restart the board counts from an unknown stage position.
  const bool was_zeroed = stage_.was_seen && (stage_.flags & stage_zeroed) != 0;
  const bool is_zeroed = (sample.state & stage_zeroed) != 0;
  has_lost_zero_ = !is_zeroed && (has_lost_zero_ || was_zeroed);
  stage_.is_heard = true;
  stage_.is_live = !has_lost_zero_;
  stage_.flags = sample.state;
  if (has_lost_zero_) return;
  stage_.was_seen = true;
  stage_.time_s = seconds(sample.arrival_ns);
  stage_.count = sample.count;
}

void BenchState::take_potentiometer(const Sample& sample)
{
  const double time_s = seconds(sample.arrival_ns);
  potentiometer_ = {true, true, true, time_s, sample.count, 0};
  potentiometer_count_ = potentiometer_filter_.filtered(sample.count, time_s);
  if (!start_count_) start_count_ = potentiometer_count_;
  // At rest the keys set the parameter.
  if (!is_turning(time_s)) return;
  const std::size_t parameter = driven_.value_or(selected_);
  const Parameter& driven = parameters()[parameter];
  if (is_angle_of_leg(parameter)) {
    const double share = std::clamp(potentiometer_count_ / most_count, 0.0, 1.0);
    const double least = least_of(parameter), most = most_of(parameter);
    set_value(values_, parameter, least + share * (most - least));
    return;
  }
  const double steps = (potentiometer_count_ - *start_count_) / most_count * steps_a_turn;
  // Whole steps suppress the noise of a potentiometer at rest.
  set_value(values_, parameter, start_value_ + std::round(steps) * driven.step);
}

/// True for the first sample, and from a motion of `turned_counts` until the filter has settled.
bool BenchState::is_turning(double time_s)
{
  if (!rest_count_ || std::abs(potentiometer_count_ - *rest_count_) >= turned_counts) {
    rest_count_ = potentiometer_count_;
    turning_until_s_ = time_s + settles_s;
  }
  return time_s < turning_until_s_;
}

double BenchState::least_of(std::size_t parameter) const
{
  const bool is_flexion = parameters()[parameter].name == "flexion";
  return deg_from_rad(is_flexion ? motion_.first_flexion_rad() : motion_.first_varus_rad());
}

double BenchState::most_of(std::size_t parameter) const
{
  const bool is_flexion = parameters()[parameter].name == "flexion";
  return deg_from_rad(is_flexion ? motion_.last_flexion_rad() : motion_.last_varus_rad());
}

void BenchState::settle()
{
  bool is_leg_new = false;
  for (std::size_t role = 0; role < n_body_roles; ++role) {
    const bool is_new = trackers_[role] && trackers_[role]->settle();
    is_leg_new = is_leg_new || (is_new && static_cast<BodyRole>(role) != BodyRole::head);
  }
  if (is_leg_new && bench_.leg == LegKind::two_bodies) update_leg();
}

void BenchState::update_leg()
{
  const BodyTracker& femur = *body(BodyRole::femur);
  const BodyTracker& tibia = *body(BodyRole::tibia);
  if (!femur.is_live() || !tibia.is_live()) return;
  const double time_s = std::max(femur.seen_s(), tibia.seen_s());
  LegBodies bodies;
  bodies.X_thigh_femur = pose_of(values_.calibration.X_body_model[static_cast<std::size_t>(BodyRole::femur)]);
  bodies.X_shank_tibia = pose_of(values_.calibration.X_body_model[static_cast<std::size_t>(BodyRole::tibia)]);
  const LegAngles raw =
      leg_angles(X_femur_tibia(bodies, femur.at(time_s), tibia.at(time_s)), frame_of_model_);
  // Filter and predictor restart after a long occlusion.
  constexpr double longest_gap_s = 0.25;
  if (angles_ && time_s - angles_->time_s > longest_gap_s) {
    filter_.start_over();
    angles_predictor_.start_over();
  }
  angles_ = TimedAngles{time_s, is_filtered_ ? filter_.filtered(raw, time_s) : raw};
  angles_predictor_.add(*angles_);
}

double BenchState::stage_mm() const
{
  return bench_.stage_mm_per_count * static_cast<double>(stage_.count);
}

Pose BenchState::X_tracker_eyes(double time_s) const
{
  const Calibration& c = values_.calibration;
  if (bench_.head == HeadKind::tracker) {
    const BodyTracker& head = *trackers_[static_cast<std::size_t>(BodyRole::head)];
    // Until the head is seen, the nominal pose on the table is used.
    if (head.was_seen()) return head.at(time_s) * pose_of(c.X_headbody_eyes);
  }
  Pose X_table_eyes = pose_of(c.X_table_eyes);
  X_table_eyes.translation() += stage_mm() * c.stage_direction_table;
  return pose_of(c.X_tracker_table) * X_table_eyes;
}

void BenchState::place_model(double time_s)
{
  const bool is_rigid = bench_.leg == LegKind::rigid;
  Attitude attitude{rad_from_deg(values_.flexion_deg), rad_from_deg(values_.varus_deg)};
  if (!is_rigid) {
    const bool is_live = body(BodyRole::femur)->is_live() && body(BodyRole::tibia)->is_live();
    if (angles_) attitude = attitude_of(is_live ? angles_predictor_.at(time_s) : angles_->angles);
  }
  const JointPose pose = motion_.at(attitude);
  // At an unsolved cell the last solved pose is kept.
  if (pose.status == PoseStatus::solved || shown_.pose.status != PoseStatus::solved) shown_.pose = pose;
  const BodyRole role = is_rigid ? BodyRole::leg : BodyRole::femur;
  shown_.X_tracker_reference =
      body(role)->at(time_s) * pose_of(values_.calibration.X_body_model[static_cast<std::size_t>(role)]);
  shown_.X_tracker_moving = shown_.X_tracker_reference * shown_.pose.X_reference_moving;
}

InputMark BenchState::mark_of(const BodyTracker& tracker, double now_s) const
{
  return {true, tracker.is_live(), tracker.was_seen(),
          tracker.was_seen() ? std::max(0.0, now_s - tracker.seen_s()) : 0.0, tracker.state()};
}

InputMark BenchState::mark_of(const BoardInput& input, double now_s) const
{
  return {true, input.is_live, input.was_seen, input.was_seen ? std::max(0.0, now_s - input.time_s) : 0.0,
          input.is_heard ? SeenState::seen : SeenState::stale};
}

const BenchFrame& BenchState::frame(std::int64_t now_ns)
{
  settle();
  const double now_s = seconds(now_ns);
  // Without prediction the newest poses are shown without extrapolation to now.
  const bool is_predicted = values_.prediction_ms > 0.0;
  const double time_s = is_predicted ? now_s + values_.prediction_ms / 1000.0 : 0.0;
  place_model(time_s);
  shown_.X_tracker_eyes = X_tracker_eyes(time_s);
  for (std::size_t role = 0; role < n_body_roles; ++role) {
    shown_.bodies[role] = trackers_[role] ? mark_of(*trackers_[role], now_s) : InputMark{};
  }
  shown_.stage = bench_.board && bench_.board->has_stage ? mark_of(stage_, now_s) : InputMark{};
  shown_.potentiometer =
      bench_.board && bench_.board->has_potentiometer ? mark_of(potentiometer_, now_s) : InputMark{};
  shown_.stage_mm = stage_mm();
  shown_.is_stage_zeroed = (stage_.flags & stage_zeroed) != 0;
  shown_.has_stage_lost_counts = (stage_.flags & stage_lost_counts) != 0;
  shown_.newest_arrival_ns = n_samples_ > 0 ? newest_arrival_ns_ : 0;
  shown_.n_samples = n_samples_;
  n_samples_ = 0;
  return shown_;
}

}  // namespace vrda
