#include "job/surface_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/axis_map.hpp"
#include "job/case_warnings.hpp"
#include "job/shells.hpp"
#include "geometry/fit_checks.hpp"
#include "geometry/nearest_surface.hpp"

namespace vrda::job {
namespace {

using geometry::NearestSurface;

// The gap between bones whose cartilage is not in the meshes.
constexpr double joint_space_mm = 8.0;
// Epiphyses, sesamoids and pieces of cartilage are larger.
constexpr double largest_speck_mm = 15.0;

// At most some 300 vertices of a shell.
std::vector<Eigen::Vector3d> samples_of(const Mesh& mesh, const std::vector<Eigen::Index>& shell)
{
  std::vector<Eigen::Vector3d> points;
  const std::size_t step = 1 + shell.size() / 100;
  for (std::size_t k = 0; k < shell.size(); k += step) {
    for (const Eigen::Vector3d& corner : corners(mesh, shell[k])) points.push_back(corner);
  }
  return points;
}

Box box_of(const Mesh& mesh, const std::vector<Eigen::Index>& shell)
{
  Eigen::AlignedBox3d box;
  for (const Eigen::Index t : shell) {
    for (const Eigen::Vector3d& corner : corners(mesh, t)) box.extend(corner);
  }
  return {box.min(), box.max()};
}

struct Near {
  double distance_mm = std::numeric_limits<double>::infinity();
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();  // of the surface
};

Near nearest_of(const std::vector<Eigen::Vector3d>& points, const NearestSurface& surface)
{
  Near best;
  for (const Eigen::Vector3d& p_mm : points) {
    const geometry::SurfacePoint at = surface.nearest(p_mm);
    if (at.triangle >= 0 && at.distance_mm < best.distance_mm) best = {at.distance_mm, at.p_mm};
  }
  return best;
}

bool comes_near(const Eigen::Vector3d& p_mm, const NearestSurface& other, const std::vector<Pose>& poses)
{
  return std::any_of(poses.begin(), poses.end(),
                     [&](const Pose& X) { return other.nearest(X * p_mm).distance_mm <= joint_space_mm; });
}

struct BodySide {
  const BodyJob& job;
  const Body& body;
  const std::vector<std::vector<Eigen::Index>>& small;
  double facing;  // along Y, of the surface that bears load
};

void warn_of_specks(const Job& job, const Case& loaded, const BodySide& side, const BodySide& other,
                    std::vector<std::string>& warnings)
{
  constexpr std::size_t most_named = 3;
  const Mesh& mesh = side.body.contact.mesh;
  const std::vector<Speck> specks =
      specks_of({mesh, side.small}, {other.body.contact.mesh, other.small},
                flexed_poses(loaded.frame.rotation_centre_mm, loaded.grid.flexion_deg, -side.facing));
  const Pose X_file_canonical = body_map(job, side.job).X_canonical_native.inverse();
  for (std::size_t k = 0; k < std::min(specks.size(), most_named); ++k) {
    const std::vector<Eigen::Index>& shell = side.small[specks[k].shell];
    const auto c =
        static_cast<std::size_t>(side.body.contact.component[static_cast<std::size_t>(shell.front())]);
    warnings.push_back(
        side.body.name + " component \"" + side.body.components[c].name + "\" (" +
        side.job.components[c].file + "): a separate piece of " +
        speck_text(specks[k], shell.size(), X_file_canonical * specks[k].centre_mm) +
        ", is in the joint space, " + rounded_text(specks[k].distance_mm, 10.0) + " mm from \"" +
        other.body.name +
        "\"; probably a left-over of the segmentation, which changes the motion: remove it from "
        "the mesh (vrda prepare leaves such pieces out)");
  }
  if (specks.size() > most_named)
    warnings.push_back(side.body.name + ": " + std::to_string(specks.size() - most_named) +
                       " more separate pieces in the joint space");
}

bool is_cover(const Component& component, const ComponentJob& job)
{
  return (component.material != "bone" && component.material != "meniscus") || job.inset_mm < 0.0 ||
         job.offset_mm > 0.0;
}

// Cartilage of one compartment where the other body reaches across both.
void warn_of_one_compartment(const Case& loaded, const BodySide& side, const BodySide& other,
                             std::vector<std::string>& warnings)
{
  const double centre_mm = loaded.frame.rotation_centre_mm.z();
  const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(side.body, side.body.contact);
  std::vector<Eigen::Index> covers;
  std::string names;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    const Component& component = side.body.components[c];
    if (rows[c].empty() || !is_cover(component, side.job.components[c])) continue;
    covers.insert(covers.end(), rows[c].begin(), rows[c].end());
    if (component.material == "cartilage") names += (names.empty() ? "\"" : ", \"") + component.name + '"';
  }
  if (names.empty()) return;
  constexpr double least_of_other =
      0.3;  // otherwise it is a model of one compartment, or its centre is wrong
  const double share =
      lesser_side_share(select_triangles(side.body.contact.mesh, covers), side.facing, centre_mm);
  if (share >= least_side_share ||
      lesser_side_share(other.body.contact.mesh, other.facing, centre_mm) < least_of_other)
    return;
  warnings.push_back(side.body.name + ": cartilage of one compartment only (" + names + "), while \"" +
                     other.body.name +
                     "\" reaches across both: the knee tilts to the bare one; add the cartilage of the other "
                     "compartment, or give the bone alone, with inset_mm = -2 in place of its cartilage");
}

// A surface that a body has twice counts twice in contact.
void warn_of_copies(const BodySide& side, std::vector<std::string>& warnings)
{
  const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(side.body, side.body.contact);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = i + 1; j < rows.size(); ++j) {
      if (rows[i].empty() || rows[j].empty() || side.job.components[i].generate ||
          side.job.components[j].generate || side.job.components[i].file == side.job.components[j].file)
        continue;
      const Mesh first = compacted(side.body.contact.mesh, rows[i]);
      const Mesh second = compacted(side.body.contact.mesh, rows[j]);
      if (!geometry::is_part_of(second, first) && !geometry::is_part_of(first, second)) continue;
      warnings.push_back(side.body.name + " components \"" + side.body.components[i].name + "\" and \"" +
                         side.body.components[j].name + "\" have the same surface in contact; " +
                         side.job.components[j].key + ".file: name the mesh of \"" +
                         side.body.components[j].name + "\", or remove it");
    }
  }
}

}  // namespace

std::vector<Speck> specks_of(const ShellsOfBody& body, const ShellsOfBody& other,
                             const std::vector<Pose>& X_other_body)
{
  std::vector<Speck> specks;
  if (body.small_shells.empty()) return specks;
  const NearestSurface own(select_triangles(body.mesh, others_than(body.mesh, body.small_shells)));
  const NearestSurface facing(select_triangles(other.mesh, others_than(other.mesh, other.small_shells)));
  for (std::size_t s = 0; s < body.small_shells.size(); ++s) {
    const Box box = box_of(body.mesh, body.small_shells[s]);
    const double size_mm = (box.max_mm - box.min_mm).maxCoeff();
    if (size_mm > largest_speck_mm) continue;
    const std::vector<Eigen::Vector3d> points = samples_of(body.mesh, body.small_shells[s]);
    const double distance_mm = nearest_of(points, facing).distance_mm;
    const Near at_own = nearest_of(points, own);
    const bool is_in_space = distance_mm <= joint_space_mm || (at_own.distance_mm <= joint_space_mm &&
                                                               comes_near(at_own.p_mm, facing, X_other_body));
    if (is_in_space) specks.push_back({s, 0.5 * (box.min_mm + box.max_mm), size_mm, distance_mm});
  }
  return specks;
}

std::vector<Pose> flexed_poses(const Eigen::Vector3d& centre_mm, const std::vector<double>& flexion_deg,
                               double sign)
{
  std::vector<Pose> poses;
  for (const double angle_deg : flexion_deg) {
    Pose X = Pose::Identity();
    X.linear() = rotation_z(sign * rad_from_deg(angle_deg));
    X.translation() = centre_mm - X.linear() * centre_mm;
    poses.push_back(X);
  }
  return poses;
}

std::string speck_text(const Speck& speck, std::size_t n_triangles, const Eigen::Vector3d& file_mm)
{
  return std::to_string(n_triangles) + " triangles, " + rounded_text(speck.size_mm, 10.0) +
         " mm across, at [" + rounded_text(file_mm.x(), 10.0) + ", " + rounded_text(file_mm.y(), 10.0) +
         ", " + rounded_text(file_mm.z(), 10.0) + "] mm in the axes of the file";
}

double lesser_side_share(const Mesh& mesh, double sign, double centre_z_mm)
{
  double below = 0.0, above = 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    const double facing = sign * (b - a).cross(c - a).y();
    if (facing > 0.0) ((a + b + c).z() / 3.0 < centre_z_mm ? below : above) += facing;
  }
  return below + above > 0.0 ? std::min(below, above) / (below + above) : 0.0;
}

std::vector<std::string> surface_warnings(const Job& job, const Case& loaded, const SmallShells& small)
{
  std::vector<std::string> warnings;
  const BodySide reference{job.reference, loaded.reference, small.reference, -1.0};
  const BodySide moving{job.moving, loaded.moving, small.moving, 1.0};
  warn_of_specks(job, loaded, reference, moving, warnings);
  warn_of_specks(job, loaded, moving, reference, warnings);
  for (const BodySide& side : {reference, moving}) {
    if (job.joint == "knee")
      warn_of_one_compartment(loaded, side, side.facing < 0.0 ? moving : reference, warnings);
    warn_of_copies(side, warnings);
  }
  return warnings;
}

}  // namespace vrda::job
