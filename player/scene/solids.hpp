/// Round solids of triangles: balls, rods, arrows and tubes, written into room made beforehand.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "core/draw_mesh.hpp"

namespace vrda {

/// Sizes of a solid: `n` of them fill n times as many vertices and indices.
struct SolidSize {
  std::size_t n_vertices = 0;
  std::size_t n_indices = 0;
};

SolidSize ball_size();
SolidSize rod_size();
SolidSize arrow_size();
SolidSize tube_size(std::size_t n_points);

/// Room for `n` solids, every index written: a solid's triangles never change, only its vertices. The
/// triangles of the first k solids are the first k n_indices.
void add_balls(DrawMesh& mesh, std::size_t n);
void add_rods(DrawMesh& mesh, std::size_t n);
void add_arrows(DrawMesh& mesh, std::size_t n);
void add_tube(DrawMesh& mesh, std::size_t n_points);

/// These write a solid's vertices, from `first_vertex` on, and allocate nothing. Lengths above 0, mm.
void set_ball(DrawMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& centre_mm, double radius_mm);
/// A cylinder from one end to the other.
void set_rod(DrawMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
             const Eigen::Vector3d& to_mm, double radius_mm);
/// `radius_mm` is that of the shaft; the head is three times as wide, and shorter where the arrow is short.
void set_arrow(DrawMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
               const Eigen::Vector3d& to_mm, double radius_mm);
/// Round a way of at least two points, closed at both ends. Points that coincide are passed over.
void set_tube(DrawMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              double radius_mm);

}  // namespace vrda
