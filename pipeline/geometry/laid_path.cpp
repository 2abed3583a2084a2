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

// Beyond the margin around a body no distance is known, and a path is not close to it.
constexpr double margin_mm = 6.0;
constexpr double most_nodes = 2e7;  // of 4 bytes: a cube of half a metre of cells of 2 mm

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
  const auto n_cells = [&] { return ((box.sizes().array() + 2.0 * margin_mm) / cell_mm_).ceil().eval(); };
  while ((n_cells() + 1.0).prod() > most_nodes) cell_mm_ *= 2.0;
  n_ = n_cells().cast<int>() + 1;
  value_mm_.assign(static_cast<std::size_t>(n_.cast<std::int64_t>().prod()),
                   std::numeric_limits<float>::quiet_NaN());
}

float LazyDistance::node_mm(const Array3i& node) const
{
  const Vector3d p_mm = first_mm_ + cell_mm_ * node.cast<double>();
  double least_mm = std::numeric_limits<double>::infinity();
  for (const NearestSurface& surface : surfaces_)
    least_mm = std::min(least_mm, signed_distance_mm(surface, p_mm));
  return static_cast<float>(least_mm);
}

LazyDistance::Sample LazyDistance::sample(const Vector3d& p_mm)
{
  const Array3d at = (p_mm.array() - first_mm_) / cell_mm_;
  if (!((at >= 0.0).all() && (at < n_.cast<double>() - 1.0).all())) return {margin_mm, Vector3d::Zero()};
  const Array3i low = at.cast<int>();
  const auto stride_y = static_cast<std::size_t>(n_.x()),
             stride_z = stride_y * static_cast<std::size_t>(n_.y());
  const std::size_t row = static_cast<std::size_t>(low.z()) * stride_z +
                          static_cast<std::size_t>(low.y()) * stride_y + static_cast<std::size_t>(low.x());
  std::array<double, 8> v;
  for (int k = 0; k < 8; ++k) {
    const Array3i bit(k & 1, k >> 1 & 1, k >> 2);
    float& value_mm =
        value_mm_[row + static_cast<std::size_t>(bit.x()) + static_cast<std::size_t>(bit.y()) * stride_y +
                  static_cast<std::size_t>(bit.z()) * stride_z];
    if (std::isnan(value_mm)) value_mm = node_mm(low + bit);
    v[static_cast<std::size_t>(k)] = value_mm;
  }
  const Array3d t = at - low.cast<double>();
  const auto mixed = [](double a, double b, double part) { return a + part * (b - a); };
  const double y0z0 = mixed(v[0], v[1], t.x()), y1z0 = mixed(v[2], v[3], t.x()),
               y0z1 = mixed(v[4], v[5], t.x()), y1z1 = mixed(v[6], v[7], t.x());
  const double z0 = mixed(y0z0, y1z0, t.y()), z1 = mixed(y0z1, y1z1, t.y());
  const Vector3d by_cell(
      mixed(mixed(v[1] - v[0], v[3] - v[2], t.y()), mixed(v[5] - v[4], v[7] - v[6], t.y()), t.z()),
      mixed(y1z0 - y0z0, y1z1 - y0z1, t.z()), z1 - z0);
  return {mixed(z0, z1, t.z()), by_cell / cell_mm_};
}

namespace {

LazyDistance::Sample sample_of(const BesidePath& beside, const Vector3d& p_mm)
{
  LazyDistance::Sample sample = beside.body->sample(beside.X_path_body.linear().transpose() *
                                                    (p_mm - beside.X_path_body.translation()));
  sample.gradient = beside.X_path_body.linear() * sample.gradient;
  return sample;
}

// A path and the bodies that it comes close to.
class Laying {
 public:
  Laying(std::span<Vector3d> path_mm, std::span<const BesidePath> bodies, double clearance_mm)
      : path_mm_(path_mm), last_(path_mm.size() - 1), clearance_mm_(clearance_mm)
  {
    check(bodies.size() <= near_.size(), "a path is beside at most ten bodies");
    for (const BesidePath& body : bodies) {
      const bool is_near = std::any_of(path_mm_.begin(), path_mm_.end(), [&](const Vector3d& p_mm) {
        return sample_of(body, p_mm).distance_mm < margin_mm;
      });
      if (!is_near) continue;
      const LazyDistance::Sample first = sample_of(body, path_mm_.front()),
                                 last = sample_of(body, path_mm_.back());
      near_[n_near_++] = {&body, first.distance_mm, last.distance_mm};
      for (const LazyDistance::Sample& end : {first, last}) {
        if (end.distance_mm < margin_mm) outward_ += end.gradient;
      }
    }
    const Vector3d along = (path_mm_.back() - path_mm_.front()).normalized();
    outward_ -= along.dot(outward_) * along;
  }

  // Lifts a point deep inside to the side on which the ends are: its nearest surface may be another.
  bool lift_to_side(std::size_t i)
  {
    constexpr double surface_mm = 0.5, most_mm = 40.0, least_side = 0.5;
    const double side = outward_.norm();
    if (side < least_side) return false;
    bool is_lifted = false;
    double way_mm = 0.0;
    while (way_mm < most_mm) {
      double deepest_mm = 0.0;
      for (const Near& near : nears())
        deepest_mm = std::min(deepest_mm, sample_of(*near.body, path_mm_[i]).distance_mm);
      if (deepest_mm > -surface_mm) break;
      path_mm_[i] -= deepest_mm / side * outward_;
      way_mm -= deepest_mm;
      is_lifted = true;
    }
    return is_lifted;
  }

  bool lift(std::size_t i)
  {
    constexpr double least_slope = 0.1;  // beyond the grid, and on ridges deep inside, there is no direction
    bool is_lifted = false;
    for (const Near& near : nears()) {
      const LazyDistance::Sample sample = sample_of(*near.body, path_mm_[i]);
      if (sample.distance_mm >= clearance_mm_) continue;
      // An end inside a body is left at an angle of 45 degrees.
      const double wanted_mm =
          std::min({clearance_mm_, near.first_mm + (path_mm_[i] - path_mm_.front()).norm(),
                    near.last_mm + (path_mm_[i] - path_mm_.back()).norm()});
      const double missing_mm = wanted_mm - sample.distance_mm, slope = sample.gradient.norm();
      if (missing_mm <= 0.0 || slope < least_slope) continue;
      path_mm_[i] += missing_mm / slope * sample.gradient;
      is_lifted = true;
    }
    return is_lifted;
  }

  // One sweep of successive over-relaxation.
  void tighten(bool is_forwards)
  {
    constexpr double relaxation = 1.5;
    for (std::size_t k = 1; k < last_; ++k) {
      const std::size_t i = is_forwards ? k : last_ - k;
      path_mm_[i] += relaxation * (0.5 * (path_mm_[i - 1] + path_mm_[i + 1]) - path_mm_[i]);
      lift(i);
    }
  }

 private:
  struct Near {
    const BesidePath* body = nullptr;
    double first_mm = 0.0, last_mm = 0.0;  // distances of the path's ends
  };
  std::span<const Near> nears() const { return std::span(near_).first(n_near_); }

  std::span<Vector3d> path_mm_;
  std::size_t last_;
  double clearance_mm_;
  std::array<Near, 2 + model::most_followers> near_{};
  std::size_t n_near_ = 0;
  Vector3d outward_ = Vector3d::Zero();  // from the bodies at the ends, across the path
};

}  // namespace

bool lay_over(std::span<Vector3d> path_mm, std::span<const BesidePath> bodies, double clearance_mm)
{
  constexpr int n_sweeps = 30;
  if (path_mm.size() < 3) return false;
  Laying laying(path_mm, bodies, clearance_mm);
  bool is_moved = false;
  for (std::size_t i = 1; i + 1 < path_mm.size(); ++i) {
    is_moved = laying.lift_to_side(i) || is_moved;
    is_moved = laying.lift(i) || is_moved;
  }
  for (int sweep = 0; is_moved && sweep < n_sweeps; ++sweep) laying.tighten(sweep % 2 == 0);
  return is_moved;
}

}  // namespace vrda::geometry
