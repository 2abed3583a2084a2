#include "recording/recording.hpp"

#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "journal/frame_bytes.hpp"
#include "journal/little_endian.hpp"

namespace vrda::recording {
namespace {

/// A frame's samples take some hundred bytes; the texts of bench and calibration some kilobytes.
constexpr journal::FrameFormat format{"VRDABREC", 1, std::uint32_t{1} << 24, "frame"};
constexpr const char* file_key = "bench recording";

constexpr std::size_t key_bytes = 5, sample_bytes = 80;
/// Hours at 60 frames a second; a larger file is not a recording.
constexpr std::int64_t most_file_bytes = std::int64_t{1} << 32;

void append_i64(std::string& bytes, std::int64_t value)
{
  journal::append_u32(bytes, static_cast<std::uint32_t>(value));
  journal::append_u32(bytes, static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) >> 32));
}

void append_text(std::string& bytes, const std::string& text)
{
  journal::append_u32(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

void append_sample(std::string& bytes, const devices::Sample& sample)
{
  append_i64(bytes, sample.arrival_ns);
  append_i64(bytes, sample.device_ns);
  for (const double v : sample.tool_pose.position_mm) journal::append_double(bytes, v);
  for (const double v : sample.tool_pose.rotation) journal::append_double(bytes, v);
  journal::append_i32(bytes, sample.count);
  bytes.push_back(static_cast<char>(sample.source & 0xFF));
  bytes.push_back(static_cast<char>(sample.source >> 8));
  journal::append_i8(bytes, static_cast<std::int8_t>(sample.kind));
  journal::append_i8(bytes, static_cast<std::int8_t>(sample.state));
}

bool has_valid_kind(const devices::Sample& sample)
{
  switch (sample.kind) {
    case devices::SampleKind::tool_pose:
      return sample.state <= static_cast<std::uint8_t>(devices::ToolVisibility::invalid_pose);
    case devices::SampleKind::link:
      return sample.state <= static_cast<std::uint8_t>(devices::LinkState::up) &&
             sample.source <= static_cast<std::uint16_t>(devices::DeviceId::board);
    case devices::SampleKind::potentiometer:
    case devices::SampleKind::stage:
    case devices::SampleKind::offset:
      return true;
  }
  return false;
}

/// The pose of a visible tool and an offset must be finite with a unit quaternion.
bool has_valid_pose(const devices::Sample& sample)
{
  if (!sample.is(devices::ToolVisibility::seen) && sample.kind != devices::SampleKind::offset) return true;
  double square = 0.0;
  for (const double v : sample.tool_pose.rotation) square += v * v;
  constexpr double unit_tolerance = 1e-6;
  const Eigen::Map<const Eigen::Vector3d> position(sample.tool_pose.position_mm);
  return position.allFinite() && std::abs(square - 1.0) < unit_tolerance;
}

devices::Sample take_sample(journal::ByteReader& cursor)
{
  devices::Sample sample;
  sample.arrival_ns = static_cast<std::int64_t>(cursor.take(8));
  sample.device_ns = static_cast<std::int64_t>(cursor.take(8));
  for (double& v : sample.tool_pose.position_mm) v = cursor.take_double();
  for (double& v : sample.tool_pose.rotation) v = cursor.take_double();
  sample.count = cursor.take_i32();
  sample.source = static_cast<std::uint16_t>(cursor.take(2));
  sample.kind = static_cast<devices::SampleKind>(cursor.take(1));
  sample.state = static_cast<std::uint8_t>(cursor.take(1));
  if (!has_valid_kind(sample) || !has_valid_pose(sample)) cursor.mark_invalid();
  return sample;
}

navigation::KeyPress take_key(journal::ByteReader& cursor)
{
  navigation::KeyPress press;
  press.key = static_cast<navigation::Key>(cursor.take_i32());
  const std::uint64_t flags = cursor.take(1);
  if (flags > 3) cursor.mark_invalid();
  press.has_shift = (flags & 1) != 0;
  press.has_control = (flags & 2) != 0;
  return press;
}

std::optional<RecordedFrame> recorded_frame(std::string_view bytes)
{
  journal::ByteReader cursor(bytes);
  RecordedFrame picture;
  picture.now_ns = static_cast<std::int64_t>(cursor.take(8));
  const std::uint64_t n_keys = cursor.take(4);
  if (n_keys > cursor.n_bytes_left() / key_bytes) cursor.mark_invalid();
  for (std::uint64_t k = 0; k < n_keys && cursor.is_valid(); ++k) picture.keys.push_back(take_key(cursor));
  const std::uint64_t n_samples = cursor.take(4);
  if (n_samples > cursor.n_bytes_left() / sample_bytes) cursor.mark_invalid();
  for (std::uint64_t k = 0; k < n_samples && cursor.is_valid(); ++k)
    picture.samples.push_back(take_sample(cursor));
  if (!cursor.is_valid() || cursor.n_bytes_left() != 0) return std::nullopt;
  return picture;
}

std::string take_text(journal::ByteReader& cursor, std::string_view bytes)
{
  const std::uint64_t n = cursor.take(4);
  if (n > cursor.n_bytes_left()) cursor.mark_invalid();
  if (!cursor.is_valid()) return {};
  std::string text(bytes.substr(bytes.size() - cursor.n_bytes_left(), n));
  for (std::uint64_t k = 0; k < n; ++k) cursor.take(1);
  return text;
}

std::optional<RecordingFacts> facts_of(std::string_view bytes)
{
  journal::ByteReader cursor(bytes);
  RecordingFacts facts;
  for (std::string* text : {&facts.bench_path, &facts.bench_text, &facts.calibration_path,
                            &facts.calibration_text, &facts.model_path, &facts.model_seal, &facts.set})
    *text = take_text(cursor, bytes);
  if (!cursor.is_valid() || cursor.n_bytes_left() != 0) return std::nullopt;
  return facts;
}

}  // namespace

Recorder::Recorder(const std::string& path, const RecordingFacts& facts)
{
  std::optional<journal::FrameWriter> writer = journal::FrameWriter::try_create(path, file_key, format);
  if (!writer) throw InputError({path, "", "an existing file", "a new name for the recording"});
  writer_ = std::make_unique<journal::FrameWriter>(std::move(*writer));
  // Frames do not wait for the disk; close() does.
  writer_->sync_every(std::chrono::hours(24));
  writer_->append(bytes_of(facts));
}

void Recorder::add(std::int64_t now_ns, std::span<const navigation::KeyPress> keys,
                   std::span<const devices::Sample> samples)
{
  writer_->append(bytes_of(now_ns, keys, samples));
}

void Recorder::close()
{
  writer_->close();
}

std::string bytes_of(std::int64_t now_ns, std::span<const navigation::KeyPress> keys,
                     std::span<const devices::Sample> samples)
{
  std::string bytes;
  bytes.reserve(16 + key_bytes * keys.size() + sample_bytes * samples.size());
  append_i64(bytes, now_ns);
  journal::append_u32(bytes, static_cast<std::uint32_t>(keys.size()));
  for (const navigation::KeyPress& press : keys) {
    journal::append_i32(bytes, static_cast<std::int32_t>(press.key));
    journal::append_i8(bytes,
                       static_cast<std::int8_t>((press.has_shift ? 1 : 0) | (press.has_control ? 2 : 0)));
  }
  journal::append_u32(bytes, static_cast<std::uint32_t>(samples.size()));
  for (const devices::Sample& sample : samples) append_sample(bytes, sample);
  return bytes;
}

std::string bytes_of(const RecordingFacts& facts)
{
  std::string bytes;
  for (const std::string* text : {&facts.bench_path, &facts.bench_text, &facts.calibration_path,
                                  &facts.calibration_text, &facts.model_path, &facts.model_seal, &facts.set})
    append_text(bytes, *text);
  return bytes;
}

Recording parsed_recording(const std::string& path, std::string_view bytes)
{
  constexpr const char* wanted = "a recording of vrda-player bench --record, format version 1";
  // Checked before parse_frames(), whose messages are about journals of a run.
  if (const journal::FrameHeader header = journal::parse_header(bytes, format); header.n_bytes == 0)
    throw InputError({path, header.field, header.found, wanted});
  Recording recording;
  bool has_facts = false;
  const journal::FrameFileSummary frames =
      journal::parse_frames(path, bytes, format, [&](std::string_view frame) -> std::string {
        if (!has_facts) {
          std::optional<RecordingFacts> facts = facts_of(frame);
          if (!facts) return "an invalid header record";
          recording.facts = std::move(*facts);
          has_facts = true;
          return {};
        }
        std::optional<RecordedFrame> picture = recorded_frame(frame);
        if (!picture) return "an invalid frame record";
        recording.frames.push_back(std::move(*picture));
        return {};
      });
  if (!has_facts)
    throw InputError(
        {path, "", frames.dropped_reason.empty() ? "no record after the file header" : frames.dropped_reason,
         wanted});
  recording.dropped_bytes = frames.dropped_bytes;
  recording.dropped_why = frames.dropped_reason;
  return recording;
}

Recording read_recording(const std::string& path)
{
  struct stat facts {};
  if (stat(path.c_str(), &facts) == 0 && facts.st_size > most_file_bytes)
    throw InputError({path, "", std::to_string(facts.st_size) + " bytes", "a recording of at most 4 GiB"});
  return parsed_recording(path, journal::read_frame_file(path));
}

}  // namespace vrda::recording
