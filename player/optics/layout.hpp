/// How the frame buffer is shared between the eyes.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "optics/viewport.hpp"

namespace vrda {

enum class Layout {
  quarters,      ///< the thesis's: left eye in the upper right quarter, right eye in the lower right one
  side_by_side,  ///< left eye in the left half
  top_bottom,    ///< left eye in the upper half
  two_outputs    ///< an output for each eye, side by side in one frame buffer, left eye first
};

/// As in the bench file, in the order of the enum.
const std::vector<std::string>& layout_names();
std::optional<Layout> layout_named(const std::string& name);

struct EyeWindows {
  Viewport left, right;
};

/// The windows of both eyes in a frame buffer of that size. Of `quarters` the width and height of a window
/// are at most 640 x 480, in the middle of its quarter. Throws InputError naming `file` when a window would
/// be empty.
EyeWindows eye_windows(Layout layout, int width, int height, const std::string& file);

/// The part of `inner` that lies within `outer`; empty (no width) where they do not meet.
Viewport within(const Viewport& inner, const Viewport& outer);

/// In pixels of the frame buffer: of a viewport an odd number of pixels wide, the middle of a pixel.
Eigen::Vector2d middle_px(const Viewport& v);

}  // namespace vrda
