/// Both eyes' views of one scene as one picture and its warp.
#pragma once

#include <array>
#include <string>

#include "optics/eye.hpp"
#include "render/renderer.hpp"

namespace vrda {

/// The camera whose picture is `box`; depth range still to be set.
Camera camera_of(const Eye& eye, const Pose& X_world_head, const ShownBox& box);

/// How the renderer is set up for a display, once: a picture that holds what both eyes are shown before
/// distortion, side by side, and the warp that puts it onto the frame buffer.
struct StereoPlan {
  int width = 0, height = 0;  ///< of the picture
  std::array<ShownBox, 2> boxes;
  std::array<Viewport, 2> viewports;  ///< of the picture
  Warp warp;
};

/// Throws InputError naming `file` where an eye is not usable. Pixels of the picture are as large as the
/// frame buffer's.
StereoPlan stereo_plan(const EyePair& eyes, int display_width, int display_height, const std::string& file);

/// The shots of the left and right eye, with depth ranges around `scene`. Allocates nothing.
std::array<Shot, 2> shots_of(const StereoPlan& plan, const EyePair& eyes, const Pose& X_world_head,
                             const Scene& scene);

}  // namespace vrda
