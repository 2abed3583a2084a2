/// How a pointer moves the object on screen (thesis 6.2.1). The object stays and the camera moves the other
/// way, so that lights on the camera stay where they are.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "render/renderer.hpp"
#include "scene/camera.hpp"
#include "scene/scene.hpp"

namespace vrda {

/// Where one looks from, and the point of the object that it turns about.
struct Gaze {
  Camera camera;  ///< its aspect is that of the viewport
  Eigen::Vector3d pivot_world_mm = Eigen::Vector3d::Zero();
};

/// Of the pivot: how far it lies in front of the camera.
double depth_mm(const Gaze& gaze);

/// What one pixel spans at a depth.
double mm_per_pixel(const Camera& camera, const Viewport& viewport, double depth_mm);

enum class DragKind {
  translate,  ///< in the plane of the picture: what lies as deep as the pivot follows the pointer
  rotate,     ///< about the pivot
  depth       ///< nearer or farther along the line of sight; up is away
};

/// A button held down. Every place of the pointer is measured from the press, so that a drag back to where
/// it began changes nothing, whatever way it took.
struct Drag {
  DragKind kind = DragKind::translate;
  Gaze at_press;
  Eigen::Vector2d press_px = Eigen::Vector2d::Zero();  ///< from the picture's top left corner
};

/// The gaze while the pointer is at `pointer_px`. Rotation: a ball around the pivot, filling nine tenths of
/// the viewport, turns by twice the arc between the points under the pointer then and now (Shoemake 1992);
/// outside of its middle the ball goes over into a hyperbola (Bell), so that the rim is no edge.
Gaze dragged(const Drag& drag, const Eigen::Vector2d& pointer_px, const Viewport& viewport);

/// Nearer by `notches` of a wheel, a tenth of the depth each; negative moves away.
Gaze nearer(const Gaze& gaze, double notches);

/// The point in the middle of the picture, as far away as it was, and the new pivot.
Gaze centred_on(const Gaze& gaze, const Eigen::Vector3d& point_world_mm);

/// The first point of the bodies that are shown under a place of the picture.
std::optional<Eigen::Vector3d> point_under(const Scene& scene, const Camera& camera, const Viewport& viewport,
                                           const Eigen::Vector2d& pointer_px);

/// Which button moves the object how (thesis 6.2.1), also for mice of two buttons and touchpads.
enum class Button { left, middle, right };

/// Left moves in the picture plane, middle turns, right moves in depth; with control the left button turns,
/// with shift it moves in depth.
DragKind drag_of(Button button, bool has_shift, bool has_control);

}  // namespace vrda
