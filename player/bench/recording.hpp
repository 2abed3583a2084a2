/// Recording of a bench session: the inputs of every frame, enough to reproduce the frames.
#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "bench/devices.hpp"
#include "core/framed_file.hpp"
#include "view/keys.hpp"

namespace vrda::bench {

/// What a session was started with. Bench file and calibration are stored as text, so that replay needs
/// only the motion model.
struct RecordingFacts {
  std::string bench_path, bench_text;
  std::string calibration_path, calibration_text;
  std::string model_path;
  std::string model_seal;  ///< identifies the contents of the model file
  std::string set;
  bool operator==(const RecordingFacts&) const = default;
};

/// Inputs of one frame: key presses, samples, start time.
struct RecordedFrame {
  std::int64_t now_ns = 0;  ///< clock of Sample::arrival_ns
  std::vector<view::KeyPress> keys;
  std::vector<Sample> samples;  ///< in order of arrival
};

/// Writes a recording while the bench runs. After a kill all added records are readable; a power cut can
/// lose those not yet on disk.
class Recorder {
 public:
  /// Throws InputError naming `path` if it cannot be written or exists already.
  Recorder(const std::string& path, const RecordingFacts& facts);

  /// Throws InputError if the disk is full or missing; earlier records stay readable.
  void add(std::int64_t now_ns, std::span<const view::KeyPress> keys, std::span<const Sample> samples);
  /// Blocks until the data are on disk.
  void close() { writer_->close(); }

 private:
  std::unique_ptr<core::FrameWriter> writer_;
};

/// Reads a recording of any length: in memory are one frame, a block of the file and a sparse index. A
/// damaged tail is dropped and reported.
class RecordingReader {
 public:
  /// Bytes of the file from an offset; fewer at its end. May throw InputError.
  using ByteSource = std::function<std::string(std::uint64_t at, std::size_t n)>;

  /// Reads the file once. Throws InputError naming `path` if it is not a recording of this version.
  explicit RecordingReader(const std::string& path);
  /// The same of `n_bytes` bytes that are somewhere else; `path` is for messages.
  RecordingReader(const std::string& path, std::uint64_t n_bytes, ByteSource bytes);

  const RecordingFacts& facts() const { return facts_; }
  std::size_t n_frames() const { return n_frames_; }
  std::uint64_t dropped_bytes() const { return dropped_bytes_; }
  const std::string& dropped_why() const { return dropped_why_; }

  /// Frame `k`, valid until the next call. The next frame is read on, any other reached by the index. Throws
  /// InputError if the file has changed since.
  const RecordedFrame& frame(std::size_t k);
  /// Time of frame `k` since the first one.
  double seconds(std::size_t k);
  /// The first frame at `s` or later; n_frames() if all are earlier.
  std::size_t index_at(double s);

 private:
  struct IndexEntry {
    std::uint64_t at = 0;  ///< of the frame in the file
    std::int64_t now_ns = 0;
  };
  void scan();
  void add_to_index(const IndexEntry& entry);
  std::string_view bytes_from(std::uint64_t at, std::size_t n);
  core::ParsedFrame frame_from(std::uint64_t at);

  std::string path_;
  std::uint64_t n_bytes_ = 0;
  ByteSource source_;
  std::string block_;  ///< bytes of the file from block_at_
  std::uint64_t block_at_ = 0;
  RecordingFacts facts_;
  std::size_t n_frames_ = 0;
  std::uint64_t dropped_bytes_ = 0;
  std::string dropped_why_;
  std::vector<IndexEntry> index_;  ///< of every stride_-th frame
  std::size_t stride_ = 1;
  RecordedFrame frame_;   ///< frame `next_` - 1
  std::size_t next_ = 0;  ///< frame at next_at_; 0: none was read
  std::uint64_t next_at_ = 0;
};

/// Serialised record of a frame; equal for equal inputs.
/// `now_ns`: start of the frame, clock of Sample::arrival_ns. `samples`: in order of arrival.
std::string bytes_of(std::int64_t now_ns, std::span<const view::KeyPress> keys,
                     std::span<const Sample> samples);
/// Serialised header record.
std::string bytes_of(const RecordingFacts& facts);

}  // namespace vrda::bench
