#include "view/screen_labels.hpp"

#include "core/error.hpp"

namespace vrda::view {

std::vector<ScreenLabel> screen_labels(const std::vector<store::JointLabel>& labels)
{
  std::vector<ScreenLabel> made;
  for (const store::JointLabel& label : labels) made.push_back({label.text});
  return made;
}

void place(std::vector<ScreenLabel>& shown, const std::vector<store::JointLabel>& labels,
           const view::JointFrames& frames, const view::Shot& shot)
{
  check(shown.size() == labels.size(), "there is a screen label for each label");
  const Eigen::Matrix4d X_clip_world =
      view::projection(shot.camera) * shot.camera.X_world_camera.inverse().matrix();
  const view::Viewport& view = shot.viewport;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const Eigen::Vector4d p_clip = X_clip_world * view::place_of(labels[i], frames).homogeneous();
    const Eigen::Vector2d device = p_clip.head<2>() / p_clip.w();
    shown[i].is_shown = p_clip.w() > 0.0 && device.cwiseAbs().maxCoeff() <= 1.0;
    shown[i].centre_px = {view.x + 0.5 * (1.0 + device.x()) * view.width,
                          view.y + 0.5 * (1.0 - device.y()) * view.height};
  }
}

}  // namespace vrda::view
