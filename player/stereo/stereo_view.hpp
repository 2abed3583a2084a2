/// The views of both eyes in one image, and its warp.
#pragma once

#include <array>
#include <string>

#include "optics/eye.hpp"
#include "render/renderer.hpp"

namespace vrda::stereo {

/// The camera whose image is `box`; the depth range must be set by with_depth_range().
scene::Camera camera_of(const optics::Eye& eye, const Pose& X_world_head, const optics::ShownBox& box);

/// Renderer set-up for a display: the undistorted views of both eyes side by side in one image, and the warp
/// that maps it to the frame buffer.
struct StereoPlan {
  int width = 0, height = 0;  ///< of the image
  std::array<optics::ShownBox, 2> boxes;
  std::array<optics::Viewport, 2> viewports;  ///< in the image
  optics::Warp warp;
};

/// Throws InputError naming `file` if an eye is not usable. The image has the pixel size of the frame buffer.
StereoPlan stereo_plan(const optics::EyePair& eyes, int display_width, int display_height,
                       const std::string& file, const optics::Reflection& reflection = {});

/// The shots of the left and right eye, with the depth range of `scene`. Allocates nothing.
std::array<render::Shot, 2> shots_of(const StereoPlan& plan, const optics::EyePair& eyes,
                                     const Pose& X_world_head, const scene::Scene& scene);

}  // namespace vrda::stereo
