/// The pictures of a bench, pre-distorted for both eyes with words over them, one after the other, wherever
/// they go.
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
  /// Throws InputError where the look or an eye of the calibration cannot be drawn.
  BenchView(const MotionModel& model, const BenchFile& bench, const Calibration& calibration,
            const LookOptions& look);

  /// Meshes, font and warp.
  void load_into(Renderer& renderer) const;

  /// Puts joint and eyes where `frame` says. Allocates nothing.
  void place(const BenchFrame& frame, const Calibration& calibration);

  /// After a change of the eyes, which have to be usable: true when the warp was made anew and wants loading.
  bool take(const EyePair& eyes);
  const Warp& warp() const { return plan_.warp; }

  const Overlay& words(const BenchState& state, const BenchFrame& frame, const PanelContent& content)
  {
    return panel_.drawn(state, frame, content);
  }
  const Scene& scene() const { return scene_; }
  std::span<const Shot> shots() const { return shots_; }

 private:
  std::string file_;  ///< of errors
  DisplaySettings display_;
  Scene scene_;
  EyePair eyes_;
  StereoPlan plan_;
  std::array<Shot, 2> shots_;
  BenchPanel panel_;
};

/// What pressed keys ask of the loop.
struct BenchWishes {
  bool quits = false, zeroes_stage = false, writes_calibration = false, takes_picture = false;
};

/// Keys first, then samples: the same for a live round and its record. Eyes that cannot be drawn for are put
/// back to what they were before, and the panel tells it. Without keys and words allocates nothing.
BenchWishes take(BenchState& state, PanelContent& panel, std::span<const KeyPress> keys,
                 std::span<const Sample> samples);

class BenchShow {
 public:
  BenchShow(const BenchOptions& options, const BenchSetup& setup);

  Sink& sink() { return sink_; }
  PanelContent& panel() { return panel_; }

  /// Draws picture `number` of the run; to files too where they are wanted.
  void show(BenchState& state, const BenchFrame& frame, std::uint64_t number);
  /// The last picture again, into a new file of the current folder.
  void save(BenchState& state, const BenchFrame& frame);
  /// Ends the film.
  void finish();
  /// Shown for some seconds.
  void tell(const std::string& message, double now_s);
  void forget_message(double now_s);
  /// Of a window that is not as the bench file has it, told once; else empty.
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
