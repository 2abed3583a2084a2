/// Meshes of balls, rods, arrows and tubes, written to preallocated vertices.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "model/render_mesh.hpp"

namespace vrda::view {

/// Numbers of vertices and indices of one solid.
struct SolidSize {
  std::size_t n_vertices = 0;
  std::size_t n_indices = 0;
};

SolidSize ball_size();
SolidSize arrow_size();
SolidSize tube_size(std::size_t n_points);

/// Append `n` solids with all indices; only the vertices change afterwards. The triangles of the first k
/// solids are the first k * n_indices indices.
void add_balls(RenderMesh& mesh, std::size_t n);
void add_rods(RenderMesh& mesh, std::size_t n);
void add_arrows(RenderMesh& mesh, std::size_t n);
void add_tube(RenderMesh& mesh, std::size_t n_points);

/// Write the vertices of a solid from `first_vertex` on; allocate nothing. Lengths must be positive, mm.
void set_ball(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& centre_mm, double radius_mm);
/// A cylinder with flat ends.
void set_rod(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
             const Eigen::Vector3d& to_mm, double radius_mm);
/// `radius_mm` is the shaft radius; the head has three times the radius. Both are reduced for short arrows.
void set_arrow(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
               const Eigen::Vector3d& to_mm, double radius_mm);
/// A tube along at least two points, closed at both ends. Coincident points are allowed.
void set_tube(RenderMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              double radius_mm);

/// The elliptic cross section of a band.
struct BandSection {
  double half_width_mm = 1.0, half_thickness_mm = 1.0;
  /// Directions of the width at both ends, of any length; between the ends they are interpolated. Zero or
  /// along the band: any direction.
  Eigen::Vector3d across_first{0, 0, 0}, across_last{0, 0, 0};
};
/// A tube with an elliptic cross section, in the vertices of a tube.
void set_band(RenderMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              const BandSection& section);

}  // namespace vrda::view
