#include "bench/body_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <sstream>

#include "bench/bench_run.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::bench {

namespace {

double cutoff_hz(const OneEuroOptions& options, double speed)
{
  return options.least_cutoff_hz + options.hz_by_speed * speed;
}

/// Smoothing factor of a first-order low-pass filter: 1 / (1 + tau / step), tau = 1 / (2 pi cutoff).
double share(double cutoff, double step_s)
{
  return 1.0 / (1.0 + 1.0 / (2.0 * pi * cutoff * step_s));
}

}  // namespace

// A first-order filter y += a (x - y) lags a ramp of slope v by v step (1 - a) / a, and (1 - a) / a is tau
// / step: the delay is tau for any step.
double OneEuroFilter::filtered(double value, double time_s)
{
  const double step_s = time_s - time_s_;
  if (has_last_ && step_s == 0.0) return value_;
  if (!has_last_ || step_s < 0.0) {
    speed_ = 0.0;
    value_ = value;
  } else {
    speed_ += share(options_.speed_cutoff_hz, step_s) * ((value - raw_) / step_s - speed_);
    value_ += share(cutoff_hz(options_, std::abs(speed_)), step_s) * (value - value_);
  }
  has_last_ = true;
  time_s_ = time_s;
  raw_ = value;
  return value_;
}

LegAngles OneEuroAngles::filtered(const LegAngles& angles, double time_s)
{
  return {flexion_.filtered(angles.flexion_rad, time_s), varus_.filtered(angles.varus_rad, time_s),
          theta_.filtered(angles.theta_rad, time_s)};
}

void OneEuroAngles::start_over()
{
  flexion_.start_over();
  varus_.start_over();
  theta_.start_over();
}

namespace {

/// Slope of the least-squares line through values at times.
template <typename Vector>
class Slope {
 public:
  void add(double time_s, const Vector& value)
  {
    n_ += 1.0;
    const double from_mean_s = time_s - mean_time_s_;
    mean_time_s_ += from_mean_s / n_;
    const Vector from_mean = value - mean_;
    mean_ += from_mean / n_;
    time_sq_s2_ += from_mean_s * (time_s - mean_time_s_);
    product_ += from_mean_s * (value - mean_);
  }
  /// Requires two values or more.
  Vector per_second() const { return product_ / time_sq_s2_; }

 private:
  double n_ = 0.0, mean_time_s_ = 0.0, time_sq_s2_ = 0.0;
  Vector mean_ = Vector::Zero(), product_ = Vector::Zero();
};

using Vector6 = Eigen::Matrix<double, 6, 1>;

Eigen::Vector3d vector_of(const LegAngles& angles)
{
  return {angles.flexion_rad, angles.varus_rad, angles.theta_rad};
}

LegAngles angles_of(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}

}  // namespace

template <typename Sample>
void SampleWindow<Sample>::add(const Sample& sample)
{
  if (n_ > 0 && sample.time_s <= last().time_s) n_ = 0;
  std::size_t first = n_ == max_window_samples ? 1 : 0;
  while (first < n_ && samples_[first].time_s < sample.time_s - options_.window_s) ++first;
  std::move(samples_.begin() + static_cast<std::ptrdiff_t>(first),
            samples_.begin() + static_cast<std::ptrdiff_t>(n_), samples_.begin());
  n_ -= first;
  samples_[n_++] = sample;
}

template <typename Sample>
bool SampleWindow<Sample>::has_velocity() const
{
  check(has_sample(), "a predictor needs a sample");
  return n_ > 1 && last().time_s - samples_[0].time_s >= options_.shortest_span_s;
}

template class SampleWindow<TimedPose>;
template class SampleWindow<TimedAngles>;

Screw PosePredictor::velocity() const
{
  if (!has_velocity()) return {};
  Slope<Vector6> slope;
  for (std::size_t i = 0; i < n_; ++i) {
    const Screw screw = screw_of(last().X.inverse() * samples_[i].X);
    Vector6 numbers;
    numbers << screw.turn_rad, screw.shift_mm;
    slope.add(samples_[i].time_s - last().time_s, numbers);
  }
  const Vector6 per_second = slope.per_second();
  return {per_second.head<3>(), per_second.tail<3>()};
}

Pose PosePredictor::at(double time_s) const
{
  const Screw per_second = velocity();
  return last().X * pose_of(scaled(per_second, std::clamp(time_s - last().time_s, 0.0, options_.longest_s)));
}

LegAngles AnglesPredictor::velocity() const
{
  if (!has_velocity()) return {};
  Slope<Eigen::Vector3d> slope;
  for (std::size_t i = 0; i < n_; ++i)
    slope.add(samples_[i].time_s - last().time_s, vector_of(samples_[i].angles));
  return angles_of(slope.per_second());
}

LegAngles AnglesPredictor::at(double time_s) const
{
  const Eigen::Vector3d per_second = vector_of(velocity());
  const double ahead_s = std::clamp(time_s - last().time_s, 0.0, options_.longest_s);
  return angles_of(vector_of(last().angles) + ahead_s * per_second);
}

namespace {

struct Errors {
  std::vector<double> held, predicted;
  PredictionError summary() const { return {summary_of(held), summary_of(predicted)}; }
};

void add_errors(Errors& shift_mm, Errors& turn_rad, const Pose& X_then, const std::array<Pose, 2>& estimates)
{
  const Pose X_held = X_then.inverse() * estimates[0];
  const Pose X_predicted = X_then.inverse() * estimates[1];
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
  summary.rms = rms_of(errors);
  std::ranges::sort(errors);
  const std::size_t n_within = (95 * errors.size() + 99) / 100;
  summary.percentile_95 = errors[n_within - 1];
  return summary;
}

PosePredictionError prediction_error(std::span<const TimedPose> series, double horizon_s,
                                     const PredictionOptions& options)
{
  PosePredictor predictor(options);
  Errors shift_mm, turn_rad;
  std::size_t j = 0;
  for (std::size_t i = 0; i < series.size(); ++i) {
    check(i == 0 || series[i].time_s > series[i - 1].time_s, "the times of a series must ascend");
    const double time_s = series[i].time_s + horizon_s;
    while (j + 1 < series.size() && series[j + 1].time_s < time_s) ++j;
    if (j + 1 == series.size()) break;
    predictor.add(series[i]);
    const double s = (time_s - series[j].time_s) / (series[j + 1].time_s - series[j].time_s);
    const Pose X_then = between(series[j].X, series[j + 1].X, s);
    add_errors(shift_mm, turn_rad, X_then, {series[i].X, predictor.at(time_s)});
  }
  return {shift_mm.summary(), turn_rad.summary()};
}

// Pose of a tracked body.

namespace {

constexpr std::int64_t clock_step_ns = 1'000'000'000;
constexpr std::int64_t drift_divisor = 10'000;  // 0.1 ms a second

}  // namespace

double ClockMap::time_s(std::int64_t device_ns, std::int64_t arrival_ns)
{
  if (device_ns == 0) {
    time_s_ = std::max(time_s_, static_cast<double>(arrival_ns) * s_per_ns);
    return time_s_;
  }
  const std::int64_t offset_ns = arrival_ns - device_ns;
  const bool is_back = has_offset_ && device_ns < device_ns_;
  const bool is_far_ahead = has_offset_ && offset_ns < offset_ns_ - clock_step_ns;
  if (!has_offset_ || is_back || is_far_ahead) {
    offset_ns_ = offset_ns;
    has_offset_ = true;
  } else {
    const std::int64_t relaxed_ns = (arrival_ns - arrival_ns_) / drift_divisor;
    offset_ns_ = std::min(offset_ns_ + relaxed_ns, offset_ns);
  }
  device_ns_ = device_ns;
  arrival_ns_ = arrival_ns;
  const std::int64_t local_ns = std::min(device_ns + offset_ns_, arrival_ns);
  time_s_ = std::max(time_s_, static_cast<double>(local_ns) * s_per_ns);
  return time_s_;
}

BodyTracker::BodyTracker(const BodySettings& settings, std::size_t first_tool)
    : first_tool_(first_tool), n_tools_(n_tools(settings)), has_markers_(settings.tool.empty())
{
  if (has_markers_) n_tools_ = settings.markers.size();
  has_come_.resize(n_tools_);
  if (!has_markers_) return;
  body_.markers_mm.resize(static_cast<Eigen::Index>(n_tools_), 3);
  for (std::size_t k = 0; k < n_tools_; ++k)
    body_.markers_mm.row(static_cast<Eigen::Index>(k)) = settings.markers_body_mm[k].transpose();
  firing_.interval_s = settings.marker_interval_ms / 1000.0;
  row_.resize(n_tools_);
}

void BodyTracker::take(const Sample& sample, double time_s)
{
  has_come_[sample.source - first_tool_] = true;
  const auto state = static_cast<ToolVisibility>(sample.state);
  if (!has_markers_) {
    state_ = state;
    is_live_ = state == ToolVisibility::seen;
    if (is_live_) see({time_s, pose_of(sample.tool_pose)});
    has_new_pose_ = has_new_pose_ || is_live_;
    return;
  }
  std::optional<Eigen::Vector3d>& marker = row_[sample.source - first_tool_];
  marker.reset();
  if (state == ToolVisibility::seen) marker = Eigen::Vector3d::Map(sample.tool_pose.position_mm);
  // Stamps may be of the frame or of each marker's firing; the frame time is the earliest.
  row_time_s_ = has_row_ ? std::min(row_time_s_, time_s) : time_s;
  has_row_ = true;
}

bool BodyTracker::end_message()
{
  std::fill(has_come_.begin(), has_come_.end(), false);
  if (has_markers_) return has_row_ && settle_markers();
  const bool is_new = has_new_pose_;
  has_new_pose_ = false;
  return is_new;
}

bool BodyTracker::settle_markers()
{
  std::optional<BodyMotion> before;
  if (has_last_) before = BodyMotion{last_, velocity_};
  const FiredFit fired = fit_fired(body_, row_, row_time_s_, before, firing_);
  fit_ = fired.fit;
  velocity_ = fired.velocity;
  has_row_ = false;
  std::fill(row_.begin(), row_.end(), std::nullopt);
  is_live_ = fit_.status == FitStatus::fitted;
  state_ = is_live_ ? ToolVisibility::seen
                    : (fit_.status == FitStatus::too_few_markers ? ToolVisibility::missing
                                                                 : ToolVisibility::invalid_pose);
  if (is_live_) see({row_time_s_, fit_.X_tracker_body});
  return is_live_;
}

void BodyTracker::see(const TimedPose& pose)
{
  // After a long occlusion the velocity is unknown.
  constexpr double longest_gap_s = 0.25;
  if (has_last_ && pose.time_s - last_.time_s > longest_gap_s) predictor_.start_over();
  predictor_.add(pose);
  last_ = pose;
  has_last_ = true;
}

void BodyTracker::disconnect()
{
  is_live_ = false;
  state_ = ToolVisibility::stale;
}

Pose BodyTracker::at(double time_s) const
{
  return is_live_ && predictor_.has_sample() ? predictor_.at(time_s) : last_.X;
}

TrackedBodies::TrackedBodies(const BenchFile& bench)
{
  for (const BodyRole role : body_roles) {
    const std::optional<BodySettings>& body = bench.bodies[role];
    if (body && body->markers_body_mm.size() == body->markers.size())
      trackers_[role].emplace(*body, first_tool_index(bench, role));
  }
}

void TrackedBodies::disconnect()
{
  for (std::optional<BodyTracker>& tracker : trackers_) {
    if (tracker) tracker->disconnect();
  }
}

namespace {

bool has_marker(const MarkerRow& row)
{
  return std::ranges::any_of(row, [](const auto& marker) { return marker.has_value(); });
}

}  // namespace

MarkerFrames::MarkerFrames(std::size_t first_tool, std::size_t n_markers)
    : first_tool_(first_tool), n_markers_(n_markers), has_come_(n_markers), row_(n_markers)
{
}

void MarkerFrames::end_row()
{
  if (has_marker(row_)) rows_.push_back(row_);
  std::fill(row_.begin(), row_.end(), std::nullopt);
  std::fill(has_come_.begin(), has_come_.end(), false);
}

void MarkerFrames::take(const Sample& sample)
{
  const bool is_marker = sample.kind == SampleKind::tool_pose && sample.source >= first_tool_ &&
                         sample.source < first_tool_ + n_markers_;
  if (!is_marker) return;
  const std::size_t k = sample.source - first_tool_;
  // A second sample of a marker starts the next message.
  if (has_come_[k]) end_row();
  has_come_[k] = true;
  if (sample.is(ToolVisibility::seen)) row_[k] = Eigen::Vector3d::Map(sample.tool_pose.position_mm);
}

std::vector<MarkerRow> MarkerFrames::frames(std::size_t most) const
{
  std::vector<MarkerRow> all = rows_;
  if (has_marker(row_)) all.push_back(row_);
  if (all.size() <= most) return all;
  std::vector<MarkerRow> some;
  for (std::size_t k = 0; k < most; ++k) some.push_back(all[k * all.size() / most]);
  return some;
}

FitQuality quality_of(const PoseFit& fit)
{
  FitQuality quality;
  if (fit.status != FitStatus::fitted) return quality;
  const PoseError error = expected_error(fit.cloud, noise_mm(fit));
  quality.residual_mm = fit.residual_rms_mm;
  quality.n_markers = fit.cloud.n;
  quality.rotation_sd_rad = error.turn_rad.maxCoeff();
  quality.centroid_sd_mm = error.centre_mm;
  return quality;
}

std::string fit_text(const PoseFit& fit)
{
  if (fit.status != FitStatus::fitted) {
    std::string why = name_of(fit.status);
    std::replace(why.begin(), why.end(), '_', ' ');
    return why;
  }
  const FitQuality quality = quality_of(fit);
  return "residual " + short_decimal(quality.residual_mm, 2) + " mm at " + std::to_string(quality.n_markers) +
         " markers, rotation sd " + short_decimal(deg_from_rad(quality.rotation_sd_rad), 2) + " deg";
}

namespace {

constexpr double range_slack_rad = rad_from_deg(1.0);
// A knee overextends by up to 15 degrees, and models end at 90 where knees bend to 160.
constexpr double most_before_rad = rad_from_deg(20.0), most_after_rad = rad_from_deg(75.0);
constexpr double most_beside_rad = rad_from_deg(30.0), largest_rotation_rad = rad_from_deg(60.0);

BeyondRange beyond(double measured_rad, double first_rad, double last_rad)
{
  const double nearest_rad = std::clamp(measured_rad, first_rad, last_rad);
  // A motion with one varus, or its own, has no range of it.
  const bool is_range = first_rad < last_rad;
  return {measured_rad, nearest_rad, is_range && std::abs(measured_rad - nearest_rad) > range_slack_rad};
}

bool is_plausible(const BeyondRange& flexion, const BeyondRange& varus, double rotation_rad)
{
  const double after_rad = flexion.measured_rad - flexion.nearest_rad;
  const double beside_rad = varus.measured_rad - varus.nearest_rad;
  return after_rad >= -most_before_rad && after_rad <= most_after_rad &&
         std::abs(beside_rad) <= most_beside_rad && std::abs(rotation_rad) <= largest_rotation_rad;
}

std::string beyond_text(const char* angle, const BeyondRange& at)
{
  const auto degrees = [](double rad) { return short_decimal(std::round(deg_from_rad(rad)), 0); };
  return std::string(angle) + ' ' + degrees(at.measured_rad) + ", model " +
         (at.measured_rad > at.nearest_rad ? "ends" : "begins") + " at " + degrees(at.nearest_rad);
}

}  // namespace

LegCheck check_leg(const store::Motion& motion, const LegAngles& measured, const LegAngles& exchanged)
{
  const auto flexion_of = [&motion](const LegAngles& angles) {
    return beyond(angles.flexion_rad, motion.first_flexion_rad(), motion.last_flexion_rad());
  };
  const auto varus_of = [&motion](const LegAngles& angles) {
    return beyond(angles.varus_rad, motion.first_varus_rad(), motion.last_varus_rad());
  };
  LegCheck check{flexion_of(measured), varus_of(measured), false, false, measured.theta_rad};
  check.is_implausible = !is_plausible(check.flexion, check.varus, measured.theta_rad);
  const BeyondRange other = flexion_of(exchanged);
  check.are_bodies_exchanged = check.is_implausible && !other.is_beyond &&
                               is_plausible(other, varus_of(exchanged), exchanged.theta_rad);
  return check;
}

std::string leg_check_text(const LegCheck& check)
{
  if (!check.is_wrong()) return {};
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  // The cause first: narrow windows cut the end.
  if (check.are_bodies_exchanged) {
    add("femur and tibia bodies probably exchanged");
  } else if (check.is_implausible) {
    add("implausible angles: check bodies and calibration");
  }
  if (check.flexion.is_beyond) add(beyond_text("flexion", check.flexion));
  if (check.varus.is_beyond) add(beyond_text("varus", check.varus));
  if (std::abs(check.rotation_rad) > largest_rotation_rad)
    add("rotation " + short_decimal(std::round(deg_from_rad(check.rotation_rad)), 0));
  return text;
}

}  // namespace vrda::bench
