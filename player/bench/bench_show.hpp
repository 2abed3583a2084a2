/// Frames of the bench, pre-distorted for both eyes with text, drawn to a window or to files.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "bench/bench_panel.hpp"
#include "bench/bench_run.hpp"
#include "bench/bench_state.hpp"
#include "bench/window_check.hpp"
#include "navigation/appearance.hpp"
#include "render/renderer.hpp"
#include "scene/joint_layers.hpp"
#include "stereo/stereo_view.hpp"

namespace vrda::bench {

class BenchView {
 public:
  /// Throws InputError if the look or an eye of the calibration is not usable. `motion`, of `model`, must
  /// outlive this.
  BenchView(const store::MotionModel& model, const motion::Motion& motion,
            const bench_files::BenchFile& bench, const bench_files::Calibration& calibration,
            const navigation::AppearanceOptions& look);

  /// Loads meshes, font and warp.
  void load_into(render::Renderer& renderer) const;

  /// Places joint and eyes as in `frame`. Does not allocate.
  void place(const BenchFrame& frame, const bench_files::Calibration& calibration);

  /// Applies changed eyes, which must be usable. Returns true if the warp changed and must be loaded.
  bool take(const optics::EyePair& eyes);
  const optics::Warp& warp() const { return plan_.warp; }

  const render::Overlay& overlay(const BenchState& state, const BenchFrame& frame,
                                 const PanelContent& content)
  {
    return panel_.drawn(state, frame, content);
  }
  const scene::Scene& scene() const { return scene_; }
  std::span<const render::Shot> shots() const { return shots_; }

 private:
  const motion::Motion& motion_;
  std::string file_;  ///< for errors
  bench_files::DisplaySettings display_;
  scene::Scene scene_;
  std::vector<Material> materials_;  ///< of the bodies of a leg that is shown as it is
  scene::LayerSet shown_layers_;
  std::optional<scene::JointLayers> layers_;  ///< if any is shown
  optics::EyePair eyes_;
  stereo::StereoPlan plan_;
  std::array<render::Shot, 2> shots_;
  BenchPanel panel_;
};

/// Requests of pressed keys to the loop.
struct BenchRequests {
  bool quit = false, zero_stage = false, write_calibration = false, take_screenshot = false;
};

/// Processes keys, then samples, in live rounds and replays. Eyes that become unusable are restored with a
/// message in the panel. Does not allocate without keys and messages.
BenchRequests apply_input(BenchState& state, PanelContent& panel, std::span<const navigation::KeyPress> keys,
                          std::span<const devices::Sample> samples);

class BenchOutput {
 public:
  BenchOutput(const BenchOptions& options, const BenchSetup& setup);

  loop::Sink& sink() { return sink_; }
  PanelContent& panel() { return panel_; }

  /// Draws frame `number` of the run at `at_s`, also to files if requested: pictures by number, the video by
  /// time, so that it takes as long as the run.
  void show(BenchState& state, const BenchFrame& frame, std::uint64_t number, double at_s);
  /// Saves the last frame to a new file in the current folder.
  void save_screenshot(BenchState& state, const BenchFrame& frame);
  /// Closes the video.
  void finish();
  /// Shows a message for some seconds.
  void show_message(const std::string& message, double now_s);
  /// Removes an expired message.
  void expire_message(double now_s);
  /// Warning, once, if the window does not match the bench file; else empty.
  std::string take_warning() { return watch_.take_warning(); }

 private:
  loop::Frame drawn(BenchState& state, const BenchFrame& frame);
  std::int64_t due_video_frames(double at_s);

  const BenchOptions& options_;
  BenchView view_;
  loop::Sink sink_;
  double video_per_s_;
  WindowCheck watch_;
  PanelContent panel_;
  navigation::DoubtReader doubts_;
  double message_until_s_ = 0.0;
  std::optional<double> video_start_s_;
  std::int64_t n_video_ = 0;  ///< frames of the video so far
};

}  // namespace vrda::bench
