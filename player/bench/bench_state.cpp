#include "bench/bench_state.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <sstream>

#include "core/text.hpp"
#include "core/units.hpp"
#include "view/stereo_view.hpp"

namespace vrda::bench {
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
  return {settings.least_cutoff_hz, settings.slope, default_angle_filter.speed_cutoff_hz};
}

}  // namespace

bool is_live(const BenchFrame& frame)
{
  const auto is_fine = [](const InputStatus& mark) { return !mark.is_used || mark.is_live; };
  return std::ranges::all_of(frame.bodies, is_fine) && is_fine(frame.stage) && is_fine(frame.potentiometer);
}

BenchState::BenchState(const BenchFile& bench, const Calibration& calibration, const store::Motion& motion,
                       const SolverFrame& frame)
    : bench_(bench),
      motion_(motion),
      frame_of_model_(frame),
      trackers_(bench),
      potentiometer_filter_(potentiometer_options),
      is_filtered_(bench.filter.is_on),
      filter_(angle_filter(bench.filter))
{
  values_.calibration = calibration;
  values_.prediction_ms = bench.prediction_ms;
  values_.flexion_rad = motion.first_flexion_rad();
  values_.varus_rad = motion.balanced_varus_rad(motion.first_flexion_rad());
  if (!bench.potentiometer.empty() && bench.potentiometer != "selected")
    driven_ = find_parameter(bench.potentiometer);
  std::size_t first = 0;
  while (!is_used(first, bench)) ++first;
  select(first);
}

const PoseFit* BenchState::fit(BodyRole role) const
{
  const std::optional<BodyTracker>& tracker = trackers_[role];
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
    case SampleKind::tool_pose:
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
    case SampleKind::offset:
      X_leg_joint_ = pose_of(sample.tool_pose);
      break;
  }
}

void BenchState::take_place(const Sample& sample)
{
  // Several messages may arrive between two frames.
  trackers_.take(sample, [&](BodyRole) { end_messages(); });
  if (!sample.is(ToolVisibility::seen)) return;
  newest_arrival_ns_ = sample.arrival_ns;
  ++n_samples_;
}

void BenchState::take_link(const Sample& sample)
{
  if (static_cast<LinkState>(sample.state) == LinkState::up) return;
  if (static_cast<DeviceId>(sample.source) == DeviceId::tracker) {
    trackers_.disconnect();
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
    const bool is_flexion = driven.name == "flexion";
    const double least = deg_from_rad(is_flexion ? motion_.first_flexion_rad() : motion_.first_varus_rad());
    const double most = deg_from_rad(is_flexion ? motion_.last_flexion_rad() : motion_.last_varus_rad());
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

void BenchState::end_messages()
{
  bool is_leg_new = false;
  for (const BodyRole role : body_roles) {
    const bool is_new = trackers_[role] && trackers_[role]->end_message();
    is_leg_new = is_leg_new || (is_new && role != BodyRole::head);
  }
  if (is_leg_new && bench_.leg == LegKind::two_bodies) update_leg();
}

void BenchState::update_leg()
{
  const BodyTracker& femur = *trackers_[BodyRole::femur];
  const BodyTracker& tibia = *trackers_[BodyRole::tibia];
  if (!femur.is_live() || !tibia.is_live()) return;
  const double time_s = std::max(femur.seen_s(), tibia.seen_s());
  const ByRole<PoseParameters>& models = values_.calibration.X_body_model;
  const LegBodies bodies{pose_of(models[BodyRole::femur]), pose_of(models[BodyRole::tibia])};
  const LegAngles raw =
      leg_angles(X_femur_tibia(bodies, femur.at(time_s), tibia.at(time_s)), frame_of_model_);
  exchanged_ = leg_angles(X_femur_tibia(bodies, tibia.at(time_s), femur.at(time_s)), frame_of_model_);
  // Filter and predictor restart after a long occlusion.
  constexpr double longest_gap_s = 0.25;
  if (angles_ && time_s - angles_->time_s > longest_gap_s) {
    filter_.start_over();
    angles_predictor_.start_over();
  }
  angles_ = TimedAngles{time_s, is_filtered_ ? filter_.filtered(raw, time_s) : raw};
  angles_predictor_.add(*angles_);
}

Pose BenchState::X_tracker_eyes(double time_s) const
{
  const Calibration& c = values_.calibration;
  if (bench_.head == HeadKind::tracker) {
    const BodyTracker& head = *trackers_[BodyRole::head];
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
  Attitude attitude{values_.flexion_rad, values_.varus_rad};
  if (!is_rigid) {
    const bool is_live = trackers_[BodyRole::femur]->is_live() && trackers_[BodyRole::tibia]->is_live();
    if (angles_) attitude = attitude_of(is_live ? angles_predictor_.at(time_s) : angles_->angles);
  }
  shown_.leg = angles_ ? check_leg(motion_, angles_->angles, exchanged_)
                       : check_leg(motion_, {attitude.flexion_rad, attitude.varus_rad, 0.0}, {});
  const store::JointPose pose = motion_.at(attitude);
  // At an unsolved cell the last solved pose is kept, which is said.
  const bool is_solved = pose.status == store::PoseStatus::solved;
  if (is_solved || shown_.pose.status != store::PoseStatus::solved) shown_.pose = pose;
  shown_.is_pose_held = !is_solved;
  const BodyRole role = is_rigid ? BodyRole::leg : BodyRole::femur;
  shown_.X_tracker_reference =
      trackers_[role]->at(time_s) * pose_of(values_.calibration.X_body_model[role]) * X_leg_joint_;
  shown_.is_moved_aside = !X_leg_joint_.isApprox(Pose::Identity(), 0.0);
  shown_.X_tracker_moving = shown_.X_tracker_reference * shown_.pose.X_reference_moving;
}

InputStatus BenchState::mark_of(const BodyTracker& tracker, double now_s)
{
  const double age_s = tracker.was_seen() ? std::max(0.0, now_s - tracker.seen_s()) : 0.0;
  return {true, tracker.is_live(), tracker.was_seen(), age_s, tracker.state()};
}

InputStatus BenchState::mark_of(const BoardInput& input, double now_s)
{
  const double age_s = input.was_seen ? std::max(0.0, now_s - input.time_s) : 0.0;
  return {true, input.is_live, input.was_seen, age_s,
          input.is_heard ? ToolVisibility::seen : ToolVisibility::stale};
}

const BenchFrame& BenchState::frame(std::int64_t now_ns)
{
  end_messages();
  const double now_s = seconds(now_ns);
  // Without prediction the newest poses are shown without extrapolation to now.
  const bool is_predicted = values_.prediction_ms > 0.0;
  const double time_s = is_predicted ? now_s + values_.prediction_ms / 1000.0 : 0.0;
  place_model(time_s);
  shown_.X_tracker_eyes = X_tracker_eyes(time_s);
  for (const BodyRole role : body_roles)
    shown_.bodies[role] = trackers_[role] ? mark_of(*trackers_[role], now_s) : InputStatus{};
  shown_.stage = bench_.board && bench_.board->has_stage ? mark_of(stage_, now_s) : InputStatus{};
  shown_.potentiometer =
      bench_.board && bench_.board->has_potentiometer ? mark_of(potentiometer_, now_s) : InputStatus{};
  shown_.stage_mm = stage_mm();
  shown_.is_stage_zeroed = (stage_.flags & stage_zeroed) != 0;
  shown_.stage_has_lost_counts = (stage_.flags & stage_lost_counts) != 0;
  shown_.newest_arrival_ns = n_samples_ > 0 ? newest_arrival_ns_ : 0;
  shown_.n_samples = n_samples_;
  n_samples_ = 0;
  return shown_;
}

namespace {

double spread_of(double sum, double sum_squares, double n)
{
  if (n < 1.0) return 0.0;
  const double mean = sum / n;
  return std::sqrt(std::max(0.0, sum_squares / n - mean * mean));
}

/// Rounded to 0.01 ms.
std::string ms_text(double ms)
{
  return short_decimal(ms, 2);
}

void write_histogram(std::ostream& out, const char* name, const TimeHistogram& times)
{
  out << "  \"" << name << "\": {\"n\": " << times.n() << ", \"mean\": " << ms_text(times.mean_ms())
      << ", \"spread\": " << ms_text(times.spread_ms())
      << ", \"median\": " << ms_text(times.percentile_ms(0.5))
      << ", \"p95\": " << ms_text(times.percentile_ms(0.95))
      << ", \"p99\": " << ms_text(times.percentile_ms(0.99)) << ", \"longest\": " << ms_text(times.max_ms())
      << ",\n    \"bins_from_ms\": [";
  const char* comma = "";
  for (std::size_t k = 0; k < times.bins().size(); ++k) {
    if (times.bins()[k] == 0) continue;
    out << comma << "[" << ms_text(static_cast<double>(k) * TimeHistogram::bin_ms) << ", " << times.bins()[k]
        << "]";
    comma = ", ";
  }
  out << "]}";
}

}  // namespace

void TimeHistogram::add(double time_ms)
{
  const double at = std::clamp(time_ms / bin_ms, 0.0, static_cast<double>(n_bins - 1));
  ++bins_[static_cast<std::size_t>(at)];
  ++n_;
  sum_ms_ += time_ms;
  sum_squares_ += time_ms * time_ms;
  longest_ms_ = std::max(longest_ms_, time_ms);
}

double TimeHistogram::spread_ms() const
{
  return spread_of(sum_ms_, sum_squares_, static_cast<double>(n_));
}

double TimeHistogram::percentile_ms(double share) const
{
  const double wanted = share * static_cast<double>(n_);
  std::uint64_t n = 0;
  for (std::size_t k = 0; k + 1 < n_bins; ++k) {
    n += bins_[k];
    if (n > 0 && static_cast<double>(n) >= wanted) return static_cast<double>(k + 1) * bin_ms;
  }
  return longest_ms_;
}

/// Updates the estimated interval slowly, because gaps are rare. A clock adjustment gives one short step,
/// stamp jitter alternating ones, a faster stream consecutive ones. Returns true for a short step.
bool StreamStatistics::follow_pace(double step_ns)
{
  constexpr double update_share = 0.02, shortest_share = 0.75, longest_share = 1.5;
  constexpr int n_to_accept = 8;  // as for clocks (bench/protocols.hpp)
  if (interval_ns_ == 0.0) interval_ns_ = step_ns;
  if (step_ns >= shortest_share * interval_ns_) {
    n_short_ = 0;
    short_sum_ns_ = 0.0;
    interval_ns_ += update_share * (std::min(step_ns, longest_share * interval_ns_) - interval_ns_);
    return false;
  }
  short_sum_ns_ += step_ns;
  if (++n_short_ == n_to_accept) {
    interval_ns_ = short_sum_ns_ / n_to_accept;
    n_short_ = 0;
    short_sum_ns_ = 0.0;
  }
  return true;
}

void StreamStatistics::add(std::int64_t device_ns, std::int64_t arrival_ns)
{
  const std::int64_t step_ns = device_ns - device_ns_;
  const std::int64_t delay_ns = arrival_ns - device_ns;
  const bool is_first = n_++ == 0;
  device_ns_ = device_ns;
  // After a clock step the delays are estimated again, and the gap is unknown.
  constexpr std::int64_t longest_gap_ns = 1'000'000'000;
  constexpr std::int64_t drift_share = 10'000;  // 0.1 ms a second
  if (is_first || step_ns <= 0 || step_ns > longest_gap_ns) {
    least_delay_ns_ = delay_ns;
    return;
  }
  const auto step = static_cast<double>(step_ns);
  // Follows clock drift as ClockMap does, and a clock set back by less than an interval.
  least_delay_ns_ += step_ns / drift_share;
  if (follow_pace(step)) least_delay_ns_ = delay_ns;
  n_missed_ += static_cast<std::uint64_t>(std::max(0.0, std::round(step / interval_ns_) - 1.0));
  least_delay_ns_ = std::min(least_delay_ns_, delay_ns);
  const double late_ns = static_cast<double>(delay_ns - least_delay_ns_);
  if (late_ns > 0.5 * interval_ns_) ++n_late_;
  const double late_ms = late_ns * ms_per_ns;
  sum_ms_ += late_ms;
  sum_squares_ += late_ms * late_ms;
  ++n_delays_;
}

double StreamStatistics::jitter_ms() const
{
  return spread_of(sum_ms_, sum_squares_, static_cast<double>(n_delays_));
}

void write_timing(std::ostream& out, const BenchTiming& timing)
{
  out << "{\n  \"pictures\": " << timing.n_pictures
      << ",\n  \"pictures_without_new_sample\": " << timing.n_without_sample
      << ",\n  \"pictures_with_an_input_not_live\": " << timing.n_not_live
      << ",\n  \"samples\": " << timing.n_samples << ",\n  \"samples_missed\": " << timing.n_missed
      << ",\n  \"samples_late\": " << timing.n_late << ",\n  \"samples_lost\": " << timing.n_lost
      << ",\n  \"sample_jitter_ms\": " << ms_text(timing.jitter_ms) << ",\n";
  write_histogram(out, "latency_ms", timing.latency);
  out << ",\n";
  if (timing.camera.n() > 0) {
    write_histogram(out, "camera_latency_ms", timing.camera);
    out << ",\n";
  }
  write_histogram(out, "interval_ms", timing.interval);
  out << ",\n";
  write_histogram(out, "drawing_ms", timing.drawing);
  out << "\n}\n";
}

std::string timing_text(const BenchTiming& timing)
{
  std::ostringstream text;
  const double rate = timing.interval.mean_ms() > 0.0 ? 1000.0 / timing.interval.mean_ms() : 0.0;
  text << timing.n_pictures << " frames, " << short_decimal(rate, 1) << " a second; latency "
       << ms_text(timing.latency.percentile_ms(0.5)) << " ms (median), "
       << ms_text(timing.latency.percentile_ms(0.99)) << " ms (99th percentile), "
       << ms_text(timing.latency.max_ms()) << " ms (longest); " << timing.n_samples << " samples, "
       << timing.n_missed << " missed, " << timing.n_late << " late, " << timing.n_lost << " lost";
  return text.str();
}

namespace {

/// The window in square pixels of its pixels' height.
view::Viewport square_window(const view::Viewport& window, double pixel_aspect)
{
  return {window.x, window.y, static_cast<int>(std::lround(window.width / pixel_aspect)), window.height};
}

}  // namespace

/// Where the pointer is in what the eye sees, in square pixels.
Eigen::Vector2d Trackball::picture_px(const HeldDrag& held, const view::InputEvent& event) const
{
  const Eigen::Vector2d at =
      view::reflected_px(display_.reflection, held.window,
                         {static_cast<float>(event.x_px), static_cast<float>(event.y_px)})
          .cast<double>();
  return {held.window.x + (at.x() - held.window.x) / held.pixel_aspect, at.y()};
}

std::optional<Sample> Trackball::take(const view::InputEvent& event, const BenchState& state,
                                      const BenchFrame& frame, std::int64_t now_ns)
{
  const view::EyePair& eyes = state.values().calibration.eyes;
  if (event.kind == view::InputKind::press && !held_) {
    for (const bool is_right : {false, true}) {
      const view::Eye& eye = view::side_of(eyes, is_right);
      const view::Viewport pixel{static_cast<int>(event.x_px), static_cast<int>(event.y_px), 1, 1};
      if (view::within(pixel, eye.window).width == 0) continue;
      HeldDrag& held = held_.emplace(HeldDrag{});
      held.button = event.button;
      held.window = eye.window;
      held.pixel_aspect = eye.pixel_aspect;
      held.X_leg_joint = state.X_leg_joint();
      held.X_tracker_leg = frame.X_tracker_reference * held.X_leg_joint.inverse();
      held.drag.kind = view::drag_of(event.button, event.has_shift, event.has_control);
      held.drag.press_px = picture_px(held, event);
      held.drag.at_press = {view::camera_of(eye, frame.X_tracker_eyes, view::box_of(eye.window)),
                            frame.X_tracker_reference * centre_mm_};
    }
    return std::nullopt;
  }
  if (!held_) return std::nullopt;
  const bool is_end = event.kind == view::InputKind::focus_lost ||
                      (event.kind == view::InputKind::release && event.button == held_->button);
  if (is_end) held_.reset();
  if (event.kind != view::InputKind::motion) return std::nullopt;
  // Moving the camera by its inverse motion moves the joint.
  const view::OrbitCamera moved = view::dragged(held_->drag, picture_px(*held_, event),
                                                square_window(held_->window, held_->pixel_aspect));
  const Pose X_motion = held_->drag.at_press.camera.X_world_camera * moved.camera.X_world_camera.inverse();
  Sample sample;
  sample.kind = SampleKind::offset;
  sample.arrival_ns = now_ns;
  sample.tool_pose =
      place_of(held_->X_tracker_leg.inverse() * X_motion * held_->X_tracker_leg * held_->X_leg_joint);
  return sample;
}

}  // namespace vrda::bench
