/// Blending of level-set fields (negative inside, about the signed distance in mm).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::geometry {

/// Union with a fillet: the smaller value where the two differ by more than `width_mm`, and at most
/// width_mm / 6 below it where they are equal. Twice continuously differentiable.
inline double smooth_min(double a, double b, double width_mm)
{
  const double h = std::max(width_mm - std::abs(a - b), 0.0) / width_mm;
  return std::min(a, b) - h * h * h * width_mm / 6.0;
}

/// Intersection with a rounded edge: -smooth_min(-a, -b).
inline double smooth_max(double a, double b, double width_mm)
{
  return -smooth_min(-a, -b, width_mm);
}

/// 0 below `from`, 1 above `to`, quintic between: twice continuously differentiable.
inline double smooth_step(double from, double to, double x)
{
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

/// Negative inside, positive outside, in mm; about the signed distance near the surface. |gradient| must be
/// below LevelSetOptions::max_gradient.
using Field = std::function<double(const Eigen::Vector3d&)>;

struct LevelSetOptions {
  double cell_mm = 2.0;       ///< edge of a sampling cell, about the mean edge of the triangles
  double max_gradient = 2.0;  ///< bound on |gradient|, used to skip empty space
  int n_relaxations = 12;     ///< smoothing passes along the surface
};

/// The zero surface of `field` inside `box_mm` by surface nets; vertices are projected onto the surface and
/// relaxed along it; normals from the gradient. The surface must be inside the box. Closed and manifold: the
/// cell is reduced by one percent until no edge is shared by more than two faces. Cost: field evaluations
/// near the surface only, about 25 per triangle.
Mesh level_set_mesh(const Field& field, const Box& box_mm, const LevelSetOptions& options);

struct LevelSet {
  Field field;
  Box box_mm;
};

struct AdjoiningMeshes {
  Mesh first, second;
};

/// level_set_mesh() of `first`, and the zero surface of `second`, which partly coincides with it: where both
/// fields are bitwise equal both meshes have the same triangles, so that no seam is visible. Closed and
/// manifold; if the cell of the first does not give a manifold second mesh, a smaller cell is used and the
/// triangles differ slightly.
AdjoiningMeshes adjoining_level_set_meshes(const LevelSet& first, const LevelSet& second,
                                           const LevelSetOptions& options);

// Closed meshes of flat-backed blocks and ellipsoids with analytically placed vertices.

/// `n_steps` equal steps from `from` to `to`, both ends included, appended to `lines` (a common end once).
void append_lines(std::vector<double>& lines, double from, double to, int n_steps);

/// A block over a rectangle of the plane y = 0: a shaped front, a flat back, vertical walls.
struct ShapedBlock {
  std::vector<double> x_mm;                          ///< grid lines, increasing
  std::vector<double> z_mm;                          ///< grid lines, increasing
  std::function<double(double, double)> front_y_mm;  ///< over (x, z)
  double back_y_mm = 0.0;                            ///< above the whole front, or below it
  double hole_half_mm = 0.0;  ///< cells wholly within this distance of both axes are omitted
};

/// Mesh of a block. Cells of the front are split along the diagonal that follows a crease through the cell,
/// so that pyramids over matching grid lines are exact. Normals from the faces.
Mesh block_mesh(const ShapedBlock& block);

/// A four-sided pyramid with its tip at the origin, its base's edge at y = `rim_y_mm`, vertical walls and a
/// flat back at `back_y_mm`, below the rim for a pyramid or above the tip for a cavity. One triangle a slope.
Mesh plain_pyramid_mesh(double half_base_mm, double rim_y_mm, double back_y_mm);

/// An ellipsoid about the origin: 20 n^2 triangles of a subdivided icosahedron with a corner at the top, all
/// vertices on the ellipsoid.
Mesh ellipsoid_mesh(const Eigen::Vector3d& half_axes_mm, int n_edges);

// Convex hull of two balls as a level-set field.

struct Ball {
  Eigen::Vector3d centre_mm;
  double radius_mm;
};

/// Neither ball may contain the other. The nearest ball's centre is offset from the foot of the perpendicular
/// by the perpendicular's length times the tangent of the hull's half angle.
class Hull {
 public:
  Hull(const Ball& a, const Ball& b)
      : start_(a),
        axis_(b.centre_mm - a.centre_mm),
        length_mm_(axis_.norm()),
        sine_narrowing_((a.radius_mm - b.radius_mm) / length_mm_),
        tangent_(sine_narrowing_ / std::sqrt(1.0 - sine_narrowing_ * sine_narrowing_))
  {
  }

  double signed_distance_mm(const Eigen::Vector3d& p) const
  {
    const Eigen::Vector3d from_start = p - start_.centre_mm;
    const double along_mm = from_start.dot(axis_) / length_mm_;
    const double across_sq_mm2 = std::max(0.0, from_start.squaredNorm() - along_mm * along_mm);
    const double nearest_mm = std::clamp(along_mm - std::sqrt(across_sq_mm2) * tangent_, 0.0, length_mm_);
    const Eigen::Vector3d centre = start_.centre_mm + nearest_mm / length_mm_ * axis_;
    return (p - centre).norm() - (start_.radius_mm - nearest_mm * sine_narrowing_);
  }

 private:
  Ball start_;
  Eigen::Vector3d axis_;
  double length_mm_, sine_narrowing_, tangent_;
};

}  // namespace vrda::geometry
