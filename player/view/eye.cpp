#include "view/eye.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vrda::view {

const std::vector<std::string>& layout_names()
{
  static const std::vector<std::string> names{"quarters", "side-by-side", "top-bottom", "two-outputs"};
  return names;
}

std::optional<Layout> layout_named(const std::string& name)
{
  const std::vector<std::string>& names = layout_names();
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Layout>(found - names.begin());
}

namespace {

/// 640 x 480, or all of a smaller quarter, centred in the quarter with corner (x, y): the part of the
/// thesis's 640 x 512 that NTSC displays.
Viewport in_quarter(int x, int y, int width, int height)
{
  constexpr int most_width = 640, most_height = 480;
  const int w = std::min(width, most_width), h = std::min(height, most_height);
  return {x + (width - w) / 2, y + (height - h) / 2, w, h};
}

}  // namespace

EyeWindows eye_windows(Layout layout, int width, int height, const std::string& file)
{
  if (width < 2 || height < 2) {
    throw InputError({file, "display.size", std::to_string(width) + "x" + std::to_string(height),
                      "at least 2 pixels each way"});
  }
  const int w = width / 2, h = height / 2;
  switch (layout) {
    case Layout::quarters:
      return {in_quarter(width - w, 0, w, h), in_quarter(width - w, height - h, w, h)};
    case Layout::top_bottom:
      return {{0, 0, width, h}, {0, height - h, width, h}};
    case Layout::side_by_side:
    case Layout::two_outputs:
      break;
  }
  return {{0, 0, w, height}, {width - w, 0, w, height}};
}

Eigen::Vector2f reflected_px(const Reflection& reflection, const Viewport& window, const Eigen::Vector2f& at)
{
  const Eigen::Vector2f across(static_cast<float>(2 * window.x + window.width),
                               static_cast<float>(2 * window.y + window.height));
  return {reflection.is_mirrored ? across.x() - at.x() : at.x(),
          reflection.is_flipped ? across.y() - at.y() : at.y()};
}

Viewport within(const Viewport& inner, const Viewport& outer)
{
  const int left = std::max(inner.x, outer.x), top = std::max(inner.y, outer.y);
  const int right = std::min(inner.x + inner.width, outer.x + outer.width);
  const int bottom = std::min(inner.y + inner.height, outer.y + outer.height);
  if (right <= left || bottom <= top) return {};
  return {left, top, right - left, bottom - top};
}

Eigen::Vector2d middle_px(const Viewport& v)
{
  return {v.x + 0.5 * v.width, v.y + 0.5 * v.height};
}

namespace {

double shown_radius(const Distortion& d, double r)
{
  return r * (1.0 + r * r * (d.k1 + d.k2 * r * r));
}

double slope(const Distortion& d, double r)
{
  return 1.0 + r * r * (3.0 * d.k1 + 5.0 * d.k2 * r * r);
}

/// Smallest root r > 0 of 1 + 3 k1 r^2 + 5 k2 r^4; infinite if none exists.
double fold_radius(const Distortion& d)
{
  constexpr double never = std::numeric_limits<double>::infinity();
  const double a = 5.0 * d.k2, b = 3.0 * d.k1;  // of a s^2 + b s + 1, s = r^2
  const double discriminant = b * b - 4.0 * a;
  if (discriminant < 0.0) return never;
  // 2 / (-b +- root) is the form of the roots without cancellation.
  const double root = std::sqrt(discriminant);
  double smallest = never;
  for (const double denominator : {-b + root, -b - root}) {
    if (denominator > 0.0) smallest = std::min(smallest, 2.0 / denominator);
  }
  return std::sqrt(smallest);
}

/// Conversions between pixels and units about the centre.
Eigen::Vector2d in_units(const Distortion& d, const Eigen::Vector2d& px)
{
  const Eigen::Vector2d from_centre = px - d.centre_px;
  return Eigen::Vector2d(from_centre.x(), from_centre.y() * d.pixel_aspect) / d.unit_px;
}

Eigen::Vector2d in_pixels(const Distortion& d, const Eigen::Vector2d& units)
{
  return d.centre_px + d.unit_px * Eigen::Vector2d(units.x(), units.y() / d.pixel_aspect);
}

/// The r with shown_radius(r) = `shown`, or the fold radius if none exists.
double drawn_radius(const Distortion& d, double shown)
{
  double low = 0.0, high = std::max(1.0, shown);
  const double fold = fold_radius(d);
  while (high < fold && shown_radius(d, high) < shown) high *= 2.0;
  high = std::min(high, fold);
  if (shown_radius(d, high) <= shown) return high;
  double r = std::min(shown, high);
  constexpr int most_steps = 100;
  constexpr double resolution = 1e-15;
  for (int step = 0; step < most_steps && high - low > resolution * high; ++step) {
    const double ahead = shown_radius(d, r) - shown;
    if (ahead == 0.0) break;
    (ahead < 0.0 ? low : high) = r;
    const double next = r - ahead / slope(d, r);
    if (std::abs(next - r) <= resolution * r) break;  // the bracket need not close around it
    r = next > low && next < high ? next : 0.5 * (low + high);
  }
  return r;
}

}  // namespace

Eigen::Vector2d shown_px(const Distortion& distortion, const Eigen::Vector2d& drawn_px)
{
  const Eigen::Vector2d p = in_units(distortion, drawn_px);
  const double s = p.squaredNorm();
  return in_pixels(distortion, p * (1.0 + s * (distortion.k1 + distortion.k2 * s)));
}

Eigen::Vector2d drawn_px(const Distortion& distortion, const Eigen::Vector2d& shown_px)
{
  const Eigen::Vector2d p = in_units(distortion, shown_px);
  const double r = p.norm();
  if (r == 0.0) return shown_px;
  return in_pixels(distortion, p * (drawn_radius(distortion, r) / r));
}

double fold_radius_px(const Distortion& distortion)
{
  return distortion.unit_px * fold_radius(distortion);
}

namespace {

std::array<Eigen::Vector2d, 4> corners_px(const Viewport& v)
{
  const double left = v.x, right = v.x + v.width, top = v.y, bottom = v.y + v.height;
  return {Eigen::Vector2d(left, top), {right, top}, {left, bottom}, {right, bottom}};
}

}  // namespace

double distance_y_px(const Eye& eye)
{
  return eye.distance_px / eye.pixel_aspect;
}

ShownBox box_of(const Viewport& viewport)
{
  return {{viewport.x, viewport.y}, {viewport.x + viewport.width, viewport.y + viewport.height}};
}

void set_ipd(EyePair& eyes, double ipd_mm)
{
  eyes.left.position_head_mm.x() = -0.5 * ipd_mm;
  eyes.right.position_head_mm.x() = 0.5 * ipd_mm;
}

ShownBox shown_box(const Eye& eye)
{
  const Viewport& v = eye.visible;
  // Along an edge the shown position is extreme at a corner (pincushion) or nearest to the centre (barrel).
  const double x = std::clamp<double>(eye.distortion.centre_px.x(), v.x, v.x + v.width);
  const double y = std::clamp<double>(eye.distortion.centre_px.y(), v.y, v.y + v.height);
  const std::array<Eigen::Vector2d, 4> corners = corners_px(v);
  const std::array<Eigen::Vector2d, 8> points = {corners[0],
                                                 corners[1],
                                                 corners[2],
                                                 corners[3],
                                                 Eigen::Vector2d(x, v.y),
                                                 Eigen::Vector2d(x, v.y + v.height),
                                                 Eigen::Vector2d(v.x, y),
                                                 Eigen::Vector2d(v.x + v.width, y)};
  ShownBox box;
  box.low_px = box.high_px = shown_px(eye.distortion, points[0]);
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d shown = shown_px(eye.distortion, point);
    box.low_px = box.low_px.cwiseMin(shown);
    box.high_px = box.high_px.cwiseMax(shown);
  }
  return box;
}

Eigen::Vector2d shown_px(const Eye& eye, const Eigen::Vector3d& p_head_mm)
{
  const Eigen::Vector3d p = p_head_mm - eye.position_head_mm;
  check(p.z() < 0.0, "a projected point is in front of the eye");
  return eye.sight_px + Eigen::Vector2d(eye.distance_px * p.x(), -distance_y_px(eye) * p.y()) / -p.z();
}

Eigen::Vector2d drawn_px(const Eye& eye, const Eigen::Vector3d& p_head_mm)
{
  return drawn_px(eye.distortion, shown_px(eye, p_head_mm));
}

double furthest_radius_px(const Distortion& distortion, const Viewport& v)
{
  double furthest_px = 0.0;
  for (const Eigen::Vector2d& corner : corners_px(v)) {
    const Eigen::Vector2d from_centre = corner - distortion.centre_px;
    furthest_px =
        std::max(furthest_px, std::hypot(from_centre.x(), distortion.pixel_aspect * from_centre.y()));
  }
  return furthest_px;
}

std::optional<InputError::Facts> usability_error(const Eye& eye, const std::string& file,
                                                 const std::string& name)
{
  const auto refused = [&](const char* field, const std::string& found, const std::string& wanted) {
    return InputError::Facts{file, name + "." + field, found, wanted};
  };
  const auto text = [](double value) { return std::to_string(value); };
  if (!(eye.distance_px > 0.0)) return refused("distance_px", text(eye.distance_px), "above 0");
  if (!(eye.pixel_aspect > 0.0)) return refused("pixel_aspect", text(eye.pixel_aspect), "above 0");
  const Viewport seen = within(eye.visible, eye.window);
  if (seen.width != eye.visible.width || seen.height != eye.visible.height || seen.width < 1) {
    return refused("visible",
                   std::to_string(eye.visible.width) + "x" + std::to_string(eye.visible.height) + " at " +
                       std::to_string(eye.visible.x) + ", " + std::to_string(eye.visible.y),
                   "a rectangle within the eye's window");
  }
  const std::string numbers = "k1 " + text(eye.distortion.k1) + ", k2 " + text(eye.distortion.k2);
  const double furthest_px = furthest_radius_px(eye.distortion, eye.visible);
  const double fold_px = fold_radius_px(eye.distortion);
  if (!(fold_px > furthest_px)) {
    return refused("distortion", numbers + ", which fold at a radius of " + text(fold_px) + " px",
                   "a distortion that is monotonic up to " + text(furthest_px) + " px");
  }
  const Eigen::Vector2d shown = shown_box(eye).high_px - shown_box(eye).low_px;
  const Eigen::Vector2d most =
      (max_source_scale * Eigen::Vector2d(eye.visible.width, eye.visible.height)).cwiseMin(max_source_px);
  if (!(shown.array() <= most.array()).all()) {
    return refused("distortion",
                   numbers + ", which require " + text(shown.x()) + " x " + text(shown.y()) + " px",
                   "at most " + text(most.x()) + " x " + text(most.y()));
  }
  return std::nullopt;
}

std::optional<InputError::Facts> usability_error(const EyePair& eyes, const std::string& file)
{
  const std::optional<InputError::Facts> left = usability_error(eyes.left, file, "left");
  return left ? left : usability_error(eyes.right, file, "right");
}

void require_usable(const EyePair& eyes, const std::string& file)
{
  if (const std::optional<InputError::Facts> facts = usability_error(eyes, file)) throw InputError(*facts);
}

namespace {

struct Cells {
  int across = 1, down = 1;
};

Eigen::Vector2d node_px(const Viewport& visible, const Cells& cells, double i, double j)
{
  return {visible.x + visible.width * (i / cells.across), visible.y + visible.height * (j / cells.down)};
}

/// The interpolation error at the midpoints of cell edges and diagonals is at most `error_px`.
bool is_fine_enough(const Eye& eye, const Cells& cells, double error_px)
{
  const auto shown = [&](double i, double j) {
    return shown_px(eye.distortion, node_px(eye.visible, cells, i, j));
  };
  const auto row = [&](int j) {
    std::vector<Eigen::Vector2d> nodes;
    for (int i = 0; i <= cells.across; ++i) nodes.push_back(shown(i, j));
    return nodes;
  };
  std::vector<Eigen::Vector2d> upper = row(0);
  for (int j = 0; j < cells.down; ++j) {
    std::vector<Eigen::Vector2d> lower = row(j + 1);
    for (int i = 0; i < cells.across; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Eigen::Vector2d& a = upper[k];
      const double largest_px = std::max({(shown(i + 0.5, j) - 0.5 * (a + upper[k + 1])).norm(),
                                          (shown(i, j + 0.5) - 0.5 * (a + lower[k])).norm(),
                                          (shown(i + 0.5, j + 0.5) - 0.5 * (a + lower[k + 1])).norm()});
      if (largest_px > error_px) return false;
    }
    upper = std::move(lower);
  }
  return true;
}

Cells cells_for(const Eye& eye, double error_px)
{
  constexpr int most = 512;  // one or two pixels per cell
  const double shape = static_cast<double>(eye.visible.height) / eye.visible.width;
  const auto cells = [shape](int across) {
    return Cells{across, std::max(1, static_cast<int>(std::ceil(across * shape)))};
  };
  int across = 1;
  while (across < most && !is_fine_enough(eye, cells(across), error_px)) across *= 2;
  return cells(across);
}

}  // namespace

WarpMesh warp_mesh(const Eye& eye, const ShownBox& box, double error_px)
{
  const Cells cells = cells_for(eye, error_px);
  const Eigen::Vector2d size_px = box.high_px - box.low_px;
  WarpMesh mesh;
  for (int j = 0; j <= cells.down; ++j) {
    for (int i = 0; i <= cells.across; ++i) {
      const Eigen::Vector2d drawn = node_px(eye.visible, cells, i, j);
      const Eigen::Vector2d uv = (shown_px(eye.distortion, drawn) - box.low_px).cwiseQuotient(size_px);
      mesh.vertices.push_back({static_cast<float>(drawn.x()), static_cast<float>(drawn.y()),
                               static_cast<float>(uv.x()), static_cast<float>(uv.y())});
    }
  }
  const auto n = static_cast<std::uint32_t>(cells.across + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(cells.down); ++j) {
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(cells.across); ++i) {
      const std::uint32_t a = j * n + i;
      // The diagonal is a-d, as in is_fine_enough.
      mesh.triangles.insert(mesh.triangles.end(), {a, a + n, a + n + 1, a, a + n + 1, a + 1});
    }
  }
  return mesh;
}

}  // namespace vrda::view
