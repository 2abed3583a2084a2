#include "follow/follow_progress.hpp"

#include <cmath>
#include <cstdio>
#include <ostream>

namespace vrda {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds between_lines{2};

std::string progress_line(const RunState& state, int n_steps, const std::string& rate)
{
  if (n_steps == 0 && !state.is_finished()) return "waiting for the first step";
  std::string line = state.counts();
  if (state.n_done() == 0) line += ", " + std::to_string(n_steps) + " steps of the spine";
  for (const std::string& more : {state.place(), rate}) line += more.empty() ? "" : ", " + more;
  return line;
}

}  // namespace

void FollowProgress::note(int n_done, int n_cells)
{
  if (n_first_ < 0) {
    n_first_ = n_done;
    first_ = steady_clock::now();
  }
  rate_.clear();
  const double seconds = std::chrono::duration<double>(steady_clock::now() - first_).count();
  const int n_new = n_done - n_first_;
  if (n_new <= 0 || seconds <= 0.0) return;
  const double rate = n_new / seconds;
  const auto left_s = std::lround((n_cells - n_done) / rate);
  char text[80];
  std::snprintf(text, sizeof text, "%.3g/s, %ld:%02ld left", rate, left_s / 60, left_s % 60);
  rate_ = text;
}

void FollowProgress::say_state(const RunState& state, int n_steps, bool is_due)
{
  if (!is_due && steady_clock::now() - said_ < between_lines) return;
  const std::string line = progress_line(state, n_steps, state.is_finished() ? "" : rate_);
  if (line != last_) say(line);
}

void FollowProgress::say(const std::string& line)
{
  last_ = line;
  said_ = steady_clock::now();
  if (!is_quiet_) stream_ << line << std::endl;
}

}  // namespace vrda
