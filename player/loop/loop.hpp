/// The loop of every mode that shows something that changes.
#pragma once

#include <functional>
#include <iosfwd>
#include <optional>

#include "core/error.hpp"
#include "loop/sink.hpp"
#include "loop/stop_signals.hpp"

namespace vrda {

/// Where a mode writes.
struct Streams {
  std::ostream& data;  ///< what a program reads: a path a line
  std::ostream& talk;
};

/// From the begin of a round to that of the next.
struct RoundTime {
  double s = 0.0;
  /// What the user does begins it at once, where there is a window. Else rounds come at even times; after a
  /// long one the next comes at once, but more than one that was missed is not made up for.
  bool is_ended_by_input = true;
};

/// What is shown and what its user does. A round takes the events, goes on by the time that went by, draws.
class Mode {
 public:
  virtual ~Mode() = default;
  virtual bool is_over() const = 0;
  virtual RoundTime round_time() const = 0;
  virtual void take(const InputEvent& event) = 0;
  virtual void advance(double elapsed_s) = 0;
  virtual void draw() = 0;
};

/// Until the mode is over, the window of `sink` is closed or a signal comes. `stop` blocks the signals from
/// before threads of the mode began.
void run_loop(Mode& mode, Sink& sink, StopSignals& stop);

/// Runs what a session survives where it fails (a full disk, a file that is none): why, or nothing.
std::optional<InputError> attempt(const std::function<void()>& work);

}  // namespace vrda
