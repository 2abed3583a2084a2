/// The bench's devices as one stream of samples. A background thread reads them, reconnects with back-off,
/// and reports tools that are not visible.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/sample.hpp"

namespace vrda::bench {

struct TrackerSettings {
  std::string host = "127.0.0.1";
  std::uint16_t port = 18944;
  std::vector<std::string> tools;  ///< device names of messages, or tool names within TDATA and QTDATA
  double stale_after_ms = 100.0;   ///< a tool without news for this long is stale
  double tdata_interval_ms =
      0.0;                  ///< requests TDATA at this interval (STT_TDATA); 0: the server streams unasked
  double retry_ms = 100.0;  ///< first back-off pause, doubling to 20 times that
  /// Instead of host and port: a program and its arguments that writes the messages to its standard output.
  /// Started again with back-off when it ends. Looked up beside this program, then in PATH.
  std::vector<std::string> program;
};

struct BoardSettings {
  std::string port;  ///< serial port or pseudo-terminal
  int baud = 115200;
  double rate_hz = 100.0;  ///< of each reading
  bool has_potentiometer = true;
  bool has_stage = true;
  double retry_ms = 100.0;  ///< as in TrackerSettings
};

struct DeviceReport {
  LinkState link = LinkState::closed;
  std::string peer;                ///< "127.0.0.1:18944", "/dev/ttyUSB0"
  std::string error_message;       ///< why the link is not up, or the last rejected input; may be empty
  std::vector<std::string> notes;  ///< what is odd about the input that is used (TrackerProtocol::notes)
  std::uint64_t n_connects = 0, n_samples = 0;
  std::uint64_t n_refused = 0;  ///< rejected messages or frames: wrong checksum, garbage, wrong size
  std::uint64_t n_lost = 0;     ///< samples dropped because the queue was full
  double rate_hz = 0.0;         ///< of samples over the last 2 s
};

class Devices {
 public:
  Devices(const std::optional<TrackerSettings>& tracker, const std::optional<BoardSettings>& board);
  ~Devices();

  /// The next sample in order of arrival; false if the queue is empty. Never blocks or allocates.
  bool take(Sample& sample);

  /// ns since construction: the clock of arrival times.
  std::int64_t now_ns() const;

  /// Requests that the board sets its stage counter to zero. Returns false, without a request, if there is
  /// no stage or the board is not up.
  bool zero_stage();

  DeviceReport report(DeviceId device) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
