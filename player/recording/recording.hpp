/// What came in while the bench ran, picture by picture: enough to show the same pictures again.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/sample.hpp"
#include "view/keys.hpp"

namespace vrda {

/// What a recording was made with. The texts are whole: a recording stands for itself, but for the motion
/// model.
struct RecordingFacts {
  std::string bench_path, bench_text;
  std::string calibration_path, calibration_text;
  std::string model_path;
  std::string model_seal;  ///< that tells the model's file from any other
  std::string set;
  bool operator==(const RecordingFacts&) const = default;
};

/// One round of the loop: what was pressed, what had come, when the picture was begun.
struct RecordedPicture {
  std::int64_t now_ns = 0;  ///< of the samples' clock
  std::vector<KeyPress> keys;
  std::vector<Sample> samples;  ///< in the order of arrival
};

struct Recording {
  RecordingFacts facts;
  std::vector<RecordedPicture> pictures;
  std::uint64_t dropped_bytes = 0;  ///< behind the last whole picture: the recording was cut off there
  std::string dropped_why;
};

/// Writes a recording as the bench runs; a kill loses nothing that was added, a power cut what the disk had
/// not taken yet.
class Recorder {
 public:
  /// Throws InputError naming `path` where it cannot be written, or holds a file already.
  Recorder(const std::string& path, const RecordingFacts& facts);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Throws InputError when the disk is full or gone; what was added before stays readable.
  void add(std::int64_t now_ns, std::span<const KeyPress> keys, std::span<const Sample> samples);
  /// Waits for the disk.
  void close();

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Throws InputError naming `path` when it is no recording, or none of this version. What is torn or damaged
/// at its end is left out and told.
Recording read_recording(const std::string& path);
Recording parsed_recording(const std::string& path, std::string_view bytes);

/// Bytes of a picture, the same for equal pictures.
std::string bytes_of(std::int64_t now_ns, std::span<const KeyPress> keys, std::span<const Sample> samples);
/// Bytes of what stands before the pictures.
std::string bytes_of(const RecordingFacts& facts);

}  // namespace vrda
