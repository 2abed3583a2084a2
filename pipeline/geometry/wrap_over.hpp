/// Ligament fibres beside a bone: how deep a path is inside it, and a wrap that keeps it outside.
#pragma once

#include <Eigen/Core>

#include <optional>
#include <span>
#include <vector>

#include "geometry/nearest_surface.hpp"
#include "model/ligaments.hpp"

namespace vrda::geometry {

/// The bone of a body: one surface a component, so that components may overlap; the cartilage of a body
/// without bone.
std::vector<NearestSurface> bone_of(const Body& body);

struct BonesOfJoint {
  std::vector<NearestSurface> reference, moving;
};

/// A point of a path inside a bone.
struct InnerPoint {
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d surface_mm = Eigen::Vector3d::Zero();  ///< nearest point of the surface
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();     ///< unit normal there
  double depth_mm = 0.0;                                 ///< between both; 0: the path is outside
};

/// The points of a polyline, one per mm, that are inside `bone`, in the bone's frame. What is within 3 mm of
/// the line's ends is left out: attachments may be below a surface. Behind the rim of an open sheet is
/// outside. Cost: a query of the nearest point per mm.
std::vector<InnerPoint> inner_points(const std::vector<NearestSurface>& bone,
                                     std::span<const Eigen::Vector3d> line_mm);

/// Where a fibre is deepest inside a bone.
struct FibreCrossing {
  BodyIndex body = BodyIndex::reference;
  double depth_mm = 0.0;  ///< 0: nowhere inside
  std::size_t pose = 0;
};

/// Over the poses of the moving bone; everything in the bodies' frames.
FibreCrossing deepest_crossing(const BonesOfJoint& bones, const model::Fibre& fibre,
                               const std::vector<model::Wrap>& wraps,
                               std::span<const Pose> X_reference_moving);

/// The cylinder, fixed to `body`, over which a fibre keeps outside both bones: across its mean direction and
/// the normal of the surfaces that it would cross, with the radius and the centre of the shortest paths that
/// clear them at all poses. Both attachments are outside it. The name is left to the caller. Empty where no
/// straight line is deeper than 0.5 mm, or no cylinder makes the deepest crossing smaller by 0.5 mm. Cost:
/// tenths of a second.
std::optional<model::Wrap> wrap_over(const BonesOfJoint& bones, BodyIndex body, const model::Fibre& fibre,
                                     std::span<const Pose> X_reference_moving);

}  // namespace vrda::geometry
