/// The views of both eyes in one image, and its warp.
#pragma once

#include <array>
#include <string>

#include "view/eye.hpp"
#include "view/renderer.hpp"

namespace vrda::view {

/// The camera whose image is `box`; the depth range must be set by with_depth_range().
Camera camera_of(const Eye& eye, const Pose& X_world_head, const ShownBox& box);

/// Renderer set-up for a display: the undistorted views of both eyes side by side in one image, and the warp
/// that maps it to the frame buffer.
struct StereoPlan {
  int width = 0, height = 0;  ///< of the image
  std::array<ShownBox, 2> boxes;
  std::array<Viewport, 2> viewports;  ///< in the image
  Warp warp;
};

/// Throws InputError naming `file` if an eye is not usable. The image has the pixel size of the frame buffer.
StereoPlan stereo_plan(const EyePair& eyes, int display_width, int display_height, const std::string& file,
                       const Reflection& reflection = {});

/// The shots of the left and right eye, with the depth range of `scene`. Allocates nothing.
std::array<Shot, 2> shots_of(const StereoPlan& plan, const EyePair& eyes, const Pose& X_world_head,
                             const Scene& scene);

}  // namespace vrda::view
