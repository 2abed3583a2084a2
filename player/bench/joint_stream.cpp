#include "bench/joint_stream.hpp"

#include <algorithm>
#include <chrono>

#include "bench/bench_panel.hpp"
#include "model/clinical.hpp"
#include "model/side.hpp"
#include "core/units.hpp"
#include "bench/message.hpp"
#include "bench/scene_message.hpp"
#include "store/joint_parts.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {
namespace {

using Bytes = std::vector<std::uint8_t>;

void append(Bytes& bytes, const Bytes& more)
{
  bytes.insert(bytes.end(), more.begin(), more.end());
}

void append_transform(Bytes& bytes, const std::string& name, const Pose& X, std::int64_t utc_ns)
{
  bench::IgtlMessage message;
  message.device = name;
  message.device_ns = utc_ns;
  message.tools.push_back({name, bench::ToolVisibility::seen, X});
  append(bytes, bench::bytes_of(message));
}

const InputStatus& status_of(const BenchFrame& frame, bench::BodyRole role)
{
  return frame.bodies[static_cast<std::size_t>(role)];
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
  for (std::size_t role = 0; role < bench::n_body_roles; ++role)
    add(input_status_text(bench::name_of(static_cast<bench::BodyRole>(role)),
                          frame.bodies[role]));
  add(leg_check_text(frame.leg));
  add(stage_status_text(frame));
  add(input_status_text("probe", streamed.probe));
  return marks;
}

/// A mesh's device name: the suffix must fit into the field of 20 bytes.
std::string mesh_name(const store::MotionModel& model, store::JointBody body)
{
  constexpr std::size_t longest = 15;
  return store::displayed_name(model, body).substr(0, longest) + "_mesh";
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
    text += std::string(", \"") + name + "\": " + show::rounded_text(value, 4);
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
    text += comma + show::quoted_text(mark);
    comma = ", ";
  }
  return text + "]}";
}

Bytes frame_messages(const StreamedFrame& streamed, const store::MotionModel& model)
{
  using bench::BodyRole;
  const BenchFrame& frame = streamed.frame;
  const bool is_reference_seen =
      is_usable(status_of(frame, BodyRole::leg)) && is_usable(status_of(frame, BodyRole::femur));
  const bool is_moving_seen = is_reference_seen && is_usable(status_of(frame, BodyRole::tibia)) &&
                              frame.pose.status == store::PoseStatus::solved;
  const bool are_eyes_seen =
      streamed.has_eyes && is_usable(status_of(frame, BodyRole::head)) && is_usable(frame.stage);
  Bytes bytes;
  if (is_reference_seen)
    append_transform(bytes, store::displayed_name(model, store::JointBody::reference),
                     frame.X_tracker_reference, streamed.utc_ns);
  if (is_moving_seen)
    append_transform(bytes, store::displayed_name(model, store::JointBody::moving), frame.X_tracker_moving,
                     streamed.utc_ns);
  if (are_eyes_seen) append_transform(bytes, "eye", frame.X_tracker_eyes, streamed.utc_ns);
  if (streamed.X_tracker_probe) append_transform(bytes, "probe", *streamed.X_tracker_probe, streamed.utc_ns);
  append(bytes, bench::string_bytes("angles", streamed.utc_ns,
                                   angles_text(streamed, side_named(model.side), model.rotation_centre_mm)));
  return bytes;
}

Bytes mesh_messages(const store::MotionModel& model, std::int64_t utc_ns)
{
  Bytes bytes;
  const auto add = [&](store::JointBody which, const Body& body) {
    append(bytes, bench::polydata_bytes(mesh_name(model, which), utc_ns, whole_mesh(body)));
  };
  add(store::JointBody::reference, model.reference);
  add(store::JointBody::moving, model.moving);
  return bytes;
}

JointStream::JointStream(const IgtlOptions& options, const store::MotionModel& model) : model_(model)
{
  bench::IgtlServerOptions listening;
  listening.address = options.address;
  listening.port = static_cast<std::uint16_t>(options.port.value());
  server_ = std::make_unique<bench::IgtlServer>(listening, mesh_messages(model, utc_now_ns()),
                                                  [this] { return next(); });
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

ProbeTool::ProbeTool(const bench::BenchFile& bench, const bench::Calibration& calibration)
{
  if (!bench.tracker || !bench.calibration.is_present) return;
  const std::vector<std::string>& tools = bench.tracker->tools;
  const auto found = std::ranges::find(tools, bench.calibration.probe);
  if (found == tools.end()) return;
  tool_ = static_cast<std::size_t>(found - tools.begin());
  const auto record = calibration.records.find(bench::CalibrationPart::probe);
  if (record == calibration.records.end() || !record->second.estimate) return;
  const Estimate& estimate = *record->second.estimate;
  const std::vector<std::string> tip =
      bench::shared_estimate_names(bench::CalibrationPart::probe);
  for (std::size_t axis = 0; axis < tip.size() && axis < 3; ++axis) {
    X_tool_tip_.translation()(static_cast<Eigen::Index>(axis)) =
        estimate.values(index_of(estimate, tip[axis]));
  }
}

void ProbeTool::take(const bench::Sample& sample)
{
  if (sample.kind == bench::SampleKind::link &&
      sample.source == static_cast<std::uint16_t>(bench::DeviceId::tracker)) {
    pose_.reset();
    state_ = bench::ToolVisibility::missing;
  }
  if (!tool_ || sample.kind != bench::SampleKind::tool_pose || sample.source != *tool_) return;
  pose_.reset();
  state_ = static_cast<bench::ToolVisibility>(sample.state);
  if (state_ != bench::ToolVisibility::seen) return;
  pose_ = bench::pose_of(sample.tool_pose) * X_tool_tip_;
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

}  // namespace vrda::bench
