/// Radial distortion of the optics between a screen and an eye (thesis 8.2).
#pragma once

#include <Eigen/Core>

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

}  // namespace vrda
