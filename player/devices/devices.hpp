/// The bench's devices as one stream of samples. Threads of their own read them, reconnect with back-off, and
/// say of each tool when it is not seen.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/sample.hpp"

namespace vrda {

struct TrackerSettings {
  std::string host = "127.0.0.1";
  std::uint16_t port = 18944;
  std::vector<std::string> tools;  ///< device names of messages, or of tools within TDATA and QTDATA
  double stale_after_ms = 100.0;   ///< a tool that says nothing for that long is stale
  double tdata_interval_ms =
      0.0;                  ///< asks the peer to stream TDATA that often (STT_TDATA); 0: it speaks by itself
  double retry_ms = 100.0;  ///< pause before the next attempt, doubling to 20 times that
};

struct BoardSettings {
  std::string port;  ///< of a serial line, or a pty
  int baud = 115200;
  double rate_hz = 100.0;  ///< of each reading
  bool has_potentiometer = true;
  bool has_stage = true;
  double retry_ms = 100.0;  ///< as of the tracker
};

struct DeviceReport {
  LinkState link = LinkState::closed;
  std::string peer;     ///< "127.0.0.1:18944", "/dev/ttyUSB0"
  std::string trouble;  ///< why it is not up, or what was last refused; empty: nothing
  std::uint64_t n_connects = 0, n_samples = 0;
  std::uint64_t n_refused = 0;  ///< messages or frames: wrong checksum, garbage, unknown types
  std::uint64_t n_lost = 0;     ///< samples that found the queue full: the loop did not take them
  double rate_hz = 0.0;         ///< of samples over the last seconds
};

class Devices {
 public:
  Devices(const std::optional<TrackerSettings>& tracker, const std::optional<BoardSettings>& board);
  ~Devices();
  Devices(const Devices&) = delete;
  Devices& operator=(const Devices&) = delete;

  /// The next sample in the order of arrival, false when none waits. Never blocks, allocates nothing.
  bool take(Sample& sample);

  /// ns since the devices were made: the clock of arrivals.
  std::int64_t now_ns() const;

  /// Asks the board to take the stage's present place for zero. False where there is no stage or its board is
  /// not up: it was not asked.
  bool zero_stage();

  DeviceReport report(DeviceId device) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda
