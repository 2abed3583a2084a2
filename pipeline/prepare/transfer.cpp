#include "prepare/transfer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/case_warnings.hpp"

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

struct BoneMaps {
  BoneMap femur, tibia;
};

BoneMaps bone_maps(const TemplateJoint& own_side, const geometry::KneeFit& fit, const SubjectBones& subject)
{
  const geometry::KneeSurfaces& known = own_side.knee.surfaces;
  const Eigen::Vector3d& origin_mm = own_side.knee.origin_mm;
  return {{fit.femur.scale, origin_mm, NearestSurface(known.femur.bone),
           NearestSurface(subject.surfaces.femur.bone)},
          {fit.tibia.scale, origin_mm, NearestSurface(known.tibia.bone),
           NearestSurface(subject.surfaces.tibia.bone)}};
}

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
  const auto [femur, tibia] = bone_maps(own_side, fit, subject);
  const BoneMap fibula{fit.tibia.scale, own_side.knee.origin_mm, NearestSurface(own_side.fibula),
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
    wrap = transferred(wrap, wrap.body == BodyIndex::reference ? femur : tibia);
  return result;
}

namespace {

// Centre and scales of the follower's map: template to the femur's frame of the subject.
struct KneecapMap {
  Eigen::Vector3d scale, centre_mm, template_centre_mm;
};

Mesh moved(Mesh mesh, const Eigen::Vector3d& by_mm)
{
  mesh.vertices_mm.rowwise() += by_mm.transpose();
  return mesh;
}

Mesh scaled_about(Mesh mesh, const KneecapMap& map)
{
  mesh.vertices_mm =
      (mesh.vertices_mm.rowwise() - map.template_centre_mm.transpose()) * map.scale.asDiagonal();
  mesh.vertices_mm.rowwise() += map.centre_mm.transpose();
  return mesh;
}

// Smallest distance of the vertices from a surface, negative inside it.
double gap_between_mm(const Mesh& mesh, const NearestSurface& surface)
{
  double least_mm = std::numeric_limits<double>::infinity();
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    const Eigen::Vector3d p_mm = mesh.vertices_mm.row(v);
    const SurfacePoint on = surface.nearest(p_mm);
    if (on.triangle < 0) continue;
    const double side = (p_mm - on.p_mm).dot(surface.normal(on.triangle)) < 0.0 ? -1.0 : 1.0;
    if (side > 0.0 || !surface.is_at_rim(on.triangle)) least_mm = std::min(least_mm, side * on.distance_mm);
  }
  return least_mm;
}

Eigen::Vector3d off_axis_mm(const Eigen::Vector3d& p_mm, const model::Wrap& wrap)
{
  const Eigen::Vector3d from_mm = p_mm - wrap.X_body_wrap.translation(),
                        axis = wrap.X_body_wrap.linear().col(2);
  return from_mm - axis * axis.dot(from_mm);
}

// The patella `own` turned about the axis of a wrap, itself by less, and moved onto the femur: an estimate of
// its way at flexions up to 120 degrees.
std::vector<Pose> way_around(const model::Wrap& wrap, const Mesh& own, const Eigen::Vector3d& centre_mm,
                             const NearestSurface& femur)
{
  constexpr double step_deg = 20.0, last_deg = 120.0, own_share = 0.6, near_mm = 0.2;
  constexpr int most_steps = 10;
  const Eigen::Vector3d axis_mm = wrap.X_body_wrap.translation();
  std::vector<Pose> way{Pose::Identity()};
  for (double turn_deg = step_deg; turn_deg <= last_deg; turn_deg += step_deg) {
    Pose X = Pose::Identity();
    X.linear() = rotation_z(-rad_from_deg(own_share * turn_deg));
    const Eigen::Vector3d at_mm = axis_mm + rotation_z(-rad_from_deg(turn_deg)) * (centre_mm - axis_mm);
    X.translation() = at_mm - X.linear() * centre_mm;
    const Eigen::Vector3d outward = off_axis_mm(at_mm, wrap).normalized();
    double gap_mm = std::numeric_limits<double>::infinity();
    for (int k = 0; k < most_steps && std::abs(gap_mm) > near_mm; ++k) {
      gap_mm = gap_between_mm(transformed(own, X), femur);
      if (!std::isfinite(gap_mm)) break;
      X.translation() -= gap_mm * outward;
    }
    if (std::isfinite(gap_mm)) way.push_back(X);
  }
  return way;
}

// A line is straight, and suddenly shorter, where its end enters its cylinder.
void keep_ends_outside(model::Ligaments& ligaments, const Mesh& own, const Eigen::Vector3d& centre_mm,
                       const NearestSurface& femur)
{
  constexpr double clear_mm = 1.0;
  for (std::size_t w = 0; w < ligaments.wraps.size(); ++w) {
    model::Wrap& wrap = ligaments.wraps[w];
    if (wrap.body != BodyIndex::reference || wrap.shape != model::WrapShape::cylinder) continue;
    double radius_mm = wrap.radii_mm.x();
    for (const Pose& X : way_around(wrap, own, centre_mm, femur)) {
      for (const model::Fibre& fibre : ligaments.fibres) {
        if (fibre.wrap == static_cast<int>(w))
          radius_mm = std::min(radius_mm, off_axis_mm(X * fibre.moving_mm, wrap).norm() - clear_mm);
      }
    }
    wrap.radii_mm.head<2>().setConstant(std::max(radius_mm, wrap.radii_mm.x() / 2.0));
  }
}

// Fibres and wraps of the template's patella on the subject's bones and on `own`, its patella.
model::Ligaments kneecap_ligaments(const TemplateJoint& own_side, const geometry::KneeFit& fit,
                                   const SubjectBones& subject, const KneecapMap& at, const Mesh& own)
{
  const BodyIndex patella = model::follower_index(0);
  const BoneMaps bones = bone_maps(own_side, fit, subject);
  const BoneMap cap{at.scale, at.template_centre_mm,
                    NearestSurface(joined(surfaces_of(own_side.patella->body))),
                    NearestSurface(moved(own, -at.centre_mm))};
  const auto map_of = [&](BodyIndex body) -> const BoneMap& {
    return body == BodyIndex::reference ? bones.femur : body == BodyIndex::moving ? bones.tibia : cap;
  };
  const auto placed = [&](BodyIndex body, const Eigen::Vector3d& p_mm) {
    const Eigen::Vector3d found_mm = attached(p_mm, map_of(body), std::nullopt).p_mm;
    return Eigen::Vector3d(body == patella ? Eigen::Vector3d(found_mm + at.centre_mm) : found_mm);
  };
  model::Ligaments ligaments = own_side.patella->ligaments;
  for (model::Fibre& fibre : ligaments.fibres) {
    // The origin of a muscle is not on the bone.
    fibre.reference_mm = fibre.tension_n > 0.0 && fibre.from != patella
                             ? map_of(fibre.from)(fibre.reference_mm)
                             : placed(fibre.from, fibre.reference_mm);
    fibre.moving_mm = placed(fibre.to, fibre.moving_mm);
  }
  for (model::Wrap& wrap : ligaments.wraps) {
    const bool is_own = wrap.body == patella;
    wrap = transferred(wrap, map_of(wrap.body));
    if (is_own) wrap.X_body_wrap.translation() += at.centre_mm;
  }
  keep_ends_outside(ligaments, own, at.centre_mm, NearestSurface(joined(subject.surfaces.femur)));
  return ligaments;
}

const job::Follower& patella_of(const TemplateJoint& own_side)
{
  if (!own_side.patella)
    throw InputError({"--template", "\"" + own_side.joint.title + "\"", "a knee without a [[follower]]",
                      "a template with a patella, or the generic one"});
  return *own_side.patella;
}

}  // namespace

Kneecap registered_kneecap(const TemplateJoint& own_side, const geometry::KneeFit& fit,
                           const SubjectBones& subject, const geometry::BoneSurfaces& patella,
                           const std::string& file)
{
  constexpr double largest_residual_mm = 4.0, farthest_centre_mm = 90.0, most_size_ratio = 3.0;
  constexpr int n_points = 1200;
  const job::Follower& of_template = patella_of(own_side);
  const Mesh whole = joined(patella), model = joined(surfaces_of(of_template.body));
  const Eigen::Vector3d mean_mm = whole.vertices_mm.colwise().mean(),
                        model_mm = model.vertices_mm.colwise().mean();
  const auto refuse = [&](const std::string& reason) {
    throw InputError(
        {file, "--patella", reason, "the patella of this knee, in the place and the unit of the bones"});
  };
  // A mesh in another unit has no point near the model.
  const double size_mm = job::diagonal_mm(bounding_box(whole)),
               model_size_mm = fit.femur.scale.mean() * job::diagonal_mm(bounding_box(model));
  if (!(size_mm > model_size_mm / most_size_ratio && size_mm < model_size_mm * most_size_ratio))
    refuse("a mesh " + fixed_text(size_mm, 0) + " mm across, where about " + fixed_text(model_size_mm, 0) +
           " are expected: its unit may be another");
  std::vector<geometry::BoneFit> starts;
  for (const double flexion_deg : {0.0, -25.0, 25.0, 50.0, 75.0}) {
    geometry::BoneFit start;
    start.scale.setConstant(fit.femur.scale.mean());
    start.R = rotation_z(-rad_from_deg(flexion_deg));
    start.t_mm = mean_mm - start.R * start.scale.cwiseProduct(model_mm);
    starts.push_back(start);
  }
  const geometry::BoneFit found = fit_bone(geometry::sample_surface(model, n_points),
                                           NearestSurface(geometry::without_noise(whole)), starts, {});
  const Eigen::Vector3d scanned_mm = found(of_template.centre_mm);
  if (!(found.residual_mm < largest_residual_mm))
    refuse("a surface " + fixed_text(found.residual_mm, 1) +
           " mm (root mean square) off the template's patella");
  if (found.scale.minCoeff() <= 0.5 || found.scale.maxCoeff() >= 2.0)
    refuse("a size beyond 0.5 to 2 times that of the template's patella");
  if (!(scanned_mm.x() > 0.0 &&
        scanned_mm.norm() < farthest_centre_mm * std::max(1.0, fit.femur.scale.mean())))
    refuse("a mesh " + fixed_text(scanned_mm.norm(), 0) + " mm from the centre of the knee" +
           (scanned_mm.x() > 0.0 ? "" : ", behind the femur's axis"));
  Kneecap cap;
  cap.centre_mm = fit.femur.scale.cwiseProduct(of_template.centre_mm - own_side.knee.origin_mm);
  const KneecapMap at{found.scale, cap.centre_mm, of_template.centre_mm};
  const Side side = own_side.joint.frame.side;
  Pose X_scan = Pose::Identity();
  X_scan.linear() = found.R;
  X_scan.translation() = scanned_mm - found.R * cap.centre_mm;
  cap.scanned = follower_coordinates(X_scan, side, cap.centre_mm);
  // The outline of many patellae is too round to determine it.
  cap.scanned(1) = 0.0;
  X_scan = follower_pose(cap.scanned, side, cap.centre_mm);
  cap.surfaces = {transformed(patella.bone, X_scan.inverse()),
                  transformed(patella.cartilage, X_scan.inverse())};
  cap.scale = found.scale;
  cap.residual_mm = found.residual_mm;
  cap.gap_mm = gap_between_mm(whole, NearestSurface(joined(subject.surfaces.femur)));
  const Mesh& attached_to = patella.bone.triangles.rows() > 0 ? cap.surfaces.bone : cap.surfaces.cartilage;
  cap.ligaments = kneecap_ligaments(own_side, fit, subject, at, attached_to);
  return cap;
}

Kneecap fitted_kneecap(const TemplateJoint& own_side, const geometry::KneeFit& fit,
                       const SubjectBones& subject)
{
  constexpr int most_steps = 20;
  constexpr double near_mm = 0.2;
  const job::Follower& of_template = patella_of(own_side);
  const NearestSurface femur(joined(subject.surfaces.femur));
  KneecapMap at{fit.femur.scale,
                fit.femur.scale.cwiseProduct(of_template.centre_mm - own_side.knee.origin_mm),
                of_template.centre_mm};
  const Mesh model = joined(surfaces_of(of_template.body));
  Kneecap cap;
  for (int k = 0; k < most_steps; ++k) {
    cap.gap_mm = gap_between_mm(scaled_about(model, at), femur);
    if (!std::isfinite(cap.gap_mm) || std::abs(cap.gap_mm - near_mm) < near_mm / 2.0) break;
    at.centre_mm.x() -= cap.gap_mm - near_mm;
  }
  const geometry::BoneSurfaces own = surfaces_of(of_template.body);
  cap.surfaces = {scaled_about(own.bone, at), scaled_about(own.cartilage, at)};
  cap.centre_mm = at.centre_mm;
  cap.scale = at.scale;
  cap.ligaments = kneecap_ligaments(own_side, fit, subject, at, joined(cap.surfaces));
  return cap;
}

}  // namespace vrda::prepare
