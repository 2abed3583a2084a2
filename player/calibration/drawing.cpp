#include "calibration/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/units.hpp"
#include "model/mesh.hpp"
#include "view/eye.hpp"

namespace vrda::calibration {
namespace {

/// Largest distance of neighbouring points.
constexpr double longest_piece_px = 8.0;

/// Limits the range of a segment to coordinates from `low` to `high`; false if it is outside.
bool clip(double at, double step, double low, double high, double& from, double& to)
{
  if (step == 0.0) return at >= low && at <= high;
  const double t1 = (low - at) / step, t2 = (high - at) / step;
  from = std::max(from, std::min(t1, t2));
  to = std::min(to, std::max(t1, t2));
  return from <= to;
}

}  // namespace

std::vector<Points2d> pieces_within(const Points2d& line, const view::ShownBox& box)
{
  std::vector<Points2d> pieces;
  bool is_continued = false;
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    double from = 0.0, to = 1.0;
    const Eigen::Vector2d a = line[k], step = line[k + 1] - a;
    const bool is_in = clip(a.x(), step.x(), box.low_px.x(), box.high_px.x(), from, to) &&
                       clip(a.y(), step.y(), box.low_px.y(), box.high_px.y(), from, to) && from < to;
    if (is_in && (!is_continued || from > 0.0)) pieces.push_back({a + from * step});
    if (is_in) pieces.back().emplace_back(a + to * step);
    is_continued = is_in && to >= 1.0;
  }
  return pieces;
}

/// Subdivides the line so that points are at most `longest_piece_px` apart.
Points2d with_points_between(const Points2d& line)
{
  Points2d dense;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (k > 0) {
      const Eigen::Vector2d& from = line[k - 1];
      const Eigen::Vector2d way = line[k] - from;
      const int n = std::max(1, static_cast<int>(std::ceil(way.norm() / longest_piece_px)));
      for (int i = 1; i < n; ++i) dense.emplace_back(from + way * i / n);
    }
    dense.push_back(line[k]);
  }
  return dense;
}

Points2d ring(const Eigen::Vector2d& middle_px, double radius_px, int n_pieces)
{
  Points2d points;
  for (int k = 0; k <= n_pieces; ++k) {
    const SinCos at = sin_cos(2.0 * pi * k / n_pieces);
    points.emplace_back(middle_px + radius_px * Eigen::Vector2d(at.cos, at.sin));
  }
  return points;
}

Points2d rectangle_points(const Eigen::Vector2d& low, const Eigen::Vector2d& high)
{
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}, low};
}

view::Viewport nearest_pixels(const view::ShownBox& box)
{
  const Eigen::Vector2d low = box.low_px.array().round(), high = box.high_px.array().round();
  const Eigen::Vector2i at = low.cast<int>(), size = (high - low).cast<int>();
  return {at.x(), at.y(), size.x(), size.y()};
}

DrawnLine real_outline(bool is_right, Points2d points_px)
{
  return {is_right, std::move(points_px), 1.5, true, {1.0F, 0.75F, 0.3F}};
}

void Pen::draw(const Points2d& points)
{
  for (Points2d& piece : pieces_within(points, view::box_of(eye_.visible)))
    lines_.push_back({is_right_, std::move(piece), 1.5});
}

void Pen::draw_shown(const Eigen::Vector2d& from, const Eigen::Vector2d& to)
{
  Points2d drawn{view::drawn_px(eye_.distortion, from)};
  const int n = std::max(1, static_cast<int>(std::ceil((to - from).norm() / longest_piece_px)));
  for (int k = 0; k < n; ++k)
    add_piece(from + (to - from) * k / n, from + (to - from) * (k + 1) / n, drawn, 0);
  draw(drawn);
}

/// Halves pieces that are too long after pre-distortion.
void Pen::add_piece(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Points2d& drawn, int depth) const
{
  constexpr int deepest = 8;
  const Eigen::Vector2d end = view::drawn_px(eye_.distortion, to);
  if ((end - drawn.back()).norm() <= longest_piece_px || depth == deepest) {
    drawn.push_back(end);
    return;
  }
  const Eigen::Vector2d middle = 0.5 * (from + to);
  add_piece(from, middle, drawn, depth + 1);
  add_piece(middle, to, drawn, depth + 1);
}

BodyOutline outline_of(const Body& body)
{
  BodyOutline outline;
  Mesh mesh = body.contact.mesh;
  append(mesh, body.visual.mesh);
  const std::array<Eigen::Vector3d, 2> towards_viewer{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  // Per edge: its faces that look to the viewer of each view, and its faces.
  struct Faces {
    std::array<int, 2> n_front{};
    int n = 0;
  };
  std::map<std::pair<std::int32_t, std::int32_t>, Faces> edges;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d normal = face_normal(mesh, t);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
      Faces& faces = edges[{std::min(a, b), std::max(a, b)}];
      ++faces.n;
      for (std::size_t view = 0; view < 2; ++view)
        if (normal.dot(towards_viewer[view]) > 0.0) ++faces.n_front[view];
    }
  }
  for (const auto& edge : edges) {
    const auto& ends = edge.first;
    const Faces& faces = edge.second;
    const Eigen::Vector3d p = mesh.vertices_mm.row(ends.first), q = mesh.vertices_mm.row(ends.second);
    const auto add = [&](std::size_t view, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      if (faces.n_front[view] == 1) outline.pieces[view].push_back({a, b});
    };
    add(0, {-p.z(), p.y()}, {-q.z(), q.y()});
    add(1, {p.x(), p.y()}, {q.x(), q.y()});
  }
  return outline;
}

void Sketch::circle(DiagramInk ink, const Eigen::Vector2d& middle, double radius)
{
  line(ink, ring(middle, radius));
}

void Sketch::arrow(DiagramInk ink, const Eigen::Vector2d& from, const Eigen::Vector2d& to)
{
  const Eigen::Vector2d along = 0.03 * (to - from).normalized(), across(-along.y(), along.x());
  line(ink, {from, to});
  line(ink, {to - along + 0.6 * across, to, to - along - 0.6 * across});
}

void Sketch::eyes(double x, double apart, DiagramInk left, DiagramInk right)
{
  constexpr double y = 0.56;
  for (const bool is_right : {false, true}) {
    const Eigen::Vector2d at(x + (is_right ? apart : -apart), y);
    circle(is_right ? right : left, at, 0.025);
    circle(is_right ? right : left, at - Eigen::Vector2d(0.0, 0.018), 0.008);
  }
}

Diagram diagram_of(const Task& task, const BenchFile& bench, const BodyOutline* outline)
{
  Sketch sketch;
  sketch.outline = outline;
  task.kind->sketch(sketch, task, bench);
  return std::move(sketch.drawn);
}

}  // namespace vrda::calibration
