/// Converts the polygons of a file to a triangle mesh for the solver.
#pragma once

#include <array>
#include <vector>

#include "job/job.hpp"
#include "job/mesh_file.hpp"
#include "model/mesh.hpp"

namespace vrda::job {

struct CleanMesh {
  Mesh mesh;                      ///< axes and unit of the raw mesh; has normals, no unused vertices
  Eigen::Index n_welded = 0;      ///< vertices merged with an earlier one
  Eigen::Index n_degenerate = 0;  ///< faces and triangles removed: repeated corner or zero area
  std::vector<Eigen::Vector3d> degenerate_at;  ///< a corner of each such face, in the unit of the raw mesh
  std::vector<Eigen::Vector3d> fold_at, needle_at;  ///< those of all shells
  Eigen::Index n_identical = 0;  ///< triangles removed: the same three vertices as another, in either winding
  bool was_flipped = false;      ///< the winding of at least one shell was reversed
  bool has_sheet = false;        ///< at least one shell has no inside: its winding defines its outside
  std::vector<std::vector<Eigen::Index>> small_shells;  ///< lists of triangles
};

/// Welds vertices with exactly equal coordinates, triangulates, and removes degenerate faces, copies of
/// triangles and unused vertices. Of copies with opposite windings the one that agrees with its neighbours is
/// kept.
/// Orientation of each shell (triangles connected by edges): an outermost shell with an inside (Shell)
/// is oriented outward by its signed volume; one inside another is reversed together with its outermost
/// enclosing shell, so an inner wall of a hollow body remains an inner wall; a sheet follows `winding`.
/// Normals: those of the file, averaged over merged vertices and oriented outward, if none is zero; otherwise
/// computed. Vertices are numbered by first use along the final winding (on a left joint against it): a
/// mirrored file with the other side gives the mirrored mesh bit for bit, whether or not its winding is
/// reversed.
CleanMesh clean_mesh(const RawMesh& raw, Winding winding, Side side);

struct WeldedVertices {
  std::vector<std::int32_t> index_of_raw;  ///< [n raw] index of the merged vertex
  Points vertices;                         ///< in the order of first occurrence
  Points normal_sums;                      ///< empty if the file has no normals
};

/// Merges vertices with exactly equal coordinates: parsers repeat a shared vertex bit for bit, and a
/// tolerance would close intended gaps.
WeldedVertices weld_vertices(const RawMesh& raw);

/// The triangles without copies (the same three vertices), in order. Of copies with equal winding the first
/// is kept; of copies with opposite windings the first with the winding that agrees with the neighbours, or,
/// where there are copies only, with that of the first triangle.
std::vector<std::array<std::int32_t, 3>> without_copies(
    const std::vector<std::array<std::int32_t, 3>>& triangles);

/// Triangulates a polygon by ear clipping in the best-fit plane of the polygon (Newell's normal). Concave
/// polygons are covered exactly once; the winding is kept. `corners_mm` are the corners in order; the result
/// contains indices into it. If no ear is left (self-intersecting polygon), the rest becomes a fan. Zero area
/// gives no triangles. Cost: cubic at worst.
std::vector<std::array<std::int32_t, 3>> triangulate(const Points& corners_mm);

// Connected components of a mesh and their orientation.

/// A set of triangles connected by shared edges.
struct Shell {
  std::vector<Eigen::Index> triangles;  ///< ascending
  bool is_closed = true;                ///< every edge has two faces with consistent winding
  bool has_inside = true;      ///< closed, or closed but for some holes and odd faces; false: an open sheet
  double signed_volume = 0.0;  ///< cube of the mesh's unit; meaningful with an inside
  Box box;                     ///< in the mesh's unit
  std::vector<Eigen::Vector3d> fold_at;  ///< a corner of each edge at which the surface turns back on itself
  std::vector<Eigen::Vector3d> needle_at;  ///< a corner of each triangle of nearly no width
};

/// Shells, ordered by their first triangles.
std::vector<Shell> shells_of(const Mesh& mesh);

/// For each shell the outermost shell with an inside that encloses it; itself if none does. An enclosed shell
/// cannot be reached from outside, whatever its winding: an inner wall, or a void of a segmentation.
/// Only the 100 largest shells are considered as enclosing ones.
std::vector<std::size_t> outermost_shells(const Mesh& mesh, const std::vector<Shell>& shells);

/// Lists of triangles of the shells of at most a fifth of the largest one's size that are not enclosed.
std::vector<std::vector<Eigen::Index>> small_shells(const std::vector<Shell>& shells,
                                                    const std::vector<std::size_t>& outermost);

/// The mesh without enclosed shells and their vertices; unchanged without any. For what depends on the
/// outer shape alone: registration and thickness. Cost: a sort of the edges.
Mesh outer_surface(const Mesh& mesh);

/// The mesh with the listed triangles only, without unused vertices; the order of the others stays.
Mesh compacted(const Mesh& mesh, const std::vector<Eigen::Index>& kept);

/// The triangles of `mesh` that are in none of the `lists`.
std::vector<Eigen::Index> others_than(const Mesh& mesh, const std::vector<std::vector<Eigen::Index>>& lists);

}  // namespace vrda::job
