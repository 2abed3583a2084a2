/// How far a followed run is, in lines of text.
#pragma once

#include <chrono>
#include <iosfwd>
#include <string>

#include "follow/run_state.hpp"

namespace vrda {

class FollowProgress {
 public:
  FollowProgress(std::ostream& stream, bool is_quiet) : stream_(stream), is_quiet_(is_quiet) {}

  /// The run began anew: its rate does too.
  void begin_again() { n_first_ = -1; }
  /// The run has done that many of its attitudes. Those of the first time do not count for the rate.
  void note(int n_done, int n_cells);
  /// "512/s, 0:02 left", or nothing while it is not known.
  const std::string& rate() const { return rate_; }

  /// Of the state, with the rate; every few seconds, and only when something came.
  void say_state(const RunState& state, int n_steps, bool is_due = false);
  void say(const std::string& line);

 private:
  std::ostream& stream_;
  bool is_quiet_;
  std::string rate_, last_;
  std::chrono::steady_clock::time_point said_, first_;
  int n_first_ = -1;
};

}  // namespace vrda
