#include "geometry/wrap_over.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.hpp"

namespace vrda::geometry {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double excepted_mm = 3.0;  // below a surface by registration, not by a crossing
constexpr double spacing_mm = 1.0;

InnerPoint inner_point(const std::vector<NearestSurface>& bone, const Vector3d& p_mm)
{
  InnerPoint deepest;
  deepest.p_mm = p_mm;
  for (const NearestSurface& surface : bone) {
    const SurfacePoint on = surface.nearest(p_mm);
    if (surface.is_behind(p_mm, on) && on.distance_mm > deepest.depth_mm)
      deepest = {p_mm, on.p_mm, surface.normal(on.triangle), on.distance_mm};
  }
  return deepest;
}

// A path enters bone through its surface, so no point is deeper than its way to the nearest one outside.
// Otherwise the normal at a sharp fin says the wrong side.
bool has_entry(const std::vector<InnerPoint>& points, std::size_t k)
{
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].depth_mm > 0.0) continue;
    if ((points[i].p_mm - points[k].p_mm).norm() + spacing_mm < points[k].depth_mm) return false;
  }
  return true;
}

InnerPoint deepest_point(const std::vector<InnerPoint>& points)
{
  InnerPoint deepest;
  for (const InnerPoint& point : points) {
    if (point.depth_mm > deepest.depth_mm) deepest = point;
  }
  return deepest;
}

}  // namespace

std::vector<NearestSurface> bone_of(const Body& body)
{
  std::vector<NearestSurface> surfaces;
  for (const char* material : {"bone", "cartilage"}) {
    for (const Part* part : {&body.contact, &body.visual}) {
      const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, *part);
      for (std::size_t c = 0; c < rows.size(); ++c) {
        if (!rows[c].empty() && body.components[c].material == material)
          surfaces.emplace_back(select_triangles(part->mesh, rows[c]));
      }
    }
    if (!surfaces.empty()) break;
  }
  return surfaces;
}

std::vector<InnerPoint> inner_points(const std::vector<NearestSurface>& bone,
                                     std::span<const Vector3d> line_mm)
{
  std::vector<InnerPoint> points;
  for (std::size_t k = 0; k + 1 < line_mm.size(); ++k) {
    const Vector3d span_mm = line_mm[k + 1] - line_mm[k];
    const int n = std::max(1, static_cast<int>(std::ceil(span_mm.norm() / spacing_mm)));
    for (int i = 0; i < n; ++i)
      points.push_back(inner_point(bone, line_mm[k] + static_cast<double>(i) / n * span_mm));
  }
  std::vector<InnerPoint> inner;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vector3d& p_mm = points[k].p_mm;
    const double off_mm = std::min((p_mm - line_mm.front()).norm(), (p_mm - line_mm.back()).norm());
    if (points[k].depth_mm > 0.0 && off_mm > excepted_mm && has_entry(points, k)) inner.push_back(points[k]);
  }
  return inner;
}

FibreCrossing deepest_crossing(const BonesOfJoint& bones, const model::Fibre& fibre,
                               const std::vector<model::Wrap>& wraps,
                               std::span<const Pose> X_reference_moving)
{
  FibreCrossing deepest;
  std::array<Vector3d, 26> line_mm;  // on a wrap, links bend by some degrees
  for (std::size_t i = 0; i < X_reference_moving.size(); ++i) {
    const Pose& X = X_reference_moving[i];
    model::sample_fibre_path(fibre, wraps, {Eigen::Matrix3d::Identity(), X.linear(), X.translation()},
                             line_mm);
    for (const BodyIndex body : all_bodies) {
      const double depth_mm = deepest_point(inner_points(part_of(bones, body), line_mm)).depth_mm;
      if (depth_mm > deepest.depth_mm) deepest = {body, depth_mm, i};
      for (Vector3d& p_mm : line_mm) p_mm = X.inverse() * p_mm;
    }
  }
  return deepest;
}

namespace {

// Points closer to each other than rounding of files must not decide on which side an attachment is.
constexpr double clear_start_mm = 0.01, clear_end_mm = 2.0;
// A fibre wraps on the side of its line. Solved poses differ from these by some mm: beside the axis the fibre
// would change sides, and its force would jump.
constexpr double clear_line_mm = 3.0;
constexpr double least_radius_mm = 4.0, most_radius_mm = 80.0;
constexpr double half_length_mm = 200.0;  // beyond every knee: the path never slips off an end
constexpr double settled_mm = 0.25;       // of depth, below the 1 mm that is allowed
constexpr double wanted_gain_mm = 0.5;

// In the plane across the cylinder: x along the fibre, y outward, the attachment at the origin.
struct Circle {
  Vector2d centre_mm = Vector2d::Zero();
  double radius_mm = 0.0;
};

// A pose of the other bone.
struct PlanePose {
  Vector2d end_mm = Vector2d::Zero();
  std::vector<Vector2d> surface_mm;  // what the path must clear
};

// The normals where the path touches the circle, from the attachment and from the end.
struct Contact {
  bool is_wrapped = false;
  Vector2d first, last;
};

// `turn` is 1 for the tangent point that lies counter-clockwise of the point.
Vector2d tangent_normal(const Vector2d& p, double turn)
{
  const double square = p.squaredNorm(), root = std::sqrt(std::max(0.0, square - 1.0));
  return (p + turn * root * Vector2d(-p.y(), p.x())) / square;
}

double cross(const Vector2d& a, const Vector2d& b)
{
  return a.x() * b.y() - a.y() * b.x();
}

Contact contact_of(const Circle& circle, const Vector2d& end_mm)
{
  Contact contact;
  const Vector2d start = -circle.centre_mm / circle.radius_mm;
  const Vector2d end = (end_mm - circle.centre_mm) / circle.radius_mm;
  contact.first = tangent_normal(start, -1.0);
  contact.last = tangent_normal(end, 1.0);
  contact.is_wrapped = cross(contact.last, contact.first) > 0.0;
  return contact;
}

double length_mm(const Circle& circle, const Contact& contact, const Vector2d& end_mm)
{
  if (!contact.is_wrapped) return end_mm.norm();
  const double r_sq = circle.radius_mm * circle.radius_mm;
  const double arc_rad = arc_tangent2(cross(contact.last, contact.first), contact.last.dot(contact.first));
  return std::sqrt(std::max(0.0, circle.centre_mm.squaredNorm() - r_sq)) + circle.radius_mm * arc_rad +
         std::sqrt(std::max(0.0, (end_mm - circle.centre_mm).squaredNorm() - r_sq));
}

// How far a point is outside the path; the path is the border of a convex set.
double protrusion_mm(const Circle& circle, const Contact& contact, const Vector2d& end_mm,
                     const Vector2d& p_mm)
{
  if (!contact.is_wrapped) return cross(end_mm, p_mm) / end_mm.norm();
  const Vector2d off_mm = p_mm - circle.centre_mm;
  if (cross(off_mm, contact.first) < 0.0) return contact.first.dot(p_mm);
  if (cross(contact.last, off_mm) < 0.0) return contact.last.dot(p_mm - end_mm);
  return off_mm.norm() - circle.radius_mm;
}

// Of the centre above the fibre's line.
double height_mm(const Circle& circle, const PlanePose& pose)
{
  return cross(pose.end_mm, circle.centre_mm) / pose.end_mm.norm();
}

// Mean length of the paths, in mm, with penalties on the surface outside them and on lines beside the axis.
double cost_of(const Circle& circle, const std::vector<PlanePose>& poses)
{
  constexpr double per_mm = 50.0;  // so that 0.1 mm of protrusion costs more than a detour of 0.3 mm
  constexpr double per_line_mm = 5.0;
  constexpr double refused = 1e6;
  double excess_mm = std::max({0.0, least_radius_mm - circle.radius_mm, circle.radius_mm - most_radius_mm,
                               circle.radius_mm + clear_start_mm - circle.centre_mm.norm()});
  for (const PlanePose& pose : poses) {
    const double line_mm = height_mm(circle, pose);
    const double end_mm = (pose.end_mm - circle.centre_mm).norm();
    excess_mm = std::max({excess_mm, line_mm, circle.radius_mm + clear_end_mm - end_mm});
  }
  if (excess_mm > 0.0) return refused * (1.0 + excess_mm);
  double sum = 0.0;
  for (const PlanePose& pose : poses) {
    const Contact contact = contact_of(circle, pose.end_mm);
    double most_mm = 0.0;
    for (const Vector2d& p_mm : pose.surface_mm)
      most_mm = std::max(most_mm, protrusion_mm(circle, contact, pose.end_mm, p_mm));
    const double beside_mm = std::max(0.0, height_mm(circle, pose) + clear_line_mm);
    sum += length_mm(circle, contact, pose.end_mm) + per_mm * most_mm * most_mm +
           per_line_mm * beside_mm * beside_mm;
  }
  return sum / static_cast<double>(poses.size());
}

// Pattern search: steps of the centre and of the radius, with the point nearest to the fibre kept or not.
Circle improved(Circle circle, const std::vector<PlanePose>& poses)
{
  constexpr double first_step_mm = 4.0, last_step_mm = 0.02;
  struct Step {
    double x, y, radius;
  };
  constexpr std::array<Step, 10> steps{{{1, 0, 0},
                                        {-1, 0, 0},
                                        {0, 1, 0},
                                        {0, -1, 0},
                                        {0, 0, 1},
                                        {0, 0, -1},
                                        {0, -1, 1},
                                        {0, 1, -1},
                                        {1, -1, 1},
                                        {-1, -1, 1}}};
  double best = cost_of(circle, poses);
  for (double step_mm = first_step_mm; step_mm > last_step_mm;) {
    bool is_better = false;
    for (const Step& step : steps) {
      const Circle next{circle.centre_mm + step_mm * Vector2d(step.x, step.y),
                        circle.radius_mm + step_mm * step.radius};
      const double cost = cost_of(next, poses);
      if (!(cost < best)) continue;
      best = cost;
      circle = next;
      is_better = true;
      break;
    }
    if (!is_better) step_mm *= 0.5;
  }
  return circle;
}

// The axes of the plane in the bone's frame, and the points in it.
struct FibrePlane {
  Vector3d start_mm;
  Eigen::Matrix3d R_bone_plane;  // columns: along the fibre, outward, along the cylinder

  Vector2d operator()(const Vector3d& p_mm) const
  {
    return (R_bone_plane.transpose() * (p_mm - start_mm)).head<2>();
  }
};

model::Wrap wrap_of(const Circle& circle, const FibrePlane& plane)
{
  model::Wrap wrap;
  wrap.radii_mm = {circle.radius_mm, circle.radius_mm, half_length_mm};
  wrap.X_body_wrap.linear() = plane.R_bone_plane;
  wrap.X_body_wrap.translation() = plane.start_mm + plane.R_bone_plane.leftCols<2>() * circle.centre_mm;
  return wrap;
}

std::vector<Vector3d> wrapped_line_mm(const model::Wrap& wrap, const Vector3d& start_mm,
                                      const Vector3d& end_mm)
{
  constexpr int n_arc = 16;
  const Pose X_wrap_body = wrap.X_body_wrap.inverse();
  const model::WrapPath path = model::cylinder_path(X_wrap_body * start_mm, X_wrap_body * end_mm,
                                                    wrap.radii_mm.x(), wrap.radii_mm.z());
  std::vector<Vector3d> line_mm{start_mm};
  for (int k = 0; path.is_wrapped && k <= n_arc; ++k)
    line_mm.push_back(wrap.X_body_wrap * model::cylinder_point_mm(path, path.arc_mm * k / n_arc));
  line_mm.push_back(end_mm);
  return line_mm;
}

// A fibre in the frame of one body, with the other body at several poses.
struct FibreLines {
  Vector3d start_mm;  // on this body
  std::vector<Vector3d> end_mm;
  std::vector<Pose> X_body_other;
};

FibreLines lines_of(const model::Fibre& fibre, BodyIndex body, std::span<const Pose> X_reference_moving)
{
  const bool is_moving = body == BodyIndex::moving;
  FibreLines lines{attachment_mm(fibre, body), {}, {}};
  for (const Pose& X : X_reference_moving) {
    lines.X_body_other.push_back(is_moving ? X.inverse() : X);
    lines.end_mm.push_back(lines.X_body_other.back() * (is_moving ? fibre.reference_mm : fibre.moving_mm));
  }
  return lines;
}

// Of both bones, in the frame of `body`.
std::vector<InnerPoint> inner_points(const BonesOfJoint& bones, BodyIndex body, const Pose& X_body_other,
                                     std::vector<Vector3d> line_mm)
{
  const BodyIndex other = body == BodyIndex::moving ? BodyIndex::reference : BodyIndex::moving;
  std::vector<InnerPoint> inner = inner_points(part_of(bones, body), line_mm);
  const Pose X_other_body = X_body_other.inverse();
  for (Vector3d& p_mm : line_mm) p_mm = X_other_body * p_mm;
  for (const InnerPoint& point : inner_points(part_of(bones, other), line_mm))
    inner.push_back({X_body_other * point.p_mm, X_body_other * point.surface_mm,
                     X_body_other.linear() * point.outward, point.depth_mm});
  return inner;
}

// The points inside either bone [poses]; of straight lines without a wrap.
std::vector<std::vector<InnerPoint>> inner_points(const BonesOfJoint& bones, BodyIndex body,
                                                  const FibreLines& lines, const model::Wrap* wrap)
{
  std::vector<std::vector<InnerPoint>> inner;
  for (std::size_t i = 0; i < lines.end_mm.size(); ++i)
    inner.push_back(inner_points(bones, body, lines.X_body_other[i],
                                 wrap ? wrapped_line_mm(*wrap, lines.start_mm, lines.end_mm[i])
                                      : std::vector{lines.start_mm, lines.end_mm[i]}));
  return inner;
}

double deepest_mm(const std::vector<std::vector<InnerPoint>>& inner)
{
  double most_mm = 0.0;
  for (const std::vector<InnerPoint>& points : inner)
    most_mm = std::max(most_mm, deepest_point(points).depth_mm);
  return most_mm;
}

// Along the mean direction of the fibre where it crosses bone, and the normals there, by depth.
FibrePlane plane_of(const FibreLines& lines, const std::vector<std::vector<InnerPoint>>& inner)
{
  Vector3d along = Vector3d::Zero(), outward = Vector3d::Zero();
  for (std::size_t i = 0; i < inner.size(); ++i) {
    for (const InnerPoint& point : inner[i]) {
      along += point.depth_mm * (lines.end_mm[i] - lines.start_mm).normalized();
      outward += point.depth_mm * point.outward;
    }
  }
  along.normalize();
  outward = (outward - outward.dot(along) * along).normalized();
  FibrePlane plane{lines.start_mm, {}};
  plane.R_bone_plane << along, outward, along.cross(outward);
  return plane;
}

// Circles of several sizes below the highest point to be cleared, improved; the best of them.
Circle best_circle(const std::vector<PlanePose>& poses)
{
  Vector2d top_mm = Vector2d::Constant(-1e9);
  for (const PlanePose& pose : poses) {
    for (const Vector2d& p_mm : pose.surface_mm) {
      if (p_mm.y() > top_mm.y()) top_mm = p_mm;
    }
  }
  Circle best;
  double least = 1e300;
  for (const double radius_mm : {5.0, 9.0, 15.0, 25.0, 40.0}) {
    const Circle circle = improved({top_mm - Vector2d(0.0, radius_mm), radius_mm}, poses);
    const double cost = cost_of(circle, poses);
    if (cost < least) {
      least = cost;
      best = circle;
    }
  }
  return best;
}

}  // namespace

std::optional<model::Wrap> wrap_over(const BonesOfJoint& bones, BodyIndex body, const model::Fibre& fibre,
                                     std::span<const Pose> X_reference_moving)
{
  constexpr int most_rounds = 6;
  const FibreLines lines = lines_of(fibre, body, X_reference_moving);
  std::vector<std::vector<InnerPoint>> inner = inner_points(bones, body, lines, nullptr);
  double least_mm = deepest_mm(inner) - wanted_gain_mm;
  if (least_mm <= 0.0) return std::nullopt;
  const FibrePlane plane = plane_of(lines, inner);
  std::vector<PlanePose> poses;
  for (const Vector3d& end_mm : lines.end_mm) poses.push_back({plane(end_mm), {}});
  std::optional<model::Wrap> best;
  for (int round = 0; round < most_rounds; ++round) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      for (const InnerPoint& point : inner[i]) poses[i].surface_mm.push_back(plane(point.surface_mm));
    }
    model::Wrap wrap = wrap_of(best_circle(poses), plane);
    wrap.body = body;
    inner = inner_points(bones, body, lines, &wrap);
    const double left_mm = deepest_mm(inner);
    if (left_mm < least_mm) {
      best = wrap;
      least_mm = left_mm;
    }
    if (left_mm <= settled_mm) break;
  }
  return best;
}

}  // namespace vrda::geometry
