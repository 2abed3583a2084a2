#include "optics/eye.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "optics/layout.hpp"

namespace vrda {
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
  // Along an edge the place shown is furthest out at a corner (pincushion) or beside the centre (barrel).
  const double x = std::clamp<double>(eye.distortion.centre_px.x(), v.x, v.x + v.width);
  const double y = std::clamp<double>(eye.distortion.centre_px.y(), v.y, v.y + v.height);
  const std::array<Eigen::Vector2d, 4> corners = corners_px(v);
  const std::array<Eigen::Vector2d, 8> places = {corners[0],
                                                 corners[1],
                                                 corners[2],
                                                 corners[3],
                                                 Eigen::Vector2d(x, v.y),
                                                 Eigen::Vector2d(x, v.y + v.height),
                                                 Eigen::Vector2d(v.x, y),
                                                 Eigen::Vector2d(v.x + v.width, y)};
  ShownBox box;
  box.low_px = box.high_px = shown_px(eye.distortion, places[0]);
  for (const Eigen::Vector2d& place : places) {
    const Eigen::Vector2d shown = shown_px(eye.distortion, place);
    box.low_px = box.low_px.cwiseMin(shown);
    box.high_px = box.high_px.cwiseMax(shown);
  }
  return box;
}

Eigen::Vector2d shown_px(const Eye& eye, const Eigen::Vector3d& p_head_mm)
{
  const Eigen::Vector3d p = p_head_mm - eye.position_head_mm;
  check(p.z() < 0.0, "a point that is shown lies in front of the eye");
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

Eigen::Vector2d field_of_view_rad(const Eye& eye)
{
  return {2.0 * std::atan(0.5 * eye.window.width / eye.distance_px),
          2.0 * std::atan(0.5 * eye.window.height / distance_y_px(eye))};
}

std::optional<InputError::Facts> unusable(const Eye& eye, const std::string& file, const std::string& name)
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
    return refused("distortion", numbers + ", which fold at " + text(fold_px) + " px",
                   "optics that keep the order of pixels out to " + text(furthest_px) + " px");
  }
  const Eigen::Vector2d shown = shown_box(eye).high_px - shown_box(eye).low_px;
  const Eigen::Vector2d most =
      (most_shown_share * Eigen::Vector2d(eye.visible.width, eye.visible.height)).cwiseMin(most_shown_px);
  if (!(shown.array() <= most.array()).all()) {
    return refused("distortion",
                   numbers + ", which ask for " + text(shown.x()) + " x " + text(shown.y()) + " px",
                   "at most " + text(most.x()) + " x " + text(most.y()));
  }
  return std::nullopt;
}

std::optional<InputError::Facts> unusable(const EyePair& eyes, const std::string& file)
{
  const std::optional<InputError::Facts> left = unusable(eyes.left, file, "left");
  return left ? left : unusable(eyes.right, file, "right");
}

void require_usable(const EyePair& eyes, const std::string& file)
{
  if (const std::optional<InputError::Facts> facts = unusable(eyes, file)) throw InputError(*facts);
}

}  // namespace vrda
