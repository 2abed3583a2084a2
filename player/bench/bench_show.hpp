/// Frames of the bench, pre-distorted for both eyes with text, drawn to a window or to files.
#pragma once

#include <array>
#include <string>

#include "bench/bench_panel.hpp"
#include "bench/bench_run.hpp"
#include "bench/bench_state.hpp"
#include "bench/screen_watch.hpp"
#include "render/renderer.hpp"
#include "stereo/stereo_view.hpp"
#include "view/look.hpp"

namespace vrda {

class BenchView {
 public:
  /// Throws InputError if the look or an eye of the calibration is not usable.
  BenchView(const MotionModel& model, const BenchFile& bench, const Calibration& calibration,
            const LookOptions& look);

  /// Loads meshes, font and warp.
  void load_into(Renderer& renderer) const;

  /// Places joint and eyes as in `frame`. Does not allocate.
  void place(const BenchFrame& frame, const Calibration& calibration);

  /// Applies changed eyes, which must be usable. Returns true if the warp changed and must be loaded.
  bool take(const EyePair& eyes);
  const Warp& warp() const { return plan_.warp; }

  const Overlay& words(const BenchState& state, const BenchFrame& frame, const PanelContent& content)
  {
    return panel_.drawn(state, frame, content);
  }
  const Scene& scene() const { return scene_; }
  std::span<const Shot> shots() const { return shots_; }

 private:
  std::string file_;  ///< for errors
  DisplaySettings display_;
  Scene scene_;
  EyePair eyes_;
  StereoPlan plan_;
  std::array<Shot, 2> shots_;
  BenchPanel panel_;
};

/// Requests of pressed keys to the loop.
struct BenchWishes {
  bool quits = false, zeroes_stage = false, writes_calibration = false, takes_picture = false;
};

/// Processes keys, then samples, in live rounds and replays. Eyes that become unusable are restored with a
/// message in the panel. Does not allocate without keys and messages.
BenchWishes take(BenchState& state, PanelContent& panel, std::span<const KeyPress> keys,
                 std::span<const Sample> samples);

class BenchShow {
 public:
  BenchShow(const BenchOptions& options, const BenchSetup& setup);

  Sink& sink() { return sink_; }
  PanelContent& panel() { return panel_; }

  /// Draws frame `number` of the run, also to files if requested.
  void show(BenchState& state, const BenchFrame& frame, std::uint64_t number);
  /// Saves the last frame to a new file in the current folder.
  void save(BenchState& state, const BenchFrame& frame);
  /// Closes the video.
  void finish();
  /// Shows a message for some seconds.
  void tell(const std::string& message, double now_s);
  /// Removes an expired message.
  void forget_message(double now_s);
  /// Warning, once, if the window does not match the bench file; else empty.
  std::string take_warning() { return watch_.take_warning(); }

 private:
  Frame drawn(BenchState& state, const BenchFrame& frame);

  const BenchOptions& options_;
  BenchView view_;
  Sink sink_;
  ScreenWatch watch_;
  PanelContent panel_;
  double message_until_s_ = 0.0;
};

}  // namespace vrda
