/// The loop of every mode that shows something that changes, and what it waits for.
#pragma once

#include <signal.h>

#include <chrono>
#include <functional>
#include <iosfwd>
#include <optional>

#include "core/error.hpp"
#include "loop/sink.hpp"
#include "render/window.hpp"
#include "view/gaze.hpp"
#include "view/keys.hpp"

namespace vrda {

/// Keeps SIGINT and SIGTERM from ending the program, for as long as it lives. Threads begun meanwhile keep
/// them too.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Whether one came; waits for it until `due`.
  bool came_by(std::chrono::steady_clock::time_point due);

 private:
  sigset_t signals_{}, before_{};
  bool has_come_ = false;
};

/// Of InputEvent::key, which is the character without shift, and has_shift; Key::none for one that nothing
/// listens to.
Key key_of_window(int key, bool has_shift);

/// Nothing where the event is no press of a key that means something.
std::optional<KeyPress> key_press_of(const InputEvent& event);

Button button_of(MouseButton button);

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
