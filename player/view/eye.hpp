/// Viewports, warps, and the layouts of the frame buffer for both eyes.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "model/frames.hpp"

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

// One eye and its screen: optics, projection of points in space, and the mesh that pre-distorts its image.

/// Radial distortion: a pixel drawn at radius r from the centre is shown in the same direction at
/// r' = r (1 + k1 r^2 + k2 r^4); r in units of unit_px, with y scaled by the pixel aspect. Pincushion if k1 >
/// 0.
struct Distortion {
  double k1 = 0.0;
  double k2 = 0.0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< in the frame buffer
  double unit_px = 320.0;                               ///< half the window's width
  double pixel_aspect = 1.0;                            ///< pixel height / pixel width

  bool operator==(const Distortion&) const = default;
};

/// The position at which the optics show a pixel drawn at `drawn_px`.
Eigen::Vector2d shown_px(const Distortion& distortion, const Eigen::Vector2d& drawn_px);

/// The inverse: the position to draw so that the optics show it at `shown_px`, by Newton's method within the
/// fold radius; positions beyond the image of the fold are clamped to it.
Eigen::Vector2d drawn_px(const Distortion& distortion, const Eigen::Vector2d& shown_px);

/// Radius in pixel widths beyond which the distortion is no longer monotonic; infinite if it always is.
double fold_radius_px(const Distortion& distortion);

/// Camera model of one eye and its screen.
struct Eye {
  Viewport window;            ///< its share of the frame buffer
  Viewport visible;           ///< the part of the window displayed by its screen (thesis 8.1)
  double distance_px = 880;   ///< focal length: a width L at depth Z is distance_px * L / Z pixels wide
  double pixel_aspect = 1.0;  ///< pixel height / pixel width
  Eigen::Vector2d sight_px = Eigen::Vector2d::Zero();          ///< principal point
  Eigen::Vector3d position_head_mm = Eigen::Vector3d::Zero();  ///< X right, Y up, Z backwards
  Distortion distortion;

  bool operator==(const Eye&) const = default;
};

/// Vertical focal length, px.
double distance_y_px(const Eye& eye);

/// Both eyes; set_ipd() places them on the head's X axis at -ipd / 2 (left) and +ipd / 2 (right).
struct EyePair {
  Eye left, right;

  bool operator==(const EyePair&) const = default;
};
void set_ipd(EyePair& eyes, double ipd_mm);

/// A rectangle in the frame buffer with sub-pixel limits.
struct ShownBox {
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();   ///< left, top
  Eigen::Vector2d high_px = Eigen::Vector2d::Zero();  ///< right, bottom
};
ShownBox box_of(const Viewport& viewport);

/// Bounds of the undistorted image that the visible part shows.
ShownBox shown_box(const Eye& eye);

/// Undistorted projection of a point, head frame; it must be in front of the eye (z less than the eye's).
Eigen::Vector2d shown_px(const Eye& eye, const Eigen::Vector3d& p_head_mm);

/// Pre-distorted projection: the position to draw so that the optics show the point at shown_px().
Eigen::Vector2d drawn_px(const Eye& eye, const Eigen::Vector3d& p_head_mm);

/// Radius in pixel widths from the distortion centre to the furthest corner of `v`; comparable with
/// fold_radius_px().
double furthest_radius_px(const Distortion& distortion, const Viewport& v);

/// Largest side of the undistorted image: both eyes together reach the largest OpenGL size (16384).
inline constexpr double max_source_px = 8192.0;
/// Largest ratio of its side to that of the visible part; a larger one indicates wrong coefficients.
inline constexpr double max_source_scale = 4.0;

/// Describes why an eye is not usable, naming `file` and the eye: an empty visible part, a distortion that
/// folds or needs too large an image, or an invalid number. Empty if it is usable.
std::optional<InputError::Facts> usability_error(const Eye& eye, const std::string& file,
                                                 const std::string& name);
std::optional<InputError::Facts> usability_error(const EyePair& eyes, const std::string& file);
/// Throws InputError if an eye is not usable.
void require_usable(const EyePair& eyes, const std::string& file);

/// The mesh that covers the eye's visible part with the image of `box`. Its linear interpolation error at the
/// midpoints of all edges is at most `error_px`, except if the finest mesh (512 cells across) does not reach
/// it.
WarpMesh warp_mesh(const Eye& eye, const ShownBox& box, double error_px = 0.01);

}  // namespace vrda::view
