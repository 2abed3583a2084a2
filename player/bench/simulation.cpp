#include "bench/simulation.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"
#include "bench/draws.hpp"
#include "bench/screw.hpp"

namespace vrda::bench {
namespace {

/// Path of an angle of the leg.
KeyPath path_of(const SimulationScript& script, double LegKey::*angle_deg)
{
  std::vector<PathPoint> points;
  for (const LegKey& key : script.leg) points.push_back({key.time_s, rad_from_deg(key.*angle_deg)});
  return {std::move(points), script.is_looped};
}

const SimulationScript& usable(const SimulationScript& script, const std::string& file)
{
  require_usable(script, file);
  return script;
}

std::int64_t rounded(double value)
{
  return static_cast<std::int64_t>(std::floor(value + 0.5));
}

constexpr double ns_a_second = 1e9;

/// To thousandths.
std::string degrees_text(double angle_rad)
{
  return shortest_decimal(std::round(1000.0 * deg_from_rad(angle_rad)) / 1000.0);
}

/// Adds noise to a body's pose: a rotation about its own axes and a translation.
Pose with_noise(const Pose& X, const SimulationScript& script, RandomSequence& draws)
{
  const Eigen::Vector3d turn_rad = script.noise_rad * draws.normal_vector();
  Pose X_noisy = X;
  X_noisy.linear() = X.linear() * bench::rotation_of(turn_rad);
  X_noisy.translation() += script.noise_mm * draws.normal_vector();
  return X_noisy;
}

}  // namespace

Simulation::Simulation(const SimulationScript& script, std::optional<store::Motion> motion,
                       const std::string& file)
    : script_(usable(script, file)),
      motion_(std::move(motion)),
      tools_(tool_names(script)),
      flexion_rad_(path_of(script, &LegKey::flexion_deg)),
      varus_rad_(path_of(script, &LegKey::varus_deg)),
      stage_mm_(script.stage, script.is_looped),
      potentiometer_(script.potentiometer, script.is_looped)
{
  if (motion_) require_solved(file);
}

bench::LegAngles Simulation::scripted_angles(double time_s) const
{
  return {flexion_rad_.at(time_s), varus_rad_.at(time_s), 0.0};
}

/// The first scripted attitude for whose pose is_wrong(pose), with its time.
template <typename IsWrong>
std::optional<std::string> Simulation::first_where(const IsWrong& is_wrong) const
{
  // Samples more densely than patches between attitudes a degree apart.
  constexpr int n_times = 2000;
  const double first_s = script_.leg.front().time_s, last_s = script_.leg.back().time_s;
  for (int i = 0; i <= n_times; ++i) {
    const double time_s = first_s + (last_s - first_s) * i / n_times;
    const Attitude wanted = bench::attitude_of(scripted_angles(time_s));
    if (!is_wrong(motion_->at(wanted))) continue;
    return "flexion " + degrees_text(wanted.flexion_rad) + ", varus " + degrees_text(wanted.varus_rad) +
           " at " + shortest_decimal(time_s) + " s";
  }
  return std::nullopt;
}

void Simulation::require_solved(const std::string& file) const
{
  const std::optional<std::string> unsolved =
      first_where([](const store::JointPose& pose) { return pose.status != store::PoseStatus::solved; });
  if (unsolved)
    throw InputError(
        {file, "leg", *unsolved + ", an attitude that the motion model has not solved", "solved attitudes"});
}

std::optional<InputError::Facts> Simulation::beyond_motion(const std::string& file) const
{
  if (!motion_) return std::nullopt;
  const bool is_varus_free = motion_->is_varus_free();
  const std::optional<std::string> beyond = first_where([&](const store::JointPose& pose) {
    return pose.is_flexion_clamped || (!is_varus_free && pose.is_varus_clamped);
  });
  if (!beyond) return std::nullopt;
  const auto range = [](double first_rad, double last_rad) {
    return degrees_text(first_rad) + " to " + degrees_text(last_rad);
  };
  std::string wanted =
      "flexion " + range(motion_->first_flexion_rad(), motion_->last_flexion_rad()) + " degrees";
  if (!is_varus_free)
    wanted += ", varus " + range(motion_->first_varus_rad(), motion_->last_varus_rad()) + " degrees";
  return InputError::Facts{file, "leg", *beyond, wanted + ", as the motion model; the leg stops at its ends"};
}

SimulatedTruth Simulation::truth(double time_s) const
{
  SimulatedTruth truth;
  truth.angles = scripted_angles(time_s);
  const store::JointPose joint =
      motion_ ? motion_->at(bench::attitude_of(truth.angles)) : store::JointPose{};
  if (joint.status == store::PoseStatus::solved) {
    truth.angles = {joint.attitude.flexion_rad, joint.attitude.varus_rad, joint.theta_rad};
    truth.X_femur_tibia = joint.X_reference_moving;
  } else {
    const SolverFrame frame{script_.side, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()};
    truth.X_femur_tibia = bench::X_femur_tibia(truth.angles, frame);
  }
  truth.stage_mm = stage_mm_.at(time_s);
  truth.potentiometer_count = potentiometer_.at(time_s);
  const double sway_mm = script_.sway_mm * sine(2.0 * pi * time_s / script_.sway_s);
  truth.X_tracker_femur = script_.X_tracker_femur * Eigen::Translation3d(sway_mm, 0.0, 0.0);
  truth.X_tracker_tibia = truth.X_tracker_femur * truth.X_femur_tibia;
  truth.X_tracker_head = script_.X_tracker_head * Eigen::Translation3d(truth.stage_mm, 0.0, 0.0);
  return truth;
}

Pose Simulation::X_tracker_body(const SimulatedBody& body, double time_s) const
{
  const SimulatedTruth now = truth(time_s);
  return &body == &script_.femur   ? now.X_tracker_femur
         : &body == &script_.tibia ? now.X_tracker_tibia
                                   : now.X_tracker_head;
}

bool Simulation::is_hidden(const std::string& tool, double time_s) const
{
  return std::ranges::any_of(script_.occlusions, [&](const Occlusion& occlusion) {
    if (occlusion.tool != tool || time_s < occlusion.from_s) return false;
    double since_s = time_s - occlusion.from_s;
    if (occlusion.every_s > 0.0) since_s -= occlusion.every_s * std::floor(since_s / occlusion.every_s);
    return since_s < occlusion.to_s - occlusion.from_s;
  });
}

void Simulation::add_body(SimulatedFrame& frame, const SimulatedBody& body, RandomSequence& draws) const
{
  const bool is_hidden_body = is_hidden(body.tool, frame.time_s);
  frame.tools.push_back({with_noise(X_tracker_body(body, frame.time_s), script_, draws), !is_hidden_body});
  for (std::size_t k = 0; k < body.markers_mm.size(); ++k) {
    const double fired_s = frame.time_s + 1e-3 * script_.firing_interval_ms * static_cast<double>(k);
    Pose X = Pose::Identity();
    X.translation() =
        X_tracker_body(body, fired_s) * body.markers_mm[k] + script_.noise_mm * draws.normal_vector();
    frame.tools.push_back({X, !is_hidden_body && !is_hidden(tools_[frame.tools.size()], fired_s)});
  }
}

SimulatedFrame Simulation::frame(std::uint64_t k) const
{
  RandomSequence draws(script_.seed, RandomPurpose::frame, k);
  SimulatedFrame frame;
  frame.time_s = static_cast<double>(k) / script_.rate_hz;
  frame.send_s = frame.time_s + 1e-3 * script_.jitter_ms * draws.uniform();
  frame.is_dropped = draws.uniform() < script_.drop_rate;
  frame.device_ns = device_ns(frame.time_s);
  frame.tools.reserve(tools_.size());
  add_body(frame, script_.femur, draws);
  add_body(frame, script_.tibia, draws);
  if (script_.head) add_body(frame, *script_.head, draws);
  return frame;
}

std::int64_t Simulation::device_ns(double time_s) const
{
  const DeviceClock& clock = script_.clock;
  // Rounded separately, so that a large offset costs no precision.
  std::int64_t shown_ns =
      rounded(clock.offset_s * ns_a_second) + rounded(time_s * (1.0 + 1e-6 * clock.drift_ppm) * ns_a_second);
  for (const ClockStep& step : clock.steps) {
    if (time_s >= step.at_s) shown_ns += rounded(step.by_ms * 1e-3 * ns_a_second);
  }
  return shown_ns;
}

std::int64_t Simulation::stage_count(double time_s) const
{
  return rounded(stage_mm_.at(time_s) / stage_mm_a_count);
}

int Simulation::potentiometer_count(double time_s) const
{
  const auto index = static_cast<std::uint64_t>(rounded(time_s * ns_a_second));
  const double noise = script_.potentiometer_noise_counts *
                       RandomSequence(script_.seed, RandomPurpose::potentiometer, index).normal();
  return static_cast<int>(rounded(std::clamp(potentiometer_.at(time_s) + noise, 0.0, 1023.0)));
}

}  // namespace vrda::bench
