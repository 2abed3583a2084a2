
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ostream>

#include "bench/bench_run.hpp"
#include "bench/simulated_devices.hpp"

namespace vrda::bench {
namespace {

double chord(const PathPoint& from, const PathPoint& to)
{
  return (to.value - from.value) / (to.time_s - from.time_s);
}

/// Weighted harmonic mean of the chords on either side, which last `before_s` and `after_s`.
double slope_between(double before, double before_s, double after, double after_s)
{
  if (before * after <= 0.0) return 0.0;
  const double weight_before = before_s + 2.0 * after_s, weight_after = 2.0 * before_s + after_s;
  return (weight_before + weight_after) / (weight_before / before + weight_after / after);
}

}  // namespace

KeyPath::KeyPath(std::vector<PathPoint> points, bool is_looped)
    : points_(std::move(points)), slopes_(points_.size(), 0.0), is_looped_(is_looped && points_.size() > 1)
{
  check(!points_.empty(), "a path needs at least one key");
  const std::size_t n = points_.size();
  for (std::size_t i = 1; i < n; ++i)
    check(points_[i].time_s > points_[i - 1].time_s, "the keys of a path must ascend in time");
  for (std::size_t i = 1; i + 1 < n; ++i) {
    slopes_[i] = slope_between(chord(points_[i - 1], points_[i]), points_[i].time_s - points_[i - 1].time_s,
                               chord(points_[i], points_[i + 1]), points_[i + 1].time_s - points_[i].time_s);
  }
  if (!is_looped_) return;
  check(points_.front().value == points_.back().value, "a looped path must end at its first value");
  slopes_.front() =
      slope_between(chord(points_[n - 2], points_[n - 1]), points_[n - 1].time_s - points_[n - 2].time_s,
                    chord(points_[0], points_[1]), points_[1].time_s - points_[0].time_s);
  slopes_.back() = slopes_.front();
}

double KeyPath::at(double time_s) const
{
  const double first_s = points_.front().time_s, last_s = points_.back().time_s;
  double t = time_s;
  if (is_looped_) {
    const double period_s = last_s - first_s;
    t = time_s - period_s * std::floor((time_s - first_s) / period_s);
  }
  if (t <= first_s) return points_.front().value;
  if (t >= last_s) return points_.back().value;
  const auto after =
      std::upper_bound(points_.begin(), points_.end(), t,
                       [](double wanted_s, const PathPoint& p) { return wanted_s < p.time_s; });
  const auto i = static_cast<std::size_t>(after - points_.begin()) - 1;
  const PathPoint &from = points_[i], &to = points_[i + 1];
  const double length_s = to.time_s - from.time_s;
  const double s = (t - from.time_s) / length_s, left = 1.0 - s;
  // Cubic Hermite polynomial, written relative to either end.
  return left * left * ((1.0 + 2.0 * s) * from.value + s * length_s * slopes_[i]) +
         s * s * ((1.0 + 2.0 * left) * to.value - left * length_s * slopes_[i + 1]);
}

namespace {

/// Throws InputError unless the value is right.
void require(bool is_right, const InputError::Facts& facts)
{
  if (!is_right) throw InputError(facts);
}

/// Checks that keys ascend in time; `is_same(first, last)` returns whether a loop closes.
template <typename Keys, typename IsSame>
void require_path(const Keys& keys, bool is_looped, const std::string& file, const std::string& field,
                  IsSame is_same)
{
  for (std::size_t i = 1; i < keys.size(); ++i) {
    require(keys[i].time_s > keys[i - 1].time_s,
            {file, field + " key " + std::to_string(i + 1), "time " + shortest_decimal(keys[i].time_s),
             "a time after " + shortest_decimal(keys[i - 1].time_s)});
  }
  require(
      !is_looped || is_same(keys.front(), keys.back()),
      {file, field, "different first and last values of a loop", "a last key with the values of the first"});
}

void require_paths(const SimulationScript& script, const std::string& file)
{
  require_path(script.leg, script.is_looped, file, "leg", [](const LegKey& a, const LegKey& b) {
    return a.flexion_deg == b.flexion_deg && a.varus_deg == b.varus_deg;
  });
  const auto is_same = [](const PathPoint& a, const PathPoint& b) { return a.value == b.value; };
  require_path(script.stage, script.is_looped, file, "stage", is_same);
  require_path(script.potentiometer, script.is_looped, file, "potentiometer", is_same);
}

void require_tools(const SimulationScript& script, const std::string& file)
{
  const std::vector<std::string> tools = tool_names(script);
  std::vector<std::string> names = tools;
  std::ranges::sort(names);
  const auto twice = std::ranges::adjacent_find(names);
  if (twice != names.end()) throw InputError({file, "tool", *twice + " twice", "unique names"});
  for (const Occlusion& occlusion : script.occlusions) {
    require(std::ranges::find(tools, occlusion.tool) != tools.end(),
            {file, "occlusion tool", "\"" + occlusion.tool + "\"", join_alternatives(tools)});
    require(occlusion.to_s >= occlusion.from_s, {file, "occlusion to_s", shortest_decimal(occlusion.to_s),
                                                 "at least from_s = " + shortest_decimal(occlusion.from_s)});
    require(occlusion.every_s == 0.0 || occlusion.every_s >= occlusion.to_s - occlusion.from_s,
            {file, "occlusion every_s", shortest_decimal(occlusion.every_s), "0, or at least to_s - from_s"});
  }
}

void require_clock(const DeviceClock& clock, const std::string& file)
{
  for (std::size_t i = 1; i < clock.steps.size(); ++i) {
    require(clock.steps[i].at_s >= clock.steps[i - 1].at_s,
            {file, "clock step at_s", shortest_decimal(clock.steps[i].at_s),
             "at least the previous step's time, " + shortest_decimal(clock.steps[i - 1].at_s)});
  }
}

}  // namespace

Pose default_X_tracker_femur()
{
  Pose X = Pose::Identity();
  // Anterior towards the viewer, proximal up, the subject's right to the viewer's left.
  X.linear() << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  X.translation() << 0, 0, -1500;
  return X;
}

std::vector<std::string> tool_names(const SimulationScript& script)
{
  std::vector<std::string> names;
  const auto add = [&](const SimulatedBody& body) {
    names.push_back(body.tool);
    for (std::size_t k = 0; k < body.markers_mm.size(); ++k)
      names.push_back(body.tool + "-" + std::to_string(k + 1));
  };
  add(script.femur);
  add(script.tibia);
  if (script.head) add(*script.head);
  return names;
}

void require_usable(const SimulationScript& script, const std::string& file)
{
  // With a longer jitter frames could overtake each other.
  const double period_ms = 1000.0 / script.rate_hz;
  require(script.jitter_ms <= period_ms, {file, "jitter_ms", shortest_decimal(script.jitter_ms),
                                          "at most the frame period, " + shortest_decimal(period_ms)});
  require_paths(script, file);
  require_tools(script, file);
  require_clock(script.clock, file);
}

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

/// Adds noise to a body's pose: a rotation about its own axes and a translation.
Pose with_noise(const Pose& X, const SimulationScript& script, RandomSequence& draws)
{
  const Eigen::Vector3d turn_rad = script.noise_rad * draws.normal_vector();
  Pose X_noisy = X;
  X_noisy.linear() = X.linear() * rotation_of(turn_rad);
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

LegAngles Simulation::scripted_angles(double time_s) const
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
    const Attitude wanted = attitude_of(scripted_angles(time_s));
    if (!is_wrong(motion_->at(wanted))) continue;
    return "flexion " + short_decimal(deg_from_rad(wanted.flexion_rad), 3) + ", varus " +
           short_decimal(deg_from_rad(wanted.varus_rad), 3) + " at " + shortest_decimal(time_s) + " s";
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
    return short_decimal(deg_from_rad(first_rad), 3) + " to " + short_decimal(deg_from_rad(last_rad), 3);
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
  const store::JointPose joint = motion_ ? motion_->at(attitude_of(truth.angles)) : store::JointPose{};
  if (joint.status == store::PoseStatus::solved) {
    truth.angles = {joint.attitude.flexion_rad, joint.attitude.varus_rad, joint.theta_rad};
    truth.X_femur_tibia = joint.X_reference_moving;
  } else {
    const SolverFrame frame{script_.side, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()};
    truth.X_femur_tibia = X_femur_tibia(truth.angles, frame);
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

namespace {

/// Bit mixer for consecutive numbers. Source: Steele, Lea, Flood (2014) OOPSLA, SplitMix64's finaliser.
std::uint64_t mixed(std::uint64_t x)
{
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

}  // namespace

RandomSequence::RandomSequence(std::uint64_t seed, RandomPurpose purpose, std::uint64_t index)
    : bits_(mixed(mixed(mixed(seed) + static_cast<std::uint64_t>(purpose)) + index))
{
}

double RandomSequence::uniform()
{
  constexpr double unit = 1.0 / 9007199254740992.0;  // 2^-53
  return static_cast<double>(bits_() >> 11U) * unit;
}

double RandomSequence::normal()
{
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

Eigen::Vector3d RandomSequence::normal_vector()
{
  const double x = normal(), y = normal(), z = normal();
  return {x, y, z};
}

// `vrda-player simulate`: sends tracker and board data of a simulated bench.

namespace {

/// A simulated tool that is sent, with its name in the bench file.
struct SentTool {
  std::size_t simulated = 0;
  std::string name;
};

std::vector<SentTool> sent_tools(const BenchFile& bench, const Simulation& simulation)
{
  std::vector<SentTool> sent;
  std::size_t at = 0;
  const auto add = [&](const std::optional<BodySettings>& settings) {
    if (!settings->tool.empty()) sent.push_back({at, settings->tool});
    ++at;
    for (const std::string& marker : settings->markers) sent.push_back({at++, marker});
  };
  const auto settings = [&](BodyRole role) { return bench.bodies[role]; };
  if (bench.leg == LegKind::rigid) {
    add(settings(BodyRole::leg));
    ++at;  // the tibia, which is not tracked
  } else {
    add(settings(BodyRole::femur));
    add(settings(BodyRole::tibia));
  }
  if (bench.head == HeadKind::tracker) add(settings(BodyRole::head));
  check(at == simulation.tools().size(), "every simulated tool is assigned");
  return sent;
}

/// One TDATA message a tick, without hidden tools.
std::vector<IgtlMessage> messages_of(const SimulatedFrame& frame, const std::vector<SentTool>& sent)
{
  if (frame.is_dropped) return {};
  IgtlMessage message;
  message.kind = IgtlKind::tdata;
  message.device = "Tracker";
  message.device_ns = frame.device_ns;
  for (const SentTool& tool : sent) {
    const SimulatedTool& simulated = frame.tools[tool.simulated];
    if (simulated.is_seen)
      message.tools.push_back({tool.name, ToolVisibility::seen, simulated.X_tracker_tool});
  }
  return {message};
}

std::optional<store::Motion> motion_of(const std::string& path)
{
  if (path.empty()) return std::nullopt;
  const store::MotionModel model = store::read_motion_model(path);
  store::require_grid(model, path, "a simulated bench");
  return store::Motion(model, store::default_motion(model).set);
}

std::unique_ptr<PtyBoard> open_board(const BenchFile& bench, const Simulation& simulation)
{
  if (!bench.board) return nullptr;
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const auto now_s = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  PtyBoardOptions options;
  options.link = bench.board->port;
  options.potentiometer = [&simulation, now_s] { return simulation.potentiometer_count(now_s()); };
  options.stage_count = [&simulation, now_s] { return static_cast<int>(simulation.stage_count(now_s())); };
  return std::make_unique<PtyBoard>(options);
}

}  // namespace

void simulate(const SimulateOptions& options, const show::Streams& streams)
{
  const BenchFile bench = read_bench_file(options.bench);
  if (bench.camera)
    throw InputError(
        {options.bench, "tracker", "\"aruco\", a webcam", "a tracker of OpenIGTLink to simulate"});
  const Simulation simulation(bench.simulation, motion_of(options.model), options.bench);
  if (const auto beyond = simulation.beyond_motion(options.bench))
    streams.messages << "vrda-player: " << InputError(*beyond).what() << "\n";
  const std::vector<SentTool> sent = sent_tools(bench, simulation);
  show::StopSignals stop;
  TrackerServerOptions server_options;
  server_options.address = options.address.empty() ? bench.simulation_address : options.address;
  server_options.port = bench.tracker->port;
  server_options.rate_hz = bench.simulation.rate_hz;
  server_options.jitter_ms = bench.simulation.jitter_ms;
  server_options.seed = bench.simulation.seed;
  const TrackerServer server(server_options,
                             [&](std::uint64_t tick) { return messages_of(simulation.frame(tick), sent); });
  // After the port is bound: a second simulation of the same bench ends before it touches the link.
  const std::unique_ptr<PtyBoard> board = open_board(bench, simulation);
  streams.data << "tracker " << server_options.address << ":" << server.port() << std::endl;
  if (board) streams.data << "board " << board->path() << std::endl;
  if (!options.is_quiet && !options.seconds) streams.messages << "Ctrl-C ends the simulation\n";
  using Clock = std::chrono::steady_clock;
  constexpr double a_year_s = 3.2e7;
  const std::chrono::duration<double> time(options.seconds.value_or(a_year_s));
  stop.wait_until(Clock::now() + std::chrono::duration_cast<Clock::duration>(time));
}

}  // namespace vrda::bench
