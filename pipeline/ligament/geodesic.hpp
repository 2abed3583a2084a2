/// Geodesics on an ellipsoid, by integration.
#pragma once

#include <Eigen/Core>

namespace vrda {

/// A point of a geodesic and of its neighbour. Places are scaled to the unit sphere: q = p / half-axes.
struct GeodesicState {
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
  Eigen::Vector3d q_slope = Eigen::Vector3d::Zero();  ///< over the length, 1/mm
  double width = 0.0;                                 ///< distance of a neighbouring geodesic
  double width_slope = 0.0;
};

/// `length_mm` further along the geodesic, backwards where negative. With q scaled, Joachimsthal's invariant
/// C makes it q'' = -C w^-2 q / a^2 where w = sum of q^2 / a^2; the neighbour follows Jacobi's equation.
/// `step_rad` is the largest angle of that problem a step; the method is of fifth order.
GeodesicState advance(const GeodesicState& from, double length_mm, const Eigen::Vector3d& half_axes_mm,
                      double step_rad);

}  // namespace vrda
