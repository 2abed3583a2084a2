/// Viewports, warps, and the layouts of the frame buffer for both eyes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vrda::view {

/// A rectangle of an image, in pixels from its top left corner.
struct Viewport {
  int x = 0, y = 0, width = 0, height = 0;

  bool operator==(const Viewport&) const = default;
};

/// A mesh that warps an image, to compensate the distortion of optics.
struct WarpVertex {
  float x_px = 0.0F, y_px = 0.0F;  ///< position in the output, from its top left corner
  float u = 0.0F, v = 0.0F;        ///< position in the source image, from its top left corner, on [0, 1]
};
struct WarpMesh {
  std::vector<WarpVertex> vertices;
  std::vector<std::uint32_t> triangles;  ///< three vertex indices per triangle
};
struct Warp {
  int width = 0, height = 0;                ///< of the output; black outside the mesh
  int source_width = 0, source_height = 0;  ///< of the source image; 0: the renderer's size
  WarpMesh mesh;
};

/// Reflection of what is drawn in each eye's window, by a mirror or an inverted display in front of the eye.
struct Reflection {
  bool is_mirrored = false;  ///< left and right exchanged
  bool is_flipped = false;   ///< upside down

  bool operator==(const Reflection&) const = default;
};

/// A point of the window, reflected in its centre lines, px.
Eigen::Vector2f reflected_px(const Reflection& reflection, const Viewport& window, const Eigen::Vector2f& at);

/// Division of the frame buffer between the eyes.
enum class Layout {
  quarters,      ///< as in the thesis: left eye in the upper right quarter, right eye in the lower right one
  side_by_side,  ///< left eye in the left half
  top_bottom,    ///< left eye in the upper half
  two_outputs    ///< an output for each eye, side by side in one frame buffer, left eye first
};

/// The names in the bench file, in the order of the enum.
const std::vector<std::string>& layout_names();
std::optional<Layout> layout_named(const std::string& name);

struct EyeWindows {
  Viewport left, right;
};

/// Of a pair with members `left` and `right`.
template <typename Pair>
auto& side_of(Pair& pair, bool is_right)
{
  return is_right ? pair.right : pair.left;
}

/// The windows of both eyes in a frame buffer of that size. With `quarters` a window is at most 640 x 480,
/// centred in its quarter. Throws InputError naming `file` if a window would be empty.
EyeWindows eye_windows(Layout layout, int width, int height, const std::string& file);

/// The intersection; empty (zero width) if they do not overlap.
Viewport within(const Viewport& inner, const Viewport& outer);

/// The centre in pixels of the frame buffer; for an odd width the centre of a pixel.
Eigen::Vector2d middle_px(const Viewport& v);

}  // namespace vrda::view
