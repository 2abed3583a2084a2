// Warnings on the surfaces of a case: specks, copies, a part over the gap, one compartment, sides.
#include "job/case_warnings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/knee_fit.hpp"
#include "geometry/nearest_surface.hpp"
#include "job/clean_mesh.hpp"

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
        ", is in the joint space, " + short_decimal(specks[k].distance_mm, 1) + " mm from \"" +
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
  return std::to_string(n_triangles) + " triangles, " + short_decimal(speck.size_mm, 1) + " mm across, " +
         places_text({file_mm});
}

std::string places_text(const std::vector<Eigen::Vector3d>& points_mm)
{
  constexpr double apart_mm = 5.0;
  constexpr std::size_t most = 3;
  std::vector<Eigen::Vector3d> places_mm;
  for (const Eigen::Vector3d& p_mm : points_mm) {
    const auto is_near = [&](const Eigen::Vector3d& q_mm) { return (p_mm - q_mm).norm() < apart_mm; };
    if (std::ranges::none_of(places_mm, is_near)) places_mm.push_back(p_mm);
    if (places_mm.size() > most) break;
  }
  std::string text;
  for (std::size_t k = 0; k < std::min(most, places_mm.size()); ++k) {
    const Eigen::Vector3d tenths_mm = (10.0 * places_mm[k]).array().round() / 10.0 + 0.0;
    text += (k == 0 ? "at [" : ", [") + core::numbers_text(tenths_mm) + "]";
  }
  if (!text.empty()) text += " mm in the axes of the file";
  return text + (places_mm.size() > most ? ", and elsewhere" : "");
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

// Warnings about meshes that are too coarse, too noisy or too full of holes for a pose. The thresholds follow
// from measured errors of the pose (schemas/frames.md).

namespace {

// Each limit is where the measured error of the pose reaches one degree. The shipped femur has 0.11 mm, real
// bones have at most 0.05 mm.
constexpr double largest_sagitta_mm = 0.17;
// Standard deviation; real bones and cartilage have at most 0.03 mm. Longer edges than these make curvature
// look like noise: of shipped and coarser bones up to 0.12 mm.
constexpr double largest_noise_mm = 0.07, largest_noise_of_long_edges_mm = 0.14, long_edge_mm = 3.0;
// Longer edges are not judged, of thin plates and menisci sooner.
constexpr double longest_judged_edge_mm = 5.5, thinnest_mm = 20.0, longest_judged_of_thin_mm = 1.5;
constexpr double largest_hole_share = 0.01;
// A larger boundary is the border of a sheet.
constexpr double sheet_share = 0.1;

// Where contact with the other object is.
Box joint_space(const Body& other)
{
  constexpr double margin_mm = 15.0;
  const Box box = bounding_box(other.contact.mesh);
  return {box.min_mm.array() - margin_mm, box.max_mm.array() + margin_mm};
}

bool is_in(const Box& box, const Eigen::Vector3d& p_mm)
{
  return (p_mm.array() >= box.min_mm.array()).all() && (p_mm.array() <= box.max_mm.array()).all();
}

Mesh part_in(const Box& box, const Mesh& mesh)
{
  std::vector<Eigen::Index> rows;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    if (is_in(box, (a + b + c) / 3.0)) rows.push_back(t);
  }
  return select_triangles(mesh, rows);
}

// Each vertex minus the mean of its neighbours in the mesh.
Points laplacian(const Points& values, const Triangles& triangles)
{
  Points sums = Points::Zero(values.rows(), 3);
  Eigen::VectorXd n = Eigen::VectorXd::Zero(values.rows());
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Index v = triangles(t, k);
      sums.row(v) += values.row(triangles(t, (k + 1) % 3)) + values.row(triangles(t, (k + 2) % 3));
      n[v] += 2.0;
    }
  }
  return values - (sums.array().colwise() / n.array().max(1.0)).matrix();
}

double median_of(std::vector<double> values)
{
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Height of a surface's arc above its edges, e^2 / 8R (median over the edges of two triangles): of
// equilateral triangles whose centres are d apart, e^2 = 3 d^2, and their normals differ by d / R.
double sagitta_mm(const Mesh& mesh)
{
  std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Index> triangle_of;  // by directed edge
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) triangle_of[{mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3)}] = t;
  const auto centre_mm = [&](Eigen::Index t) {
    const auto [a, b, c] = corners(mesh, t);
    return Eigen::Vector3d((a + b + c) / 3.0);
  };
  std::vector<double> all_mm;
  for (const auto& [edge, t] : triangle_of) {
    const auto other = triangle_of.find({edge.second, edge.first});
    if (edge.first > edge.second || other == triangle_of.end()) continue;
    const double turn = (face_normal(mesh, t) - face_normal(mesh, other->second)).norm();
    all_mm.push_back(3.0 / 8.0 * (centre_mm(t) - centre_mm(other->second)).norm() * turn);
  }
  return median_of(std::move(all_mm));
}

// Standard deviation of the vertices across the surface: applied twice, the Laplacian keeps noise and takes
// away curvature that changes slowly. By the median, which edges of bones do not change.
double noise_mm(const Mesh& mesh, double sagitta_mm)
{
  if (mesh.triangles.rows() == 0) return 0.0;
  const Points twice = laplacian(laplacian(mesh.vertices_mm, mesh.triangles), mesh.triangles);
  const Points normals = vertex_normals(mesh);
  std::vector<bool> is_used(static_cast<std::size_t>(twice.rows()), false);
  for (Eigen::Index k = 0; k < mesh.triangles.size(); ++k)
    is_used[static_cast<std::size_t>(mesh.triangles.data()[k])] = true;
  std::vector<double> across_mm;
  for (Eigen::Index v = 0; v < twice.rows(); ++v)
    if (is_used[static_cast<std::size_t>(v)]) across_mm.push_back(std::abs(twice.row(v).dot(normals.row(v))));
  constexpr double median_of_normal = 0.6745;  // of the absolute value, in standard deviations
  // Of independent vertices with six neighbours; what curvature leaves, measured on decimated bones.
  constexpr double gain = 1.36, share_of_sagitta = 0.7;
  return median_of(std::move(across_mm)) / (median_of_normal * gain) - share_of_sagitta * sagitta_mm;
}

// Areas of the boundary loops of a component, each by its vector area, where their middle is in the joint
// space. Loops that share a vertex count as one.
double hole_area_mm2(const Mesh& mesh, const Box& space)
{
  std::map<std::pair<std::int32_t, std::int32_t>, int> directed;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) ++directed[{mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3)}];
  std::map<std::int32_t, std::int32_t> next;
  for (const auto& [edge, n] : directed)
    if (!directed.contains({edge.second, edge.first})) next[edge.first] = edge.second;
  const double all_mm2 = area_mm2(mesh);
  double sum_mm2 = 0.0;
  while (!next.empty()) {
    const Eigen::Vector3d first_mm = mesh.vertices_mm.row(next.begin()->first).transpose();
    Eigen::Vector3d area = Eigen::Vector3d::Zero(), middle_mm = Eigen::Vector3d::Zero();
    double n = 0.0;
    for (auto at = next.begin(); at != next.end();) {
      const Eigen::Vector3d p_mm = mesh.vertices_mm.row(at->first).transpose(),
                            q_mm = mesh.vertices_mm.row(at->second).transpose();
      area += 0.5 * (p_mm - first_mm).cross(q_mm - first_mm);
      middle_mm += p_mm;
      n += 1.0;
      const std::int32_t end = at->second;
      next.erase(at);
      at = next.find(end);
    }
    middle_mm /= n;
    if (is_in(space, middle_mm) && area.norm() < sheet_share * all_mm2) sum_mm2 += area.norm();
  }
  return sum_mm2;
}

void warn_of_component(const std::string& name, const Box& box, const Mesh& whole, const Box& space,
                       std::vector<std::string>& warnings)
{
  const Mesh near = part_in(space, whole);
  // With fewer it is no bone, but a block or a plate.
  constexpr Eigen::Index fewest_triangles = 50;
  const bool is_bone = near.triangles.rows() >= fewest_triangles;
  const double edge_mm = is_bone ? mean_edge_length_mm(near) : 0.0;
  const double arc_mm = is_bone ? sagitta_mm(near) : 0.0;
  const bool is_thin = (box.max_mm - box.min_mm).minCoeff() < thinnest_mm;
  const bool is_judged = is_bone && edge_mm <= (is_thin ? longest_judged_of_thin_mm : longest_judged_edge_mm);
  const double most_noise_mm = edge_mm > long_edge_mm ? largest_noise_of_long_edges_mm : largest_noise_mm;
  if (const double found_mm = is_judged ? noise_mm(near, arc_mm) : 0.0; found_mm > most_noise_mm)
    warnings.push_back(
        name + ": its surface is rough: vertices are about " + short_decimal(found_mm, 3) +
        " mm off it (standard deviation), wanted at most " + shortest_decimal(most_noise_mm) +
        "; noise of 0.1 mm changed the pose by up to 2 degrees and 1 mm, of 0.5 mm by 8 degrees "
        "and 4 mm (schemas/frames.md); smooth the mesh");
  else if (arc_mm > largest_sagitta_mm)
    warnings.push_back(name + ": it is coarse: between the vertices its edges in the joint space, " +
                       short_decimal(edge_mm, 1) + " mm long (mean), are " + short_decimal(arc_mm, 2) +
                       " mm off a smooth surface (median), wanted at most " +
                       shortest_decimal(largest_sagitta_mm) +
                       " mm; bones so coarse, 500 to 1,000 triangles, changed the pose by up to 2 degrees "
                       "and 1 mm (schemas/frames.md); use a finer mesh");
  const double share = hole_area_mm2(whole, space) / area_mm2(whole);
  if (share > largest_hole_share)
    warnings.push_back(name + ": holes of " + short_decimal(100.0 * share, 1) +
                       " % of its surface in the joint space, wanted at most " +
                       shortest_decimal(100.0 * largest_hole_share) +
                       " %; where contact falls into one, the pose changed by up to 2 degrees and 0.5 mm "
                       "(schemas/frames.md); close them");
}

}  // namespace

std::vector<std::string> mesh_warnings(const Job& job, const Case& loaded)
{
  std::vector<std::string> warnings;
  if (job.joint == "other") return warnings;
  std::size_t row = 0;  // of the survey
  for (const BodyIndex index : all_bodies) {
    const Body& body = part_of(loaded, index);
    const Box space = joint_space(index == BodyIndex::reference ? loaded.moving : loaded.reference);
    const std::vector<ComponentJob>& parts = part_of(job, index).components;
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, body.contact);
    for (std::size_t c = 0; c < parts.size(); ++c, ++row) {
      if (parts[c].generate || !parts[c].has_contact) continue;
      warn_of_component(named(loaded.survey[row]), loaded.survey[row].box,
                        select_triangles(body.contact.mesh, rows[c]), space, warnings);
    }
  }
  return warnings;
}

std::string coordinate_warning(const ComponentSurvey& survey, const Points& native, double unit_mm)
{
  constexpr double largest_step_mm = 0.03;
  const bool is_single = (native.array() == native.cast<float>().cast<double>().array()).all();
  if (!is_single || native.rows() == 0) return "";
  const auto largest = static_cast<float>(native.cwiseAbs().maxCoeff());
  const double step_mm =
      unit_mm * static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::max()) - largest);
  if (!(step_mm > largest_step_mm)) return "";
  return survey.body + " component \"" + survey.name + "\" (" + survey.source + "): it is " +
         short_decimal(static_cast<double>(largest) * unit_mm, 0) +
         " mm from the files' origin, where numbers in single precision have steps of " +
         short_decimal(step_mm, 3) + " mm, wanted at most " + shortest_decimal(largest_step_mm) +
         "; steps of 0.06 mm changed the pose by 0.2 degrees, of 1 mm by 2 degrees and 1 mm "
         "(schemas/frames.md); save the meshes near their origin";
}

namespace {

// From mice to whales; a wrong unit gives a factor of 10 to 1000.
SizeRange possible_sizes(const Job& job)
{
  return {job.joint == "knee" ? 3.0 : 1.0, 3000.0};
}

bool is_within(double size_mm, const SizeRange& sizes)
{
  return size_mm >= sizes.least_mm && size_mm <= sizes.most_mm;
}

// The largest mesh file of one object; null if all components are generated.
const ComponentSurvey* largest_file(const BodyJob& body, const ComponentSurvey* survey)
{
  const ComponentSurvey* largest = nullptr;
  for (std::size_t c = 0; c < body.components.size(); ++c) {
    if (body.components[c].generate) continue;
    if (largest == nullptr || diagonal_mm(survey[c].box) > diagonal_mm(largest->box)) largest = &survey[c];
  }
  return largest;
}

}  // namespace

std::string named(const ComponentSurvey& component)
{
  return component.body + " component \"" + component.name + "\" (" + component.source + ")";
}

double diagonal_mm(const Box& box)
{
  return (box.max_mm - box.min_mm).norm();
}

SizeRange usual_size_range(const Job& job)
{
  // Menisci are 40 mm long, a whole tibia 450 mm; other joints range from fingers to hips.
  return job.joint == "knee" ? SizeRange{12.0, 800.0} : SizeRange{3.0, 2000.0};
}

std::string suggested_unit(const std::string& given, double size_mm, const SizeRange& sizes)
{
  for (const char* unit : {"mm", "cm", "m"}) {
    if (is_within(size_mm / mm_per_unit(given) * mm_per_unit(unit), sizes)) return unit;
  }
  return "";
}

void check_unit(const Job& job, const std::vector<ComponentSurvey>& survey)
{
  const std::array files{largest_file(job.reference, survey.data()),
                         largest_file(job.moving, survey.data() + job.reference.components.size())};
  for (std::size_t b = 0; b < files.size(); ++b) {
    const ComponentSurvey* file = files.at(b);
    const ComponentSurvey* other = files.at(1 - b);
    if (file == nullptr) continue;
    const FrameJob& frame = frame_of(job, b == 0 ? job.reference : job.moving);
    const std::string key = frame.key + ".unit";
    const double size_mm = diagonal_mm(file->box);
    if (is_within(size_mm, possible_sizes(job))) continue;
    const std::string unit = suggested_unit(frame.unit, size_mm, usual_size_range(job));
    const std::string found = "\"" + frame.unit + "\", in which \"" + file->name + "\" (" + file->source +
                              ") measures " + short_decimal(size_mm, 3) + " mm across";
    std::string wanted = "meshes of a joint in mm, cm or m";
    if (other != nullptr && is_within(diagonal_mm(other->box), usual_size_range(job))) {
      wanted = "all mesh files in one unit: \"" + other->name + "\" measures " +
               short_decimal(diagonal_mm(other->box), 3) + " mm; convert \"" + file->source + "\" to " +
               frame.unit + (unit.empty() ? "" : ", its size suggests " + unit);
    } else if (!unit.empty()) {
      wanted = key + " = \"" + unit + "\", in which it measures " +
               short_decimal(size_mm / mm_per_unit(frame.unit) * mm_per_unit(unit), 3) + " mm";
    }
    throw InputError({job.document.source_of(key), key, found, wanted});
  }
}

}  // namespace vrda::job
