#include "prepare/joint_frame.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/nearest_surface.hpp"
#include "job/auto_frame.hpp"
#include "job/job.hpp"

namespace vrda::prepare {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::PointTree;
using geometry::SurfacePoints;

constexpr double undetermined = 0.1;  // sines below it do not determine a direction

struct Faces {
  Points centres_mm, normals;
  Eigen::VectorXd areas_mm2;

  Index size() const { return areas_mm2.size(); }
  Vector3d centre(Index i) const { return centres_mm.row(i); }
  Vector3d normal(Index i) const { return normals.row(i); }
};

Faces faces_of(const Mesh& mesh)
{
  const Index n = mesh.triangles.rows();
  Faces faces{Points(n, 3), Points(n, 3), Eigen::VectorXd(n)};
  for (Index t = 0; t < n; ++t) {
    const auto [a, b, c] = corners(mesh, t);
    faces.centres_mm.row(t) = (a + b + c) / 3.0;
    faces.normals.row(t) = face_normal(mesh, t);
    faces.areas_mm2[t] = 0.5 * (b - a).cross(c - a).norm();
  }
  return faces;
}

Mesh in_mm(Mesh mesh, double unit_mm)
{
  mesh.vertices_mm *= unit_mm;
  return mesh;
}

Vector3d across(const Vector3d& v, const Vector3d& axis)
{
  return (v - v.dot(axis) * axis).normalized();
}

struct Line {
  Vector3d p_mm = Vector3d::Zero(), direction = Vector3d::UnitY();
};

// Weighted sums over faces.
using Weight = std::function<double(Index)>;

Vector3d mean_of(const Faces& faces, const Weight& weight)
{
  Vector3d sum = Vector3d::Zero();
  double total = 0.0;
  for (Index i = 0; i < faces.size(); ++i) {
    const double w = weight(i) * faces.areas_mm2[i];
    sum += w * faces.centre(i);
    total += w;
  }
  return sum / total;
}

double area_of(const Faces& faces, const Weight& weight)
{
  double total = 0.0;
  for (Index i = 0; i < faces.size(); ++i) total += weight(i) * faces.areas_mm2[i];
  return total;
}

// Where two surfaces face each other. Distances that count grow with the joint, whatever else of the bones is
// there: the weight falls over a reach from the facing area and the gap, 3 to 6 mm on four subtalar joints.
struct Facing {
  Eigen::VectorXd distance_mm;  // [faces] to the other surface; infinite: it faces none
  double reach_mm = 0.0;

  double weight(Index i) const
  {
    const double d = distance_mm[i] / reach_mm, left = 1.0 - d * d / 6.25;  // exp(-d^2), 0 from 2.5 on
    return left > 0.0 ? left * left * left * left * left * left : 0.0;
  }
};

Eigen::VectorXd distances_mm(const Faces& faces, const geometry::NearestSurface& other)
{
  constexpr double farthest_mm = 20.0, least_opposition = 0.3;
  Eigen::VectorXd d(faces.size());
  for (Index i = 0; i < faces.size(); ++i) {
    const Vector3d p = faces.centre(i), out = -faces.normal(i);
    const geometry::SurfacePoint on = other.nearest(p, {farthest_mm, least_opposition, out});
    d[i] = on.triangle < 0 ? std::numeric_limits<double>::infinity() : on.distance_mm;
  }
  return d;
}

struct Contact {
  Faces faces;
  Facing facing;
};

// Distances of faces, a quarter of whose weight is nearer.
double lower_quartile_mm(const Contact& contact, const Weight& weight)
{
  std::vector<std::pair<double, double>> rows;
  double total = 0.0;
  for (Index i = 0; i < contact.faces.size(); ++i) {
    const double w = weight(i) * contact.faces.areas_mm2[i];
    if (!(w > 0.0)) continue;
    rows.emplace_back(contact.facing.distance_mm[i], w);
    total += w;
  }
  std::sort(rows.begin(), rows.end());
  double sum = 0.0;
  for (const auto& [d, w] : rows) {
    if ((sum += w) >= 0.25 * total) return d;
  }
  return 0.0;
}

double lower_quartile_mm(const Contact& contact)
{
  return lower_quartile_mm(contact, [&](Index i) { return contact.facing.weight(i); });
}

// Of each surface to the other.
std::array<Contact, 2> facing_surfaces(const Mesh& reference, const Mesh& moving)
{
  constexpr double of_root_area = 0.12, start_mm = 8.0;
  constexpr double least_mm = 2.0;  // else the reach shrinks to a point where bones touch
  std::array<Contact, 2> both{Contact{faces_of(reference), {}}, Contact{faces_of(moving), {}}};
  both[0].facing.distance_mm = distances_mm(both[0].faces, geometry::NearestSurface(moving));
  both[1].facing.distance_mm = distances_mm(both[1].faces, geometry::NearestSurface(reference));
  double reach_mm = start_mm;
  for (int round = 0; round < 50; ++round) {
    double area_mm2 = 0.0;
    for (Contact& one : both) {
      one.facing.reach_mm = reach_mm;
      area_mm2 += 0.5 * area_of(one.faces, [&](Index i) { return one.facing.weight(i); });
    }
    const double gap_mm = std::max(lower_quartile_mm(both[0]), lower_quartile_mm(both[1]));
    reach_mm = std::max(least_mm, std::sqrt(gap_mm * gap_mm + of_root_area * of_root_area * area_mm2));
  }
  return both;
}

// The rotation that moves a surface least along its normals: n . (omega x (x - o) + v) = 0 by least squares
// with |omega| = 1. Source: Gelfand and Guibas (2004), Symp Geometry Processing 214-223.
struct Slide {
  Line axis;
  double residual_mm = 0.0;  // motion along the normals per radian, RMS
};

Slide slide_of(const std::vector<std::pair<const Faces*, Weight>>& surfaces, const Vector3d& o)
{
  Eigen::Matrix<double, 6, 6> M = Eigen::Matrix<double, 6, 6>::Zero();
  double total = 0.0;
  for (const auto& [faces, weight] : surfaces) {
    for (Index i = 0; i < faces->size(); ++i) {
      const double w = weight(i) * faces->areas_mm2[i];
      if (!(w > 0.0)) continue;
      Eigen::Matrix<double, 6, 1> q;
      q << (faces->centre(i) - o).cross(faces->normal(i)), faces->normal(i);
      M += w * q * q.transpose();
      total += w;
    }
  }
  M /= total;
  const Matrix3d of_v = M.bottomRightCorner<3, 3>(), mixed = M.topRightCorner<3, 3>();
  // A cylinder slides along its axis for nothing.
  const Eigen::SelfAdjointEigenSolver<Matrix3d> v_solver(of_v);
  Matrix3d inverse = Matrix3d::Zero();
  for (Index k = 0; k < 3; ++k) {
    const Vector3d e = v_solver.eigenvectors().col(k);
    if (v_solver.eigenvalues()[k] > 1e-6 * v_solver.eigenvalues()[2])
      inverse += e * e.transpose() / v_solver.eigenvalues()[k];
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(
      Matrix3d(M.topLeftCorner<3, 3>() - mixed * inverse * mixed.transpose()));
  const Vector3d omega = solver.eigenvectors().col(0);
  const Vector3d v = -inverse * mixed.transpose() * omega;
  return {{o + omega.cross(v), omega}, std::sqrt(std::max(0.0, solver.eigenvalues()[0]))};
}

// The direction of a shaft, across which its normals are, from `centre_mm` along about `direction`, as far as
// the bone reaches. Lengths in radii of the joint.
struct Shaft {
  Line axis;  // away from the joint
  double length = 0.0;
};

std::optional<Shaft> shaft_of(const Faces& faces, const Vector3d& centre_mm, Vector3d direction,
                              double radius_mm, double shortest = 3.5)
{
  constexpr double whole = 12.0, steepest = 0.6, roughest = 0.3;
  Shaft shaft;
  for (int round = 0; round < 6; ++round) {
    const auto along = [&](Index i) { return (faces.centre(i) - centre_mm).dot(direction) / radius_mm; };
    shaft.length = 0.0;
    for (Index i = 0; i < faces.size(); ++i) shaft.length = std::max(shaft.length, along(i));
    if (shaft.length < shortest) return std::nullopt;
    const bool is_whole = shaft.length > whole;
    const double from = is_whole ? 0.3 * shaft.length : std::max(2.2, 0.5 * shaft.length);
    const double to = is_whole ? 0.7 * shaft.length : shaft.length - 0.1;
    const Weight is_side = [&](Index i) {
      const double t = along(i);
      return t > from && t < to && std::abs(faces.normal(i).dot(direction)) < steepest ? 1.0 : 0.0;
    };
    Matrix3d S = Matrix3d::Zero();
    for (Index i = 0; i < faces.size(); ++i)
      S += is_side(i) * faces.areas_mm2[i] * faces.normal(i) * faces.normal(i).transpose();
    const double area_mm2 = area_of(faces, is_side);
    if (!(area_mm2 > radius_mm * radius_mm)) return std::nullopt;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(S);
    if (std::sqrt(std::max(0.0, solver.eigenvalues()[0]) / area_mm2) > roughest) return std::nullopt;
    const Vector3d found = solver.eigenvectors().col(0);
    direction = found.dot(direction) < 0.0 ? Vector3d(-found) : found;
    shaft.axis = {mean_of(faces, is_side), direction};
  }
  return shaft;
}

// The rotation R with R a_k near b_k.
Matrix3d rotation_between(const std::array<Vector3d, 2>& a, const std::array<Vector3d, 2>& b)
{
  const Matrix3d B = b[0] * a[0].transpose() + b[1] * a[1].transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  if (R.determinant() < 0.0)
    R = svd.matrixU() * Vector3d(1.0, 1.0, -1.0).asDiagonal() * svd.matrixV().transpose();
  return R;
}

enum class Which { reference, moving, both };

[[noreturn]] void refuse(const JointFrameOptions& options, Which which, const std::string& found,
                         const std::string& wanted)
{
  const auto bones = bones_of(options.joint);
  const std::string reference = "--" + std::string(bones.reference),
                    moving = "--" + std::string(bones.moving);
  if (which == Which::reference) throw InputError({options.reference_file, reference, found, wanted});
  if (which == Which::moving) throw InputError({options.moving_file, moving, found, wanted});
  throw InputError(
      {options.reference_file + ", " + options.moving_file, reference + ", " + moving, found, wanted});
}

// `what_else` follows the name of the bone that is wanted.
[[noreturn]] void refuse_exchanged(const JointFrameOptions& options, const std::string& found,
                                   const std::string& what_else = "")
{
  const auto bones = bones_of(options.joint);
  const std::string reference = bones.reference, moving = bones.moving;
  refuse(options, Which::reference, found,
         "the " + reference + what_else + "; exchange --" + reference + " and --" + moving);
}

// What the bones say of the axes, each with the sine by which it is known.
struct Directions {
  Vector3d centre_mm = Vector3d::Zero();
  Vector3d proximal = Vector3d::UnitY(), lateral = Vector3d::UnitZ(), anterior = Vector3d::UnitX();
  double anterior_margin = 0.0, lateral_margin = 1.0;
  bool is_lateral_exact = false;  // proximal is turned across it, not the other way
};

struct Found {
  Directions directions;
  JointFrame frame;
};

double longest_mm(const Mesh& mesh)
{
  const Vector3d middle = mesh.vertices_mm.colwise().mean();
  return 2.0 * (mesh.vertices_mm.rowwise() - middle.transpose()).rowwise().norm().maxCoeff();
}

// Factor from the unit of a mesh to mm: 1, 10 or 1000, whichever makes its length nearest to the usual one.
double unit_of(const Mesh& mesh, double usual_mm)
{
  const double length = longest_mm(mesh);
  const auto off = [&](double unit_mm) {
    const double ratio = unit_mm * length / usual_mm;
    return std::max(ratio, 1.0 / ratio);
  };
  double best = 1.0;
  for (const double unit_mm : {10.0, 1000.0}) {
    if (off(unit_mm) < off(best)) best = unit_mm;
  }
  return best;
}

void require_size(const JointFrameOptions& options, const Mesh& mesh, double usual_mm)
{
  const double length_mm = longest_mm(mesh), share = length_mm / usual_mm;
  if (share > 0.4 && share < 2.0) return;
  refuse(options, Which::moving, "a bone " + short_decimal(length_mm, 1) + " mm long",
         "about " + shortest_decimal(usual_mm) + " mm; --unit gives the unit of the meshes");
}

void require_facing(const JointFrameOptions& options, const std::array<Contact, 2>& contact)
{
  constexpr double least_mm2 = 50.0;
  const double area_mm2 = area_of(contact[1].faces, [&](Index i) { return contact[1].facing.weight(i); });
  if (area_mm2 >= least_mm2) return;
  refuse(options, Which::both, "no surfaces that face each other within 20 mm",
         "both bones of one joint in the pose of one scan");
}

// Mean curvature of a weighted surface by the spread of its normals, 1/mm; positive: convex. Their mean does
// not count, since the arms from the middle add up to zero.
double convexity(const Faces& faces, const Weight& weight)
{
  const Vector3d middle = mean_of(faces, weight);
  double spread = 0.0, size = 0.0;
  for (Index i = 0; i < faces.size(); ++i) {
    const Vector3d arm = faces.centre(i) - middle;
    const double w = weight(i) * faces.areas_mm2[i];
    spread += w * arm.dot(faces.normal(i));
    size += w * arm.squaredNorm();
  }
  return spread / size;
}

// The convex one of the facing surfaces is the moving bone's: the trochlea of a talus, the posterior facet of
// a calcaneus. In four feet the difference is 0.008 to 0.02 per mm.
void require_order(const JointFrameOptions& options, const std::array<Contact, 2>& contact)
{
  constexpr double least_per_mm = 0.002;
  const auto of = [&](std::size_t k) {
    return convexity(contact[k].faces, [&](Index i) { return contact[k].facing.weight(i); });
  };
  if (of(0) - of(1) < least_per_mm) return;
  refuse_exchanged(options, "the bone with the convex surface of the two", ", whose surface is concave");
}

// Hip.

std::optional<job::Sphere> head_of(const Mesh& pelvis, const Mesh& femur)
{
  job::Case joint;
  joint.reference.contact.mesh = pelvis;
  joint.moving.contact.mesh = femur;
  return job::head_sphere(joint);
}

// Area of the faces on the sphere with their normals outward.
double area_on(const Faces& faces, const job::Sphere& head)
{
  return area_of(faces, [&](Index i) {
    const Vector3d arm = faces.centre(i) - head.centre_mm;
    const bool is_near = std::abs(arm.norm() - head.radius_mm) < 0.05 * head.radius_mm;
    return is_near && faces.normal(i).dot(arm.normalized()) > 0.9 ? 1.0 : 0.0;
  });
}

// The plane by which a whole pelvis is its own mirror image; nothing if it is not.
std::optional<Line> symmetry_of(const Faces& faces, const Vector3d& centre_mm, double radius_mm)
{
  constexpr double whole = 8.0;             // radii from the hip's centre to the farthest point; a half: 6.5
  constexpr double kept = 0.7, most = 0.2;  // share of the pairs; their distance in radii (RMS)
  constexpr Index n_points = 1500;
  const Eigen::VectorXd off_mm = (faces.centres_mm.rowwise() - centre_mm.transpose()).rowwise().norm();
  if (off_mm.maxCoeff() < whole * radius_mm) return std::nullopt;
  const Index step = std::max<Index>(1, faces.size() / (20 * n_points));
  SurfacePoints points;
  const Index n = (faces.size() + step - 1) / step;
  points.positions_mm.resize(n, 3);
  points.normals.resize(n, 3);
  for (Index i = 0; i < n; ++i) {
    points.positions_mm.row(i) = faces.centres_mm.row(i * step);
    points.normals.row(i) = faces.normals.row(i * step);
  }
  const Vector3d mean = mean_of(faces, [](Index) { return 1.0; });
  Matrix3d S = Matrix3d::Zero();
  for (Index i = 0; i < faces.size(); ++i) {
    const Vector3d arm = faces.centre(i) - mean;
    S += faces.areas_mm2[i] * arm * arm.transpose();
  }
  const PointTree tree(points);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(S);
  std::optional<Line> best;
  double least_mm = most * radius_mm;
  for (Index k = 0; k < 3; ++k) {
    Line plane{mean, axes.eigenvectors().col(k)};
    double rms_mm = 0.0;
    for (int round = 0; round < 40; ++round) {
      std::vector<std::tuple<double, Vector3d, Vector3d>> pairs;
      for (Index i = 0; i < n; i += std::max<Index>(1, n / n_points)) {
        const Vector3d p = points.positions_mm.row(i);
        const Vector3d mirrored = p - 2.0 * (p - plane.p_mm).dot(plane.direction) * plane.direction;
        const PointTree::Nearest on = tree.nearest(mirrored, Vector3d::Zero(), -1.1);
        pairs.emplace_back(on.distance_sq_mm2, p, tree.points().positions_mm.row(on.row));
      }
      std::sort(pairs.begin(), pairs.end(),
                [](const auto& a, const auto& b) { return std::get<0>(a) < std::get<0>(b); });
      pairs.resize(static_cast<std::size_t>(kept * static_cast<double>(pairs.size())));
      const auto count = static_cast<double>(pairs.size());
      Vector3d middle = Vector3d::Zero();
      double sum_sq = 0.0;
      for (const auto& [d_sq, p, q] : pairs) {
        middle += 0.5 * (p + q) / count;
        sum_sq += d_sq;
      }
      Matrix3d C = Matrix3d::Zero();
      for (const auto& [d_sq, p, q] : pairs) {
        const Matrix3d one = (p - middle) * (q - middle).transpose();
        C += one + one.transpose();
      }
      const Vector3d normal = Eigen::SelfAdjointEigenSolver<Matrix3d>(C).eigenvectors().col(0);
      plane = {middle, normal};
      rms_mm = std::sqrt(sum_sq / count);
    }
    const double to_side = std::abs((centre_mm - plane.p_mm).dot(plane.direction)) / radius_mm;
    if (rms_mm < least_mm && to_side > 2.0 && to_side < 6.0) {
      least_mm = rms_mm;
      best = plane;
    }
  }
  return best;
}

// Both condyles of a whole femur, by its shaft: posterior-distal spheres.
struct Knee {
  Vector3d middle_mm, across, anterior;
};

std::optional<Knee> knee_of(const Mesh& femur, const Faces& faces, const Shaft& shaft, double radius_mm)
{
  const Vector3d down = shaft.axis.direction;
  double end_mm = -1e9;
  for (Index i = 0; i < faces.size(); ++i)
    end_mm = std::max(end_mm, (faces.centre(i) - shaft.axis.p_mm).dot(down));
  const Weight is_end = [&](Index i) {
    return (faces.centre(i) - shaft.axis.p_mm).dot(down) > end_mm - 1.2 * radius_mm ? 1.0 : 0.0;
  };
  const Vector3d middle = mean_of(faces, is_end);
  const Vector3d off = middle - shaft.axis.p_mm;
  const Vector3d behind = off - off.dot(down) * down;  // the condyles are behind the shaft
  Matrix3d S = Matrix3d::Zero();
  for (Index i = 0; i < faces.size(); ++i) {
    Vector3d arm = faces.centre(i) - middle;
    arm -= arm.dot(down) * down;
    S += is_end(i) * faces.areas_mm2[i] * arm * arm.transpose();
  }
  const Vector3d wide = across(Eigen::SelfAdjointEigenSolver<Matrix3d>(S).eigenvectors().col(2), down);
  Matrix3d R;
  R.col(1) = -down;
  R.col(0) = wide.cross(down).dot(behind) < 0.0 ? wide.cross(down) : down.cross(wide);
  R.col(2) = R.col(0).cross(R.col(1));
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = middle;
  const std::optional<job::CondyleSpheres> spheres = job::condyle_spheres(transformed(femur, X.inverse()));
  if (!spheres) return Knee{middle, wide, R.col(0)};
  const Vector3d left = X * spheres->left.centre_mm, right = X * spheres->right.centre_mm;
  return Knee{0.5 * (left + right), (right - left).normalized(), R.col(0)};
}

Found hip(const JointSurfaces& scan, const JointFrameOptions& options)
{
  constexpr double anteversion_deg = 12.0;  // of the neck from the condyles
  constexpr double femur_length = 17.0;     // from the head to the knee, radii of the head: 410 of 24 mm
  Found out;
  JointFrame& frame = out.frame;
  Directions& to = out.directions;
  std::optional<job::Sphere> head;
  JointSurfaces bones;
  for (const double unit_mm : {1.0, 10.0, 1000.0}) {
    if (head || (options.unit_mm && *options.unit_mm != unit_mm)) continue;
    frame.unit_mm = unit_mm;
    bones = {in_mm(scan.reference, unit_mm), in_mm(scan.moving, unit_mm), {}};
    head = head_of(bones.reference, bones.moving);
  }
  if (!head)
    refuse(options, Which::both, "no head of 5 to 60 mm radius in a socket",
           "the pelvis and the femur of one hip in the pose of one scan");
  const std::array<Contact, 2> contact = facing_surfaces(bones.reference, bones.moving);
  require_facing(options, contact);
  const Faces &pelvis = contact[0].faces, &femur = contact[1].faces;
  if (area_on(pelvis, *head) > area_on(femur, *head)) refuse_exchanged(options, "the bone with the head");
  const Vector3d c = to.centre_mm = head->centre_mm;
  const double r = frame.radius_mm = head->radius_mm;
  frame.gap_mm = lower_quartile_mm(contact[1]);
  frame.residual_mm = 0.0;
  double on_mm2 = 0.0;
  for (Index i = 0; i < femur.size(); ++i) {
    const double off_mm = (femur.centre(i) - c).norm() - r,
                 w = contact[1].facing.weight(i) * femur.areas_mm2[i];
    if (std::abs(off_mm) > 2.0) continue;
    frame.residual_mm += w * off_mm * off_mm;
    on_mm2 += w;
  }
  frame.residual_mm = std::sqrt(frame.residual_mm / std::max(on_mm2, 1e-9));

  const auto distance = [&](const Faces& faces, Index i) { return (faces.centre(i) - c).norm() / r; };
  const auto window = [](double x, double least, double most) {
    const double u = (x - least) / (most - least);
    return u > 0.0 && u < 1.0 ? 16.0 * u * u * (1.0 - u) * (1.0 - u) : 0.0;
  };
  const Weight on_neck = [&](Index i) { return window(distance(femur, i), 1.1, 1.9); };
  const Weight in_socket = [&](Index i) {
    const Vector3d arm = (pelvis.centre(i) - c).normalized();
    return pelvis.normal(i).dot(arm) < -0.7 ? window(distance(pelvis, i), 0.7, 1.5) : 0.0;
  };
  if (!(area_of(femur, on_neck) > 0.1 * r * r))
    refuse(options, Which::moving, "a head without its neck",
           "a femur with its neck, as far as the scan shows it");
  const Vector3d neck = (mean_of(femur, on_neck) - c).normalized();
  const Vector3d opening = -(mean_of(pelvis, in_socket) - c).normalized();

  const Weight is_far = [&](Index i) { return distance(femur, i) > 2.0 ? 1.0 : 0.0; };
  std::optional<Shaft> shaft;
  if (area_of(femur, is_far) > 0.0) shaft = shaft_of(femur, c, (mean_of(femur, is_far) - c).normalized(), r);
  if (!shaft) {
    // The neck and the opening alone: the same for both sides. Of a right hip, of healthy adults (the opening
    // as in the default push of a hip, the neck of 130 degrees), and of the generated one.
    constexpr double neck_deg = 50.0;
    using Model = std::array<Vector3d, 2>;
    const auto at = [](double from_down_deg) {
      const SinCos a = sin_cos(rad_from_deg(from_down_deg));
      return Vector3d(0.0, -a.cos, a.sin);
    };
    const Model adult{Vector3d(0.342, -0.6645, 0.6645).normalized(), at(neck_deg)};
    const Model generated{at(0.0), at(45.0)};
    const auto misfit = [&](const Model& m) {
      return std::abs(arc_cosine(m[0].dot(m[1])) - arc_cosine(std::clamp(opening.dot(neck), -1.0, 1.0)));
    };
    const Model& model = misfit(adult) <= misfit(generated) ? adult : generated;
    const bool is_left = options.side == Side::left;
    const Vector3d flip(1.0, 1.0, is_left ? -1.0 : 1.0);
    const Matrix3d R =
        rotation_between({flip.cwiseProduct(model[0]), flip.cwiseProduct(model[1])}, {opening, neck});
    to.anterior = R.col(0);
    to.proximal = R.col(1);
    to.lateral = (is_left ? -1.0 : 1.0) * R.col(2);
    frame.found = {
        "all axes: the directions of the neck and of the socket's opening, since the femur has no shaft"};
  } else {
    const Vector3d down = shaft->axis.direction;
    const bool is_whole = shaft->length > 12.0;
    const Vector3d on_axis = shaft->axis.p_mm + (c - shaft->axis.p_mm).dot(down) * down;
    std::optional<Knee> knee;
    if (is_whole) knee = knee_of(bones.moving, femur, *shaft, r);
    const Vector3d knee_mm = knee ? knee->middle_mm : Vector3d(on_axis + femur_length * r * down);
    to.proximal = (c - knee_mm).normalized();
    frame.found = {knee ? "proximal: from the middle of the condyles to the head"
                        : "proximal: from the knee, expected " + short_decimal(femur_length * r, 0) +
                              " mm down the shaft, to the head"};
    const Vector3d outward = across(neck, to.proximal);
    const auto votes_for = [&](const Vector3d& front) {  // sines, positive: towards `front`
      double sum = 0.0;
      if (knee) sum += 2.0 * knee->anterior.dot(front);
      const double reach = (pelvis.centres_mm.rowwise() - c.transpose()).rowwise().norm().maxCoeff() / r;
      if (reach > 4.0) sum -= (mean_of(pelvis, [](Index) { return 1.0; }) - c).dot(front) / r;
      // Trochanters and their crest are behind the plane of the head and the shaft.
      const Vector3d sideways = across(on_axis - c, down), normal = sideways.cross(down);
      const Weight on_trochanters = [&](Index i) {
        const Vector3d arm = femur.centre(i) - c;
        const double t = arm.dot(down) / r;
        return t < 3.5 && arm.norm() > 1.6 * r ? 1.0 : 0.0;
      };
      sum -= (mean_of(femur, on_trochanters) - c).dot(normal) / r * (normal.dot(front) > 0.0 ? 1.0 : -1.0);
      return sum + opening.dot(front);
    };
    const std::optional<Line> plane = symmetry_of(pelvis, c, r);
    std::string source;
    if (plane) {
      const bool is_towards = (c - plane->p_mm).dot(plane->direction) > 0.0;
      to.lateral = is_towards ? plane->direction : Vector3d(-plane->direction);
      to.is_lateral_exact = true;
      source = "the symmetry of the pelvis";
    } else if (knee) {
      to.lateral = knee->across.dot(outward) > 0.0 ? knee->across : Vector3d(-knee->across);
      source = "the line through both condyles";
    } else {
      to.lateral = outward;
      source = "the neck, taken as " + shortest_decimal(anteversion_deg) + " degrees anteverted";
    }
    const Vector3d front = across(to.lateral, to.proximal).cross(to.proximal);
    const double votes = votes_for(front);
    to.anterior_margin = std::min(1.0, std::abs(votes));
    to.anterior = votes >= 0.0 ? front : Vector3d(-front);
    if (!plane && !knee) {
      const Vector3d forward =
          options.side ? Vector3d(to.proximal.cross(outward) * (*options.side == Side::right ? 1.0 : -1.0))
                       : to.anterior;
      const SinCos a = sin_cos(rad_from_deg(anteversion_deg));
      to.lateral = a.cos * outward - a.sin * forward;
    }
    frame.found.push_back("lateral: " + source);
  }
  frame.delta = -opening;  // in the scan, until the axes are known
  return out;
}

// Ankle.

// A part of a bone that is a surface of revolution.
struct Trochlea {
  Line axis;
  double radius_mm = 0.0, residual_mm = 0.0, area_mm2 = 0.0;
  std::vector<char> is_on;  // [faces]
};

// The point of an axis along `a` that the normals of the top pass most closely, by least squares with the
// weights of Cauchy; nothing if they are parallel.
std::optional<Vector3d> foot_of(const Faces& faces, const std::vector<Index>& top, const Vector3d& a)
{
  constexpr double usual_mm = 1.5, flattest = 0.02;
  Vector3d p = Vector3d::Zero();
  for (int round = 0; round < 8; ++round) {
    Matrix3d M = 1e-9 * Matrix3d::Identity();
    Vector3d b = Vector3d::Zero();
    double total = 0.0;
    for (const Index i : top) {
      const Vector3d t = a.cross(faces.normal(i));
      const double off_mm = t.dot(faces.centre(i) - p) / usual_mm;
      const double w = faces.areas_mm2[i] / (round == 0 ? 1.0 : 1.0 + off_mm * off_mm);
      M += w * t * t.transpose();
      b += w * t * t.dot(faces.centre(i));
      total += w;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(M);
    if (solver.eigenvalues()[1] < flattest * total) return std::nullopt;  // [0] is along a
    p = Vector3d::Zero();
    for (Index k = 1; k < 3; ++k) {
      const Vector3d e = solver.eigenvectors().col(k);
      p += e * e.dot(b) / solver.eigenvalues()[k];
    }
  }
  return p;
}

// From the top to the whole trochlea, as far as it is of revolution.
std::optional<Trochlea> grown(const Faces& faces, const std::vector<Index>& top, Line axis)
{
  constexpr double radial = 0.6, sliding = 0.25, widest_deg = 65.0, least_mm = 8.0, most_mm = 45.0;
  const double least_cosine = sin_cos(rad_from_deg(widest_deg)).cos;
  Trochlea out;
  Vector3d up = Vector3d::Zero();  // the middle of the arc
  out.is_on.resize(static_cast<std::size_t>(faces.size()));
  for (int round = 0; round < 25; ++round) {
    const auto arm_of = [&](Index i) {
      const Vector3d off = faces.centre(i) - axis.p_mm;
      return Vector3d(off - off.dot(axis.direction) * axis.direction);
    };
    const auto slides = [&](Index i, const Vector3d& arm) {
      const Vector3d out_of = arm.normalized();
      return faces.normal(i).dot(out_of) > radial &&
             std::abs(faces.normal(i).dot(axis.direction.cross(out_of))) < sliding;
    };
    double total = 0.0, sum_mm = 0.0;
    Vector3d sum = Vector3d::Zero();
    std::vector<std::pair<double, double>> along;
    for (const Index i : top) {
      const Vector3d arm = arm_of(i);
      if (!slides(i, arm)) continue;
      const double w = faces.areas_mm2[i];
      total += w;
      sum_mm += w * arm.norm();
      sum += w * arm.normalized();
      along.emplace_back((faces.centre(i) - axis.p_mm).dot(axis.direction), w);
    }
    if (!(total > 0.0)) return std::nullopt;
    out.radius_mm = sum_mm / total;
    if (round == 0) up = sum.normalized();
    if (!(out.radius_mm > least_mm) || out.radius_mm > most_mm) return std::nullopt;
    std::sort(along.begin(), along.end());
    double passed = 0.0, from_mm = along.front().first, to_mm = from_mm;
    for (const auto& [z, w] : along) {
      if (passed < 0.02 * total) from_mm = z;
      if (passed < 0.98 * total) to_mm = z;
      passed += w;
    }
    out.area_mm2 = 0.0;
    Vector3d middle = Vector3d::Zero();
    for (Index i = 0; i < faces.size(); ++i) {
      const Vector3d arm = arm_of(i);
      const double z = (faces.centre(i) - axis.p_mm).dot(axis.direction);
      const bool is_on = slides(i, arm) && std::abs(arm.norm() - out.radius_mm) < 0.3 * out.radius_mm &&
                         z > from_mm - 0.1 * out.radius_mm && z < to_mm + 0.1 * out.radius_mm &&
                         arm.normalized().dot(up) > least_cosine;
      out.is_on[static_cast<std::size_t>(i)] = is_on ? 1 : 0;
      if (!is_on) continue;
      out.area_mm2 += faces.areas_mm2[i];
      middle += faces.areas_mm2[i] * arm.normalized();
    }
    if (!(out.area_mm2 > 0.0)) return std::nullopt;
    const Weight chosen = [&](Index i) {
      return static_cast<double>(out.is_on[static_cast<std::size_t>(i)]);
    };
    const Slide slide = slide_of({{&faces, chosen}}, mean_of(faces, chosen));
    out.residual_mm = slide.residual_mm;
    axis = slide.axis;
    up = across(middle.normalized(), axis.direction);
  }
  out.axis = axis;
  return out;
}

// The trochlea of a talus: of all axes across the direction of the tibia the one with the largest surface of
// revolution.
std::optional<Trochlea> trochlea_of(const Contact& contact, const Vector3d& towards_tibia)
{
  constexpr double step_deg = 15.0, tilt_deg = 20.0, steepest = 0.5, behind_nearest_mm = 10.0;
  const Faces& faces = contact.faces;
  double nearest_mm = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < faces.size(); ++i) nearest_mm = std::min(nearest_mm, contact.facing.distance_mm[i]);
  std::vector<Index> top;
  for (Index i = 0; i < faces.size(); ++i) {
    if (contact.facing.distance_mm[i] < nearest_mm + behind_nearest_mm &&
        faces.normal(i).dot(towards_tibia) > steepest)
      top.push_back(i);
  }
  const Vector3d x = towards_tibia.unitOrthogonal(), y = towards_tibia.cross(x);
  std::optional<Trochlea> best;
  for (double turn_deg = 0.0; turn_deg < 180.0; turn_deg += step_deg) {
    for (const double up_deg : {-tilt_deg, 0.0, tilt_deg}) {
      const SinCos turn = sin_cos(rad_from_deg(turn_deg)), up = sin_cos(rad_from_deg(up_deg));
      const Vector3d a = up.cos * (turn.cos * x + turn.sin * y) + up.sin * towards_tibia;
      const std::optional<Vector3d> p = foot_of(faces, top, a);
      if (!p) continue;
      std::optional<Trochlea> found = grown(faces, top, {*p, a});
      if (found && (!best || found->area_mm2 > best->area_mm2)) best = std::move(found);
    }
  }
  return best;
}

Found ankle(const JointSurfaces& scan, const JointFrameOptions& options)
{
  constexpr double usual_mm = 58.0, shortest_tibia = 2.8;
  Found out;
  JointFrame& frame = out.frame;
  Directions& to = out.directions;
  frame.unit_mm = options.unit_mm.value_or(unit_of(scan.moving, usual_mm));
  const JointSurfaces bones{in_mm(scan.reference, frame.unit_mm), in_mm(scan.moving, frame.unit_mm),
                            in_mm(scan.fibula, frame.unit_mm)};
  require_size(options, bones.moving, usual_mm);
  const std::array<Contact, 2> contact = facing_surfaces(bones.reference, bones.moving);
  require_facing(options, contact);
  require_order(options, contact);
  const Faces &tibia = contact[0].faces, &talus = contact[1].faces;
  Vector3d towards_tibia = Vector3d::Zero();
  for (Index i = 0; i < talus.size(); ++i) {
    if (std::isfinite(contact[1].facing.distance_mm[i]))
      towards_tibia += talus.areas_mm2[i] * talus.normal(i);
  }
  towards_tibia.normalize();
  const std::optional<Trochlea> trochlea = trochlea_of(contact[1], towards_tibia);
  if (!trochlea)
    refuse(options, Which::moving, "no trochlea of 8 to 45 mm radius that faces the tibia",
           "tibia and talus of one ankle in the pose of one scan");
  const double radius_mm = trochlea->radius_mm;
  const Vector3d a = trochlea->axis.direction;
  const Weight chosen = [&](Index i) {
    return static_cast<double>(trochlea->is_on[static_cast<std::size_t>(i)]);
  };
  Vector3d up = Vector3d::Zero();  // to where it faces the tibia
  for (Index i = 0; i < talus.size(); ++i) {
    const Vector3d out_of = across(talus.centre(i) - trochlea->axis.p_mm, a);
    if (talus.normal(i).dot(out_of) > 0.6) up += contact[1].facing.weight(i) * talus.areas_mm2[i] * out_of;
  }
  up.normalize();
  const Vector3d middle = mean_of(talus, chosen);
  to.centre_mm = trochlea->axis.p_mm + (middle - trochlea->axis.p_mm).dot(a) * a;
  frame.radius_mm = radius_mm;
  frame.residual_mm = trochlea->residual_mm;
  frame.gap_mm = lower_quartile_mm(
      contact[1], [&](Index i) { return std::isfinite(contact[1].facing.distance_mm[i]) ? chosen(i) : 0.0; });
  const Vector3d c = to.centre_mm;
  to.lateral = a;
  to.is_lateral_exact = true;
  frame.found = {"lateral: the axis of the trochlea, a surface of revolution of " +
                 short_decimal(radius_mm, 1) + " mm radius"};
  const Weight is_far = [&](Index i) { return (tibia.centre(i) - c).norm() > 2.2 * radius_mm ? 1.0 : 0.0; };
  std::optional<Shaft> shaft;  // not from `up`: the foot of a scan may be pointed
  if (area_of(tibia, is_far) > 0.0)
    shaft = shaft_of(tibia, c, (mean_of(tibia, is_far) - c).normalized(), radius_mm, shortest_tibia);
  to.proximal = shaft ? shaft->axis.direction : up;
  frame.found.push_back(shaft ? "proximal: the shaft of the tibia"
                              : "proximal: the middle of the trochlea, since the tibia has no shaft");
  const Vector3d front = across(a.cross(to.proximal), a);
  const double forward = (mean_of(talus, [](Index) { return 1.0; }) - c).dot(front) / radius_mm;
  to.anterior = forward >= 0.0 ? front : Vector3d(-front);
  to.anterior_margin = std::abs(forward);
  if (to.anterior_margin >= undetermined) frame.found.push_back("anterior: the head of the talus");
  double outward = 0.0;
  if (bones.fibula.triangles.rows() > 0) {
    outward = (mean_of(faces_of(bones.fibula), [](Index) { return 1.0; }) - c).dot(a) / radius_mm;
    frame.found.push_back("medial and lateral: the fibula");
  } else {
    // The lowest part of a tibia is its medial malleolus, whose tip is about as high as the axis.
    const auto height = [&](Index i) {
      const Vector3d off = tibia.centre(i) - c;
      return off.norm() < 3.0 * radius_mm ? off.dot(to.proximal) / radius_mm : 1e9;
    };
    double tip = 1e9;
    for (Index i = 0; i < tibia.size(); ++i) tip = std::min(tip, height(i));
    const Weight low = [&](Index i) { return height(i) < tip + 0.3 ? 1.0 : 0.0; };
    if (tip < 0.75) {
      outward = -(mean_of(tibia, low) - c).dot(a) / radius_mm;
      if (std::abs(outward) >= undetermined)
        frame.found.push_back("medial and lateral: the medial malleolus");
    }
  }
  if (outward < 0.0) to.lateral = -a;
  to.lateral_margin = std::abs(outward);
  frame.delta = across(to.proximal, a);  // along the shaft the talus would slide off where there is no fibula
  frame.axis = a;
  return out;
}

// Subtalar.

Found subtalar(const JointSurfaces& scan, const JointFrameOptions& options)
{
  constexpr double usual_mm = 85.0;  // of the calcaneus
  Found out;
  JointFrame& frame = out.frame;
  Directions& to = out.directions;
  frame.unit_mm = options.unit_mm.value_or(unit_of(scan.moving, usual_mm));
  const JointSurfaces bones{in_mm(scan.reference, frame.unit_mm), in_mm(scan.moving, frame.unit_mm), {}};
  require_size(options, bones.moving, usual_mm);
  const std::array<Contact, 2> contact = facing_surfaces(bones.reference, bones.moving);
  require_facing(options, contact);
  require_order(options, contact);
  const Faces &talus = contact[0].faces, &calcaneus = contact[1].faces;
  const std::array<Weight, 2> weight{[&](Index i) { return contact[0].facing.weight(i); },
                                     [&](Index i) { return contact[1].facing.weight(i); }};
  const Vector3d c = to.centre_mm = 0.5 * (mean_of(talus, weight[0]) + mean_of(calcaneus, weight[1]));
  const double talus_mm2 = area_of(talus, weight[0]), calcaneus_mm2 = area_of(calcaneus, weight[1]);
  const Slide slide = slide_of({{&talus, [&](Index i) { return weight[0](i) / talus_mm2; }},
                                {&calcaneus, [&](Index i) { return weight[1](i) / calcaneus_mm2; }}},
                               c);
  frame.residual_mm = slide.residual_mm;
  frame.radius_mm = std::numeric_limits<double>::quiet_NaN();
  frame.gap_mm = lower_quartile_mm(contact[1]);
  Vector3d facing = Vector3d::Zero();  // from the calcaneus to the talus
  for (Index i = 0; i < calcaneus.size(); ++i)
    facing += weight[1](i) * calcaneus.areas_mm2[i] * calcaneus.normal(i);
  for (Index i = 0; i < talus.size(); ++i) facing -= weight[0](i) * talus.areas_mm2[i] * talus.normal(i);
  facing.normalize();
  // Signs only: the talus is in front of the calcaneus, and the axis goes to its medial side.
  const Weight all = [](Index) { return 1.0; };
  const Vector3d behind = mean_of(calcaneus, all), ahead = mean_of(talus, all) - behind;
  // How far the long axis of a surface points to the right of the axis, less where it is hardly longer.
  const auto to_right_of = [&](const Faces& faces, const Weight& of, const Vector3d& to_the_right) {
    const Vector3d middle = mean_of(faces, of);
    Matrix3d S = Matrix3d::Zero();
    for (Index i = 0; i < faces.size(); ++i) {
      const Vector3d arm = faces.centre(i) - middle;
      S += of(i) * faces.areas_mm2[i] * arm * arm.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(S);
    const Vector3d v = solver.eigenvectors().col(2);
    const double longer = 1.0 - solver.eigenvalues()[1] / solver.eigenvalues()[2];
    return longer * longer * v.dot(to_the_right) * (v.dot(ahead) < 0.0 ? -1.0 : 1.0);
  };
  Vector3d axis = slide.axis.direction;
  if (axis.dot(ahead) < 0.0) axis = -axis;
  const Vector3d right = axis.cross(facing).normalized();
  const double to_right = to_right_of(calcaneus, all, right) + to_right_of(calcaneus, weight[1], right) +
                          to_right_of(talus, weight[0], right);
  const bool is_left = options.side ? *options.side == Side::left : to_right < 0.0;
  // Means of four feet, of a right one: X along the calcaneus, Y across it towards the talus.
  const Vector3d flip(1.0, 1.0, is_left ? -1.0 : 1.0);
  const Vector3d usual_axis = flip.cwiseProduct(Vector3d(0.794, 0.557, -0.238)).normalized();
  const Vector3d usual_facing = flip.cwiseProduct(Vector3d(0.519, 0.840, 0.154)).normalized();
  const Matrix3d R = rotation_between({usual_axis, usual_facing}, {axis, facing});
  to.anterior = R.col(0);
  to.proximal = R.col(1);
  to.lateral = (is_left ? -1.0 : 1.0) * R.col(2);
  to.anterior_margin = std::abs(to_right);
  if (options.side && (to_right < 0.0) != is_left) to.anterior_margin = -to.anterior_margin;
  frame.delta = facing;
  frame.axis = axis;
  frame.found = {
      "all axes: the axis about which the facing surfaces slide and their mean normal, as in four feet"};
  return out;
}

// Points of the user: where each is from the centre.
void apply_landmarks(const JointFrameOptions& options, double unit_mm, Directions& to)
{
  for (const NamedPoint& point : options.landmarks) {
    const Vector3d direction = (unit_mm * point.p - to.centre_mm).normalized();
    if (point.name == "proximal") to.proximal = direction;
    if (point.name == "distal") to.proximal = -direction;
    if (point.name == "lateral" || point.name == "medial") {
      const Vector3d outward = point.name == "lateral" ? direction : Vector3d(-direction);
      to.lateral = !to.is_lateral_exact            ? outward
                   : to.lateral.dot(outward) < 0.0 ? Vector3d(-to.lateral)
                                                   : to.lateral;
      to.lateral_margin = 1.0;
    }
  }
  for (const NamedPoint& point : options.landmarks) {
    if (point.name != "anterior" && point.name != "posterior") continue;
    const Vector3d direction = (unit_mm * point.p - to.centre_mm).normalized();
    to.anterior = point.name == "anterior" ? direction : Vector3d(-direction);
    to.anterior_margin = 1.0;
  }
}

// The axes, from what is known of them.
void set_axes(const JointFrameOptions& options, Found& found)
{
  Directions& to = found.directions;
  JointFrame& frame = found.frame;
  apply_landmarks(options, frame.unit_mm, to);
  Vector3d lateral = to.lateral, proximal = to.proximal;
  if (to.is_lateral_exact) {
    proximal = across(proximal, lateral);
  } else {
    lateral = across(lateral, proximal);
  }
  const double forward = to.anterior.dot(proximal.cross(lateral));
  const Side shown = forward >= 0.0 ? Side::right : Side::left;
  const bool is_contradicted = to.anterior_margin < 0.0;
  frame.side_margin = std::min(std::abs(to.anterior_margin), to.lateral_margin);
  const bool is_known = frame.side_margin >= undetermined;
  frame.side = options.side.value_or(is_known ? shown : Side::right);
  if (!options.side && !is_known)
    frame.warnings.push_back("side: these bones do not show it; " + side_name(frame.side) +
                             " is assumed, --side gives it");
  if (options.side && is_known && (is_contradicted || shown != frame.side))
    frame.warnings.push_back("side: the bones look like those of a " +
                             side_name(frame.side == Side::right ? Side::left : Side::right) + " " +
                             options.joint + "; --side " + side_name(frame.side) + " is used");
  if (shown != frame.side && to.lateral_margin < std::abs(to.anterior_margin)) lateral = -lateral;
  const Vector3d right = frame.side == Side::right ? lateral : Vector3d(-lateral);
  frame.X_scan_joint.linear() << proximal.cross(right), proximal, right;
  frame.X_scan_joint.translation() = to.centre_mm;
  const Matrix3d R = frame.X_scan_joint.linear().transpose();
  frame.delta = R * frame.delta;
  frame.axis = R * frame.axis;
}

// Source of the form, fibres that are isometric in passive motion: Leardini et al. (1999), J Biomech
// 32:585-591. One scale, the radius of the trochlea.
void add_ankle_fibres(const JointSurfaces& scan, JointFrame& frame)
{
  constexpr double malleolus = 1.15, side = 0.75;
  constexpr std::array<std::pair<const char*, std::array<double, 2>>, 3> ends{
      {{"anterior", {0.65, -0.15}}, {"posterior", {-0.65, -0.15}}, {"inferior", {0.0, -0.5}}}};
  const geometry::NearestSurface talus(
      transformed(in_mm(scan.moving, frame.unit_mm), frame.X_scan_joint.inverse()));
  for (const bool is_medial : {true, false}) {
    const double out = (frame.side == Side::right) == is_medial ? -1.0 : 1.0;
    for (const auto& [name, at] : ends) {
      model::Fibre fibre;
      fibre.bundle = is_medial ? "deltoid" : "lateral";
      fibre.name = fibre.bundle + "-" + name;
      fibre.reference_mm = Vector3d(0.0, 0.0, out * malleolus * frame.radius_mm);
      const Vector3d near = frame.radius_mm * Vector3d(at[0], at[1], out * side);
      fibre.moving_mm = talus.nearest(near, {2.0 * frame.radius_mm}).p_mm;
      frame.fibres.push_back(fibre);
    }
  }
}

// The flexions about the centre at which no part of the femur but its head is inside the pelvis.
void limit_flexion(const JointSurfaces& scan, JointFrame& frame)
{
  constexpr double step_deg = 5.0, deepest_mm = 0.3, farthest_mm = 30.0;
  constexpr Index most_faces = 8000;
  const Pose X = frame.X_scan_joint.inverse();
  const geometry::NearestSurface pelvis(transformed(in_mm(scan.reference, frame.unit_mm), X));
  const Faces femur = faces_of(transformed(in_mm(scan.moving, frame.unit_mm), X));
  const Index every = std::max<Index>(1, femur.size() / most_faces);
  const auto is_free = [&](double flexion_deg) {
    const Matrix3d R = rotation_z(-rad_from_deg(flexion_deg));
    for (Index i = 0; i < femur.size(); i += every) {
      const Vector3d p = R * femur.centre(i);
      if (p.norm() < 1.1 * frame.radius_mm || p.norm() > 6.0 * frame.radius_mm) continue;
      const geometry::SurfacePoint on = pelvis.nearest(p, {farthest_mm});
      if (on.triangle >= 0 && on.distance_mm > deepest_mm && pelvis.is_behind(p, on)) return false;
    }
    return true;
  };
  if (!is_free(-step_deg) || !is_free(step_deg)) return;  // as the scan is
  double least_deg = 0.0, most_deg = 0.0;
  while (least_deg > frame.least_flexion_deg && is_free(least_deg - step_deg)) least_deg -= step_deg;
  while (most_deg < frame.most_flexion_deg && is_free(most_deg + step_deg)) most_deg += step_deg;
  if (least_deg > frame.least_flexion_deg) frame.least_flexion_deg = least_deg + step_deg;
  if (most_deg < frame.most_flexion_deg) frame.most_flexion_deg = most_deg - step_deg;
  frame.found.push_back("flexion " + shortest_decimal(-frame.least_flexion_deg) + " to extension " +
                        shortest_decimal(frame.most_flexion_deg) + " degrees: free of impingement");
}

}  // namespace

JointBones bones_of(const std::string& joint)
{
  if (joint == "hip") return {"pelvis", "femur"};
  if (joint == "ankle") return {"tibia", "talus"};
  if (joint == "subtalar") return {"talus", "calcaneus"};
  return {"femur", "tibia"};
}

JointFrame joint_frame(const JointSurfaces& surfaces, const JointFrameOptions& options)
{
  if (surfaces.reference.vertices_mm.rows() == surfaces.moving.vertices_mm.rows() &&
      surfaces.reference.vertices_mm == surfaces.moving.vertices_mm)
    refuse(options, Which::both, "the same mesh twice", "a mesh of each bone");
  Found found = options.joint == "hip"     ? hip(surfaces, options)
                : options.joint == "ankle" ? ankle(surfaces, options)
                                           : subtalar(surfaces, options);
  set_axes(options, found);
  if (options.joint == "hip") limit_flexion(surfaces, found.frame);
  if (options.joint == "ankle") add_ankle_fibres(surfaces, found.frame);
  return found.frame;
}

double joint_cartilage_mm(double gap_mm, int n_bare)
{
  constexpr double left_mm = 0.5, most_mm = 5.0;
  if (n_bare == 0) return 0.0;
  const double each_mm = (std::min(gap_mm, most_mm) - left_mm) / n_bare;
  return std::max(0.0, std::round(100.0 * each_mm) / 100.0);
}

}  // namespace vrda::prepare
