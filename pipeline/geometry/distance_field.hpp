/// Smoothed signed distance to a surface on a regular grid: twice continuously differentiable, with
/// derivatives in closed form.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::geometry {

class DistanceField {
 public:
  /// Distances are clipped to +-band_mm.
  static constexpr double band_mm = 10.0;

  /// Of the outer surface of a mesh of one or several components (`component`: of each triangle, or empty):
  /// where solids touch or overlap, as cartilage on bone, the triangles between them do not count. Negative
  /// inside; beyond the rim of an open sheet positive. Mesh::offset_mm is subtracted. Cost: a second for a
  /// femur.
  explicit DistanceField(const Mesh& mesh, const std::vector<std::int32_t>& component = {});

  struct Sample {
    double distance_mm = band_mm;
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix3d hessian_per_mm = Eigen::Matrix3d::Zero();
  };
  /// Exact for planes and, to second order in the width of the filter over the radius of curvature, for
  /// curved surfaces. Derivatives are left out where the distance is not below `least_mm`. Cost: 0.2
  /// microseconds.
  Sample sample(const Eigen::Vector3d& p_mm, double least_mm = band_mm) const;

  /// A lower bound of the distance at most 2.5 mm below it, from the nearest node.
  double bound_mm(const Eigen::Vector3d& p_mm) const;

 private:
  std::size_t row_of(std::int64_t i, std::int64_t j, std::int64_t k) const
  {
    return static_cast<std::size_t>((k * n_[1] + j) * n_[0] + i);
  }
  void set_grid(const Box& surface_mm);
  void add_surface(const Mesh& surface, const std::vector<bool>& rim, double offset_mm);
  void smooth();

  std::array<std::int64_t, 3> first_{}, n_{};  // nodes at whole multiples of the cell
  std::vector<double> value_;                  // [n_[2], n_[1], n_[0]] distances, then spline coefficients
};

/// The binomial filter (1/4, 1/2, 1/4), `n_passes` times along `axis` of an array [n[2], n[1], n[0]]; ends
/// are repeated. Its variance is half a cell squared a pass; sums of few terms, equal on every processor.
void filter_binomially(std::vector<double>& values, const std::array<std::int64_t, 3>& n, int axis,
                       int n_passes);

/// The filter as it is used to smooth surfaces: a standard deviation of 1.6 cells of 1 mm.
inline constexpr int surface_passes = 5;

/// The triangles of the outer surface (DistanceField).
std::vector<Eigen::Index> outer_triangles(const Mesh& mesh, const std::vector<std::int32_t>& component);

}  // namespace vrda::geometry
