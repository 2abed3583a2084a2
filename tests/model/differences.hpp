/// Derivatives by central differences, to hold analytical ones against.
#pragma once

#include "model/ligaments.hpp"

namespace vrda::test {

/// A pose with its attitude, moved along the five coordinates.
struct Place {
  Attitude attitude;
  MovingPose pose;

  Place moved(Eigen::Index coordinate, double by) const
  {
    Place out = *this;
    if (coordinate < about_y) out.pose.translation_mm[coordinate] += by;
    if (coordinate == about_y) out.pose.theta_rad += by;
    if (coordinate == about_varus) out.attitude.varus_rad += by;
    return out;
  }
};

/// Steps where truncation and rounding of doubles are in balance for lengths of tens of mm.
inline double difference_step(Eigen::Index coordinate)
{
  return coordinate < about_y ? 1e-4 : 2e-6;
}

inline Potential energy_at(const model::Ligaments& ligaments, const Place& place)
{
  return model::ligament_energy(ligaments, place.attitude, place.pose);
}

/// Gradient from energies, second derivatives from gradients.
inline Potential energy_by_differences(const model::Ligaments& ligaments, const Place& place)
{
  Potential out = energy_at(ligaments, place);
  for (Eigen::Index i = 0; i < n_coordinates; ++i) {
    const double h = difference_step(i);
    const Potential ahead = energy_at(ligaments, place.moved(i, h));
    const Potential behind = energy_at(ligaments, place.moved(i, -h));
    out.gradient[i] = (ahead.energy_nmm - behind.energy_nmm) / (2.0 * h);
    out.hessian.col(i) = (ahead.gradient - behind.gradient) / (2.0 * h);
  }
  return out;
}

}  // namespace vrda::test
