#include "job/condyles.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace vrda::job {
namespace {

struct Face {
  Eigen::Vector3d centre_mm;
  Eigen::Vector3d normal;
  double area_mm2 = 0.0;
};

std::vector<Face> faces_of(const Mesh& mesh)
{
  std::vector<Face> faces;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    faces.push_back({(a + b + c) / 3.0, face_normal(mesh, t), 0.5 * (b - a).cross(c - a).norm()});
  }
  return faces;
}

// |p|^2 = 2 c.p + (r^2 - |c|^2) is linear in c and in the bracket.
Sphere fitted(const std::vector<Face>& faces)
{
  const Eigen::Vector3d origin = faces.front().centre_mm;  // near the points, for precision
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  for (const Face& face : faces) {
    const Eigen::Vector3d p = face.centre_mm - origin;
    const Eigen::Vector4d row(2.0 * p.x(), 2.0 * p.y(), 2.0 * p.z(), 1.0);
    A += face.area_mm2 * row * row.transpose();
    b += face.area_mm2 * p.squaredNorm() * row;
  }
  const Eigen::Vector4d x = A.ldlt().solve(b);
  const Eigen::Vector3d centre = x.head<3>();
  return {origin + centre, std::sqrt(std::max(0.0, x[3] + centre.squaredNorm()))};
}

double spread_mm(const std::vector<Face>& faces, const Sphere& sphere)
{
  double sum = 0.0, weight = 0.0;
  for (const Face& face : faces) {
    const double residual_mm = (face.centre_mm - sphere.centre_mm).norm() - sphere.radius_mm;
    sum += face.area_mm2 * residual_mm * residual_mm;
    weight += face.area_mm2;
  }
  return std::sqrt(sum / weight);
}

// Faces with a posterior-distal normal in the posterior-distal part of the half; w_mm is the femur's width.
std::vector<Face> initial_faces(const std::vector<Face>& half, double w_mm)
{
  double back_mm = half.front().centre_mm.x(), bottom_mm = half.front().centre_mm.y();
  for (const Face& face : half) {
    back_mm = std::min(back_mm, face.centre_mm.x());
    bottom_mm = std::min(bottom_mm, face.centre_mm.y());
  }
  std::vector<Face> chosen;
  for (const Face& face : half) {
    const bool is_facing = face.normal.x() < 0.3 && face.normal.y() < 0.3 && std::abs(face.normal.z()) < 0.5;
    const bool is_near =
        face.centre_mm.x() < back_mm + 0.45 * w_mm && face.centre_mm.y() < bottom_mm + 0.5 * w_mm;
    if (is_facing && is_near) chosen.push_back(face);
  }
  return chosen;
}

// Faces near the sphere with a radial normal, on its posterior-distal side.
std::vector<Face> faces_near(const std::vector<Face>& half, const Sphere& sphere, double spread)
{
  const double tolerance_mm = std::clamp(2.0 * spread, 0.3, 0.5);
  std::vector<Face> chosen;
  for (const Face& face : half) {
    const Eigen::Vector3d arm = face.centre_mm - sphere.centre_mm;
    const double distance_mm = arm.norm();
    if (std::abs(distance_mm - sphere.radius_mm) > tolerance_mm) continue;
    const Eigen::Vector3d radial = arm / distance_mm;
    const bool is_radial = face.normal.dot(radial) > 0.9;
    if (is_radial && radial.x() < 0.4 && radial.y() < 0.2 && std::abs(radial.z()) < 0.5)
      chosen.push_back(face);
  }
  return chosen;
}

// The thresholds here and above were chosen on four real knees. Nearby values move the midpoint of the
// spheres by about 3 mm; the warning limit is 30 mm.
std::optional<Sphere> condyle_sphere(const std::vector<Face>& half, double w_mm)
{
  constexpr std::size_t fewest_faces = 20;
  constexpr int n_rounds = 20;
  if (half.empty()) return std::nullopt;
  std::vector<Face> chosen = initial_faces(half, w_mm);
  Sphere sphere;
  for (int round = 0; round < n_rounds; ++round) {
    if (chosen.size() < fewest_faces) return std::nullopt;
    sphere = fitted(chosen);
    if (!(sphere.radius_mm > 5.0) || sphere.radius_mm > 60.0 || !sphere.centre_mm.allFinite())
      return std::nullopt;
    chosen = faces_near(half, sphere, spread_mm(chosen, sphere));
  }
  return sphere;
}

Box box_of_faces(const std::vector<Face>& faces)
{
  Box box{faces.front().centre_mm, faces.front().centre_mm};
  for (const Face& face : faces) {
    box.min_mm = box.min_mm.cwiseMin(face.centre_mm);
    box.max_mm = box.max_mm.cwiseMax(face.centre_mm);
  }
  return box;
}

// The distal end of a whole bone, up to 1.2 times its width. Head and trochanter enlarge the box of a whole
// femur, so the width is recomputed from the remaining faces.
std::vector<Face> lower_end(std::vector<Face> faces)
{
  constexpr double height_of_width = 1.2;
  constexpr int n_rounds = 3;
  for (int round = 0; round < n_rounds && !faces.empty(); ++round) {
    const Box box = box_of_faces(faces);
    const double top_mm = box.min_mm.y() + height_of_width * (box.max_mm.z() - box.min_mm.z());
    std::erase_if(faces, [&](const Face& face) { return face.centre_mm.y() > top_mm; });
  }
  return faces;
}

}  // namespace

std::optional<CondyleSpheres> condyle_spheres(const Mesh& femur)
{
  const std::vector<Face> faces = lower_end(faces_of(femur));
  if (faces.empty()) return std::nullopt;
  const Box box = box_of_faces(faces);
  const double middle_z_mm = 0.5 * (box.min_mm.z() + box.max_mm.z());
  const double w_mm = box.max_mm.z() - box.min_mm.z();
  std::vector<Face> left, right;
  for (const Face& face : faces) (face.centre_mm.z() < middle_z_mm ? left : right).push_back(face);
  const std::optional<Sphere> left_sphere = condyle_sphere(left, w_mm);
  const std::optional<Sphere> right_sphere = condyle_sphere(right, w_mm);
  if (!left_sphere || !right_sphere) return std::nullopt;
  return CondyleSpheres{*left_sphere, *right_sphere};
}

}  // namespace vrda::job
