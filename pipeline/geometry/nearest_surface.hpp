/// The nearest point of a triangle mesh.
#pragma once

#include "model/mesh.hpp"
#include "geometry/box_tree.hpp"
#include "geometry/surface_points.hpp"

namespace vrda::geometry {

struct SurfacePoint {
  Eigen::Index triangle = -1;  ///< -1: none within the limits
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();
  double distance_mm = 0.0;
};

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

  /// Exact for the triangles that count.
  SurfacePoint nearest(const Eigen::Vector3d& p_mm, const NearestLimits& limits = {}) const;

 private:
  Mesh mesh_;
  Points normals_;
  geometry::BoxTree tree_;
  std::vector<NormalBounds> normal_bounds_;  // of the tree's nodes
};

}  // namespace vrda::geometry
