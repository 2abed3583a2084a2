/// Statistics of the bench's latency and of its tools' samples. In: times in ms, time stamps in ns. Out:
/// counts, mean, percentiles in ms. Adding a value allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <string>

#include "bench/sample.hpp"

namespace vrda::bench {

/// Histogram of times with bins of 0.25 ms up to 250 ms; the last bin counts longer times.
class TimeHistogram {
 public:
  static constexpr double bin_ms = 0.25;
  static constexpr std::size_t n_bins = 1001;

  void add(double time_ms);
  std::uint64_t n() const { return n_; }
  double mean_ms() const;
  double max_ms() const { return longest_ms_; }
  /// Smallest bin edge that `share` of the times do not exceed; from 250 ms the longest time; 0 if empty.
  double percentile_ms(double share) const;
  /// Standard deviation.
  double spread_ms() const;
  const std::array<std::uint64_t, n_bins>& bins() const { return bins_; }

 private:
  std::array<std::uint64_t, n_bins> bins_{};
  std::uint64_t n_ = 0;
  double sum_ms_ = 0.0, sum_squares_ = 0.0, longest_ms_ = 0.0;
};

/// Counts missed and late samples of one tool by the device's time stamps.
class StreamStatistics {
 public:
  /// Samples of a hidden tool count as received; samples without a stamp are ignored.
  void add(const bench::Sample& sample);
  void add(std::int64_t device_ns, std::int64_t arrival_ns);
  std::uint64_t n() const { return n_; }
  std::uint64_t n_missed() const { return n_missed_; }  ///< gaps of whole intervals between stamps
  std::uint64_t n_late() const { return n_late_; }      ///< more than half an interval above the least delay
  double jitter_ms() const;  ///< standard deviation of the delays between stamps and arrivals

 private:
  bool follow_pace(double step_ns);

  std::uint64_t n_ = 0, n_missed_ = 0, n_late_ = 0;
  std::int64_t device_ns_ = 0, least_delay_ns_ = 0;
  double interval_ns_ = 0.0;  ///< estimated sample interval
  int n_short_ = 0;           ///< consecutive much shorter steps, and their sum
  double short_sum_ns_ = 0.0;
  double sum_ms_ = 0.0, sum_squares_ = 0.0;
  std::int64_t n_delays_ = 0;
};

struct BenchTiming {
  TimeHistogram latency;   ///< from the arrival of a frame's newest sample to its last pixel
  TimeHistogram camera;    ///< from the exposure of a webcam's newest picture to the last pixel; else empty
  TimeHistogram interval;  ///< between frames
  TimeHistogram drawing;   ///< duration of a frame
  std::uint64_t n_pictures = 0;
  std::uint64_t n_without_sample = 0;  ///< frames without a new sample
  std::uint64_t n_not_live = 0;        ///< frames with an input that is not live
  std::uint64_t n_samples = 0, n_missed = 0, n_late = 0, n_lost = 0;
  double jitter_ms = 0.0;  ///< largest of all tools
};

/// JSON: {"pictures": ..., "latency_ms": {"median": ..., "p99": ..., "bins_from_ms": [[from, count], ...]},
/// ...}
void write_timing(std::ostream& out, const BenchTiming& timing);
/// One line of text.
std::string timing_text(const BenchTiming& timing);

}  // namespace vrda::bench
