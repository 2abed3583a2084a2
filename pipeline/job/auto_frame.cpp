#include "job/auto_frame.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/knee_fit.hpp"
#include "geometry/nearest_surface.hpp"
#include "job/clean_mesh.hpp"

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

// Least squares of |p|^2 = 2 c.p + (r^2 - |c|^2), linear in c and in the bracket. `origin_mm`: near the
// points, for precision.
Sphere sphere_through(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& weights,
                      const Eigen::Vector3d& origin_mm)
{
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d p = points[k] - origin_mm;
    const Eigen::Vector4d row(2.0 * p.x(), 2.0 * p.y(), 2.0 * p.z(), 1.0);
    A += weights[k] * row * row.transpose();
    b += weights[k] * p.squaredNorm() * row;
  }
  const Eigen::Vector4d x = A.ldlt().solve(b);
  const Eigen::Vector3d centre = x.head<3>();
  return {origin_mm + centre, std::sqrt(std::max(0.0, x[3] + centre.squaredNorm()))};
}

Sphere fitted(const std::vector<Face>& faces)
{
  std::vector<Eigen::Vector3d> centres_mm;
  std::vector<double> areas_mm2;
  for (const Face& face : faces) {
    centres_mm.push_back(face.centre_mm);
    areas_mm2.push_back(face.area_mm2);
  }
  return sphere_through(centres_mm, areas_mm2, centres_mm.front());
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

// Faces near the sphere with a radial normal, of those whose direction from its centre `is_there`.
template <typename IsThere>
std::vector<Face> faces_near(const std::vector<Face>& faces, const Sphere& sphere, double spread,
                             const IsThere& is_there)
{
  const double tolerance_mm = std::clamp(2.0 * spread, 0.3, 0.5);
  std::vector<Face> chosen;
  for (const Face& face : faces) {
    const Eigen::Vector3d arm = face.centre_mm - sphere.centre_mm;
    const double distance_mm = arm.norm();
    if (std::abs(distance_mm - sphere.radius_mm) > tolerance_mm) continue;
    const Eigen::Vector3d radial = arm / distance_mm;
    if (face.normal.dot(radial) > 0.9 && is_there(radial)) chosen.push_back(face);
  }
  return chosen;
}

bool is_posterior_distal(const Eigen::Vector3d& radial)
{
  return radial.x() < 0.4 && radial.y() < 0.2 && std::abs(radial.z()) < 0.5;
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
    chosen = faces_near(half, sphere, spread_mm(chosen, sphere), is_posterior_distal);
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

namespace {

constexpr double facing_band_mm = 4.0;  // cartilage of both sides together
constexpr Eigen::Index most_samples = 2000;
constexpr std::size_t fewest_facing = 20;
// Femoral heads deviate from spheres by up to 1 to 2 mm on radii of 20 to 28 mm.
constexpr double ball_rms_share = 0.04;
constexpr double smallest_ball_mm = 5.0;
constexpr double largest_ball_mm = 60.0;
// Length of the mean direction from the centre: (1 + cos a) / 2 for a cap of half-angle a, here 53 degrees.
constexpr double flattest_cap = 0.8;

std::vector<Eigen::Vector3d> facing_vertices(const Case& loaded)
{
  const geometry::NearestSurface reference(loaded.reference.contact.mesh);
  const Points& vertices = loaded.moving.contact.mesh.vertices_mm;
  if (reference.is_empty()) return {};
  const Eigen::Index step = std::max<Eigen::Index>(1, vertices.rows() / most_samples);
  std::vector<std::pair<double, Eigen::Vector3d>> found;
  double least_mm = std::numeric_limits<double>::infinity();
  for (Eigen::Index v = 0; v < vertices.rows(); v += step) {
    const Eigen::Vector3d p_mm = vertices.row(v);
    geometry::NearestLimits limits;
    limits.max_distance_mm = std::min(least_mm + facing_band_mm, limits.max_distance_mm);
    const geometry::SurfacePoint nearest = reference.nearest(p_mm, limits);
    if (nearest.triangle < 0) continue;
    least_mm = std::min(least_mm, nearest.distance_mm);
    found.emplace_back(nearest.distance_mm, p_mm);
  }
  std::vector<Eigen::Vector3d> facing;
  for (const auto& [distance_mm, p_mm] : found) {
    if (distance_mm <= least_mm + facing_band_mm) facing.push_back(p_mm);
  }
  return facing;
}

}  // namespace

std::optional<BallFit> ball_fit(const Case& loaded)
{
  const std::vector<Eigen::Vector3d> points = facing_vertices(loaded);
  if (points.size() < fewest_facing) return std::nullopt;
  BallFit fit;
  const auto n = static_cast<double>(points.size());
  Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean_mm += p / n;
  fit.sphere = sphere_through(points, std::vector<double>(points.size(), 1.0), mean_mm);
  double sum_sq = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d out = p - fit.sphere.centre_mm;
    sum_sq += (out.norm() - fit.sphere.radius_mm) * (out.norm() - fit.sphere.radius_mm);
    direction += out.normalized() / n;
  }
  fit.rms_mm = std::sqrt(sum_sq / n);
  fit.is_ball = fit.rms_mm <= ball_rms_share * fit.sphere.radius_mm && direction.norm() <= flattest_cap &&
                fit.sphere.radius_mm >= smallest_ball_mm && fit.sphere.radius_mm <= largest_ball_mm;
  return fit;
}

namespace {

// The sphere near `start` through the faces on it; nothing unless they cover a good part of it.
std::optional<Sphere> sphere_of_head(const std::vector<Face>& faces, const BallFit& start)
{
  constexpr int n_rounds = 20;
  constexpr double least_share = 0.2;  // a head without its neck has 0.6, a condyle 0.05
  Sphere sphere = start.sphere;
  double spread = start.rms_mm, area_mm2 = 0.0;
  for (int round = 0; round < n_rounds; ++round) {
    const std::vector<Face> chosen =
        faces_near(faces, sphere, spread, [](const Eigen::Vector3d&) { return true; });
    if (chosen.size() < fewest_facing) return std::nullopt;
    sphere = fitted(chosen);
    spread = spread_mm(chosen, sphere);
    area_mm2 = 0.0;
    for (const Face& face : chosen) area_mm2 += face.area_mm2;
  }
  const bool is_head = sphere.radius_mm >= smallest_ball_mm && sphere.radius_mm <= largest_ball_mm &&
                       area_mm2 >= least_share * 4.0 * pi * sphere.radius_mm * sphere.radius_mm;
  return is_head ? std::optional(sphere) : std::nullopt;
}

}  // namespace

std::optional<Sphere> head_sphere(const Case& loaded)
{
  const std::optional<BallFit> start = ball_fit(loaded);
  if (!start) return std::nullopt;
  const std::optional<Sphere> head = sphere_of_head(faces_of(loaded.moving.contact.mesh), *start);
  return head ? head : sphere_of_head(faces_of(loaded.reference.contact.mesh), *start);
}

std::string joint_shape_warning(const std::string& joint, const Case& loaded)
{
  if (joint == "other") return "";
  const std::optional<BallFit> fit = ball_fit(loaded);
  if (!fit || fit->is_ball == (joint == "hip")) return "";
  const std::string sphere = "one sphere (radius " + short_decimal(fit->sphere.radius_mm, 1) +
                             " mm, off by " + short_decimal(fit->rms_mm, 1) + " mm RMS)";
  if (fit->is_ball)
    return "joint: \"" + joint + "\", but \"" + loaded.moving.name + "\" faces the reference with " + sphere +
           ", as a hip does; write joint = \"hip\", or \"other\" for another ball joint";
  return "joint: \"hip\", but where \"" + loaded.moving.name + "\" faces the reference it is not part of " +
         sphere +
         "; write joint = \"knee\", \"ankle\" or \"subtalar\" if it is one, else \"other\", or check "
         "the meshes and frames";
}

}  // namespace vrda::job
