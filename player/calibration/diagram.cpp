#include "calibration/diagram.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "calibration/viewport_fit.hpp"
#include "calibration/parts.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

using Point = Eigen::Vector2d;
using Stroke = std::vector<Point>;
using enum DiagramInk;

class Sketch {
 public:
  void line(DiagramInk ink, Stroke points) { drawn.lines.push_back({std::move(points), ink}); }
  void box(DiagramInk ink, const Point& low, const Point& high)
  {
    line(ink, {low, {high.x(), low.y()}, high, {low.x(), high.y()}, low});
  }
  void circle(DiagramInk ink, const Point& middle, double radius)
  {
    constexpr int n = 24;
    Stroke points;
    for (int k = 0; k <= n; ++k)
      points.emplace_back(middle + radius * Point(std::cos(2.0 * pi * k / n), std::sin(2.0 * pi * k / n)));
    line(ink, std::move(points));
  }
  void arrow(DiagramInk ink, const Point& from, const Point& to)
  {
    const Point along = 0.03 * (to - from).normalized(), across(-along.y(), along.x());
    line(ink, {from, to});
    line(ink, {to - along + 0.6 * across, to, to - along - 0.6 * across});
  }
  void label(const Point& at, std::string text) { drawn.labels.push_back({at, std::move(text)}); }
  /// Seen from above: looks towards smaller y.
  void eye(const Point& at, DiagramInk ink = plain)
  {
    circle(ink, at, 0.025);
    circle(ink, at - Point(0.0, 0.018), 0.008);
  }

  Diagram drawn;
};

void draw_scan(Sketch& sketch, const Task& task)
{
  const Point low(0.1, 0.03), high(0.9, 0.57), seen_low(0.22, 0.09), seen_high(0.78, 0.51);
  sketch.box(plain, low, high);
  sketch.box(real, seen_low, seen_high);
  const auto edge = static_cast<calibration::Edge>(task.index);
  const bool is_first = edge == calibration::Edge::left || edge == calibration::Edge::top;
  constexpr double off = 0.09;
  if (task.is_column) {
    const double border = is_first ? seen_low.x() : seen_high.x(), at = border + (is_first ? off : -off);
    sketch.line(lit, {{at, low.y()}, {at, high.y()}});
    sketch.arrow(lit, {at, 0.3}, {border, 0.3});
  } else {
    const double border = is_first ? seen_low.y() : seen_high.y(), at = border + (is_first ? off : -off);
    sketch.line(lit, {{low.x(), at}, {high.x(), at}});
    sketch.arrow(lit, {0.5, at}, {0.5, border});
  }
}

/// Lines of the operator's grid, of which the task's node is lit.
void draw_nodes(Sketch& sketch, const Task& task, const CalibrationSettings& settings)
{
  const bool is_grid = task.kind == TaskKind::grid;
  const double spacing = std::min(0.8 / (settings.grid_columns - 1), 0.5 / (settings.grid_rows - 1));
  const Point half = 0.5 * spacing * Point(settings.grid_columns - 1, settings.grid_rows - 1);
  const Point middle(0.5, 0.3);
  const auto add_lines = [&](DiagramInk ink, double bend) {
    const auto at = [&](double x, double y) {
      const double r_sq = Point(x, y).squaredNorm() / half.squaredNorm();
      return Point(middle + (1.0 - bend * r_sq) * Point(x, y));
    };
    constexpr int n = 12;
    const auto add = [&](const Point& from, const Point& to) {
      Stroke points;
      for (int k = 0; k <= n; ++k) {
        const Point p = from + (to - from) * k / n;
        points.push_back(at(p.x(), p.y()));
      }
      sketch.line(ink, std::move(points));
    };
    for (int k = 0; k < settings.grid_columns; ++k)
      add({-half.x() + k * spacing, -half.y()}, {-half.x() + k * spacing, half.y()});
    for (int k = 0; k < settings.grid_rows; ++k)
      add({-half.x(), -half.y() + k * spacing}, {half.x(), -half.y() + k * spacing});
  };
  add_lines(real, 0.0);
  if (is_grid) return add_lines(lit, 0.08);
  const Point node = middle + spacing * Point(task.node.x(), -task.node.y());
  sketch.line(lit, {node - Point(0.03, 0.0), node + Point(0.03, 0.0)});
  sketch.line(lit, {node - Point(0.0, 0.03), node + Point(0.0, 0.03)});
  sketch.circle(lit, node, 0.02);
}

/// From above: eye, screen, rectangles behind each other.
void draw_rectangles(Sketch& sketch, const Task& task, const CalibrationSettings& settings)
{
  double deepest = 1.0, widest = 1.0;
  for (const auto& r : settings.rectangles) {
    deepest = std::max(deepest, r.depth_mm);
    widest = std::max(widest, r.width_mm);
  }
  const Point eye(task.is_right ? 0.55 : 0.45, 0.56);
  sketch.eye({0.45, 0.56}, task.is_right ? plain : lit);
  sketch.eye({0.55, 0.56}, task.is_right ? lit : plain);
  for (std::size_t k = 0; k < settings.rectangles.size(); ++k) {
    const auto& r = settings.rectangles[k];
    const double y = 0.34 - 0.28 * r.depth_mm / deepest, half = 0.3 * r.width_mm / widest;
    const bool is_it = static_cast<int>(k) == task.index;
    sketch.line(is_it ? real : plain, {{0.5 - half, y}, {0.5 + half, y}});
    if (!is_it) continue;
    sketch.line(lit, {eye, {0.5 - half, y}});
    sketch.line(lit, {eye, {0.5 + half, y}});
  }
}

void draw_pupils(Sketch& sketch, const Task& task)
{
  const Point left(0.35, 0.35), right(0.65, 0.35);
  for (const Point& eye : {left, right}) {
    sketch.circle(plain, eye, 0.08);
    sketch.circle(plain, eye, 0.025);
  }
  const auto measure = [&](double from, double to) {
    sketch.arrow(lit, {0.5 * (from + to), 0.18}, {to, 0.18});
    sketch.arrow(lit, {0.5 * (from + to), 0.18}, {from, 0.18});
  };
  if (task.index == 0) measure(left.x(), right.x());
  if (task.index == 1) measure(left.x(), 0.5);
  if (task.index == 2) measure(0.5, right.x());
  if (task.index == 3) {
    sketch.box(real, {0.35, 0.02}, {0.65, 0.12});
    sketch.arrow(lit, {0.5, 0.5}, {0.5, 0.14});
  }
}

void draw_depth_check(Sketch& sketch)
{
  sketch.eye({0.45, 0.56});
  sketch.eye({0.55, 0.56});
  sketch.box(real, {0.3, 0.06}, {0.68, 0.3});
  sketch.box(lit, {0.32, 0.08}, {0.7, 0.32});
  sketch.label({0.02, 0.12}, "both at one depth?");
}

/// From above: rails of the stage (x) and of the slide (z).
void draw_rails(Sketch& sketch, const Task& task)
{
  const bool is_x = task.name != "z rail";
  sketch.box(plain, {0.08, 0.04}, {0.92, 0.56});
  sketch.line(is_x ? real : plain, {{0.15, 0.46}, {0.85, 0.46}});
  sketch.line(is_x ? plain : real, {{0.5, 0.1}, {0.5, 0.4}});
  if (task.kind == TaskKind::stop) {
    sketch.box(real, {0.1, 0.42}, {0.14, 0.5});
    sketch.box(plain, {0.3, 0.43}, {0.4, 0.49});
    sketch.arrow(lit, {0.3, 0.46}, {0.15, 0.46});
    return;
  }
  const Point from = is_x ? Point(0.2, 0.46) : Point(0.5, 0.12),
              to = is_x ? Point(0.8, 0.46) : Point(0.5, 0.38);
  sketch.circle(real, from, 0.025);
  sketch.arrow(lit, from, to);
}

void draw_pivot(Sketch& sketch)
{
  const Point tip(0.5, 0.55);
  sketch.line(plain, {{0.1, 0.56}, {0.9, 0.56}});
  for (const double turn : {-0.35, 0.0, 0.35}) {
    const Point end = tip + 0.45 * Point(std::sin(turn), -std::cos(turn));
    sketch.line(turn == 0.0 ? real : plain, {tip, end});
  }
  sketch.arrow(lit, {0.52, 0.1}, {0.66, 0.14});
  sketch.arrow(lit, {0.48, 0.1}, {0.34, 0.14});
}

/// From the side: thigh and shank, bent and extended.
void draw_bend(Sketch& sketch)
{
  const Point hip(0.15, 0.12), knee(0.5, 0.12);
  sketch.line(real, {hip, knee});
  sketch.circle(plain, knee, 0.025);
  for (const double angle : {0.2, 0.9, 1.6})
    sketch.line(angle == 0.9 ? real : plain, {knee, knee + 0.38 * Point(std::cos(angle), std::sin(angle))});
  sketch.arrow(lit, {0.8, 0.2}, {0.62, 0.44});
  sketch.arrow(lit, {0.8, 0.2}, {0.86, 0.12});
}

/// The marker's requested position in front of the eyes, from above and, for the height, from the side.
void draw_bullseye(Sketch& sketch, const Task& task)
{
  const Eigen::Vector3d at = calibration::requested_marker_position(task.index).cast<double>();
  sketch.label({0.12, 0.0}, "from above");
  sketch.label({0.62, 0.0}, "from the side");
  sketch.eye({0.22, 0.56}, task.is_right ? plain : lit);
  sketch.eye({0.28, 0.56}, task.is_right ? lit : plain);
  sketch.box(plain, {0.07, 0.1}, {0.43, 0.42});
  const Point above(0.25 + 0.15 * at.x(), 0.26 - 0.13 * at.z());
  sketch.circle(real, above, 0.015);
  sketch.circle(lit, above, 0.03);
  sketch.circle(plain, {0.55, 0.3}, 0.025);
  sketch.box(plain, {0.62, 0.12}, {0.95, 0.48});
  const Point beside(0.785 + 0.13 * at.z(), 0.3 - 0.14 * at.y());
  sketch.circle(real, beside, 0.015);
  sketch.circle(lit, beside, 0.03);
}

/// From the front and from the side: outline of the body, and all points, with the one to be touched lit.
void draw_points(Sketch& sketch, const std::vector<CalibrationPoint>& points, int next,
                 const BodyOutline* outline)
{
  sketch.drawn.height = 1.0;
  // Both views have the same scale.
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (const CalibrationPoint& point : points) {
    low = low.cwiseMin(point.p_model_mm);
    high = high.cwiseMax(point.p_model_mm);
  }
  constexpr double margin_mm = 15.0, view_width = 0.46, view_height = 0.88;
  low.array() -= margin_mm;
  high.array() += margin_mm;
  const double mm = std::min({view_width / (high.z() - low.z()), view_width / (high.x() - low.x()),
                              view_height / (high.y() - low.y())});
  for (std::size_t view = 0; view < 2; ++view) {
    const double left = view == 0 ? 0.02 : 0.52;
    sketch.label({left, 0.0}, view == 0 ? "from the front" : "from the right");
    const auto flat = [&](const Eigen::Vector3d& p) {
      return view == 0 ? Point(-p.z(), p.y()) : Point(p.x(), p.y());
    };
    const Point middle = 0.5 * (flat(low) + flat(high));
    const auto placed = [&](const Point& p) {
      return Point(left + 0.5 * view_width + mm * (p.x() - middle.x()), 0.54 - mm * (p.y() - middle.y()));
    };
    if (outline != nullptr) {
      for (const auto& [from, to] : outline->pieces[view]) {
        const Point a = placed(from), b = placed(to);
        const auto fits = [&](const Point& p) {
          return p.x() >= left && p.x() <= left + view_width && p.y() >= 0.06 && p.y() <= 1.0;
        };
        if (fits(a) && fits(b)) sketch.line(plain, {a, b});
      }
    }
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Point at = placed(flat(points[k].p_model_mm));
      const bool is_next = static_cast<int>(k) == next;
      sketch.circle(is_next ? lit : real, at, is_next ? 0.008 : 0.006);
      if (!is_next) continue;
      sketch.circle(lit, at, 0.025);
      if (view == 0) sketch.label(at + Point(0.03, -0.025), points[k].name);
    }
  }
}

}  // namespace

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
    const auto add = [&](std::size_t view, const Point& a, const Point& b) {
      if (faces.n_front[view] == 1) outline.pieces[view].push_back({a, b});
    };
    add(0, {-p.z(), p.y()}, {-q.z(), q.y()});
    add(1, {p.x(), p.y()}, {q.x(), q.y()});
  }
  return outline;
}

Diagram diagram_of(CalibrationPart part, const Task& task, const BenchFile& bench, const BodyOutline* outline)
{
  Sketch sketch;
  switch (task.kind) {
    case TaskKind::scan_line:
      draw_scan(sketch, task);
      break;
    case TaskKind::point:
    case TaskKind::grid:
      draw_nodes(sketch, task, bench.calibration);
      break;
    case TaskKind::rectangle_sides:
      draw_rectangles(sketch, task, bench.calibration);
      break;
    case TaskKind::number:
      if (part == CalibrationPart::ipd) {
        draw_pupils(sketch, task);
      } else if (part == CalibrationPart::viewport) {
        sketch.box(real, {0.2, 0.1}, {0.8, 0.5});
        const bool is_height = task.index == 1;
        sketch.arrow(lit, {0.5, 0.3}, is_height ? Point(0.5, 0.1) : Point(0.2, 0.3));
        sketch.arrow(lit, {0.5, 0.3}, is_height ? Point(0.5, 0.5) : Point(0.8, 0.3));
      } else {
        sketch.circle(real, {0.25, 0.3}, 0.012);
        sketch.circle(real, {0.75, 0.3}, 0.012);
        sketch.arrow(lit, {0.5, 0.3}, {0.26, 0.3});
        sketch.arrow(lit, {0.5, 0.3}, {0.74, 0.3});
        sketch.label({0.25, 0.36}, task.name);
      }
      break;
    case TaskKind::depth_check:
      draw_depth_check(sketch);
      break;
    case TaskKind::sweep:
      if (part == CalibrationPart::probe) {
        draw_pivot(sketch);
        break;
      }
      [[fallthrough]];
    case TaskKind::stop:
      draw_rails(sketch, task);
      break;
    case TaskKind::bend:
      draw_bend(sketch);
      break;
    case TaskKind::bullseye:
      draw_bullseye(sketch, task);
      break;
    case TaskKind::hold:
      draw_points(sketch, calibration::points_of(part, bench.calibration), task.index, outline);
      break;
    case TaskKind::model_pose:
      draw_points(sketch, calibration::points_of(part, bench.calibration), -1, outline);
      break;
  }
  return std::move(sketch.drawn);
}

}  // namespace vrda::calibration
