#include "prepare/transferred_ligaments.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/units.hpp"

namespace vrda::prepare {
namespace {

using geometry::NearestSurface;
using geometry::SurfacePoint;

constexpr double farthest_mm = 10.0, farthest_fibula_mm = 25.0;

// The map of one bone into its anatomical frame, with the surfaces on both sides of it.
struct BoneMap {
  Eigen::Vector3d scale;
  Eigen::Vector3d origin_mm;
  NearestSurface of_template;
  NearestSurface of_subject;
  double max_distance_mm = farthest_mm;

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_template_mm) const
  {
    return scale.cwiseProduct(p_template_mm - origin_mm);
  }
};

struct Attached {
  Eigen::Vector3d p_mm;
  double moved_mm = nan;
};

// The point at `distance_mm` from the surface, on the way to `p_mm` if that is on the same side of it.
Eigen::Vector3d at_distance(const SurfacePoint& on, const Eigen::Vector3d& normal,
                            const Eigen::Vector3d& p_mm, double signed_distance_mm)
{
  const Eigen::Vector3d off_mm = p_mm - on.p_mm;
  const bool is_same_side = off_mm.dot(normal) * signed_distance_mm > 0.0;
  constexpr double shortest_mm = 1e-6;
  if (is_same_side && off_mm.norm() > shortest_mm)
    return on.p_mm + std::abs(signed_distance_mm) * off_mm.normalized();
  return on.p_mm + signed_distance_mm * normal;
}

// `known_mm`: its position on the subject, instead of the fitted one.
Attached attached(const Eigen::Vector3d& p_template_mm, const BoneMap& map,
                  const std::optional<Eigen::Vector3d>& known_mm)
{
  constexpr double on_bone_mm = 2.0;
  const Eigen::Vector3d transferred_mm = known_mm.value_or(map(p_template_mm));
  if (map.of_subject.is_empty()) return {transferred_mm};
  if (known_mm && map.of_subject.nearest(transferred_mm, {on_bone_mm}).triangle >= 0) return {transferred_mm};
  geometry::NearestLimits limits;
  limits.max_distance_mm = map.max_distance_mm;
  double own_mm = 0.0;
  if (!map.of_template.is_empty()) {
    const SurfacePoint own = map.of_template.nearest(p_template_mm);
    const Eigen::Vector3d normal = map.of_template.normal(own.triangle);
    own_mm = own.distance_mm * ((p_template_mm - own.p_mm).dot(normal) < 0.0 ? -1.0 : 1.0);
    limits.normal = normal.cwiseQuotient(map.scale).normalized();
    limits.least_cosine = 0.2;
    limits.max_distance_mm += own.distance_mm;
  }
  const SurfacePoint nearest = map.of_subject.nearest(transferred_mm, limits);
  if (nearest.triangle < 0) return {transferred_mm};
  const Eigen::Vector3d p_mm =
      at_distance(nearest, map.of_subject.normal(nearest.triangle), transferred_mm, own_mm);
  return {p_mm, (p_mm - transferred_mm).norm()};
}

model::Wrap transferred(const model::Wrap& wrap, const BoneMap& map)
{
  constexpr double largest_ratio = 4.9;  // load refuses above 5
  model::Wrap placed = wrap;
  placed.X_body_wrap.translation() = map(wrap.X_body_wrap.translation());
  for (Eigen::Index k = 0; k < 3; ++k)
    placed.radii_mm[k] *= map.scale.cwiseProduct(wrap.X_body_wrap.linear().col(k)).norm();
  if (wrap.shape == model::WrapShape::cylinder) {
    placed.radii_mm.head<2>().setConstant(placed.radii_mm.head<2>().mean());
  } else {
    placed.radii_mm = placed.radii_mm.cwiseMax(placed.radii_mm.maxCoeff() / largest_ratio);
  }
  return placed;
}

bool is_fibular(const model::Fibre& fibre)
{
  return fibre.bundle.starts_with("LCL") || fibre.bundle.starts_with("PFL");
}

}  // namespace

TransferredLigaments transferred_ligaments(const TemplateJoint& own_side, const geometry::KneeFit& fit,
                                           const SubjectBones& subject)
{
  const geometry::KneeSurfaces& known = own_side.knee.surfaces;
  const Eigen::Vector3d& origin_mm = own_side.knee.origin_mm;
  const BoneMap femur{fit.femur.scale, origin_mm, NearestSurface(known.femur.bone),
                      NearestSurface(subject.surfaces.femur.bone)};
  const BoneMap tibia{fit.tibia.scale, origin_mm, NearestSurface(known.tibia.bone),
                      NearestSurface(subject.surfaces.tibia.bone)};
  const BoneMap fibula{fit.tibia.scale, origin_mm, NearestSurface(own_side.fibula),
                       NearestSurface(subject.fibula), farthest_fibula_mm};
  TransferredLigaments result;
  result.ligaments = own_side.joint.ligaments;
  for (model::Fibre& fibre : result.ligaments.fibres) {
    const auto given = std::find_if(subject.known_ends.begin(), subject.known_ends.end(),
                                    [&](const FibreEnds& other) { return other.name == fibre.name; });
    const FibreEnds ends = given == subject.known_ends.end() ? FibreEnds{} : *given;
    const Attached above = attached(fibre.reference_mm, femur, ends.femur);
    const Attached below = attached(fibre.moving_mm, is_fibular(fibre) ? fibula : tibia, ends.tibia);
    fibre.reference_mm = above.p_mm;
    fibre.moving_mm = below.p_mm;
    result.moves.push_back({above.moved_mm, below.moved_mm});
  }
  for (model::Wrap& wrap : result.ligaments.wraps)
    wrap = transferred(wrap, wrap.body == model::WrapBody::reference ? femur : tibia);
  return result;
}

}  // namespace vrda::prepare
