/// One eye before its screen: its optics, what it is shown, where points of space land, and the mesh that
/// pre-distorts its picture.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "core/frames.hpp"
#include "optics/viewport.hpp"

namespace vrda {

/// A pixel drawn at radius r from the centre is shown, in the same direction, at r' = r (1 + k1 r^2 + k2
/// r^4); r in units of unit_px, heights measured in widths of a pixel. Pincushion where k1 > 0.
struct Distortion {
  double k1 = 0.0;
  double k2 = 0.0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< of the frame buffer
  double unit_px = 320.0;                               ///< half the window's width
  double pixel_aspect = 1.0;                            ///< height of a pixel by its width

  bool operator==(const Distortion&) const = default;
};

/// Where a pixel drawn at `drawn_px` is shown.
Eigen::Vector2d shown_px(const Distortion& distortion, const Eigen::Vector2d& drawn_px);

/// Where to draw what is to be shown at `shown_px`: the inverse, by Newton's method within the radius that
/// does not fold; of a place shown from nowhere the nearest that is.
Eigen::Vector2d drawn_px(const Distortion& distortion, const Eigen::Vector2d& shown_px);

/// Radius in px, widths of a pixel, beyond which pixels drawn further out are shown further in; infinite
/// where that never happens.
double fold_radius_px(const Distortion& distortion);

/// One eye before its screen: where it is, what it is shown, and where points of space land.
struct Eye {
  Viewport window;            ///< its share of the frame buffer
  Viewport visible;           ///< the part of it that its screen shows (thesis 8.1)
  double distance_px = 880;   ///< a width L at depth Z is distance_px * L / Z pixels wide
  double pixel_aspect = 1.0;  ///< height of a pixel by its width
  Eigen::Vector2d sight_px = Eigen::Vector2d::Zero();  ///< where the direction straight ahead is shown
  Eigen::Vector3d position_head_mm = Eigen::Vector3d::Zero();  ///< X right, Y up, Z backwards
  Distortion distortion;

  bool operator==(const Eye&) const = default;
};

/// distance_px of heights.
double distance_y_px(const Eye& eye);

/// Two eyes `ipd_mm` apart on the head's X axis: x = -ipd / 2 the left, +ipd / 2 the right.
struct EyePair {
  Eye left, right;

  bool operator==(const EyePair&) const = default;
};
void set_ipd(EyePair& eyes, double ipd_mm);

/// A part of the frame buffer in fractions of pixels.
struct ShownBox {
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();   ///< left, top
  Eigen::Vector2d high_px = Eigen::Vector2d::Zero();  ///< right, bottom
};
ShownBox box_of(const Viewport& viewport);

/// Everything of the undistorted picture that the visible part shows.
ShownBox shown_box(const Eye& eye);

/// Where a point of space is to be shown, in the head frame; it must lie in front of the eye (z below the
/// eye's).
Eigen::Vector2d shown_px(const Eye& eye, const Eigen::Vector3d& p_head_mm);

/// Where it must be drawn, so that the optics show it there.
Eigen::Vector2d drawn_px(const Eye& eye, const Eigen::Vector3d& p_head_mm);

/// Radius from the optics' centre to the furthest corner of `v`, as fold_radius_px() measures it.
double furthest_radius_px(const Distortion& distortion, const Viewport& v);

/// Full angles of the undistorted window, rad.
Eigen::Vector2d field_of_view_rad(const Eye& eye);

/// The picture that is drawn before distortion has so many pixels a side at most: both eyes' together are as
/// wide as OpenGL draws anywhere (16384).
inline constexpr double most_shown_px = 8192.0;
/// And so many times those of the visible part: beyond, the optics are a slip.
inline constexpr double most_shown_share = 4.0;

/// Why nothing can be drawn for an eye, naming `file` and the eye: the visible part is empty, the optics fold
/// within it or ask for too large a picture, or a number makes no sense. Nothing: it is usable.
std::optional<InputError::Facts> unusable(const Eye& eye, const std::string& file, const std::string& name);
std::optional<InputError::Facts> unusable(const EyePair& eyes, const std::string& file);
/// Throws InputError of that.
void require_usable(const EyePair& eyes, const std::string& file);

/// Covers the eye's visible part with the picture of `box`. Linear between its nodes it is off by at most
/// `error_px`, measured in the middles of all its triangles' edges, or by what the finest mesh (512 cells
/// across) leaves: of optics far stronger than a display's some hundredths of a pixel.
WarpMesh warp_mesh(const Eye& eye, const ShownBox& box, double error_px = 0.01);

/// Where the mesh shows, of the undistorted picture, at a place of the visible part: what linear drawing
/// does.
Eigen::Vector2d looked_up_px(const WarpMesh& mesh, const ShownBox& box, const Eigen::Vector2d& drawn_px);

}  // namespace vrda
