#include "bench/device_output.hpp"

#include <algorithm>
#include <utility>

namespace vrda::bench {

void RateMeter::count(std::int64_t now_ns)
{
  const std::int64_t number = now_ns / bucket_ns;
  Bucket& bucket = buckets_[static_cast<std::size_t>(number) % n_buckets];
  if (bucket.number != number) bucket = {number, 0};
  ++bucket.n;
  if (first_ns_ < 0) first_ns_ = now_ns;
}

double RateMeter::rate_hz(std::int64_t now_ns) const
{
  const std::int64_t number = now_ns / bucket_ns;
  std::uint64_t n = 0;
  for (const Bucket& bucket : buckets_) {
    if (bucket.number > number - static_cast<std::int64_t>(n_buckets)) n += bucket.n;
  }
  if (n == 0) return 0.0;
  // From the oldest bin or the first reading, whichever is later, and at least one bin: a single reading
  // must not give a high rate.
  const std::int64_t begin_ns = (number - static_cast<std::int64_t>(n_buckets) + 1) * bucket_ns;
  const std::int64_t span_ns = std::max(now_ns - std::max(begin_ns, first_ns_), bucket_ns);
  return 1e9 * static_cast<double>(n) / static_cast<double>(span_ns);
}

DeviceOutput::DeviceOutput(DeviceId device, std::string peer, SampleQueue& queue, const ArrivalClock& clock)
    : device_(device), queue_(queue), clock_(clock)
{
  report_.peer = std::move(peer);
}

void DeviceOutput::put_one(const Sample& sample)
{
  if (!queue_.stage(sample)) ++report_.n_lost;
  if (sample.kind == SampleKind::link) return;
  if (sample.kind == SampleKind::tool_pose && !sample.is(ToolVisibility::seen)) return;
  ++report_.n_samples;
  rate_.count(sample.arrival_ns);
}

void DeviceOutput::put(const std::vector<Sample>& samples)
{
  if (samples.empty()) return;
  const std::scoped_lock lock(mutex_);
  for (const Sample& sample : samples) put_one(sample);
  queue_.publish();
}

void DeviceOutput::set_link(LinkState link, const std::string& error_message)
{
  const std::scoped_lock lock(mutex_);
  if (link == LinkState::up) {
    ++report_.n_connects;
    report_.error_message.clear();
  } else if (!error_message.empty()) {
    report_.error_message = error_message;
  }
  if (std::exchange(report_.link, link) == link) return;
  Sample sample;
  sample.arrival_ns = clock_.now_ns();
  sample.source = static_cast<std::uint16_t>(device_);
  sample.state = static_cast<std::uint8_t>(link);
  put_one(sample);
  queue_.publish();
}

void DeviceOutput::count_rejected(std::uint64_t n, const std::string& error_message)
{
  if (n == 0) return;
  const std::scoped_lock lock(mutex_);
  report_.n_refused += n;
  if (!error_message.empty()) report_.error_message = error_message;
}

void DeviceOutput::set_notes(std::vector<std::string> notes)
{
  const std::scoped_lock lock(mutex_);
  report_.notes = std::move(notes);
}

void DeviceOutput::set_error_message(const std::string& error_message)
{
  const std::scoped_lock lock(mutex_);
  report_.error_message = error_message;
}

DeviceReport DeviceOutput::report() const
{
  const std::scoped_lock lock(mutex_);
  DeviceReport report = report_;
  report.rate_hz = rate_.rate_hz(clock_.now_ns());
  return report;
}

}  // namespace vrda::bench
