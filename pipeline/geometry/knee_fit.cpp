#include "geometry/knee_fit.hpp"

#include <algorithm>

#include "core/units.hpp"

namespace vrda::geometry {
namespace {

constexpr int n_points = 2200;
constexpr double femur_radius_mm = 58.0, tibia_radius_mm = 75.0;  // of the template, about the joint
constexpr double femur_kept = 0.88, tibia_kept = 0.95;
constexpr double subject_radius_mm = 95.0;

void scale_unit(KneeSurfaces& knee, double unit_mm)
{
  for (BoneSurfaces* bone : {&knee.femur, &knee.tibia}) {
    bone->bone.vertices_mm *= unit_mm;
    bone->cartilage.vertices_mm *= unit_mm;
  }
}

bool is_cartilage_only(const BoneSurfaces& bone)
{
  return bone.bone.triangles.rows() == 0;
}

Pose frame_of(const BoneFit& fit, const Eigen::Vector3d& origin_mm)
{
  Pose X = Pose::Identity();
  X.linear() = fit.R;
  X.translation() = fit(origin_mm);
  return X;
}

// One bone of the template and of the subject, and the settings of its fit.
struct BoneTask {
  const BoneSurfaces& of_template;
  const BoneSurfaces& of_subject;
  BoneFit start;
  double radius_mm = 0.0;
  double kept = 0.0;
  std::vector<KnownPoint> known = {};  // mm
  std::function<bool()> is_stopped = {};
};

// The template turned about its flexion axis: the coarse fit takes both bones as one.
std::vector<BoneFit> flexed_starts(const BoneFit& start, const Eigen::Vector3d& axis_mm)
{
  constexpr double step_rad = pi / 6.0;
  std::vector<BoneFit> starts;
  for (const int k : {0, -1, 1, -2, 2, -3, 3}) {
    BoneFit turned = start;
    turned.R = start.R * rotation_z(k * step_rad);
    turned.t_mm = start(axis_mm) - turned.R * turned.scale.cwiseProduct(axis_mm);
    starts.push_back(turned);
  }
  return starts;
}

BoneFit bone_fit(const BoneTask& task, const Eigen::Vector3d& centre_mm, const std::vector<BoneFit>& starts,
                 ScaleFreedom freedom)
{
  // Cartilage alone is compared with cartilage where the template has it.
  const bool as_cartilage =
      is_cartilage_only(task.of_subject) && task.of_template.cartilage.triangles.rows() > 0;
  const Mesh surface = as_cartilage ? task.of_template.cartilage : joined(task.of_template);
  const SurfacePoints points = sample_surface(cropped(surface, centre_mm, task.radius_mm), n_points);
  const NearestSurface subject(
      without_noise(cropped(joined(task.of_subject), starts.front()(centre_mm), subject_radius_mm)));
  return fit_bone(points, subject, starts, {freedom, task.kept, task.known, task.is_stopped});
}

// The template with its femur turned about the flexion axis.
TemplateKnee flexed(TemplateKnee knee, double flexion_rad)
{
  Pose X = Pose::Identity();
  X.linear() = rotation_z(flexion_rad);
  X.translation() = knee.origin_mm - X.linear() * knee.origin_mm;
  for (Mesh* mesh : {&knee.surfaces.femur.bone, &knee.surfaces.femur.cartilage})
    *mesh = transformed(*mesh, X);
  return knee;
}

// In flexion the bones do not fit as one: beyond some 60 degrees a good and a bad fit have equal residuals.
CoarseFit fit_in_flexion(const KneeSurfaces& subject, const TemplateKnee& reference)
{
  constexpr double good_mm = 2.5, flexion_rad = rad_from_deg(75.0);
  CoarseFit best = coarse_fit(subject, reference);
  const bool is_good = std::min(best.right.residual_mm, best.left.residual_mm) < good_mm;
  if (is_good || best.nearest_mm > largest_gap_mm) return best;
  CoarseFit other = coarse_fit(subject, flexed(reference, flexion_rad));
  other.right.flexion_rad = other.left.flexion_rad = flexion_rad;
  if (other.right.residual_mm < best.right.residual_mm) best.right = other.right;
  if (other.left.residual_mm < best.left.residual_mm) best.left = other.left;
  return best;
}

BoneFit start_of(const SimilarityFit& coarse, double flexion_rad, const Eigen::Vector3d& axis_mm)
{
  BoneFit start{Eigen::Vector3d::Constant(coarse.scale), coarse.R * rotation_z(flexion_rad), coarse.t_mm};
  start.t_mm += coarse.scale * (coarse.R * axis_mm - start.R * axis_mm);
  return start;
}

std::vector<KnownPoint> scaled(std::vector<KnownPoint> points, double unit_mm, bool is_left)
{
  for (KnownPoint& point : points) {
    point.subject_mm *= unit_mm;
    if (is_left) point.template_mm.z() *= -1.0;
  }
  return points;
}

void fit_bones(KneeFit& fit, const KneeSurfaces& subject, const TemplateKnee& own_side,
               const SimilarityFit& coarse, const KneeFitOptions& options)
{
  const KneeSurfaces& of_template = own_side.surfaces;
  const Eigen::Vector3d centre_mm =
      joint_region(joined(of_template.femur), joined(of_template.tibia)).centre_mm;
  const bool is_left = fit.side == Side::left;
  const Eigen::Vector3d& axis_mm = own_side.origin_mm;
  const BoneTask femur{of_template.femur, subject.femur, start_of(coarse, coarse.flexion_rad, axis_mm),
                       femur_radius_mm,   femur_kept,    scaled(options.femur_points, fit.unit_mm, is_left),
                       options.is_stopped};
  const BoneTask tibia{of_template.tibia, subject.tibia, start_of(coarse, 0.0, axis_mm),
                       tibia_radius_mm,   tibia_kept,    scaled(options.tibia_points, fit.unit_mm, is_left),
                       options.is_stopped};
  const auto free = [&](const BoneTask& task) {
    return bone_fit(task, centre_mm, flexed_starts(task.start, axis_mm), ScaleFreedom::axes);
  };
  // A free scale of a cartilage shrinks by 7 to 17 %. The length of a shaft is no measure of the joint.
  const auto near_other = [&](const BoneTask& task, const BoneFit& other) {
    BoneFit from = task.start;
    from.scale = {other.scale.x(), 0.5 * (other.scale.x() + other.scale.z()), other.scale.z()};
    from.t_mm = task.start(centre_mm) - from.R * from.scale.cwiseProduct(centre_mm);
    return bone_fit(task, centre_mm, flexed_starts(from, axis_mm), ScaleFreedom::near_start);
  };
  const bool femur_last = is_cartilage_only(subject.femur) && !is_cartilage_only(subject.tibia);
  const bool tibia_last = is_cartilage_only(subject.tibia) && !is_cartilage_only(subject.femur);
  if (!femur_last) fit.femur = free(femur);
  fit.tibia = tibia_last ? near_other(tibia, fit.femur) : free(tibia);
  if (femur_last) fit.femur = near_other(femur, fit.tibia);
}

}  // namespace

KneeFit fit_knee(const KneeSurfaces& subject, const TemplateKnee& reference, const KneeFitOptions& options)
{
  KneeFit fit;
  fit.unit_mm = options.unit_mm ? *options.unit_mm : unit_mm_of(joined(subject.femur), joined(subject.tibia));
  KneeSurfaces in_mm = subject;
  scale_unit(in_mm, fit.unit_mm);
  const CoarseFit coarse = fit_in_flexion(in_mm, reference);
  const bool is_left =
      options.side ? *options.side == Side::left : coarse.left.residual_mm < coarse.right.residual_mm;
  fit.side = is_left ? Side::left : Side::right;
  const SimilarityFit& chosen = is_left ? coarse.left : coarse.right;
  fit.coarse_residual_mm = chosen.residual_mm;
  fit.nearest_mm = coarse.nearest_mm;
  fit.side_margin = (is_left ? coarse.right : coarse.left).residual_mm / chosen.residual_mm;
  TemplateKnee own_side = reference;
  if (is_left) {
    own_side.surfaces = mirrored_z(reference.surfaces);
    own_side.origin_mm.z() *= -1.0;
  }
  fit_bones(fit, in_mm, own_side, chosen, options);
  fit.X_scan_femur = frame_of(fit.femur, own_side.origin_mm);
  fit.X_scan_tibia = frame_of(fit.tibia, own_side.origin_mm);
  fit.scanned =
      clinical_coordinates(fit.X_scan_femur.inverse() * fit.X_scan_tibia, fit.side, Eigen::Vector3d::Zero());
  return fit;
}

}  // namespace vrda::geometry
