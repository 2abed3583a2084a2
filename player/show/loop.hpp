/// The main loop of every interactive mode: waits for input events, a due frame or a stop signal, and calls
/// the mode. In: a Mode, the sink of its frames. It returns when the mode is over, the window is closed or a
/// signal arrives; an InputError of the mode passes through.
#pragma once

#include <signal.h>

#include <chrono>
#include <functional>
#include <iosfwd>
#include <optional>

#include "core/text.hpp"
#include "show/sink.hpp"
#include "view/keys.hpp"
#include "view/orbit_camera.hpp"
#include "view/window.hpp"

namespace vrda::show {

/// Blocks SIGINT, SIGTERM and SIGHUP during its lifetime; threads started meanwhile inherit the mask.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Waits until `due` for a signal; returns true if one has arrived.
  bool wait_until(std::chrono::steady_clock::time_point due);

 private:
  sigset_t signals_{}, before_{};
  bool has_come_ = false;
};

/// The key press of an event; empty for other events and unused keys.
std::optional<view::KeyPress> key_press_of(const view::InputEvent& event);

/// The output streams of a mode.
struct Streams {
  std::ostream& data;      ///< machine-readable output: one path per line
  std::ostream& messages;  ///< messages for the user
};

/// The period from the start of a round to that of the next.
struct RoundTime {
  double s = 0.0;
  /// With a window, input starts the next round at once. Otherwise rounds have a fixed period; after an
  /// overrun the next starts at once, and at most one missed round is caught up.
  bool is_ended_by_input = true;
};

/// State, input handling and drawing of a mode. Each round calls take for all events, advance, then draw.
class Mode {
 public:
  virtual ~Mode() = default;
  virtual bool is_over() const = 0;
  virtual RoundTime round_time() const = 0;
  virtual void take(const view::InputEvent& event) = 0;
  virtual void advance(double elapsed_s) = 0;
  virtual void draw() = 0;
};

/// Runs until the mode is over, the window of `sink` is closed or a signal arrives. `stop` must be
/// constructed before the mode starts threads.
void run_loop(Mode& mode, Sink& sink, StopSignals& stop);

/// Runs `work` and returns a caught InputError (a full disk, an invalid file); empty on success.
std::optional<InputError> catch_input_error(const std::function<void()>& work);

}  // namespace vrda::show
