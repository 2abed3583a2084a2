#include "registration/knee_fit.hpp"

#include <algorithm>

#include "core/units.hpp"

namespace vrda::registration {
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
  double radius_mm = 0.0;
  double kept = 0.0;
};

// The template turned about its flexion axis: the coarse fit takes both bones as one, in extension.
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
  return fit_bone(points, subject, starts, {freedom, task.kept});
}

void fit_bones(KneeFit& fit, const KneeSurfaces& subject, const TemplateKnee& own_side,
               const SimilarityFit& coarse)
{
  const KneeSurfaces& of_template = own_side.surfaces;
  const Eigen::Vector3d centre_mm =
      joint_region(joined(of_template.femur), joined(of_template.tibia)).centre_mm;
  const BoneTask femur{of_template.femur, subject.femur, femur_radius_mm, femur_kept};
  const BoneTask tibia{of_template.tibia, subject.tibia, tibia_radius_mm, tibia_kept};
  const BoneFit start{Eigen::Vector3d::Constant(coarse.scale), coarse.R, coarse.t_mm};
  const auto free = [&](const BoneTask& task) {
    return bone_fit(task, centre_mm, flexed_starts(start, own_side.origin_mm), ScaleFreedom::axes);
  };
  // Free, the scale of a cartilage shrinks by 7 to 17 %. The length of a shaft is no measure of the joint.
  const auto held = [&](const BoneTask& task, const BoneFit& other) {
    BoneFit from = start;
    from.scale.setConstant(0.5 * (other.scale.x() + other.scale.z()));
    from.t_mm = start(centre_mm) - from.R * from.scale.cwiseProduct(centre_mm);
    return bone_fit(task, centre_mm, flexed_starts(from, own_side.origin_mm), ScaleFreedom::held);
  };
  const bool femur_held = is_cartilage_only(subject.femur) && !is_cartilage_only(subject.tibia);
  const bool tibia_held = is_cartilage_only(subject.tibia) && !is_cartilage_only(subject.femur);
  if (!femur_held) fit.femur = free(femur);
  fit.tibia = tibia_held ? held(tibia, fit.femur) : free(tibia);
  if (femur_held) fit.femur = held(femur, fit.tibia);
}

}  // namespace

KneeFit fit_knee(const KneeSurfaces& subject, const TemplateKnee& reference, const KneeFitOptions& options)
{
  KneeFit fit;
  fit.unit_mm = options.unit_mm ? *options.unit_mm : unit_mm_of(joined(subject.femur), joined(subject.tibia));
  KneeSurfaces scaled = subject;
  scale_unit(scaled, fit.unit_mm);
  const CoarseFit coarse = coarse_fit(scaled, reference);
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
  fit_bones(fit, scaled, own_side, chosen);
  fit.X_scan_femur = frame_of(fit.femur, own_side.origin_mm);
  fit.X_scan_tibia = frame_of(fit.tibia, own_side.origin_mm);
  fit.scanned =
      clinical_coordinates(fit.X_scan_femur.inverse() * fit.X_scan_tibia, fit.side, Eigen::Vector3d::Zero());
  return fit;
}

}  // namespace vrda::registration
