/// Points with normals on a surface, and the nearest of them.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "geometry/placement.hpp"
#include "model/mesh.hpp"

namespace vrda::geometry {

struct SurfacePoints {
  Points positions_mm;  ///< [n, 3]
  Points normals;       ///< [n, 3] unit, outward
};

/// `n` points, one in each of `n` equal shares of the area in the order of the triangles. No random source:
/// a moved or mirrored mesh gives the moved or mirrored points. Empty for a mesh without area.
SurfacePoints sample_surface(const Mesh& mesh, int n);

/// The triangles whose centres are within `radius_mm` of `centre_mm`.
Mesh cropped(const Mesh& mesh, const Eigen::Vector3d& centre_mm, double radius_mm);

/// Points reflected in Z = 0.
SurfacePoints mirrored_z(const SurfacePoints& points);

SurfacePoints joined(const SurfacePoints& a, const SurfacePoints& b);

/// A box around unit normals.
struct NormalBounds {
  Eigen::Array3d least = Eigen::Array3d::Constant(2.0);
  Eigen::Array3d most = Eigen::Array3d::Constant(-2.0);

  void add(const NormalBounds& other);
  /// False: no normal within has a component above `least_cosine` along `normal`.
  bool may_exceed(double least_cosine, const Eigen::Vector3d& normal) const;
};

/// Finds the nearest of a set of points by a k-d tree.
class PointTree {
 public:
  explicit PointTree(SurfacePoints points);

  const SurfacePoints& points() const { return points_; }

  struct Nearest {
    Eigen::Index row = -1;  ///< -1: none
    double distance_sq_mm2 = 0.0;
  };

  /// Nearest point whose normal has a component above `least_cosine` along `normal`; -1.1: any point. A row
  /// that is near as `start` makes it faster; -1: none.
  Nearest nearest(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& normal, double least_cosine,
                  Eigen::Index start = -1) const;

 private:
  struct Range {
    Eigen::Index begin, end;
    int axis;

    bool is_empty() const { return begin >= end; }
    Eigen::Index middle() const { return (begin + end) / 2; }
    Range below() const { return {begin, middle(), (axis + 1) % 3}; }
    Range above() const { return {middle() + 1, end, (axis + 1) % 3}; }
  };
  static constexpr Eigen::Index most_at_once = 8;  // ranges of so few are not divided
  // Of the positions and normals of a range.
  struct Bounds {
    Eigen::Array3d least_mm, most_mm;
    NormalBounds normals;

    double distance_sq_mm2(const Eigen::Vector3d& p_mm) const;
  };
  void arrange(std::vector<Eigen::Index>& order, Range range) const;
  void bound(Range range);

  SurfacePoints points_;        // in the order of the tree: the middle row of a range splits it
  std::vector<Bounds> bounds_;  // of the range with this middle
};

// The nearest point of a triangle mesh.

struct SurfacePoint {
  Eigen::Index triangle = -1;  ///< -1: none within the limits
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();
  double distance_mm = 0.0;
};

/// Of each vertex, whether the surface ends there.
std::vector<bool> rim_vertices(const Mesh& mesh);

/// Of a triangle with these corners. Source: Ericson (2005), Real-Time Collision Detection, 5.1.5.
Eigen::Vector3d nearest_in_triangle(const Eigen::Vector3d& p_mm,
                                    const std::array<Eigen::Vector3d, 3>& corner_mm);

/// Which points of a surface count.
struct NearestLimits {
  double max_distance_mm = 1e9;
  double least_cosine = -1.1;  ///< between the triangle's normal and `normal`; -1.1: any triangle
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// The mesh without the noise of a segmentation, of wavelengths below some 5 mm; the rims of sheets stay.
Mesh without_noise(Mesh mesh);

/// A mesh with a tree, and unit normals of its triangles averaged over their neighbours, which noise of a
/// segmentation tilts less.
class NearestSurface {
 public:
  explicit NearestSurface(Mesh mesh);

  const Mesh& mesh() const { return mesh_; }
  Eigen::Vector3d normal(Eigen::Index triangle) const { return normals_.row(triangle); }
  bool is_empty() const { return tree_.is_empty(); }
  /// Whether the triangle has a vertex at a border of the surface.
  bool is_at_rim(Eigen::Index triangle) const;
  /// Whether a point is behind the surface, whose nearest point is `on`. Behind a rim is outside.
  bool is_behind(const Eigen::Vector3d& p_mm, const SurfacePoint& on) const;

  /// Exact for the triangles that count.
  SurfacePoint nearest(const Eigen::Vector3d& p_mm, const NearestLimits& limits = {}) const;

 private:
  Mesh mesh_;
  Points normals_;
  std::vector<bool> is_rim_;  // of the vertices
  geometry::BoxTree tree_;
  std::vector<NormalBounds> normal_bounds_;  // of the tree's nodes
};

}  // namespace vrda::geometry
