/// Recording of a bench session: the inputs of every frame, enough to reproduce the frames.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/sample.hpp"
#include "journal/framed_file.hpp"
#include "navigation/keys.hpp"

namespace vrda::recording {

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
  std::vector<navigation::KeyPress> keys;
  std::vector<devices::Sample> samples;  ///< in order of arrival
};

struct Recording {
  RecordingFacts facts;
  std::vector<RecordedFrame> frames;
  std::uint64_t dropped_bytes =
      0;  ///< after the last complete record: the file is truncated or damaged there
  std::string dropped_why;
};

/// Writes a recording while the bench runs. After a kill all added records are readable; a power cut can
/// lose those not yet on disk.
class Recorder {
 public:
  /// Throws InputError naming `path` if it cannot be written or exists already.
  Recorder(const std::string& path, const RecordingFacts& facts);

  /// Throws InputError if the disk is full or missing; earlier records stay readable.
  void add(std::int64_t now_ns, std::span<const navigation::KeyPress> keys,
           std::span<const devices::Sample> samples);
  /// Blocks until the data are on disk.
  void close();

 private:
  std::unique_ptr<journal::FrameWriter> writer_;
};

/// Throws InputError naming `path` if it is not a recording of this version. A damaged tail is dropped and
/// reported in dropped_bytes and dropped_why.
Recording read_recording(const std::string& path);
Recording parsed_recording(const std::string& path, std::string_view bytes);

/// Serialised record of a frame; equal for equal inputs.
std::string bytes_of(std::int64_t now_ns, std::span<const navigation::KeyPress> keys,
                     std::span<const devices::Sample> samples);
/// Serialised header record.
std::string bytes_of(const RecordingFacts& facts);

}  // namespace vrda::recording
