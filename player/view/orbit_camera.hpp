/// Pointer navigation (thesis 6.2.1). The camera moves instead of the object, so that the lights, which are
/// attached to the camera, stay fixed on screen.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "view/camera.hpp"
#include "view/keys.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"

namespace vrda::view {

/// A camera and the pivot of its rotations.
struct OrbitCamera {
  Camera camera;  ///< with the aspect of the viewport
  Eigen::Vector3d pivot_world_mm = Eigen::Vector3d::Zero();
};

/// Depth of the pivot in front of the camera.
double depth_mm(const OrbitCamera& gaze);

/// Size of one pixel at a depth.
double mm_per_pixel(const Camera& camera, const Viewport& viewport, double depth_mm);

enum class DragKind {
  translate,  ///< in the image plane: points at the pivot's depth follow the pointer
  rotate,     ///< about the pivot
  depth       ///< nearer or farther along the line of sight; up is away
};

/// A drag in progress. Motion is measured from the press, so that returning there restores the camera
/// exactly.
struct Drag {
  DragKind kind = DragKind::translate;
  OrbitCamera at_press;
  Eigen::Vector2d press_px = Eigen::Vector2d::Zero();  ///< from the top left corner of the window
};

/// The camera while the pointer is at `pointer_px`. Rotation: a ball about the pivot, covering nine tenths of
/// the viewport, turns by twice the arc between the points under the pointer at the press and now (Shoemake
/// 1992); outside its middle the ball continues as a hyperbola (Bell), which avoids a discontinuity at its
/// edge.
OrbitCamera dragged(const Drag& drag, const Eigen::Vector2d& pointer_px, const Viewport& viewport);

/// Moves the camera towards the pivot by `notches` of a wheel, a tenth of the depth each; negative moves
/// away.
OrbitCamera moved_closer(const OrbitCamera& gaze, double notches);

/// Moves the camera so that the point is centred at its present depth and becomes the pivot.
OrbitCamera centred_on(const OrbitCamera& gaze, const Eigen::Vector3d& point_world_mm);

/// The nearest point of the visible bodies under a pixel, world; empty if none exists.
std::optional<Eigen::Vector3d> point_under(const Scene& scene, const Camera& camera, const Viewport& viewport,
                                           const Eigen::Vector2d& pointer_px);

/// Left rotates, right (or left with shift or control) translates in the image plane, middle moves in depth:
/// the same in the page. Differs from thesis 6.2.1, where left translates and middle rotates.
DragKind drag_of(MouseButton button, bool has_shift, bool has_control);

/// Turns the events of a window into motions of a camera: drags, wheel, and double clicks, which centre.
class Navigation {
 public:
  /// The camera `gaze` after an event over the picture of `scene` in `viewport`, or during a drag.
  OrbitCamera after(const InputEvent& event, const OrbitCamera& gaze, const Scene& scene,
                    const Viewport& viewport);
  bool is_dragging() const { return drag_.has_value(); }
  void stop() { drag_.reset(); }

 private:
  std::optional<Drag> drag_;
  MouseButton button_ = MouseButton::left;  ///< of the drag
};

}  // namespace vrda::view
