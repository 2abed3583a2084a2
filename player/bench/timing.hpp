/// How long the bench takes from a sample to the picture, and what it missed.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <string>

#include "devices/sample.hpp"

namespace vrda {

/// Counts of times in bins of a quarter of a millisecond, up to 250 ms; longer ones in the last.
class TimeHistogram {
 public:
  static constexpr double bin_ms = 0.25;
  static constexpr std::size_t n_bins = 1001;

  void add(double time_ms);
  std::uint64_t n() const { return n_; }
  double mean_ms() const;
  double longest_ms() const { return longest_ms_; }
  /// The smallest bin edge that `share` of the times do not exceed; 0 without any. 250 or more: the longest.
  double percentile_ms(double share) const;
  /// Standard deviation.
  double spread_ms() const;
  const std::array<std::uint64_t, n_bins>& bins() const { return bins_; }

 private:
  std::array<std::uint64_t, n_bins> bins_{};
  std::uint64_t n_ = 0;
  double sum_ms_ = 0.0, sum_squares_ = 0.0, longest_ms_ = 0.0;
};

/// One tool's stream: samples that never came, and those that came late, by the device's time stamps.
class SampleWatch {
 public:
  /// One that says that the tool is hidden came, too; without a stamp nothing can be told.
  void add(const Sample& sample);
  void add(std::int64_t device_ns, std::int64_t arrival_ns);
  std::uint64_t n() const { return n_; }
  std::uint64_t n_missed() const { return n_missed_; }  ///< gaps of whole intervals between stamps
  std::uint64_t n_late() const { return n_late_; }      ///< more than half an interval behind the quickest
  double jitter_ms() const;  ///< standard deviation of the delays between stamps and arrivals

 private:
  bool follow_pace(double step_ns);

  std::uint64_t n_ = 0, n_missed_ = 0, n_late_ = 0;
  std::int64_t device_ns_ = 0, least_delay_ns_ = 0;
  double interval_ns_ = 0.0;  ///< the usual one: gaps are measured by it
  int n_short_ = 0;           ///< steps in a row that are much shorter, and their sum
  double short_sum_ns_ = 0.0;
  double sum_ms_ = 0.0, sum_squares_ = 0.0;
  std::int64_t n_delays_ = 0;
};

struct BenchTiming {
  TimeHistogram latency;   ///< from the arrival of the newest sample of a picture to its last pixel
  TimeHistogram interval;  ///< between pictures
  TimeHistogram drawing;   ///< of a picture, from begin to last pixel
  std::uint64_t n_pictures = 0;
  std::uint64_t n_repeated = 0;   ///< pictures for which no new sample had come
  std::uint64_t n_unsampled = 0;  ///< pictures of which an input was not live
  std::uint64_t n_samples = 0, n_missed = 0, n_late = 0, n_lost = 0;
  double jitter_ms = 0.0;  ///< of samples
};

/// {"pictures": ..., "latency_ms": {"median": ..., "p99": ..., "bins": [[from, count], ...]}, ...}
void write_timing(std::ostream& out, const BenchTiming& timing);
/// For people, some lines.
std::string timing_text(const BenchTiming& timing);

}  // namespace vrda
