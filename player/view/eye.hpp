/// One eye and its screen: optics, projection of points in space, and the mesh that pre-distorts its image.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "model/frames.hpp"
#include "view/viewport.hpp"

namespace vrda::view {

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
