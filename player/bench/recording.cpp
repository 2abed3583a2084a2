#include "bench/recording.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "core/files.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::bench {
namespace {

/// A frame's samples take some hundred bytes; the texts of bench and calibration some kilobytes.
constexpr core::FrameFormat format{"VRDABREC", 1, std::uint32_t{1} << 24, "frame"};
constexpr const char* file_key = "bench recording";

constexpr std::size_t key_bytes = 5, sample_bytes = 80;
/// Read at once; a frame that is longer is read whole.
constexpr std::size_t block_bytes = std::size_t{1} << 20;
/// 10 hours at 60 frames a second have an entry for every 256th frame; 16 bytes each.
constexpr std::size_t most_index_entries = 16384;
constexpr const char* wanted_recording = "a recording of vrda-player bench --record, format version 1";

// Samples are stored as they are in memory.
static_assert(std::endian::native == std::endian::little && sizeof(Sample) == sample_bytes);

void append_i64(std::string& bytes, std::int64_t value)
{
  core::append_u32(bytes, static_cast<std::uint32_t>(value));
  core::append_u32(bytes, static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) >> 32));
}

/// The texts of the header record, in the order of the file.
template <typename Facts>
auto texts_of(Facts& facts)
{
  return std::array{&facts.bench_path,
                    &facts.bench_text,
                    &facts.calibration_path,
                    &facts.calibration_text,
                    &facts.model_path,
                    &facts.model_seal,
                    &facts.set};
}

bool has_valid_kind(const Sample& sample)
{
  switch (sample.kind) {
    case SampleKind::tool_pose:
      return sample.state <= static_cast<std::uint8_t>(ToolVisibility::invalid_pose);
    case SampleKind::link:
      return sample.state <= static_cast<std::uint8_t>(LinkState::up) &&
             sample.source <= static_cast<std::uint16_t>(DeviceId::board);
    case SampleKind::potentiometer:
    case SampleKind::stage:
    case SampleKind::offset:
      return true;
  }
  return false;
}

/// The pose of a visible tool and an offset must be finite with a unit quaternion.
bool has_valid_pose(const Sample& sample)
{
  if (!sample.is(ToolVisibility::seen) && sample.kind != SampleKind::offset) return true;
  double square = 0.0;
  for (const double v : sample.tool_pose.rotation) square += v * v;
  constexpr double unit_tolerance = 1e-6;
  const Eigen::Map<const Eigen::Vector3d> position(sample.tool_pose.position_mm);
  return position.allFinite() && std::abs(square - 1.0) < unit_tolerance;
}

Sample take_sample(core::ByteReader& cursor)
{
  Sample sample;
  const std::string_view bytes = cursor.take_bytes(sample_bytes);
  if (!cursor.is_valid()) return sample;
  std::memcpy(&sample, bytes.data(), sample_bytes);
  if (!has_valid_kind(sample) || !has_valid_pose(sample)) cursor.mark_invalid();
  return sample;
}

view::KeyPress take_key(core::ByteReader& cursor)
{
  view::KeyPress press;
  press.key = static_cast<view::Key>(cursor.take_i32());
  const std::uint64_t flags = cursor.take(1);
  if (flags > 3) cursor.mark_invalid();
  press.has_shift = (flags & 1) != 0;
  press.has_control = (flags & 2) != 0;
  return press;
}

std::optional<RecordedFrame> recorded_frame(std::string_view bytes)
{
  core::ByteReader cursor(bytes);
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

std::optional<RecordingFacts> facts_of(std::string_view bytes)
{
  core::ByteReader cursor(bytes);
  RecordingFacts facts;
  for (std::string* text : texts_of(facts)) *text = cursor.take_bytes(cursor.take(4));
  if (!cursor.is_valid() || cursor.n_bytes_left() != 0) return std::nullopt;
  return facts;
}

}  // namespace

Recorder::Recorder(const std::string& path, const RecordingFacts& facts)
{
  std::optional<core::FrameWriter> writer = core::FrameWriter::try_create(path, file_key, format);
  if (!writer) throw InputError({path, "", "an existing file", "a new name for the recording"});
  writer_ = std::make_unique<core::FrameWriter>(std::move(*writer));
  // Frames do not wait for the disk; close() does.
  writer_->sync_every(std::chrono::hours(24));
  writer_->append(bytes_of(facts));
}

void Recorder::add(std::int64_t now_ns, std::span<const view::KeyPress> keys, std::span<const Sample> samples)
{
  writer_->append(bytes_of(now_ns, keys, samples));
}

std::string bytes_of(std::int64_t now_ns, std::span<const view::KeyPress> keys,
                     std::span<const Sample> samples)
{
  std::string bytes;
  bytes.reserve(16 + key_bytes * keys.size() + sample_bytes * samples.size());
  append_i64(bytes, now_ns);
  core::append_u32(bytes, static_cast<std::uint32_t>(keys.size()));
  for (const view::KeyPress& press : keys) {
    core::append_i32(bytes, static_cast<std::int32_t>(press.key));
    core::append_i8(bytes, static_cast<std::int8_t>((press.has_shift ? 1 : 0) | (press.has_control ? 2 : 0)));
  }
  core::append_u32(bytes, static_cast<std::uint32_t>(samples.size()));
  for (const Sample& sample : samples) bytes.append(reinterpret_cast<const char*>(&sample), sample_bytes);
  return bytes;
}

std::string bytes_of(const RecordingFacts& facts)
{
  std::string bytes;
  for (const std::string* text : texts_of(facts)) {
    core::append_u32(bytes, static_cast<std::uint32_t>(text->size()));
    bytes += *text;
  }
  return bytes;
}

namespace {

RecordingReader::ByteSource source_of(const std::string& path, const std::shared_ptr<OpenFile>& file)
{
  return [path, file](std::uint64_t at, std::size_t n) {
    std::string bytes(n, '\0');
    std::size_t n_read = 0;
    while (n_read < n) {
      const ssize_t more =
          pread(file->get(), bytes.data() + n_read, n - n_read, static_cast<off_t>(at + n_read));
      if (more < 0 && errno == EINTR) continue;
      if (more < 0)
        throw InputError({path, "", std::string("a read error (") + std::strerror(errno) + ")",
                          "a recording that can be read"});
      if (more == 0) break;
      n_read += static_cast<std::size_t>(more);
    }
    bytes.resize(n_read);
    return bytes;
  };
}

}  // namespace

RecordingReader::RecordingReader(const std::string& path) : path_(path)
{
  const auto file = std::make_shared<OpenFile>(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat facts {};
  if (!file->is_open() || fstat(file->get(), &facts) != 0)
    throw InputError(
        {path, "", std::string("no access (") + std::strerror(errno) + ")", "a recording that can be read"});
  n_bytes_ = static_cast<std::uint64_t>(facts.st_size);
  source_ = source_of(path, file);
  scan();
}

RecordingReader::RecordingReader(const std::string& path, std::uint64_t n_bytes, ByteSource bytes)
    : path_(path), n_bytes_(n_bytes), source_(std::move(bytes))
{
  scan();
}

/// At least `n` bytes of the file, or what there is.
std::string_view RecordingReader::bytes_from(std::uint64_t at, std::size_t n)
{
  n = static_cast<std::size_t>(std::min<std::uint64_t>(n, n_bytes_ - at));
  if (at < block_at_ || at + n > block_at_ + block_.size()) {
    block_ = source_(
        at, static_cast<std::size_t>(std::min<std::uint64_t>(std::max(n, block_bytes), n_bytes_ - at)));
    block_at_ = at;
  }
  return std::string_view(block_).substr(static_cast<std::size_t>(at - block_at_));
}

core::ParsedFrame RecordingReader::frame_from(std::uint64_t at)
{
  const core::ParsedFrame parsed = core::parse_frame(bytes_from(at, core::frame_head_bytes), format);
  return parsed.n_bytes_needed == 0 ? parsed
                                    : core::parse_frame(bytes_from(at, parsed.n_bytes_needed), format);
}

void RecordingReader::add_to_index(const IndexEntry& entry)
{
  if (n_frames_ % stride_ != 0) return;
  if (index_.size() == most_index_entries) {
    stride_ *= 2;
    for (std::size_t k = 0; 2 * k < index_.size(); ++k) index_[k] = index_[2 * k];
    index_.resize(index_.size() / 2);
  }
  if (n_frames_ % stride_ == 0) index_.push_back(entry);
}

void RecordingReader::scan()
{
  const core::FrameHeader header = core::parse_header(bytes_from(0, core::longest_header_bytes), format);
  if (header.n_bytes == 0) throw InputError({path_, header.field, header.found, wanted_recording});
  std::uint64_t at = header.n_bytes;
  bool has_facts = false;
  while (at < n_bytes_) {
    const core::ParsedFrame parsed = frame_from(at);
    dropped_why_ = parsed.invalid_reason;
    if (!dropped_why_.empty()) break;
    if (!has_facts) {
      std::optional<RecordingFacts> facts = facts_of(parsed.content);
      if (!facts) {
        dropped_why_ = "an invalid header record";
        break;
      }
      facts_ = std::move(*facts);
      has_facts = true;
    } else if (const std::optional<RecordedFrame> frame = recorded_frame(parsed.content)) {
      add_to_index({at, frame->now_ns});
      ++n_frames_;
    } else {
      dropped_why_ = "an invalid frame record";
      break;
    }
    at += parsed.n_bytes;
  }
  if (!has_facts)
    throw InputError({path_, "", dropped_why_.empty() ? "no record after the file header" : dropped_why_,
                      wanted_recording});
  dropped_bytes_ = n_bytes_ - at;
}

const RecordedFrame& RecordingReader::frame(std::size_t k)
{
  check(k < n_frames_, "the frame is in the recording");
  if (next_ == k + 1) return frame_;
  if (next_ == 0 || k < next_ || k / stride_ > next_ / stride_) {
    next_ = k / stride_ * stride_;
    next_at_ = index_[k / stride_].at;
  }
  for (; next_ <= k; ++next_) {
    const core::ParsedFrame parsed = frame_from(next_at_);
    std::optional<RecordedFrame> read;
    if (parsed.invalid_reason.empty()) read = recorded_frame(parsed.content);
    if (!read) {
      next_ = 0;
      throw InputError({path_, "", "a frame that has changed since it was opened", "a recording at rest"});
    }
    next_at_ += parsed.n_bytes;
    frame_ = std::move(*read);
  }
  return frame_;
}

double RecordingReader::seconds(std::size_t k)
{
  const std::int64_t now_ns = k % stride_ == 0 ? index_[k / stride_].now_ns : frame(k).now_ns;
  return static_cast<double>(now_ns - index_.front().now_ns) * s_per_ns;
}

std::size_t RecordingReader::index_at(double s)
{
  const auto later = std::ranges::partition_point(index_, [&](const IndexEntry& entry) {
    return static_cast<double>(entry.now_ns - index_.front().now_ns) * s_per_ns < s;
  });
  std::size_t k =
      later == index_.begin() ? 0 : static_cast<std::size_t>(later - index_.begin() - 1) * stride_;
  while (k < n_frames_ && seconds(k) < s) ++k;
  return k;
}

}  // namespace vrda::bench
