#include "geometry/laid_path.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "model/ligaments.hpp"

namespace vrda::geometry {
namespace {

using Eigen::Array3d;
using Eigen::Array3i;
using Eigen::Vector3d;

constexpr double cell_mm = 2.0, margin_mm = 6.0;
double signed_distance_mm(const NearestSurface& surface, const Vector3d& p_mm)
{
  const SurfacePoint on = surface.nearest(p_mm);
  return surface.is_behind(p_mm, on) ? -on.distance_mm : on.distance_mm;
}

}  // namespace

LazyDistance::LazyDistance(const Body& body)
{
  Eigen::AlignedBox3d box;
  for (const Part* part : {&body.contact, &body.visual}) {
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, *part);
    for (const std::vector<Eigen::Index>& own : rows) {
      if (own.empty()) continue;
      surfaces_.emplace_back(select_triangles(part->mesh, own));
      for (const auto& row : surfaces_.back().mesh().vertices_mm.rowwise()) box.extend(row.transpose());
    }
  }
  if (surfaces_.empty()) return;
  first_mm_ = box.min().array() - margin_mm;
  n_ = ((box.sizes().array() + 2.0 * margin_mm) / cell_mm).ceil().cast<int>() + 1;
  value_mm_.assign(static_cast<std::size_t>(n_.cast<std::int64_t>().prod()),
                   std::numeric_limits<float>::quiet_NaN());
}

double LazyDistance::node_mm(std::size_t row, const Array3i& node)
{
  float& value_mm = value_mm_[row];
  if (std::isnan(value_mm)) {
    const Vector3d p_mm = first_mm_ + cell_mm * node.cast<double>();
    double least_mm = std::numeric_limits<double>::infinity();
    for (const NearestSurface& surface : surfaces_)
      least_mm = std::min(least_mm, signed_distance_mm(surface, p_mm));
    value_mm = static_cast<float>(least_mm);
  }
  return value_mm;
}

LazyDistance::Sample LazyDistance::sample(const Vector3d& p_mm)
{
  const Array3d at = (p_mm.array() - first_mm_) / cell_mm;
  const Array3i low = at.floor().cast<int>();
  if ((low < 0).any() || (low + 1 >= n_).any()) return {margin_mm, Vector3d::Zero()};
  const Array3d t = at - low.cast<double>();
  Sample sample;
  for (int k = 0; k < 8; ++k) {
    const Array3i bit(k & 1, k >> 1 & 1, k >> 2 & 1);
    const Array3i node = low + bit;
    const std::size_t row = (static_cast<std::size_t>(node.z()) * static_cast<std::size_t>(n_.y()) +
                             static_cast<std::size_t>(node.y())) *
                                static_cast<std::size_t>(n_.x()) +
                            static_cast<std::size_t>(node.x());
    const Array3d high = bit.cast<double>(), weight = high * t + (1.0 - high) * (1.0 - t),
                  sign = 2.0 * high - 1.0;
    const double value_mm = node_mm(row, node);
    sample.distance_mm += weight.prod() * value_mm;
    sample.gradient += value_mm / cell_mm *
                       Vector3d(sign.x() * weight.y() * weight.z(), sign.y() * weight.x() * weight.z(),
                                sign.z() * weight.x() * weight.y());
  }
  return sample;
}

namespace {

LazyDistance::Sample sample_of(const BesidePath& beside, const Vector3d& p_mm)
{
  LazyDistance::Sample sample = beside.body->sample(beside.X_path_body.linear().transpose() *
                                                    (p_mm - beside.X_path_body.translation()));
  sample.gradient = beside.X_path_body.linear() * sample.gradient;
  return sample;
}

}  // namespace

bool lay_over(std::span<Vector3d> path_mm, std::span<const BesidePath> bodies, double clearance_mm)
{
  constexpr int n_sweeps = 30;
  constexpr double relaxation = 1.5;   // of the successive over-relaxation
  constexpr double least_slope = 0.1;  // beyond the grid, and on ridges deep inside, there is no direction
  constexpr double near_mm = 6.0, surface_mm = 0.5, most_lift_mm = 40.0;
  if (path_mm.size() < 3) return false;
  const std::size_t last = path_mm.size() - 1;
  std::array<std::array<double, 2>, 2 + model::most_followers> end_mm{};
  check(bodies.size() <= end_mm.size(), "a path is beside at most ten bodies");
  for (std::size_t b = 0; b < bodies.size(); ++b)
    end_mm[b] = {sample_of(bodies[b], path_mm.front()).distance_mm,
                 sample_of(bodies[b], path_mm.back()).distance_mm};
  // An end inside a body is left at an angle of 45 degrees.
  const auto lift = [&](std::size_t i) {
    bool is_lifted = false;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const LazyDistance::Sample sample = sample_of(bodies[b], path_mm[i]);
      const double wanted_mm = std::min({clearance_mm, end_mm[b][0] + (path_mm[i] - path_mm.front()).norm(),
                                         end_mm[b][1] + (path_mm[i] - path_mm.back()).norm()});
      const double missing_mm = wanted_mm - sample.distance_mm, slope = sample.gradient.norm();
      if (missing_mm <= 0.0 || slope < least_slope) continue;
      path_mm[i] += missing_mm / slope * sample.gradient;
      is_lifted = true;
    }
    return is_lifted;
  };
  // A point deep inside is lifted to the side on which the ends are: its nearest surface may be another.
  Vector3d outward = Vector3d::Zero();
  for (const BesidePath& beside : bodies) {
    for (const Vector3d& end_point_mm : {path_mm.front(), path_mm.back()}) {
      const LazyDistance::Sample sample = sample_of(beside, end_point_mm);
      if (sample.distance_mm < near_mm) outward += sample.gradient;
    }
  }
  const Vector3d along = (path_mm.back() - path_mm.front()).normalized();
  outward -= along.dot(outward) * along;
  const bool has_side = outward.norm() > 0.5;
  outward.normalize();
  bool is_moved = false;
  for (std::size_t i = 1; i < last; ++i) {
    double deepest_mm = 0.0;
    for (double way_mm = 0.0; way_mm < most_lift_mm && has_side; way_mm -= deepest_mm) {
      deepest_mm = 0.0;
      for (const BesidePath& beside : bodies)
        deepest_mm = std::min(deepest_mm, sample_of(beside, path_mm[i]).distance_mm);
      if (deepest_mm > -surface_mm) break;
      path_mm[i] -= deepest_mm * outward;
      is_moved = true;
    }
    is_moved = lift(i) || is_moved;
  }
  for (int sweep = 0; is_moved && sweep < n_sweeps; ++sweep) {
    for (std::size_t k = 1; k < last; ++k) {
      const std::size_t i = sweep % 2 == 0 ? k : last - k;
      path_mm[i] += relaxation * (0.5 * (path_mm[i - 1] + path_mm[i + 1]) - path_mm[i]);
      lift(i);
    }
  }
  return is_moved;
}

}  // namespace vrda::geometry
