#include "geometry/coarse_fit.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "geometry/surface_points.hpp"

namespace vrda::geometry {
namespace {

constexpr double sampled_radius_mm = 70.0, template_radius_mm = 50.0;
constexpr int n_subject = 2500, n_template = 220;  // points per bone
constexpr double least_cosine_coarse = 0.34;       // normals within 70 degrees
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

struct Pairs {
  Points from_mm, to_mm;  // template and subject
  std::vector<double> distance_sq_mm2;
};

void add_pairs(const SurfacePoints& points, const PointTree& subject, const SimilarityFit& fit, Pairs& pairs)
{
  for (Eigen::Index i = 0; i < points.positions_mm.rows(); ++i) {
    const Eigen::Vector3d p_mm = points.positions_mm.row(i);
    const Eigen::Vector3d placed_mm = fit.scale * fit.R * p_mm + fit.t_mm;
    const Eigen::Vector3d normal = fit.R * points.normals.row(i).transpose();
    const PointTree::Nearest nearest = subject.nearest(placed_mm, normal, least_cosine_coarse);
    if (nearest.row < 0) continue;
    const auto row = static_cast<Eigen::Index>(pairs.distance_sq_mm2.size());
    pairs.from_mm.row(row) = p_mm;
    pairs.to_mm.row(row) = subject.points().positions_mm.row(nearest.row);
    pairs.distance_sq_mm2.push_back(nearest.distance_sq_mm2);
  }
}

Pairs pairs_of(const Bones& bones, const Subject& subject, const SimilarityFit& fit)
{
  const Eigen::Index n = bones.femur.positions_mm.rows() + bones.tibia.positions_mm.rows();
  Pairs pairs{Points(n, 3), Points(n, 3), {}};
  add_pairs(bones.femur, subject.femur, fit, pairs);
  add_pairs(bones.tibia, subject.tibia, fit, pairs);
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
  for (int i = 0; i < n_iterations; ++i) {
    const Pairs pairs = pairs_of(bones, subject, fit);
    const auto n = static_cast<std::size_t>(kept * static_cast<double>(n_points));
    const std::vector<Eigen::Index> rows = nearest_rows(pairs, n);
    if (static_cast<Eigen::Index>(rows.size()) < fewest_pairs) return {};
    fit = fitted(pairs, rows);
  }
  fit.residual_mm = residual_mm(pairs_of(bones, subject, fit), n_points, fit.scale);
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
Bones template_points(const KneeSurfaces& surfaces, const KneeSurfaces& subject, const Eigen::Vector3d& at_mm)
{
  const auto points = [&](const BoneSurfaces& bone, const BoneSurfaces& of_subject) {
    const bool is_cartilage = of_subject.bone.triangles.rows() == 0 && bone.cartilage.triangles.rows() > 0;
    return sample_surface(cropped(is_cartilage ? bone.cartilage : joined(bone), at_mm, template_radius_mm),
                          n_template);
  };
  return {points(surfaces.femur, subject.femur), points(surfaces.tibia, subject.tibia)};
}

SimilarityFit best_fit(const Bones& bones, const JointRegion& from, const Subject& subject,
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
  const auto is_better = [](const SimilarityFit& a, const SimilarityFit& b) {
    return a.residual_mm < b.residual_mm;
  };
  std::sort(fits.begin(), fits.end(), is_better);
  fits.resize(n_finalists);
  for (SimilarityFit& fit : fits) {
    if (std::isfinite(fit.residual_mm)) fit = iterated(bones, subject, fit, n_fine, kept_fine);
  }
  return *std::min_element(fits.begin(), fits.end(), is_better);
}

}  // namespace

CoarseFit coarse_fit(const KneeSurfaces& subject, const TemplateKnee& reference)
{
  const Mesh femur = joined(subject.femur), tibia = joined(subject.tibia);
  const JointRegion to = joint_region(femur, tibia);
  const auto sampled = [&](const Mesh& mesh) {
    return PointTree(sample_surface(cropped(mesh, to.centre_mm, sampled_radius_mm), n_subject));
  };
  const Subject points{sampled(femur), sampled(tibia)};
  const KneeSurfaces& surfaces = reference.surfaces;
  JointRegion from = joint_region(joined(surfaces.femur), joined(surfaces.tibia));
  const Bones right = template_points(surfaces, subject, from.centre_mm);
  CoarseFit fit;
  fit.nearest_mm = to.nearest_mm;
  fit.right = best_fit(right, from, points, to);
  from.centre_mm.z() *= -1.0;
  from.up.z() *= -1.0;
  fit.left = best_fit({mirrored_z(right.femur), mirrored_z(right.tibia)}, from, points, to);
  return fit;
}

}  // namespace vrda::geometry
