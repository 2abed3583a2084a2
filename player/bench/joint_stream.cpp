
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <ostream>

#include "bench/bench_show.hpp"
#include "bench/igtl_message.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "show/session.hpp"
#include "store/motion.hpp"
#include "view/keys.hpp"

namespace vrda::bench {
namespace {

using Bytes = std::vector<std::uint8_t>;

void append(Bytes& bytes, const Bytes& more)
{
  bytes.insert(bytes.end(), more.begin(), more.end());
}

void append_transform(Bytes& bytes, const std::string& name, const Pose& X, std::int64_t utc_ns)
{
  IgtlMessage message;
  message.device = name;
  message.device_ns = utc_ns;
  message.tools.push_back({name, ToolVisibility::seen, X});
  append(bytes, bytes_of(message));
}

bool is_usable(const InputStatus& status)
{
  return !status.is_used || status.is_live;
}

/// The marks of the bench's screen, and that of the probe.
std::vector<std::string> marks_of(const StreamedFrame& streamed)
{
  const BenchFrame& frame = streamed.frame;
  std::vector<std::string> marks;
  const auto add = [&](const std::string& mark) {
    if (!mark.empty()) marks.push_back(mark);
  };
  for (const BodyRole role : body_roles) add(input_status_text(name_of(role), frame.bodies[role]));
  add(leg_check_text(frame.leg));
  add(stage_status_text(frame));
  add(input_status_text("probe", streamed.probe));
  return marks;
}

/// The parts of a bone in one mesh.
Mesh whole_mesh(const Body& body)
{
  Mesh mesh = body.contact.mesh;
  append(mesh, body.visual.mesh);
  return mesh;
}

}  // namespace

std::string angles_text(const StreamedFrame& streamed, Side side, const Eigen::Vector3d& rotation_centre_mm)
{
  const BenchFrame& frame = streamed.frame;
  const ClinicalCoordinates c = clinical_coordinates(frame.pose.X_reference_moving, side, rotation_centre_mm);
  std::string text = "{\"frame\": " + std::to_string(streamed.number);
  const auto add = [&text](const char* name, double value) {
    text += std::string(", \"") + name + "\": " + short_decimal(value, 4);
  };
  add("flexion_deg", deg_from_rad(c.flexion_rad));
  add("varus_deg", deg_from_rad(c.varus_rad));
  add("internal_rotation_deg", deg_from_rad(c.internal_rotation_rad));
  add("anterior_mm", c.anterior_mm);
  add("proximal_mm", c.proximal_mm);
  add("lateral_mm", c.lateral_mm);
  text += std::string(", \"live\": ") + (is_live(frame) ? "true" : "false") + ", \"marks\": [";
  const char* comma = "";
  for (const std::string& mark : marks_of(streamed)) {
    text += comma + core::quoted_text(mark);
    comma = ", ";
  }
  return text + "]}";
}

Bytes frame_messages(const StreamedFrame& streamed, const store::MotionModel& model)
{
  const BenchFrame& frame = streamed.frame;
  const bool is_reference_seen =
      is_usable(frame.bodies[BodyRole::leg]) && is_usable(frame.bodies[BodyRole::femur]);
  const bool is_moving_seen = is_reference_seen && is_usable(frame.bodies[BodyRole::tibia]) &&
                              frame.pose.status == store::PoseStatus::solved;
  const bool are_eyes_seen =
      streamed.has_eyes && is_usable(frame.bodies[BodyRole::head]) && is_usable(frame.stage);
  Bytes bytes;
  if (is_reference_seen)
    append_transform(bytes, store::displayed_name(model, BodyIndex::reference), frame.X_tracker_reference,
                     streamed.utc_ns);
  if (is_moving_seen)
    append_transform(bytes, store::displayed_name(model, BodyIndex::moving), frame.X_tracker_moving,
                     streamed.utc_ns);
  for (const store::FollowerRows& follower : model.followers) {
    const std::size_t row = model::follower_row(static_cast<BodyIndex>(follower.body_index));
    if (is_moving_seen && frame.pose.has_follower.at(row))
      append_transform(bytes, follower.name,
                       frame.X_tracker_reference * frame.pose.X_reference_follower.at(row), streamed.utc_ns);
  }
  if (are_eyes_seen) append_transform(bytes, "eye", frame.X_tracker_eyes, streamed.utc_ns);
  if (streamed.X_tracker_probe) append_transform(bytes, "probe", *streamed.X_tracker_probe, streamed.utc_ns);
  append(bytes, string_bytes("angles", streamed.utc_ns,
                             angles_text(streamed, side_named(model.side), model.rotation_centre_mm)));
  return bytes;
}

Bytes mesh_messages(const store::MotionModel& model, std::int64_t utc_ns)
{
  Bytes bytes;
  const auto add = [&](const std::string& name, const Body& body) {
    constexpr std::size_t longest = 15;  // the suffix must fit into the field of 20 bytes
    append(bytes, polydata_bytes(name.substr(0, longest) + "_mesh", utc_ns, whole_mesh(body)));
  };
  add(store::displayed_name(model, BodyIndex::reference), model.reference);
  add(store::displayed_name(model, BodyIndex::moving), model.moving);
  for (const store::FollowerRows& follower : model.followers) add(follower.name, follower.body);
  return bytes;
}

JointStream::JointStream(const IgtlOptions& options, const store::MotionModel& model) : model_(model)
{
  IgtlServerOptions listening;
  listening.address = options.address;
  listening.port = static_cast<std::uint16_t>(options.port.value());
  server_ =
      std::make_unique<IgtlServer>(listening, mesh_messages(model, utc_now_ns()), [this] { return next(); });
}

void JointStream::put(const StreamedFrame& streamed)
{
  {
    const std::lock_guard lock(mutex_);
    const std::uint64_t number = number_++;
    if (n_put_ - n_taken_ == capacity) return;
    StreamedFrame& slot = frames_[n_put_++ % capacity];
    slot = streamed;
    slot.number = number;
  }
  server_->wake();
}

Bytes JointStream::next()
{
  StreamedFrame streamed;
  {
    const std::lock_guard lock(mutex_);
    if (n_put_ == n_taken_) return {};
    streamed = frames_[n_taken_++ % capacity];
  }
  return frame_messages(streamed, model_);
}

std::int64_t utc_now_ns()
{
  return std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

ProbeTool::ProbeTool(const BenchFile& bench, const Calibration& calibration)
{
  if (!bench.calibration.is_present) return;
  const std::vector<std::string>& tools = bench.tracker->tools;
  const auto found = std::ranges::find(tools, bench.calibration.probe);
  if (found == tools.end()) return;
  tool_ = static_cast<std::size_t>(found - tools.begin());
  const auto record = calibration.records.find(CalibrationPart::probe);
  if (record == calibration.records.end() || !record->second.estimate) return;
  const Estimate& estimate = *record->second.estimate;
  const std::vector<std::string> tip = shared_estimate_names(CalibrationPart::probe);
  for (std::size_t axis = 0; axis < tip.size() && axis < 3; ++axis) {
    X_tool_tip_.translation()(static_cast<Eigen::Index>(axis)) =
        estimate.values(index_of(estimate, tip[axis]));
  }
}

void ProbeTool::take(const Sample& sample)
{
  if (sample.kind == SampleKind::link && sample.source == static_cast<std::uint16_t>(DeviceId::tracker)) {
    pose_.reset();
    state_ = ToolVisibility::missing;
  }
  if (!tool_ || sample.kind != SampleKind::tool_pose || sample.source != *tool_) return;
  pose_.reset();
  state_ = static_cast<ToolVisibility>(sample.state);
  if (state_ != ToolVisibility::seen) return;
  pose_ = pose_of(sample.tool_pose) * X_tool_tip_;
  seen_ns_ = sample.arrival_ns;
}

InputStatus ProbeTool::status(std::int64_t now_ns) const
{
  InputStatus status;
  if (!seen_ns_) return status;
  status.is_used = status.was_seen = true;
  status.is_live = pose_.has_value();
  status.age_s = 1e-9 * static_cast<double>(now_ns - *seen_ns_);
  status.state = state_;
  return status;
}

// `vrda-player serve`: sends a joint by OpenIGTLink, without a picture.

namespace {

/// Calls `send(seconds)` at the rate until the end or a stop signal. The times are computed from the start,
/// so that they do not drift.
template <typename Send>
void send_regularly(const ServeOptions& options, show::StopSignals& stop, Send send)
{
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  const auto at = [start](double s) {
    return start +
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
  };
  for (std::uint64_t tick = 0;; ++tick) {
    const double s = static_cast<double>(tick) / options.rate_hz;
    if (options.seconds && s > *options.seconds) return;
    if (stop.wait_until(at(s))) return;
    send(s);
  }
}

void announce(const JointStream& stream, const ServeOptions& options, const show::Streams& streams)
{
  streams.data << "igtl " << options.igtl.address << ":" << stream.port() << std::endl;
  if (!options.is_quiet && !options.seconds) streams.messages << "Ctrl-C ends it\n";
}

/// To and fro with a cosine, or held.
double flexion_at(const ServeOptions& options, const store::Motion& motion, double s)
{
  if (options.flexion_deg) return rad_from_deg(*options.flexion_deg);
  const double first = motion.first_flexion_rad(), last = motion.last_flexion_rad();
  const double share = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * s / options.period_s);
  return first + share * (last - first);
}

void serve_motion(const ServeOptions& options, const show::Streams& streams)
{
  const store::MotionModel model = store::read_motion_model(options.file);
  store::require_grid(model, options.file, "serve");
  const store::Motion motion(model, store::chosen_set(model, options.file, options.set));
  const auto attitude_at = [&](double s) -> Attitude {
    const double flexion_rad = flexion_at(options, motion, s);
    return {flexion_rad,
            options.varus_deg ? rad_from_deg(*options.varus_deg) : motion.balanced_varus_rad(flexion_rad)};
  };
  view::report_clamped(motion, motion.at(attitude_at(0.0)), attitude_at(0.0), "sent", streams.messages);
  show::StopSignals stop;
  JointStream stream(options.igtl, model);
  announce(stream, options, streams);
  StreamedFrame streamed;
  send_regularly(options, stop, [&](double s) {
    streamed.frame.pose = motion.at(attitude_at(s));
    streamed.frame.X_tracker_moving = streamed.frame.pose.X_reference_moving;
    streamed.utc_ns = utc_now_ns();
    stream.put(streamed);
  });
}

void serve_bench(const ServeOptions& options, const show::Streams& streams)
{
  BenchOptions bench;
  bench.file = options.file;
  bench.set = options.set;
  bench.bench = options.bench;
  bench.calibration = options.calibration;
  bench.igtl = options.igtl;
  const BenchSetup setup = read_bench_setup(bench);
  BenchState state(setup.bench, setup.calibration, setup.motion, setup.frame);
  ProbeTool probe(setup.bench, setup.calibration);
  show::StopSignals stop;
  Devices devices(setup.bench.tracker, setup.bench.board);
  JointStream stream(options.igtl, setup.model);
  announce(stream, options, streams);
  send_regularly(options, stop, [&](double) {
    for (Sample sample; devices.take(sample);) {
      state.take(sample);
      probe.take(sample);
    }
    const std::int64_t now_ns = devices.now_ns();
    stream.put({state.frame(now_ns), true, probe.X_tracker_probe(), probe.status(now_ns), utc_now_ns(), 0});
  });
}

}  // namespace

void serve(const ServeOptions& options, const show::Streams& streams)
{
  if (!options.igtl.port) view::refuse_option("--igtl", "nothing", "a port, such as 18944");
  if (options.bench.empty()) {
    if (!options.calibration.empty())
      view::refuse_option("--calibration", "no --bench", "--bench with a bench file");
    if (options.flexion_deg) view::require_angle("--flexion", *options.flexion_deg);
    if (options.varus_deg) view::require_angle("--varus", *options.varus_deg);
    return serve_motion(options, streams);
  }
  if (options.flexion_deg || options.varus_deg)
    view::refuse_option(options.flexion_deg ? "--flexion" : "--varus", "--bench",
                        "one of them: the bench measures the angles");
  serve_bench(options, streams);
}

}  // namespace vrda::bench
