// The right knee that `vrda prepare` registers.
#include "geometry/template_knee.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "geometry/generic_knee.hpp"
#include "geometry/level_set.hpp"
#include "geometry/nearest_surface.hpp"

namespace vrda::geometry {
namespace {

constexpr double template_cell_mm = 3.0;
constexpr double femur_top_mm = 50.0, tibia_end_mm = -95.0;  // shafts vary considerably between people
constexpr double template_clearance_mm = 2.0;                // of the tibia below the pose of the solids

double union_of(const std::vector<Hull>& hulls, const Eigen::Vector3d& p, double width_mm)
{
  double distance_mm = hulls.front().signed_distance_mm(p);
  for (std::size_t i = 1; i < hulls.size(); ++i)
    distance_mm = smooth_min(distance_mm, hulls[i].signed_distance_mm(p), width_mm);
  return distance_mm;
}

// Solids joined by fillets of 8 mm, hollows with edges rounded over 5 mm. The numbers are rounded from a
// least-squares fit of these solids to points of four knees (results/prepare.md): root mean square 1.1 mm at
// the femur and 1.3 mm at the tibia, mostly variation between people.
constexpr double solid_fillet_mm = 8.0, hollow_edge_mm = 5.0;

double template_femur_field(const Eigen::Vector3d& p)
{
  static const std::vector<Hull> solids = {Hull({{-2.8, -4.7, -22.9}, 17.9}, {{-4.1, -0.8, -22.1}, 18.5}),
                                           Hull({{9.5, -7.8, -20.5}, 17.1}, {{24.1, -1.6, -8.9}, 16.0}),
                                           Hull({{-5.2, -0.6, 17.9}, 17.4}, {{2.3, 1.5, 21.4}, 15.2}),
                                           Hull({{-5.1, -10.7, 23.9}, 12.3}, {{21.2, -8.5, 20.6}, 13.7}),
                                           Hull({{23.4, 9.0, -11.9}, 14.0}, {{25.6, 27.7, -6.4}, 11.0}),
                                           Hull({{32.3, -1.1, 19.5}, 11.3}, {{27.1, 30.5, 15.4}, 8.0}),
                                           Hull({{18.4, 23.3, -11.2}, 10.6}, {{25.2, 50.5, -6.0}, 9.2}),
                                           Hull({{23.9, 29.4, 10.4}, 15.1}, {{25.2, 51.6, 11.4}, 13.4}),
                                           Hull({{10.7, 6.5, -16.4}, 9.0}, {{16.9, 3.7, 10.9}, 21.7}),
                                           Hull({{5.9, 7.3, -30.6}, 11.2}, {{5.6, 13.3, -32.2}, 7.9}),
                                           Hull({{0.9, 4.5, 31.6}, 6.7}, {{5.0, 14.3, 23.0}, 6.5}),
                                           Hull({{11.8, 8.4, -20.9}, 15.1}, {{19.3, 42.0, -9.7}, 4.2}),
                                           Hull({{9.6, 15.7, 19.0}, 10.5}, {{15.3, 44.8, 17.9}, 6.9}),
                                           Hull({{20.4, 21.0, 1.1}, 12.1}, {{26.7, 42.3, -1.0}, 12.0})};
  static const std::vector<Hull> hollows = {Hull({{-28.7, -15.5, 0.5}, 8.4}, {{0.2, -7.6, -3.0}, 7.9}),
                                            Hull({{-25.6, -0.4, 1.4}, 8.1}, {{-5.5, 0.5, -3.5}, 9.1})};
  const double whole =
      smooth_max(union_of(solids, p, solid_fillet_mm), -union_of(hollows, p, hollow_edge_mm), hollow_edge_mm);
  return smooth_max(whole, p.y() - femur_top_mm, 2.0);
}

double template_tibia_field(const Eigen::Vector3d& p)
{
  static const std::vector<Hull> solids = {Hull({{-6.9, -30.1, -19.9}, 9.3}, {{12.8, -32.3, -7.6}, 15.6}),
                                           Hull({{-4.4, -37.2, 27.7}, 11.1}, {{15.6, -41.1, 22.9}, 13.9}),
                                           Hull({{2.1, -32.5, -8.4}, 23.5}, {{13.5, -40.6, 6.8}, 19.7}),
                                           Hull({{3.5, -39.3, -13.9}, 11.7}, {{7.6, -85.9, -7.2}, 8.8}),
                                           Hull({{7.9, -33.6, 23.2}, 15.0}, {{12.6, -82.3, 2.7}, 8.2}),
                                           Hull({{10.8, -54.4, 1.6}, 16.5}, {{10.8, -119.8, -1.9}, 9.9}),
                                           Hull({{25.6, -53.6, 12.0}, 12.6}, {{24.2, -85.2, 5.8}, 9.2}),
                                           Hull({{-5.4, -34.4, 17.1}, 10.8}, {{0.6, -54.5, 14.7}, 2.0})};
  // The first two are the plateaus.
  static const std::vector<Hull> hollows = {Hull({{-14.8, 9.2, -21.6}, 36.9}, {{16.0, 11.5, -22.0}, 33.3}),
                                            Hull({{-10.0, 50.2, 21.5}, 70.8}, {{14.8, 47.6, 20.6}, 72.8}),
                                            Hull({{-30.0, -31.4, 0.3}, 5.3}, {{-20.0, -21.4, -1.5}, 12.3}),
                                            Hull({{30.9, -16.8, -1.3}, 9.2}, {{40.0, -10.0, 0.0}, 8.0})};
  static const std::vector<Hull> spines = {Hull({{-1.6, -25.7, -5.7}, 3.4}, {{3.2, -24.8, -3.8}, 5.3}),
                                           Hull({{-1.6, -24.7, 8.3}, 5.2}, {{3.9, -27.3, 16.0}, 6.3})};
  const double head =
      smooth_max(union_of(solids, p, solid_fillet_mm), -union_of(hollows, p, hollow_edge_mm), hollow_edge_mm);
  const double whole = smooth_min(head, union_of(spines, p, hollow_edge_mm), hollow_edge_mm);
  return smooth_max(whole, tibia_end_mm - p.y(), 2.0);
}

// Stiffness and reference strain as in knee.cpp. Attachments are evenly spaced between two points.
std::vector<Bundle> template_bundles()
{
  return {
      {"ACLam", 3, 4920, -0.112, {0, 3, 3}, {-1, 1, 5}, {16, -21, -4}, {15, -22, -1}, template_tibia_field},
      {"ACLpl", 3, 4920, -0.030, {-3, -1, 7}, {-1, -4, 6}, {11, -21, 1}, {13, -22, 4}, template_tibia_field},
      {"PCLal",
       3,
       4500,
       -0.020,
       {5, -3, -8},
       {6, -5, -6},
       {-12, -28, 3},
       {-13, -30, -1},
       template_tibia_field},
      {"PCLpm",
       3,
       1500,
       -0.094,
       {3, -7, -10},
       {5, -7, -9},
       {-14, -32, -2},
       {-15, -32, -6},
       template_tibia_field},
      {"MCLs",
       4,
       3000,
       0.047,
       {0, 9, -40},
       {4, 12, -40},
       {4, -60, -19},
       {12, -66, -16},
       template_tibia_field},
      {"MCLd", 3, 2500, 0.016, {0, 1, -38}, {3, 2, -38}, {0, -32, -31}, {5, -32, -31}, template_tibia_field},
      {"MCLp",
       3,
       2500,
       0.030,
       {-7, -7, -35},
       {-5, -9, -35},
       {-16, -36, -25},
       {-13, -36, -27},
       template_tibia_field},
      {"LCL", 4, 2400, 0.060, {-2, 3, 36}, {0, 5, 36}, {-15, -47, 43}, {-12, -49, 45}, fibula_field},
  };
}

}  // namespace

// By direction from the flexion axis: the condyles from behind to the front, then the trochlea.
bool is_articular_femur(const Eigen::Vector3d& p, const Eigen::Vector3d& normal)
{
  const Eigen::Vector3d from_axis(p.x() - 4.0, p.y() - 6.0, 0.0);
  const double upward_deg = deg_from_rad(arc_tangent2(from_axis.y(), from_axis.x()));
  if (upward_deg > 0.0 && upward_deg < 50.0) return normal.x() > 0.3 && std::abs(p.z()) < 22.0;
  if (upward_deg >= 50.0 && upward_deg < 160.0) return false;
  return normal.dot(from_axis.normalized()) > 0.6 && std::abs(p.z()) < 32.0;
}

bool is_articular_tibia(const Eigen::Vector3d& p, const Eigen::Vector3d& normal)
{
  const double u = p.x() / 20.0, w = (std::abs(p.z()) - 19.0) / 15.0;
  return normal.y() > 0.6 && u * u + w * w < 1.0;
}

Shape right_template_knee()
{
  Shape shape;
  const Mesh femur =
      level_set_mesh(template_femur_field, {{-60, -60, -70}, {70, 60, 70}}, {template_cell_mm});
  const Mesh tibia =
      level_set_mesh(template_tibia_field, {{-60, -105, -70}, {70, 10, 70}}, {template_cell_mm});
  shape.reference = {{"femur", "bone", true, femur}};
  shape.moving = {{"tibia", "bone", true, tibia}, {"fibula", "bone", false, fibula_mesh(1.0)}};
  for (ShapePart& part : shape.moving) part.mesh.vertices_mm.col(1).array() -= template_clearance_mm;
  return shape;
}

const char* const template_knee_fibre_sources =
    "# Ligaments of the knee that vrda prepare registers; mm in canonical axes: X anterior, Y proximal, Z to "
    "the subject's right.\n"
    "# Stiffness and reference strain of each bundle in extension: Lenhart et al. 2015, Ann Biomed Eng "
    "43:2675-2685,\n"
    "# means over the bundle. Tension: Blankevoort et al. 1991, J Biomech 24:1019-1031, transition strain "
    "0.06.\n";

std::vector<ShapeFibre> right_template_knee_fibres()
{
  return fibres_of(template_bundles(), template_femur_field, template_clearance_mm);
}

// The knee that is registered where no other template is given.

namespace {

BoneSurfaces divided(const Mesh& mesh, bool (*is_articular)(const Eigen::Vector3d&, const Eigen::Vector3d&))
{
  std::vector<Eigen::Index> bone, cartilage;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    (is_articular((a + b + c) / 3.0, face_normal(mesh, t)) ? cartilage : bone).push_back(t);
  }
  return {select_triangles(mesh, bone), select_triangles(mesh, cartilage)};
}

}  // namespace

TemplateKnee generic_template()
{
  const geometry::Shape knee = geometry::right_template_knee();
  return {{divided(knee.reference.front().mesh, geometry::is_articular_femur),
           divided(knee.moving.front().mesh, geometry::is_articular_tibia)},
          Eigen::Vector3d::Zero()};
}

namespace {

// Second-largest extent of the vertices along their principal axes.
double second_extent(const Mesh& mesh)
{
  const Eigen::RowVector3d mean = mesh.vertices_mm.colwise().mean();
  const Points off = mesh.vertices_mm.rowwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(Eigen::Matrix3d(off.transpose() * off));
  const Points along = off * axes.eigenvectors();
  Eigen::Vector3d extent = along.colwise().maxCoeff() - along.colwise().minCoeff();
  std::sort(extent.begin(), extent.end());
  return extent[1];
}

struct NearPart {
  double nearest_sq_mm2 = std::numeric_limits<double>::infinity();
  Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
};

// The part of `points` that is nearest to `other`: within 6 mm of the smallest distance, or within 8 mm.
NearPart part_near(const SurfacePoints& points, const PointTree& other)
{
  std::vector<double> distance;
  for (const auto& p : points.positions_mm.rowwise())
    distance.push_back(std::sqrt(other.nearest(p, Eigen::Vector3d::Zero(), -1.1).distance_sq_mm2));
  const double least = *std::min_element(distance.begin(), distance.end());
  NearPart part{least * least};
  int n = 0;
  for (std::size_t i = 0; i < distance.size(); ++i) {
    if (distance[i] > std::max(least + 6.0, 8.0)) continue;
    part.mean_mm += points.positions_mm.row(static_cast<Eigen::Index>(i));
    ++n;
  }
  part.mean_mm /= n;
  return part;
}

Eigen::Vector3d mean_within(const SurfacePoints& points, const Eigen::Vector3d& centre_mm, double radius_mm)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int n = 0;
  for (const auto& p : points.positions_mm.rowwise()) {
    if ((p.transpose() - centre_mm).squaredNorm() > radius_mm * radius_mm) continue;
    sum += p;
    ++n;
  }
  return n == 0 ? centre_mm : Eigen::Vector3d(sum / n);
}

}  // namespace

void reverse_winding(Mesh& mesh)
{
  for (auto row : mesh.triangles.rowwise()) std::swap(row[1], row[2]);
  mesh.normals *= -1.0;
}

Mesh joined(const BoneSurfaces& surfaces)
{
  Mesh mesh = surfaces.bone;
  append(mesh, surfaces.cartilage);
  return mesh;
}

KneeSurfaces mirrored_z(const KneeSurfaces& knee)
{
  const auto mirrored = [](const BoneSurfaces& bone) {
    return BoneSurfaces{mirrored_z(bone.bone), mirrored_z(bone.cartilage)};
  };
  return {mirrored(knee.femur), mirrored(knee.tibia)};
}

double unit_mm_of(const Mesh& femur, const Mesh& tibia)
{
  constexpr double joint_mm = 75.0;
  const double width = std::sqrt(second_extent(femur) * second_extent(tibia));
  double best = 1.0, best_ratio = std::numeric_limits<double>::infinity();
  for (const double unit_mm : {1.0, 10.0, 1000.0}) {
    const double ratio = std::max(width * unit_mm / joint_mm, joint_mm / (width * unit_mm));
    if (ratio >= best_ratio) continue;
    best = unit_mm;
    best_ratio = ratio;
  }
  return best;
}

JointRegion joint_region(const Mesh& femur, const Mesh& tibia)
{
  constexpr int n_samples = 6000;     // 3 to 4 mm apart on a whole tibia
  constexpr double around_mm = 55.0;  // of the joint, where shafts weigh little
  const PointTree of_femur(sample_surface(femur, n_samples)), of_tibia(sample_surface(tibia, n_samples));
  const NearPart above = part_near(of_femur.points(), of_tibia);
  const NearPart below = part_near(of_tibia.points(), of_femur);
  JointRegion region;
  region.nearest_mm = std::sqrt(above.nearest_sq_mm2);
  region.centre_mm = 0.5 * (above.mean_mm + below.mean_mm);
  const Eigen::Vector3d up_mm = mean_within(of_femur.points(), region.centre_mm, around_mm) -
                                mean_within(of_tibia.points(), region.centre_mm, around_mm);
  if (up_mm.norm() > 0.0) region.up = up_mm.normalized();
  return region;
}

}  // namespace vrda::geometry
