/// The thesis's trackball on the bench (chapter 7): the pointer moves the drawn joint relative to the leg, with
/// the buttons of `show`. In: pointer events and the displayed frame. Out: the offset of the joint as a sample,
/// so that it is recorded with those of the devices. Lengths in mm, positions in px of the frame buffer.
#pragma once

#include <optional>

#include "bench/bench_state.hpp"
#include "view/orbit_camera.hpp"
#include "view/input.hpp"

namespace vrda::bench {

class Trackball {
 public:
  /// `centre_mm`: of the rotations, in the axes of the reference object.
  Trackball(const bench::DisplaySettings& display, const Eigen::Vector3d& centre_mm)
      : display_(display), centre_mm_(centre_mm)
  {
  }

  /// Processes an event over the picture of `frame`, the last one drawn; returns the new offset, if it
  /// changed, as a sample of kind `offset` that arrived at `now_ns`.
  std::optional<bench::Sample> take(const view::InputEvent& event, const BenchState& state,
                                      const BenchFrame& frame, std::int64_t now_ns);

 private:
  struct HeldDrag {
    view::Drag drag;
    view::MouseButton button = view::MouseButton::left;
    view::Viewport window;
    double pixel_aspect = 1.0;  ///< of the eye
    Pose X_tracker_leg = Pose::Identity();  ///< of the joint without offset, at the press
    Pose X_leg_joint = Pose::Identity();    ///< offset at the press
  };
  Eigen::Vector2d picture_px(const HeldDrag& held, const view::InputEvent& event) const;

  bench::DisplaySettings display_;
  Eigen::Vector3d centre_mm_;
  std::optional<HeldDrag> held_;
};

}  // namespace vrda::bench
