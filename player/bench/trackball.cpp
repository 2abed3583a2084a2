#include "bench/trackball.hpp"

#include <cmath>

#include "view/stereo_view.hpp"

namespace vrda::bench {

namespace {

/// The window in square pixels of its pixels' height.
view::Viewport square_window(const view::Viewport& window, double pixel_aspect)
{
  return {window.x, window.y, static_cast<int>(std::lround(window.width / pixel_aspect)), window.height};
}

}  // namespace

/// Where the pointer is in what the eye sees, in square pixels.
Eigen::Vector2d Trackball::picture_px(const HeldDrag& held, const view::InputEvent& event) const
{
  const Eigen::Vector2d at =
      view::reflected_px(display_.reflection, held.window,
                           {static_cast<float>(event.x_px), static_cast<float>(event.y_px)})
          .cast<double>();
  return {held.window.x + (at.x() - held.window.x) / held.pixel_aspect, at.y()};
}

std::optional<bench::Sample> Trackball::take(const view::InputEvent& event, const BenchState& state,
                                               const BenchFrame& frame, std::int64_t now_ns)
{
  const view::EyePair& eyes = state.values().calibration.eyes;
  if (event.kind == view::InputKind::press && !held_) {
    for (const bool is_right : {false, true}) {
      const view::Eye& eye = view::side_of(eyes, is_right);
      const view::Viewport pixel{static_cast<int>(event.x_px), static_cast<int>(event.y_px), 1, 1};
      if (view::within(pixel, eye.window).width == 0) continue;
      HeldDrag& held = held_.emplace(HeldDrag{});
      held.button = event.button;
      held.window = eye.window;
      held.pixel_aspect = eye.pixel_aspect;
      held.X_leg_joint = state.X_leg_joint();
      held.X_tracker_leg = frame.X_tracker_reference * held.X_leg_joint.inverse();
      held.drag.kind = view::drag_of(event.button, event.has_shift, event.has_control);
      held.drag.press_px = picture_px(held, event);
      held.drag.at_press = {view::camera_of(eye, frame.X_tracker_eyes, view::box_of(eye.window)),
                            frame.X_tracker_reference * centre_mm_};
    }
    return std::nullopt;
  }
  if (!held_) return std::nullopt;
  const bool is_end = event.kind == view::InputKind::focus_lost ||
                      (event.kind == view::InputKind::release && event.button == held_->button);
  if (is_end) held_.reset();
  if (event.kind != view::InputKind::motion) return std::nullopt;
  // Moving the camera by its inverse motion moves the joint.
  const view::OrbitCamera moved =
      view::dragged(held_->drag, picture_px(*held_, event), square_window(held_->window, held_->pixel_aspect));
  const Pose X_motion =
      held_->drag.at_press.camera.X_world_camera * moved.camera.X_world_camera.inverse();
  bench::Sample sample;
  sample.kind = bench::SampleKind::offset;
  sample.arrival_ns = now_ns;
  sample.tool_pose = bench::place_of(held_->X_tracker_leg.inverse() * X_motion * held_->X_tracker_leg *
                                       held_->X_leg_joint);
  return sample;
}

}  // namespace vrda::bench
