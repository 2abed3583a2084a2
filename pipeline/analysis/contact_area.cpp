// Contact area: the part of the moving surface within 1 mm of the reference.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "analysis/flexion_curves.hpp"
#include "core/parallel.hpp"
#include "geometry/nearest_surface.hpp"

namespace vrda::analysis {
namespace {

/// Share of a triangle in which a linear function with these values at its corners is below 0.
double share_below(std::array<double, 3> v)
{
  std::sort(v.begin(), v.end());
  if (v[2] <= 0.0) return 1.0;
  if (v[0] >= 0.0) return 0.0;
  // One corner is cut off along two edges.
  if (v[1] >= 0.0) return v[0] / (v[0] - v[1]) * (v[0] / (v[0] - v[2]));
  return 1.0 - v[2] / (v[2] - v[0]) * (v[2] / (v[2] - v[1]));
}

// Edge of the cubes whose triangles are left out together where they are far.
constexpr double patch_mm = 4.0;

/// The triangles of one compartment with what does not depend on the pose.
class Area {
 public:
  Area(const Mesh& moving, std::vector<std::int32_t> triangles)
      : moving_(moving),
        triangles_(std::move(triangles)),
        normals_(vertex_normals(moving)),
        offset_mm_(static_cast<std::size_t>(moving.vertices_mm.rows()))
  {
    std::map<std::array<int, 3>, std::size_t> patch_in;
    for (const std::int32_t t : triangles_) {
      const auto corner = corners(moving, t);
      const Eigen::Array3i cube = (corner[0] / patch_mm).array().floor().cast<int>();
      patch_of_.push_back(patch_in.try_emplace({cube[0], cube[1], cube[2]}, patch_in.size()).first->second);
      patches_.resize(patch_in.size());
      for (const Eigen::Vector3d& p_mm : corner) patches_[patch_of_.back()].extend(p_mm);
      area_mm2_.push_back(0.5 * (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm());
      for (const std::size_t k : {0u, 1u, 2u}) {
        longest_mm_ = std::max(longest_mm_, (corner[(k + 1) % 3] - corner[k]).norm());
        offset_mm_[vertex(t, k)] = offset_mm(moving, t);
      }
    }
  }

  double at(const geometry::NearestSurface& reference, const Pose& X_reference_moving) const
  {
    const double largest_mm = largest_offset_mm(reference.mesh());
    const auto excess_of = [&](std::size_t vertex, double beyond_mm) {
      return excess_mm(reference, largest_mm + beyond_mm, X_reference_moving, vertex);
    };
    const std::vector<bool> is_near = near_patches(reference, largest_mm, X_reference_moving);
    std::vector<std::optional<double>> excess(offset_mm_.size());  // of each vertex
    double area_mm2 = 0.0;
    for (std::size_t k = 0; k < triangles_.size(); ++k) {
      if (!is_near[patch_of_[k]]) continue;
      std::array<double, 3> of_corner{};
      for (const std::size_t corner : {0u, 1u, 2u}) {
        std::optional<double>& known = excess[vertex(triangles_[k], corner)];
        if (!known) known = excess_of(vertex(triangles_[k], corner), 0.0);
        of_corner[corner] = *known;
      }
      if (std::ranges::min(of_corner) >= 0.0) continue;
      // How far the other corners are matters only beside one that counts. Where nothing is near it is an
      // edge's length, more than such a triangle can have.
      for (const std::size_t corner : {0u, 1u, 2u}) {
        if (!std::isinf(of_corner[corner])) continue;
        const double further_mm = excess_of(vertex(triangles_[k], corner), longest_mm_);
        of_corner[corner] = std::isinf(further_mm) ? longest_mm_ : further_mm;
      }
      area_mm2 += share_below(of_corner) * area_mm2_[k];
    }
    return area_mm2;
  }

 private:
  std::size_t vertex(std::int32_t triangle, std::size_t corner) const
  {
    return static_cast<std::size_t>(moving_.triangles(triangle, static_cast<Eigen::Index>(corner)));
  }

  // Of each patch, whether a corner in it can count.
  std::vector<bool> near_patches(const geometry::NearestSurface& reference, double largest_mm,
                                 const Pose& X_reference_moving) const
  {
    constexpr double rounding_mm = 1e-6;
    const double counts_mm = contact_area_distance_mm + largest_offset_mm(moving_) + largest_mm + rounding_mm;
    std::vector<bool> is_near;
    for (const Eigen::AlignedBox3d& patch : patches_) {
      const double within_mm = counts_mm + 0.5 * patch.diagonal().norm();
      is_near.push_back(reference.nearest(X_reference_moving * patch.center(), {within_mm}).triangle >= 0);
    }
    return is_near;
  }

  // Distance between both surfaces, rounded by their offsets, less the distance that counts; infinite where
  // nothing is within it and `beyond_mm`.
  double excess_mm(const geometry::NearestSurface& reference, double beyond_mm,
                   const Pose& X_reference_moving, std::size_t vertex) const
  {
    const auto row = static_cast<Eigen::Index>(vertex);
    const Eigen::Vector3d p_mm = X_reference_moving * moving_.vertices_mm.row(row).transpose();
    const Eigen::Vector3d facing = -(X_reference_moving.linear() * normals_.row(row).transpose());
    const double counts_mm = contact_area_distance_mm + offset_mm_[vertex];
    const geometry::SurfacePoint nearest = reference.nearest(p_mm, {counts_mm + beyond_mm, 0.0, facing});
    if (nearest.triangle < 0) return std::numeric_limits<double>::infinity();
    return nearest.distance_mm - counts_mm - offset_mm(reference.mesh(), nearest.triangle);
  }

  const Mesh& moving_;
  std::vector<std::int32_t> triangles_;
  std::vector<std::size_t> patch_of_;  ///< of each of them
  std::vector<Eigen::AlignedBox3d> patches_;
  std::vector<double> area_mm2_;  ///< of each of them
  Points normals_;
  std::vector<double> offset_mm_;  ///< of each vertex, as of its triangles
  double longest_mm_ = 0.0;        ///< edge
};

/// Triangles of the moving contact mesh that are measured together.
struct Region {
  const char *name, *label;
  std::vector<std::int32_t> triangles;
};

std::vector<Region> regions_of(const store::MotionModel& model)
{
  if (model.has_compartments) {
    const auto of = [&](Compartment side) { return triangles_of(model.compartment_of_triangle, side); };
    return {{"contact_area_medial_mm2", "medial", of(Compartment::medial)},
            {"contact_area_lateral_mm2", "lateral", of(Compartment::lateral)}};
  }
  std::vector<std::int32_t> all(static_cast<std::size_t>(model.moving.contact.mesh.triangles.rows()));
  std::iota(all.begin(), all.end(), 0);
  return {{"contact_area_mm2", "whole surface", all}};
}

}  // namespace

std::vector<CurveGroup> contact_area(const store::MotionModel& model,
                                     const std::vector<store::JointPose>& poses, int n_threads)
{
  CurveGroup group{"Contact area",
                   "Area of the moving contact surface within 1 mm of the surface that faces it, mm².",
                   "mm²",
                   {}};
  const std::vector<Region> regions = regions_of(model);
  std::optional<geometry::NearestSurface> reference;
  std::vector<std::optional<Area>> areas(regions.size());
  for_each_index(1 + regions.size(), n_threads, [&] {
    return [&](std::size_t k) {
      if (k == 0) {
        reference.emplace(model.reference.contact.mesh);
      } else {
        areas[k - 1].emplace(model.moving.contact.mesh, regions[k - 1].triangles);
      }
    };
  });
  for (const Region& region : regions)
    group.curves.push_back({region.name, region.label, std::vector<double>(poses.size())});
  for_each_index(regions.size() * poses.size(), n_threads, [&] {
    return [&](std::size_t k) {
      const std::size_t region = k / poses.size(), pose = k % poses.size();
      group.curves[region].values[pose] = areas[region]->at(*reference, poses[pose].X_reference_moving);
    };
  });
  return {group};
}

}  // namespace vrda::analysis
