/// Text over the bench's frame: inputs that are not live in both eyes' views, and a panel for the operator
/// with devices, parameter and timing.
#pragma once

#include <utility>

#include "bench/bench_run.hpp"
#include "show/loop.hpp"
#include "view/overlay_text.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"
#include "view/stereo_view.hpp"

namespace vrda::bench {

struct PanelContent {
  bool has_panel = true, has_help = false;
  DeviceReport tracker, board;
  bool has_board = false, is_calibrated = true;  ///< false: the values are nominal
  const BenchTiming* timing = nullptr;
  std::string error_message;  ///< problem of the display; may be empty
  std::string message;        ///< newest message, shown for some seconds
  view::DoubtText doubt{};    ///< what is wrong with the model's pose; may be empty
};

/// The words in lines that are no wider than the width unless a word is; a line feed ends a line.
std::vector<std::string> wrapped(const view::OverlayText& text, const std::string& words, float width_px);

class BenchPanel {
 public:
  explicit BenchPanel(const BenchFile& bench);

  const view::OverlayFont& font() const { return text_.font(); }
  /// Valid until the next call. The panel is beside the eyes' windows, or over the left one where they leave
  /// no room.
  const view::Overlay& drawn(const BenchState& state, const BenchFrame& frame, const PanelContent& content);

 private:
  void add_marks(const view::Viewport& visible, const BenchFrame& frame, const PanelContent& content);
  void add_panel(const view::Viewport& area, const BenchState& state, const BenchFrame& frame,
                 const PanelContent& content);
  void add_histogram(const view::Viewport& area, float top_px, const TimeHistogram& times);

  view::OverlayText text_;
  view::Overlay overlay_;
  DisplaySettings display_;
  view::OverlayReflector reflector_;
};

/// What the operator does next, until the bench is ready: start the tracker, zero the stage, calibrate. Empty
/// then.
std::string next_step_text(const BenchFrame& frame, const PanelContent& content);

/// Largest area beside, above or below the eyes' windows that is large enough for a panel.
std::optional<view::Viewport> operator_area(const DisplaySettings& display);

/// "tracker 127.0.0.1:18944: up, 100 a second".
std::string device_text(const std::string& name, const DeviceReport& report);

/// "tibia hidden for 1.2 s"; empty if the input is live or not used.
std::string input_status_text(const std::string& name, const InputStatus& mark);

/// The same for the stage, also if it has no zero or has lost counts.
std::string stage_status_text(const BenchFrame& frame);

// Window or memory of the bench, and a check that the window has the calibrated position and size.

/// Window of the frame buffer's size, at the bench file's position or monitors if given; without vertical
/// synchronisation, because the loop paces the frames. Throws InputError without a display, or if a monitor
/// is missing or two monitors are not side by side.
show::Sink bench_window(const BenchFile& bench, const std::string& title, int samples);
/// The same without a window. `samples`: per pixel, 1, 2 or 4.
show::Sink bench_memory(const BenchFile& bench, int samples);

/// The position of the window by `display.at` or `display.outputs`; empty: placed by the desktop. Throws
/// InputError as bench_window().
std::optional<std::array<int, 2>> window_position(const BenchFile& bench,
                                                  std::span<const view::Monitor> monitors);

/// Differences of the window from the bench file, which invalidate the calibration, and parts of it that no
/// monitor displays; empty: none.
std::optional<InputError::Facts> window_mismatch(const BenchFile& bench,
                                                 const std::optional<view::WindowGeometry>& place,
                                                 std::span<const view::Monitor> monitors);

/// Checks the window periodically.
class WindowCheck {
 public:
  /// `bench` must outlive this object.
  explicit WindowCheck(const BenchFile& bench) : bench_(bench) {}

  /// Message for the panel; empty: the window is correct. Allocates only on a change.
  const std::string& error_message(const show::Sink& sink);
  /// The same for the log, returned once.
  std::string take_warning() { return std::exchange(warning_, {}); }

 private:
  const BenchFile& bench_;
  int n_calls_ = 0;
  bool was_warned_ = false;
  view::WindowGeometry place_;
  std::vector<view::Monitor> monitors_;
  std::string error_message_, warning_;
};

// Frames of the bench, pre-distorted for both eyes with text, drawn to a window or to files.

class BenchView {
 public:
  /// Throws InputError if the look or an eye of the calibration is not usable. `motion`, of `model`, must
  /// outlive this.
  BenchView(const store::MotionModel& model, const store::Motion& motion, const BenchFile& bench,
            const Calibration& calibration, const view::AppearanceOptions& look);

  /// Loads meshes, font and warp.
  void load_into(view::Renderer& renderer) const;

  /// Places joint and eyes as in `frame`. Does not allocate.
  void place(const BenchFrame& frame, const Calibration& calibration);

  /// Applies changed eyes, which must be usable. Returns true if the warp changed and must be loaded.
  bool take(const view::EyePair& eyes);
  const view::Warp& warp() const { return plan_.warp; }

  const view::Overlay& overlay(const BenchState& state, const BenchFrame& frame, const PanelContent& content)
  {
    return panel_.drawn(state, frame, content);
  }
  const view::Scene& scene() const { return scene_; }
  std::span<const view::Shot> shots() const { return shots_; }

 private:
  const store::Motion& motion_;
  std::string file_;  ///< for errors
  DisplaySettings display_;
  view::Scene scene_;
  std::vector<bool> shown_bodies_;   ///< of scene_, as the appearance has them
  std::vector<Material> materials_;  ///< of the bodies of a leg that is shown as it is
  view::LayerSet shown_layers_;
  std::optional<view::JointLayers> layers_;  ///< if any is shown
  view::EyePair eyes_;
  view::StereoPlan plan_;
  std::array<view::Shot, 2> shots_;
  BenchPanel panel_;
};

/// Requests of pressed keys to the loop.
struct BenchRequests {
  bool quit = false, zero_stage = false, write_calibration = false, take_screenshot = false;
};

/// Processes keys, then samples, in live rounds and replays. Eyes that become unusable are restored with a
/// message in the panel. Does not allocate without keys and messages.
BenchRequests apply_input(BenchState& state, PanelContent& panel, std::span<const view::KeyPress> keys,
                          std::span<const Sample> samples);

class BenchOutput {
 public:
  BenchOutput(const BenchOptions& options, const BenchSetup& setup);

  show::Sink& sink() { return sink_; }
  PanelContent& panel() { return panel_; }

  /// Draws frame `number` of the run at `at_s`, also to files if requested: pictures by number, the video by
  /// time, so that it takes as long as the run.
  void show(BenchState& state, const BenchFrame& frame, std::uint64_t number, double at_s);
  /// Saves the last frame to a new file in the current folder.
  void save_screenshot(BenchState& state, const BenchFrame& frame);
  /// Closes the video.
  void finish() { sink_.finish(); }
  /// Shows a message for some seconds.
  void show_message(const std::string& message, double now_s);
  /// Removes an expired message.
  void expire_message(double now_s);
  /// Warning, once, if the window does not match the bench file; else empty.
  std::string take_warning() { return watch_.take_warning(); }

 private:
  show::Frame drawn(BenchState& state, const BenchFrame& frame);
  std::int64_t due_video_frames(double at_s);

  const BenchOptions& options_;
  BenchView view_;
  show::Sink sink_;
  double video_per_s_;
  WindowCheck watch_;
  PanelContent panel_;
  view::DoubtReader doubts_;
  double message_until_s_ = 0.0;
  std::optional<double> video_start_s_;
  std::int64_t n_video_ = 0;  ///< frames of the video so far
};

}  // namespace vrda::bench
