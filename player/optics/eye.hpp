/// One eye before its screen: where it is, what it is shown, and where points of space land.
#pragma once

#include <optional>
#include <string>

#include "core/error.hpp"
#include "core/frames.hpp"
#include "optics/distortion.hpp"
#include "optics/viewport.hpp"

namespace vrda {

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

}  // namespace vrda
