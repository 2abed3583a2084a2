#include "geometry/knee_surfaces.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/surface_points.hpp"

namespace vrda::geometry {
namespace {

// Second-largest extent of the vertices along their principal axes.
double second_extent(const Mesh& mesh)
{
  const Eigen::RowVector3d mean = mesh.vertices_mm.colwise().mean();
  const Points off = mesh.vertices_mm.rowwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(Eigen::Matrix3d(off.transpose() * off));
  const Points along = off * axes.eigenvectors();
  Eigen::Vector3d extent = along.colwise().maxCoeff() - along.colwise().minCoeff();
  std::sort(extent.begin(), extent.end());
  return extent[1];
}

struct NearPart {
  double nearest_sq_mm2 = std::numeric_limits<double>::infinity();
  Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
};

// The part of `points` that is nearest to `other`: within 6 mm of the smallest distance, or within 8 mm.
NearPart part_near(const SurfacePoints& points, const PointTree& other)
{
  std::vector<double> distance;
  for (const auto& p : points.positions_mm.rowwise())
    distance.push_back(std::sqrt(other.nearest(p, Eigen::Vector3d::Zero(), -1.1).distance_sq_mm2));
  const double least = *std::min_element(distance.begin(), distance.end());
  NearPart part{least * least};
  int n = 0;
  for (std::size_t i = 0; i < distance.size(); ++i) {
    if (distance[i] > std::max(least + 6.0, 8.0)) continue;
    part.mean_mm += points.positions_mm.row(static_cast<Eigen::Index>(i));
    ++n;
  }
  part.mean_mm /= n;
  return part;
}

Eigen::Vector3d mean_within(const SurfacePoints& points, const Eigen::Vector3d& centre_mm, double radius_mm)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int n = 0;
  for (const auto& p : points.positions_mm.rowwise()) {
    if ((p.transpose() - centre_mm).squaredNorm() > radius_mm * radius_mm) continue;
    sum += p;
    ++n;
  }
  return n == 0 ? centre_mm : Eigen::Vector3d(sum / n);
}

}  // namespace

void reverse_winding(Mesh& mesh)
{
  for (auto row : mesh.triangles.rowwise()) std::swap(row[1], row[2]);
  mesh.normals *= -1.0;
}

Mesh joined(const BoneSurfaces& surfaces)
{
  Mesh mesh = surfaces.bone;
  append(mesh, surfaces.cartilage);
  return mesh;
}

KneeSurfaces mirrored_z(const KneeSurfaces& knee)
{
  const auto mirrored = [](const BoneSurfaces& bone) {
    return BoneSurfaces{mirrored_z(bone.bone), mirrored_z(bone.cartilage)};
  };
  return {mirrored(knee.femur), mirrored(knee.tibia)};
}

double unit_mm_of(const Mesh& femur, const Mesh& tibia)
{
  constexpr double joint_mm = 75.0;
  const double width = std::sqrt(second_extent(femur) * second_extent(tibia));
  double best = 1.0, best_ratio = std::numeric_limits<double>::infinity();
  for (const double unit_mm : {1.0, 10.0, 1000.0}) {
    const double ratio = std::max(width * unit_mm / joint_mm, joint_mm / (width * unit_mm));
    if (ratio >= best_ratio) continue;
    best = unit_mm;
    best_ratio = ratio;
  }
  return best;
}

JointRegion joint_region(const Mesh& femur, const Mesh& tibia)
{
  constexpr int n_samples = 6000;     // 3 to 4 mm apart on a whole tibia
  constexpr double around_mm = 55.0;  // of the joint, where shafts weigh little
  const PointTree of_femur(sample_surface(femur, n_samples)), of_tibia(sample_surface(tibia, n_samples));
  const NearPart above = part_near(of_femur.points(), of_tibia);
  const NearPart below = part_near(of_tibia.points(), of_femur);
  JointRegion region;
  region.nearest_mm = std::sqrt(above.nearest_sq_mm2);
  region.centre_mm = 0.5 * (above.mean_mm + below.mean_mm);
  const Eigen::Vector3d up_mm = mean_within(of_femur.points(), region.centre_mm, around_mm) -
                                mean_within(of_tibia.points(), region.centre_mm, around_mm);
  if (up_mm.norm() > 0.0) region.up = up_mm.normalized();
  return region;
}

}  // namespace vrda::geometry
