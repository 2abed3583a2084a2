#include "bench/timing.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <sstream>

#include "core/units.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {
namespace {

double spread_of(double sum, double sum_squares, double n)
{
  if (n < 1.0) return 0.0;
  const double mean = sum / n;
  return std::sqrt(std::max(0.0, sum_squares / n - mean * mean));
}

/// Rounded to 0.01 ms.
std::string ms_text(double ms)
{
  return show::rounded_text(ms, 2);
}

void write_histogram(std::ostream& out, const char* name, const TimeHistogram& times)
{
  out << "  \"" << name << "\": {\"n\": " << times.n() << ", \"mean\": " << ms_text(times.mean_ms())
      << ", \"spread\": " << ms_text(times.spread_ms())
      << ", \"median\": " << ms_text(times.percentile_ms(0.5))
      << ", \"p95\": " << ms_text(times.percentile_ms(0.95))
      << ", \"p99\": " << ms_text(times.percentile_ms(0.99)) << ", \"longest\": " << ms_text(times.max_ms())
      << ",\n    \"bins_from_ms\": [";
  const char* comma = "";
  for (std::size_t k = 0; k < times.bins().size(); ++k) {
    if (times.bins()[k] == 0) continue;
    out << comma << "[" << ms_text(static_cast<double>(k) * TimeHistogram::bin_ms) << ", " << times.bins()[k]
        << "]";
    comma = ", ";
  }
  out << "]}";
}

}  // namespace

void TimeHistogram::add(double time_ms)
{
  const double at = std::clamp(time_ms / bin_ms, 0.0, static_cast<double>(n_bins - 1));
  ++bins_[static_cast<std::size_t>(at)];
  ++n_;
  sum_ms_ += time_ms;
  sum_squares_ += time_ms * time_ms;
  longest_ms_ = std::max(longest_ms_, time_ms);
}

double TimeHistogram::mean_ms() const
{
  return n_ == 0 ? 0.0 : sum_ms_ / static_cast<double>(n_);
}

double TimeHistogram::spread_ms() const
{
  return spread_of(sum_ms_, sum_squares_, static_cast<double>(n_));
}

double TimeHistogram::percentile_ms(double share) const
{
  const double wanted = share * static_cast<double>(n_);
  std::uint64_t n = 0;
  for (std::size_t k = 0; k + 1 < n_bins; ++k) {
    n += bins_[k];
    if (n > 0 && static_cast<double>(n) >= wanted) return static_cast<double>(k + 1) * bin_ms;
  }
  return longest_ms_;
}

/// Updates the estimated interval slowly, because gaps are rare. A clock adjustment gives one short step,
/// stamp jitter alternating ones, a faster stream consecutive ones. Returns true for a short step.
bool StreamStatistics::follow_pace(double step_ns)
{
  constexpr double update_share = 0.02, shortest_share = 0.75, longest_share = 1.5;
  constexpr int n_to_accept = 8;  // as for clocks (devices/tracker_protocol.hpp)
  if (interval_ns_ == 0.0) interval_ns_ = step_ns;
  if (step_ns >= shortest_share * interval_ns_) {
    n_short_ = 0;
    short_sum_ns_ = 0.0;
    interval_ns_ += update_share * (std::min(step_ns, longest_share * interval_ns_) - interval_ns_);
    return false;
  }
  short_sum_ns_ += step_ns;
  if (++n_short_ == n_to_accept) {
    interval_ns_ = short_sum_ns_ / n_to_accept;
    n_short_ = 0;
    short_sum_ns_ = 0.0;
  }
  return true;
}

void StreamStatistics::add(const bench::Sample& sample)
{
  if (sample.device_ns != 0) add(sample.device_ns, sample.arrival_ns);
}

void StreamStatistics::add(std::int64_t device_ns, std::int64_t arrival_ns)
{
  const std::int64_t step_ns = device_ns - device_ns_;
  const std::int64_t delay_ns = arrival_ns - device_ns;
  const bool is_first = n_++ == 0;
  device_ns_ = device_ns;
  // After a clock step the delays are estimated again, and the gap is unknown.
  constexpr std::int64_t longest_gap_ns = 1'000'000'000;
  constexpr std::int64_t drift_share = 10'000;  // 0.1 ms a second
  if (is_first || step_ns <= 0 || step_ns > longest_gap_ns) {
    least_delay_ns_ = delay_ns;
    return;
  }
  const auto step = static_cast<double>(step_ns);
  // Follows clock drift as ClockMap does, and a clock set back by less than an interval.
  least_delay_ns_ += step_ns / drift_share;
  if (follow_pace(step)) least_delay_ns_ = delay_ns;
  n_missed_ += static_cast<std::uint64_t>(std::max(0.0, std::round(step / interval_ns_) - 1.0));
  least_delay_ns_ = std::min(least_delay_ns_, delay_ns);
  const double late_ns = static_cast<double>(delay_ns - least_delay_ns_);
  if (late_ns > 0.5 * interval_ns_) ++n_late_;
  const double late_ms = late_ns * ms_per_ns;
  sum_ms_ += late_ms;
  sum_squares_ += late_ms * late_ms;
  ++n_delays_;
}

double StreamStatistics::jitter_ms() const
{
  return spread_of(sum_ms_, sum_squares_, static_cast<double>(n_delays_));
}

void write_timing(std::ostream& out, const BenchTiming& timing)
{
  out << "{\n  \"pictures\": " << timing.n_pictures
      << ",\n  \"pictures_without_new_sample\": " << timing.n_without_sample
      << ",\n  \"pictures_with_an_input_not_live\": " << timing.n_not_live
      << ",\n  \"samples\": " << timing.n_samples << ",\n  \"samples_missed\": " << timing.n_missed
      << ",\n  \"samples_late\": " << timing.n_late << ",\n  \"samples_lost\": " << timing.n_lost
      << ",\n  \"sample_jitter_ms\": " << ms_text(timing.jitter_ms) << ",\n";
  write_histogram(out, "latency_ms", timing.latency);
  out << ",\n";
  if (timing.camera.n() > 0) {
    write_histogram(out, "camera_latency_ms", timing.camera);
    out << ",\n";
  }
  write_histogram(out, "interval_ms", timing.interval);
  out << ",\n";
  write_histogram(out, "drawing_ms", timing.drawing);
  out << "\n}\n";
}

std::string timing_text(const BenchTiming& timing)
{
  std::ostringstream text;
  const double rate = timing.interval.mean_ms() > 0.0 ? 1000.0 / timing.interval.mean_ms() : 0.0;
  text << timing.n_pictures << " frames, " << show::rounded_text(rate, 1) << " a second; latency "
       << ms_text(timing.latency.percentile_ms(0.5)) << " ms (median), "
       << ms_text(timing.latency.percentile_ms(0.99)) << " ms (99th percentile), "
       << ms_text(timing.latency.max_ms()) << " ms (longest); " << timing.n_samples << " samples, "
       << timing.n_missed << " missed, " << timing.n_late << " late, " << timing.n_lost << " lost";
  return text.str();
}

}  // namespace vrda::bench
