#include "bench/trackball.hpp"

#include "stereo/stereo_view.hpp"

namespace vrda::bench {

/// Where the pointer is in what the eye sees.
Eigen::Vector2d Trackball::picture_px(const optics::Viewport& window, const render::InputEvent& event) const
{
  return optics::reflected_px(display_.reflection, window,
                              {static_cast<float>(event.x_px), static_cast<float>(event.y_px)})
      .cast<double>();
}

std::optional<devices::Sample> Trackball::take(const render::InputEvent& event, const BenchState& state,
                                               const BenchFrame& frame, std::int64_t now_ns)
{
  const optics::EyePair& eyes = state.values().calibration.eyes;
  if (event.kind == render::InputKind::press && !grip_) {
    for (const bool is_right : {false, true}) {
      const optics::Eye& eye = optics::side_of(eyes, is_right);
      const optics::Viewport pixel{static_cast<int>(event.x_px), static_cast<int>(event.y_px), 1, 1};
      if (optics::within(pixel, eye.window).width == 0) continue;
      Grip& grip = grip_.emplace();
      grip.button = event.button;
      grip.window = eye.window;
      grip.X_leg_joint = state.X_leg_joint();
      grip.X_tracker_leg = frame.X_tracker_reference * grip.X_leg_joint.inverse();
      grip.drag.kind = navigation::drag_of(event.button, event.has_shift, event.has_control);
      grip.drag.press_px = picture_px(eye.window, event);
      grip.drag.at_press = {stereo::camera_of(eye, frame.X_tracker_eyes, optics::box_of(eye.window)),
                            frame.X_tracker_reference * centre_mm_};
    }
    return std::nullopt;
  }
  if (!grip_) return std::nullopt;
  const bool is_end = event.kind == render::InputKind::focus_lost ||
                      (event.kind == render::InputKind::release && event.button == grip_->button);
  if (is_end) grip_.reset();
  if (event.kind != render::InputKind::motion) return std::nullopt;
  // Moving the camera by its inverse motion moves the joint.
  const navigation::OrbitCamera moved =
      navigation::dragged(grip_->drag, picture_px(grip_->window, event), grip_->window);
  const Pose X_motion =
      grip_->drag.at_press.camera.X_world_camera * moved.camera.X_world_camera.inverse();
  devices::Sample sample;
  sample.kind = devices::SampleKind::offset;
  sample.arrival_ns = now_ns;
  sample.tool_pose = devices::place_of(grip_->X_tracker_leg.inverse() * X_motion * grip_->X_tracker_leg *
                                       grip_->X_leg_joint);
  return sample;
}

}  // namespace vrda::bench
