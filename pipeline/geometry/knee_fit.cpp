// The right knee that `vrda prepare` registers.
#include "geometry/knee_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "geometry/generic_knee.hpp"
#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

constexpr double template_cell_mm = 3.0;
constexpr double template_max_gradient = 1.42;               // of signed distances, with the next cell
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

PatellaPlace template_patella()
{
  return {.femur = template_femur_field,
          .tibia = template_tibia_field,
          .clearance_mm = template_clearance_mm,
          .shift_mm = {8.6, -6.0, 2.0},
          .tuberosity_shift_mm = {8.0, -14.0, 4.0},
          .cylinder_mm = {8.0, 4.0, 2.0},
          .cylinder_radius_mm = 33.5};
}

Shape right_template_knee()
{
  Shape shape;
  const Mesh femur = level_set_mesh(template_femur_field, {{-60, -60, -70}, {70, 60, 70}},
                                    {template_cell_mm, template_max_gradient});
  const Mesh tibia = level_set_mesh(template_tibia_field, {{-60, -105, -70}, {70, 10, 70}},
                                    {template_cell_mm, template_max_gradient});
  shape.reference = {{"femur", "bone", true, femur}};
  shape.moving = {{"tibia", "bone", true, tibia}, {"fibula", "bone", false, fibula_mesh(1.0)}};
  shape.followers = {{"patella", "bone", true, patella_mesh(1.0, template_patella())}};
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

double joint_width(const Mesh& femur, const Mesh& tibia)
{
  return std::sqrt(second_extent(femur) * second_extent(tibia));
}

double unit_mm_of(const Mesh& femur, const Mesh& tibia)
{
  constexpr double joint_mm = usual_joint_width_mm;
  const double width = joint_width(femur, tibia);
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

namespace {

constexpr double sampled_radius_mm = 70.0, template_radius_mm = 50.0;
constexpr int n_subject = 2500, n_template = 220, n_screened = 55;  // points per bone
constexpr double least_cosine_coarse = 0.34;                        // normals within 70 degrees
constexpr double least_scale = 0.7, most_scale = 1.45;
constexpr double kept_coarse = 0.7, kept_fine = 0.8;
constexpr int n_turns = 12, n_coarse = 8, n_fine = 30;
constexpr std::size_t n_finalists = 4;
constexpr Eigen::Index fewest_pairs = 30;

struct Subject {
  PointTree femur, tibia;
};

struct Bones {
  SurfacePoints femur, tibia;
};

Bones mirrored_z(const Bones& bones)
{
  return {mirrored_z(bones.femur), mirrored_z(bones.tibia)};
}

struct Pairs {
  Points from_mm, to_mm;  // template and subject
  std::vector<double> distance_sq_mm2;
};

// Of a bone's points, their nearest on the subject of the last fit; -1: none.
using NearestRows = std::vector<Eigen::Index>;

void add_pairs(const SurfacePoints& points, const PointTree& subject, const SimilarityFit& fit,
               NearestRows& rows, Pairs& pairs)
{
  rows.resize(static_cast<std::size_t>(points.positions_mm.rows()), -1);
  for (Eigen::Index i = 0; i < points.positions_mm.rows(); ++i) {
    const Eigen::Vector3d p_mm = points.positions_mm.row(i);
    const Eigen::Vector3d placed_mm = fit.scale * fit.R * p_mm + fit.t_mm;
    const Eigen::Vector3d normal = fit.R * points.normals.row(i).transpose();
    Eigen::Index& last = rows[static_cast<std::size_t>(i)];
    const PointTree::Nearest nearest = subject.nearest(placed_mm, normal, least_cosine_coarse, last);
    last = nearest.row;
    if (nearest.row < 0) continue;
    const auto row = static_cast<Eigen::Index>(pairs.distance_sq_mm2.size());
    pairs.from_mm.row(row) = p_mm;
    pairs.to_mm.row(row) = subject.points().positions_mm.row(nearest.row);
    pairs.distance_sq_mm2.push_back(nearest.distance_sq_mm2);
  }
}

struct BoneRows {
  NearestRows femur, tibia;

  bool operator==(const BoneRows&) const = default;
};

Pairs pairs_of(const Bones& bones, const Subject& subject, const SimilarityFit& fit, BoneRows& rows)
{
  const Eigen::Index n = bones.femur.positions_mm.rows() + bones.tibia.positions_mm.rows();
  Pairs pairs{Points(n, 3), Points(n, 3), {}};
  add_pairs(bones.femur, subject.femur, fit, rows.femur, pairs);
  add_pairs(bones.tibia, subject.tibia, fit, rows.tibia, pairs);
  return pairs;
}

// Rows of the nearest `n` pairs.
std::vector<Eigen::Index> nearest_rows(const Pairs& pairs, std::size_t n)
{
  std::vector<Eigen::Index> rows(pairs.distance_sq_mm2.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<Eigen::Index>(i);
  n = std::min(n, rows.size());
  std::nth_element(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(n), rows.end(),
                   [&](Eigen::Index a, Eigen::Index b) {
                     return pairs.distance_sq_mm2[static_cast<std::size_t>(a)] <
                            pairs.distance_sq_mm2[static_cast<std::size_t>(b)];
                   });
  rows.resize(n);
  return rows;
}

// Source: Umeyama (1991) IEEE PAMI 13:376-380. Differs: the scale is limited.
SimilarityFit fitted(const Pairs& pairs, const std::vector<Eigen::Index>& rows)
{
  const Points from = pairs.from_mm(rows, Eigen::all), to = pairs.to_mm(rows, Eigen::all);
  const Eigen::RowVector3d from_mean = from.colwise().mean(), to_mean = to.colwise().mean();
  const Points a = from.rowwise() - from_mean, b = to.rowwise() - to_mean;
  const Eigen::Matrix3d covariance = b.transpose() * a;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1.0, 1.0,
                       (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  SimilarityFit fit;
  fit.R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  fit.scale = std::clamp(svd.singularValues().dot(sign) / a.squaredNorm(), least_scale, most_scale);
  fit.t_mm = to_mean.transpose() - fit.scale * fit.R * from_mean.transpose();
  return fit;
}

double residual_mm(const Pairs& pairs, Eigen::Index n_points, double scale)
{
  // A point without a counterpart counts as 20 mm away.
  constexpr double farthest_sq_mm2 = 400.0;
  std::vector<double> sq(static_cast<std::size_t>(n_points), farthest_sq_mm2);
  for (std::size_t i = 0; i < pairs.distance_sq_mm2.size(); ++i)
    sq[i] = std::min(pairs.distance_sq_mm2[i], farthest_sq_mm2);
  std::sort(sq.begin(), sq.end());
  const auto n = static_cast<std::size_t>(kept_fine * static_cast<double>(n_points));
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) sum += sq[i];
  return std::sqrt(sum / static_cast<double>(n)) / scale;
}

SimilarityFit iterated(const Bones& bones, const Subject& subject, SimilarityFit fit, int n_iterations,
                       double kept)
{
  const Eigen::Index n_points = bones.femur.positions_mm.rows() + bones.tibia.positions_mm.rows();
  BoneRows counterparts, last_counterparts;
  std::vector<Eigen::Index> last_rows;
  Pairs pairs = pairs_of(bones, subject, fit, counterparts);
  for (int i = 0; i < n_iterations; ++i) {
    const auto n = static_cast<std::size_t>(kept * static_cast<double>(n_points));
    const std::vector<Eigen::Index> rows = nearest_rows(pairs, n);
    if (static_cast<Eigen::Index>(rows.size()) < fewest_pairs) return {};
    if (counterparts == last_counterparts && rows == last_rows) break;  // all further fits are this one
    last_counterparts = counterparts;
    last_rows = rows;
    fit = fitted(pairs, rows);
    pairs = pairs_of(bones, subject, fit, counterparts);
  }
  fit.residual_mm = residual_mm(pairs, n_points, fit.scale);
  return fit;
}

// A direction across `up` that moves with the points: that of their largest extent.
Eigen::Vector3d widest_across(const SurfacePoints& points, const Eigen::Vector3d& up)
{
  const Eigen::RowVector3d mean = points.positions_mm.colwise().mean();
  const Points off = points.positions_mm.rowwise() - mean;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - up * up.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
      Eigen::Matrix3d(across * (off.transpose() * off) * across));
  const Eigen::Vector3d widest = axes.eigenvectors().col(2);
  return (widest - widest.dot(up) * up).normalized();
}

Eigen::Matrix3d axes_of(const Eigen::Vector3d& up, const Eigen::Vector3d& across)
{
  Eigen::Matrix3d R;
  R << across, up, across.cross(up);
  return R;
}

// The bones' points within a radius of the joint; those of cartilage alone where only that is known of the
// subject.
Bones template_points(const KneeSurfaces& surfaces, const KneeSurfaces& subject, const Eigen::Vector3d& at_mm,
                      int n_points)
{
  const auto points = [&](const BoneSurfaces& bone, const BoneSurfaces& of_subject) {
    const bool is_cartilage = of_subject.bone.triangles.rows() == 0 && bone.cartilage.triangles.rows() > 0;
    return sample_surface(cropped(is_cartilage ? bone.cartilage : joined(bone), at_mm, template_radius_mm),
                          n_points);
  };
  return {points(surfaces.femur, subject.femur), points(surfaces.tibia, subject.tibia)};
}

bool is_better(const SimilarityFit& a, const SimilarityFit& b)
{
  return a.residual_mm < b.residual_mm;
}

// From each of the turns, the best first.
std::vector<SimilarityFit> coarse_fits(const Bones& bones, const JointRegion& from, const Subject& subject,
                                       const JointRegion& to)
{
  const SurfacePoints both = joined(bones.femur, bones.tibia);
  const SurfacePoints subject_points = joined(subject.femur.points(), subject.tibia.points());
  const Eigen::Matrix3d R_from = axes_of(from.up, widest_across(both, from.up));
  const Eigen::Matrix3d R_to = axes_of(to.up, widest_across(subject_points, to.up));
  std::vector<SimilarityFit> fits;
  for (int k = 0; k < n_turns; ++k) {
    SimilarityFit start;
    start.R = R_to * rotation_y(2.0 * pi * k / n_turns) * R_from.transpose();
    start.t_mm = to.centre_mm - start.R * from.centre_mm;
    fits.push_back(iterated(bones, subject, start, n_coarse, kept_coarse));
  }
  std::sort(fits.begin(), fits.end(), is_better);
  return fits;
}

SimilarityFit best_fit(const Bones& bones, const JointRegion& from, const Subject& subject,
                       const JointRegion& to)
{
  std::vector<SimilarityFit> fits = coarse_fits(bones, from, subject, to);
  fits.resize(n_finalists);
  for (SimilarityFit& fit : fits) {
    if (std::isfinite(fit.residual_mm)) fit = iterated(bones, subject, fit, n_fine, kept_fine);
  }
  return *std::min_element(fits.begin(), fits.end(), is_better);
}

}  // namespace

CoarseFit coarse_fit(const KneeSurfaces& subject, const TemplateKnee& reference, double hopeless_mm)
{
  const Mesh femur = joined(subject.femur), tibia = joined(subject.tibia);
  const JointRegion to = joint_region(femur, tibia);
  const auto sampled = [&](const Mesh& mesh) {
    return PointTree(sample_surface(cropped(mesh, to.centre_mm, sampled_radius_mm), n_subject));
  };
  const Subject points{sampled(femur), sampled(tibia)};
  const KneeSurfaces& surfaces = reference.surfaces;
  const JointRegion from = joint_region(joined(surfaces.femur), joined(surfaces.tibia));
  JointRegion mirrored_from = from;
  mirrored_from.centre_mm.z() *= -1.0;
  mirrored_from.up.z() *= -1.0;
  const auto right_points = [&](int n) { return template_points(surfaces, subject, from.centre_mm, n); };
  CoarseFit fit;
  fit.nearest_mm = to.nearest_mm;
  if (std::isfinite(hopeless_mm)) {
    const Bones few = right_points(n_screened);
    const auto residual = [&](const Bones& bones, const JointRegion& at) {
      return coarse_fits(bones, at, points, to).front().residual_mm;
    };
    if (std::min(residual(few, from), residual(mirrored_z(few), mirrored_from)) > hopeless_mm) return fit;
  }
  const Bones right = right_points(n_template);
  fit.right = best_fit(right, from, points, to);
  fit.left = best_fit(mirrored_z(right), mirrored_from, points, to);
  return fit;
}

namespace {

constexpr double farthest_pair_mm = 20.0;
constexpr double least_pair_cosine = 0.4;
constexpr double capped_mm = 5.0;
// mm^2 per point and squared relative deviation of a scale from the mean of the three: a deviation of 5 %
// costs as much as 0.13 mm on every point.
constexpr double anisotropy_weight_mm2 = 7.0;
// The same for deviations from the start's scales: cartilage determines its height better than its width.
const Eigen::Vector3d near_start_weight_mm2(100.0, 10.0, 100.0);
constexpr double known_share = 0.01;  // of the surface's weight
constexpr double doubtful_mm = 15.0;  // landmarks are located to about 5 mm

struct Pair {
  Eigen::Vector3d from_mm;  // template
  Eigen::Vector3d at_mm;    // template placed
  Eigen::Vector3d to_mm;    // subject
  Eigen::Vector3d normal;   // of the subject
  double distance_sq_mm2;
  double weight;
};

double weight_sum(const std::vector<Pair>& pairs)
{
  double sum = 0.0;
  for (const Pair& pair : pairs) sum += pair.weight;
  return sum;
}

// Three pairs a point, one along each axis.
void add_known(std::vector<Pair>& pairs, const std::vector<KnownPoint>& known, const BoneFit& fit)
{
  const double weight = known_share * weight_sum(pairs);
  for (const KnownPoint& point : known) {
    const Eigen::Vector3d at_mm = fit(point.template_mm);
    const double distance_sq_mm2 = (at_mm - point.subject_mm).squaredNorm();
    const double trust = 1.0 / (1.0 + distance_sq_mm2 / (doubtful_mm * doubtful_mm));
    for (Eigen::Index k = 0; k < 3; ++k)
      pairs.push_back({point.template_mm, at_mm, point.subject_mm, Eigen::Vector3d::Unit(k), distance_sq_mm2,
                       weight * trust * trust});
  }
}

// The direction to the nearest point of a surface is along its normal, except where the surface ends: 0
// there. The transition is gradual, since pairs that appear or disappear at once cause local optima.
double weight_at_border(const Eigen::Vector3d& off_mm, const Eigen::Vector3d& normal)
{
  constexpr double base_mm = 1.0, slope = 0.35;  // of facets and of noise
  const double across_mm = (off_mm - off_mm.dot(normal) * normal).norm();
  return std::clamp(2.0 - 2.0 * across_mm / (base_mm + slope * off_mm.norm()), 0.0, 1.0);
}

// None if stopped.
std::vector<Pair> all_pairs(const SurfacePoints& points, const NearestSurface& subject, const BoneFit& fit,
                            const BoneFitOptions& options)
{
  std::vector<Pair> pairs;
  for (Eigen::Index i = 0; i < points.positions_mm.rows(); ++i) {
    if (options.is_stopped && options.is_stopped()) return {};
    const Eigen::Vector3d from_mm = points.positions_mm.row(i), at_mm = fit(from_mm);
    const SurfacePoint nearest = subject.nearest(
        at_mm, {farthest_pair_mm, least_pair_cosine, fit.normal(points.normals.row(i).transpose())});
    if (nearest.triangle < 0) continue;
    const double weight = weight_at_border(at_mm - nearest.p_mm, subject.normal(nearest.triangle));
    if (weight == 0.0) continue;
    pairs.push_back({from_mm, at_mm, nearest.p_mm, subject.normal(nearest.triangle),
                     nearest.distance_mm * nearest.distance_mm, weight});
  }
  return pairs;
}

// The farthest of the pairs kept weigh little.
void keep_nearest(std::vector<Pair>& pairs, double kept)
{
  const auto n = static_cast<std::ptrdiff_t>(kept * static_cast<double>(pairs.size()));
  std::nth_element(pairs.begin(), pairs.begin() + n, pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.distance_sq_mm2 < b.distance_sq_mm2; });
  pairs.resize(static_cast<std::size_t>(n));
  double farthest_sq_mm2 = 0.0;
  for (const Pair& pair : pairs) farthest_sq_mm2 = std::max(farthest_sq_mm2, pair.distance_sq_mm2);
  for (Pair& pair : pairs)
    pair.weight *= farthest_sq_mm2 > 0.0 ? 1.0 - pair.distance_sq_mm2 / farthest_sq_mm2 : 1.0;
}

void set_residuals(BoneFit& fit, const SurfacePoints& points, const NearestSurface& subject,
                   const BoneFitOptions& options)
{
  std::vector<Pair> pairs = all_pairs(points, subject, fit, options);
  const auto n = static_cast<double>(points.positions_mm.rows());
  double sum = capped_mm * capped_mm * (n - static_cast<double>(pairs.size()));
  for (const Pair& pair : pairs) sum += std::min(pair.distance_sq_mm2, capped_mm * capped_mm);
  for (const KnownPoint& point : options.known) {
    const double off_sq_mm2 = (fit(point.template_mm) - point.subject_mm).squaredNorm();
    sum += known_share * n * std::min(off_sq_mm2, doubtful_mm * doubtful_mm);
  }
  fit.mismatch_mm = std::sqrt(sum / n);
  keep_nearest(pairs, options.kept);
  sum = 0.0;
  for (const Pair& pair : pairs) sum += pair.distance_sq_mm2;
  fit.residual_mm = std::sqrt(sum / static_cast<double>(pairs.size())) / fit.scale.mean();
}

Eigen::Matrix3d small_rotation(const Eigen::Vector3d& w_rad)
{
  const Eigen::Vector3d half = 0.5 * w_rad;
  return Eigen::Quaterniond(1.0, half.x(), half.y(), half.z()).normalized().toRotationMatrix();
}

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

Eigen::Index n_scales(ScaleFreedom freedom)
{
  return freedom == ScaleFreedom::held ? 0 : freedom == ScaleFreedom::similarity ? 1 : 3;
}

// Adds the prior on the scales, in units of the pairs' weight.
void add_prior(Matrix9d& H, Vector9d& g, double weight, const Eigen::Vector3d& scale, ScaleFreedom freedom,
               const Eigen::Vector3d& start)
{
  Eigen::Matrix3d curvature = weight * near_start_weight_mm2.asDiagonal().toDenseMatrix();
  if (freedom == ScaleFreedom::axes)
    curvature =
        weight * anisotropy_weight_mm2 * (Eigen::Matrix3d::Identity() - Eigen::Matrix3d::Constant(1.0 / 3.0));
  H.bottomRightCorner<3, 3>() += curvature;
  g.tail<3>() += curvature * (freedom == ScaleFreedom::axes ? scale : scale - start);
}

// One Gauss-Newton step; returns the length of the motion in mm and rad.
double advance(BoneFit& fit, const std::vector<Pair>& pairs, ScaleFreedom freedom,
               const Eigen::Vector3d& start)
{
  const bool has_axes = n_scales(freedom) == 3;
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  for (const Pair& pair : pairs) centre_mm += pair.at_mm;
  centre_mm /= static_cast<double>(pairs.size());
  Matrix9d H = Matrix9d::Zero();
  Vector9d g = Vector9d::Zero();
  for (const Pair& pair : pairs) {
    Vector9d slope = Vector9d::Zero();
    slope.head<3>() = (pair.at_mm - centre_mm).cross(pair.normal);
    slope.segment<3>(3) = pair.normal;
    const Eigen::Vector3d of_scale = (fit.R.transpose() * pair.normal).cwiseProduct(pair.from_mm);
    if (has_axes) slope.tail<3>() = of_scale;
    if (freedom == ScaleFreedom::similarity) slope[6] = of_scale.dot(fit.scale) / fit.scale.mean();
    const double off_mm = pair.normal.dot(pair.at_mm - pair.to_mm);
    H += pair.weight * slope * slope.transpose();
    g += pair.weight * off_mm * slope;
  }
  if (has_axes) add_prior(H, g, weight_sum(pairs), fit.scale, freedom, start);
  const Eigen::Index n = 6 + n_scales(freedom);
  // Keeps a bone of revolution solvable; a thousandth of a micrometre on a real one.
  H.diagonal().array() += 1e-9 * H.trace();
  const Eigen::VectorXd step = -H.topLeftCorner(n, n).ldlt().solve(g.head(n));
  const Eigen::Matrix3d turn = small_rotation(step.head<3>());
  fit.t_mm = turn * (fit.t_mm - centre_mm) + centre_mm + step.segment<3>(3);
  fit.R = turn * fit.R;
  if (has_axes) fit.scale += step.tail<3>();
  if (freedom == ScaleFreedom::similarity) fit.scale *= 1.0 + step[6] / fit.scale.mean();
  fit.scale = fit.scale.cwiseMax(0.5).cwiseMin(2.0);
  return step.norm();
}

void iterate(BoneFit& fit, const SurfacePoints& points, const NearestSurface& subject, ScaleFreedom freedom,
             const BoneFitOptions& options, int n)
{
  constexpr double smallest_step = 1e-5;
  const Eigen::Vector3d start = fit.scale;
  constexpr std::size_t fewest = 50;
  for (int i = 0; i < n; ++i) {
    std::vector<Pair> pairs = all_pairs(points, subject, fit, options);
    keep_nearest(pairs, options.kept);
    if (pairs.size() < fewest) break;
    add_known(pairs, options.known, fit);
    if (advance(fit, pairs, freedom, start) < smallest_step) break;
  }
}

// Every fourth point.
SurfacePoints quarter_of(const SurfacePoints& points)
{
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < points.positions_mm.rows(); i += 4) rows.push_back(i);
  return {points.positions_mm(rows, Eigen::all), points.normals(rows, Eigen::all)};
}

}  // namespace

BoneFit fit_bone(const SurfacePoints& template_points, const NearestSurface& subject,
                 const std::vector<BoneFit>& starts, const BoneFitOptions& options)
{
  const ScaleFreedom first =
      options.freedom == ScaleFreedom::axes ? ScaleFreedom::similarity : ScaleFreedom::held;
  const SurfacePoints few = quarter_of(template_points);
  std::vector<BoneFit> fits = starts;
  for (BoneFit& fit : fits) {
    iterate(fit, few, subject, first, options, 12);
    set_residuals(fit, few, subject, options);
  }
  BoneFit fit = *std::min_element(fits.begin(), fits.end(), [](const BoneFit& a, const BoneFit& b) {
    return a.mismatch_mm < b.mismatch_mm;
  });
  iterate(fit, template_points, subject, first, options, first == ScaleFreedom::held ? 60 : 15);
  if (n_scales(options.freedom) == 3) iterate(fit, template_points, subject, options.freedom, options, 40);
  set_residuals(fit, template_points, subject, options);
  return fit;
}

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
  for_each_index(2, options.n_threads, [&] {
    return [&](std::size_t bone) {
      if (bone == 0 && !femur_last) fit.femur = free(femur);
      if (bone == 1 && !tibia_last) fit.tibia = free(tibia);
    };
  });
  if (tibia_last) fit.tibia = near_other(tibia, fit.femur);
  if (femur_last) fit.femur = near_other(femur, fit.tibia);
}

// With the subject enlarged by 1 / size.
KneeFit fit_at_size(const KneeSurfaces& subject, const TemplateKnee& reference, const KneeFitOptions& options,
                    double unit_mm, double size)
{
  KneeFit fit;
  fit.unit_mm = unit_mm / size;
  KneeSurfaces in_mm = subject;
  scale_unit(in_mm, fit.unit_mm);
  const CoarseFit coarse = fit_in_flexion(in_mm, reference);
  const bool is_left =
      options.side ? *options.side == Side::left : coarse.left.residual_mm < coarse.right.residual_mm;
  fit.side = is_left ? Side::left : Side::right;
  const SimilarityFit& chosen = is_left ? coarse.left : coarse.right;
  fit.coarse_residual_mm = chosen.residual_mm;
  fit.nearest_mm = coarse.nearest_mm * size;
  fit.side_margin = (is_left ? coarse.right : coarse.left).residual_mm / chosen.residual_mm;
  TemplateKnee own_side = reference;
  if (is_left) {
    own_side.surfaces = mirrored_z(reference.surfaces);
    own_side.origin_mm.z() *= -1.0;
  }
  fit_bones(fit, in_mm, own_side, chosen, options);
  for (BoneFit* bone : {&fit.femur, &fit.tibia}) {
    bone->scale *= size;
    bone->t_mm *= size;
  }
  fit.unit_mm = unit_mm;
  fit.size = size;
  fit.X_scan_femur = frame_of(fit.femur, own_side.origin_mm);
  fit.X_scan_tibia = frame_of(fit.tibia, own_side.origin_mm);
  fit.scanned =
      clinical_coordinates(fit.X_scan_femur.inverse() * fit.X_scan_tibia, fit.side, Eigen::Vector3d::Zero());
  return fit;
}

}  // namespace

KneeFit fit_knee(const KneeSurfaces& subject, const TemplateKnee& reference, const KneeFitOptions& options)
{
  constexpr double smaller = 0.8;
  const Mesh femur = joined(subject.femur), tibia = joined(subject.tibia);
  const double unit_mm = options.unit_mm ? *options.unit_mm : unit_mm_of(femur, tibia);
  KneeFit fit = fit_at_size(subject, reference, options, unit_mm, 1.0);
  const bool is_stopped = options.is_stopped && options.is_stopped();
  const double size = joint_width(femur, tibia) * unit_mm / usual_joint_width_mm;
  const bool is_child = size >= least_knee_size && size < smaller;
  if (is_stopped || !is_child || rejection_reasons(fit, subject).empty()) return fit;
  KneeFit child = fit_at_size(subject, reference, options, unit_mm, size);
  return rejection_reasons(child, subject).empty() ? child : fit;
}

}  // namespace vrda::geometry
