#include "job/auto_frame.hpp"

#include <cmath>

#include "core/text.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"
#include "job/shells.hpp"
#include "geometry/fit_checks.hpp"
#include "geometry/knee_surfaces.hpp"

namespace vrda::job {
namespace {

using geometry::BoneSurfaces;
using geometry::KneeFit;

bool is_automatic(const BodyJob& body)
{
  return body.frame && (body.frame->is_origin_auto || body.frame->is_align_auto);
}

double unit_mm_of(const Job& job, const BodyJob& body)
{
  return mm_per_unit(frame_of(job, body).unit);
}

// Bone and cartilage in the axes of the files, mm.
BoneSurfaces native_surfaces(const Job& job, const BodyJob& body, ComponentLoader& source)
{
  const AxisMap to_mm{unit_mm_of(job, body)};
  BoneSurfaces surfaces;
  for (ComponentJob component : body.components) {
    const bool is_bone = component.material == "bone", is_cartilage = component.material == "cartilage";
    if ((!is_bone && !is_cartilage) || component.name.find("fibula") != std::string::npos) continue;
    if (component.generate) continue;
    component.inset_mm = 0.0;
    component.shift_mm.setZero();
    append(is_bone ? surfaces.bone : surfaces.cartilage,
           outer_surface(source.load(component, to_mm).clean.mesh));
  }
  return surfaces;
}

void require_surface(const Job& job, const std::string& key, const BoneSurfaces& surfaces,
                     const std::string& body)
{
  const Mesh all = joined(surfaces);
  const std::string tangle = geometry::tangle_in(all);
  if (!tangle.empty())
    job.document.refuse(key, "\"auto\" with [" + body + "]: " + tangle, "surfaces of bones, or numbers");
  if (all.triangles.rows() > 0) return;
  job.document.refuse(key, "\"auto\", and no mesh file of bone or cartilage in [" + body + "]",
                      "mesh files of both bones, or numbers");
}

// The first key with "auto", for messages.
std::string automatic_key(const Job& job)
{
  for (const BodyJob* body : {&job.reference, &job.moving}) {
    if (is_automatic(*body)) return body->frame->key + (body->frame->is_align_auto ? ".align" : ".origin");
  }
  return "";
}

void check_size(const Job& job, const geometry::KneeSurfaces& bones)
{
  const double factor = geometry::unit_mm_of(joined(bones.femur), joined(bones.tibia));
  if (factor == 1.0) return;
  const FrameJob& frame = frame_of(job, job.reference);
  const double found_mm = factor * mm_per_unit(frame.unit);
  job.document.refuse(
      frame.key + ".unit",
      "\"" + frame.unit + "\", and bones " + shortest_decimal(factor) + " times smaller than a knee's",
      "the unit of the mesh files" +
          (found_mm == 10.0 || found_mm == 1000.0 ? ": \"" + std::string(unit_of_mm(found_mm)) + "\"" : ""));
}

void refuse_other_objects(const Job& job, const KneeFit& fit, const geometry::KneeSurfaces& bones)
{
  std::string all;
  for (const std::string& reason : geometry::rejection_reasons(fit, bones))
    all += (all.empty() ? "" : "; ") + reason;
  if (all.empty()) return;
  job.document.refuse(
      automatic_key(job), "bones without a frame: " + all,
      "femur and tibia of one knee in one pose, similar to the generic knee, or numbers; vrda "
      "prepare draws what it finds");
}

// R = Rz Ry Rx.
Eigen::Vector3d fixed_angles_deg(const Eigen::Matrix3d& R)
{
  const double across = std::sqrt(R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0));
  constexpr double locked = 1e-9;  // then only the sum of the first and the last angle is determined
  const Eigen::Vector3d angles_rad =
      across > locked ? Eigen::Vector3d(arc_tangent2(R(2, 1), R(2, 2)), arc_tangent2(-R(2, 0), across),
                                        arc_tangent2(R(1, 0), R(0, 0)))
                      : Eigen::Vector3d(0.0, arc_tangent2(-R(2, 0), across), arc_tangent2(-R(0, 1), R(1, 1)));
  return {deg_from_rad(angles_rad.x()), deg_from_rad(angles_rad.y()), deg_from_rad(angles_rad.z())};
}

Eigen::Vector3d rounded_to(const Eigen::Vector3d& v, double per_unit)
{
  return ((v * per_unit).array().round() / per_unit + 0.0).matrix();
}

FoundFrame found_frame(const Pose& X_scan_bone, double unit_mm)
{
  constexpr double per_degree = 1e7, per_mm = 1e6;
  return {rounded_to(X_scan_bone.translation() / unit_mm, per_mm * unit_mm),
          rounded_to(fixed_angles_deg(X_scan_bone.linear().transpose()), per_degree)};
}

}  // namespace

std::optional<AutoFrames> auto_frames(const Job& job, ComponentLoader& source)
{
  if (!is_automatic(job.reference) && !is_automatic(job.moving)) return std::nullopt;
  const geometry::KneeSurfaces bones{native_surfaces(job, job.reference, source),
                                         native_surfaces(job, job.moving, source)};
  require_surface(job, automatic_key(job), bones.femur, "reference");
  require_surface(job, automatic_key(job), bones.tibia, "moving");
  check_size(job, bones);
  const KneeFit fit = geometry::fit_knee(bones, geometry::generic_template(), {job.side, 1.0});
  refuse_other_objects(job, fit, bones);
  AutoFrames found{{found_frame(fit.X_scan_femur, unit_mm_of(job, job.reference)),
                    found_frame(fit.X_scan_tibia, unit_mm_of(job, job.moving))},
                   {}};
  for (const std::string& warning : geometry::fit_warnings(fit, bones, true))
    found.warnings.push_back(automatic_key(job) + ": " + warning);
  return found;
}

}  // namespace vrda::job
