#include "bench/replay_state.hpp"

#include <algorithm>
#include <iterator>

#include "bench/bench_show.hpp"

namespace vrda::bench {
namespace {

/// Frames before the end of a skipped part that set what is remembered of the tools: those up to the last
/// frame that had a sample of a tool, or that showed it.
class RememberedFrames {
 public:
  void take(std::size_t k, const std::vector<bench::Sample>& samples)
  {
    for (const bench::Sample& sample : samples) {
      if (sample.kind != bench::SampleKind::tool_pose) continue;
      const std::size_t at = 2 * static_cast<std::size_t>(sample.source);
      if (at >= last_.size()) last_.resize(at + 2);
      last_[at] = k;
      if (sample.is(bench::ToolVisibility::seen)) last_[at + 1] = k;
    }
  }
  bool has(std::size_t k) const
  {
    constexpr std::size_t window = 600;  // 10 s at 60 frames a second: filters have settled
    return std::ranges::any_of(last_, [k](const std::optional<std::size_t>& last) {
      return last && k <= *last && k + window > *last;
    });
  }

 private:
  std::vector<std::optional<std::size_t>> last_;
};

}  // namespace

ReplayState::ReplayState(const BenchSetup& setup, bench::RecordingReader& recording)
    : setup_(setup), recording_(recording)
{
  begin();
}

void ReplayState::begin()
{
  state_.emplace(setup_.bench, setup_.calibration, setup_.motion, setup_.frame);
  n_taken_ = 0;
}

void ReplayState::skip_to(std::size_t n)
{
  RememberedFrames remembered;
  for (std::size_t k = n_taken_; k < n; ++k) remembered.take(k, recording_.frame(k).samples);
  std::vector<bench::Sample> lasting;
  while (n_taken_ < n) {
    if (remembered.has(n_taken_)) {
      take_next();
      continue;
    }
    const bench::RecordedFrame& frame = recording_.frame(n_taken_++);
    lasting.clear();
    std::ranges::copy_if(frame.samples, std::back_inserter(lasting), [](const bench::Sample& sample) {
      return sample.kind != bench::SampleKind::tool_pose;
    });
    PanelContent unused;
    apply_input(*state_, unused, frame.keys, lasting);
  }
}

void ReplayState::take_next()
{
  const bench::RecordedFrame& frame = recording_.frame(n_taken_++);
  PanelContent unused;
  apply_input(*state_, unused, frame.keys, frame.samples);
  frame_ = &state_->frame(frame.now_ns);
}

const BenchFrame& ReplayState::at(std::size_t n)
{
  if (n + 1 < n_taken_) begin();
  if (n > n_taken_ + run_up) skip_to(n - run_up);
  while (n_taken_ <= n) take_next();
  return *frame_;
}

}  // namespace vrda::bench
