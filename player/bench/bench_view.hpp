/// The bench's picture: the joint for both eyes, pre-distorted, and the words over it.
#pragma once

#include <array>
#include <string>

#include "bench/bench_panel.hpp"
#include "bench/bench_state.hpp"
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

}  // namespace vrda
