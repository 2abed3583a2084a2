/// Parts of pictures, and how the frame buffer is shared between the eyes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vrda {

/// Part of a picture, in pixels from its top left corner.
struct Viewport {
  int x = 0, y = 0, width = 0, height = 0;

  bool operator==(const Viewport&) const = default;
};

/// Triangles that carry the picture to other places: what takes the distortion of optics back.
struct WarpVertex {
  float x_px = 0.0F, y_px = 0.0F;  ///< where it is drawn, from the warped picture's top left corner
  float u = 0.0F, v = 0.0F;        ///< of the picture, from its top left corner, on [0, 1]
};
struct WarpMesh {
  std::vector<WarpVertex> vertices;
  std::vector<std::uint32_t> triangles;  ///< three indices of `vertices` each
};
struct Warp {
  int width = 0, height = 0;                  ///< of the warped picture; black where no triangle is
  int picture_width = 0, picture_height = 0;  ///< of the picture that is warped; 0: the renderer's
  WarpMesh mesh;
};

/// How the frame buffer is shared between the eyes.
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
