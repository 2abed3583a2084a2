#include "ligament/geodesic.hpp"

#include <algorithm>
#include <cmath>

namespace vrda {
namespace {

constexpr int max_steps = 2000;

struct Pull {
  Eigen::Vector3d q;
  double width;
};

struct Ellipsoid {
  Eigen::Vector3d inverse_sq;  // 1 / a^2
  double inverse_volume_sq;    // 1 / (a b c)^2
  double invariant;            // Joachimsthal's: w times the square of q'

  double w(const Eigen::Vector3d& q) const
  {
    return inverse_sq.x() * q.x() * q.x() + inverse_sq.y() * q.y() * q.y() + inverse_sq.z() * q.z() * q.z();
  }

  // Second derivatives over the length.
  Pull pull(const Eigen::Vector3d& q, double width) const
  {
    const double w_now = w(q);
    const double inverse_w_sq = 1.0 / (w_now * w_now);
    return {(-invariant * inverse_w_sq) * inverse_sq.cwiseProduct(q),
            -inverse_volume_sq * inverse_w_sq * width};
  }
};

// One step of Nystroem's method of fifth order for y'' = f(y). Source: Hairer, Noersett, Wanner (1993),
// II.14.
GeodesicState step(const GeodesicState& s, double h, const Ellipsoid& surface)
{
  const auto place = [&](double c, const Eigen::Vector3d& bent) {
    return Eigen::Vector3d(s.q + (c * h) * s.q_slope + (h * h) * bent);
  };
  const auto width = [&](double c, double bent) { return s.width + c * h * s.width_slope + h * h * bent; };
  const Pull k1 = surface.pull(s.q, s.width);
  const Pull k2 = surface.pull(place(0.2, k1.q / 50.0), width(0.2, k1.width / 50.0));
  const Pull k3 = surface.pull(place(2.0 / 3.0, (7.0 * k2.q - k1.q) / 27.0),
                               width(2.0 / 3.0, (7.0 * k2.width - k1.width) / 27.0));
  const Pull k4 = surface.pull(place(1.0, (21.0 * k1.q - 4.0 * k2.q + 18.0 * k3.q) / 70.0),
                               width(1.0, (21.0 * k1.width - 4.0 * k2.width + 18.0 * k3.width) / 70.0));
  GeodesicState out;
  out.q = place(1.0, (14.0 * k1.q + 100.0 * k2.q + 54.0 * k3.q) / 336.0);
  out.q_slope = s.q_slope + h * ((14.0 * k1.q + 125.0 * k2.q + 162.0 * k3.q + 35.0 * k4.q) / 336.0);
  out.width = width(1.0, (14.0 * k1.width + 100.0 * k2.width + 54.0 * k3.width) / 336.0);
  out.width_slope =
      s.width_slope + h * ((14.0 * k1.width + 125.0 * k2.width + 162.0 * k3.width + 35.0 * k4.width) / 336.0);
  return out;
}

}  // namespace

GeodesicState advance(const GeodesicState& from, double length_mm, const Eigen::Vector3d& half_axes_mm,
                      double step_rad)
{
  Ellipsoid surface;
  surface.inverse_sq = half_axes_mm.cwiseProduct(half_axes_mm).cwiseInverse();
  surface.inverse_volume_sq = surface.inverse_sq.prod();
  surface.invariant = surface.w(from.q) * from.q_slope.squaredNorm();
  // The fastest angle by length is sqrt(C) / (smallest half-axis * w): steps are short where w is small.
  const double pace = step_rad / std::sqrt(surface.invariant * surface.inverse_sq.maxCoeff());
  GeodesicState state = from;
  double left_mm = length_mm;
  for (int i = 0; i < max_steps && left_mm != 0.0; ++i) {
    const double longest_mm = pace * surface.w(state.q);
    const bool is_last = std::abs(left_mm) <= longest_mm;
    const double h_mm = is_last ? left_mm : std::copysign(longest_mm, left_mm);
    state = step(state, h_mm, surface);
    left_mm = is_last ? 0.0 : left_mm - h_mm;
  }
  return state;
}

}  // namespace vrda
