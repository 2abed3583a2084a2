// Warnings about meshes that are too coarse, too noisy or too full of holes for a pose. The thresholds follow
// from measured errors of the pose (schemas/frames.md).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/text.hpp"
#include "job/case_warnings.hpp"

namespace vrda::job {
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
        name + ": its surface is rough: vertices are about " + rounded_text(found_mm, 1000.0) +
        " mm off it (standard deviation), wanted at most " + shortest_decimal(most_noise_mm) +
        "; noise of 0.1 mm changed the pose by up to 2 degrees and 1 mm, of 0.5 mm by 8 degrees "
        "and 4 mm (schemas/frames.md); smooth the mesh");
  else if (arc_mm > largest_sagitta_mm)
    warnings.push_back(name + ": it is coarse: between the vertices its edges in the joint space, " +
                       rounded_text(edge_mm, 10.0) + " mm long (mean), are " + rounded_text(arc_mm, 100.0) +
                       " mm off a smooth surface (median), wanted at most " +
                       shortest_decimal(largest_sagitta_mm) +
                       " mm; bones so coarse, 500 to 1,000 triangles, changed the pose by up to 2 degrees "
                       "and 1 mm (schemas/frames.md); use a finer mesh");
  const double share = hole_area_mm2(whole, space) / area_mm2(whole);
  if (share > largest_hole_share)
    warnings.push_back(name + ": holes of " + rounded_text(100.0 * share, 10.0) +
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
  for (const bool is_reference : {true, false}) {
    const Body& body = is_reference ? loaded.reference : loaded.moving;
    const Box space = joint_space(is_reference ? loaded.moving : loaded.reference);
    const std::vector<ComponentJob>& parts = (is_reference ? job.reference : job.moving).components;
    for (std::size_t c = 0; c < parts.size(); ++c, ++row) {
      if (parts[c].generate || !parts[c].has_contact) continue;
      std::vector<Eigen::Index> rows;
      for (std::size_t t = 0; t < body.contact.component.size(); ++t)
        if (body.contact.component[t] == static_cast<std::int32_t>(c))
          rows.push_back(static_cast<Eigen::Index>(t));
      const ComponentSurvey& survey = loaded.survey[row];
      warn_of_component(survey.body + " component \"" + survey.name + "\" (" + survey.source + ")",
                        survey.box, select_triangles(body.contact.mesh, rows), space, warnings);
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
         rounded_text(static_cast<double>(largest) * unit_mm, 1.0) +
         " mm from the files' origin, where numbers in single precision have steps of " +
         rounded_text(step_mm, 1000.0) + " mm, wanted at most " + shortest_decimal(largest_step_mm) +
         "; steps of 0.06 mm changed the pose by 0.2 degrees, of 1 mm by 2 degrees and 1 mm "
         "(schemas/frames.md); save the meshes near their origin";
}

}  // namespace vrda::job
