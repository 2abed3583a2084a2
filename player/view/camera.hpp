/// Cameras, anatomical views, fitting a camera to points, and pointer navigation.
#pragma once

#include <Eigen/Core>

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "model/frames.hpp"
#include "view/eye.hpp"
#include "view/keys.hpp"
#include "view/scene.hpp"

namespace vrda::view {

/// Camera axes: X right, Y up, Z towards the viewer.
struct Camera {
  Pose X_world_camera = Pose::Identity();
  double half_height_tangent = 0.25;  ///< tangent of half the vertical field of view
  double aspect = 4.0 / 3.0;          ///< width / height
  double near_mm = 1.0;
  double far_mm = 1000.0;
  /// Off-axis projection: tangents (right, up) of the direction at the image centre.
  Eigen::Vector2d middle_tangent = Eigen::Vector2d::Zero();
};

/// The side of the subject that faces the viewer. `inverted` is oblique and upside down, so that an upward
/// push appears as a fall.
enum class View { front, back, left, right, medial, lateral, top, oblique, inverted };

/// The names on the command line, in the order of the enum.
const std::vector<std::string>& view_names();
std::optional<View> view_named(const std::string& name);

struct FrameOptions {
  double vertical_field_of_view_rad = rad_from_deg(22.0);  ///< a knee at about one metre
  double aspect = 4.0 / 3.0;
  double fill_fraction =
      0.9;  ///< fraction of the half height or half width that the outermost point may reach
};

/// Rotation of the camera: columns are its axes in world W (canonical axes).
Eigen::Matrix3d view_rotation(View view, Side side);

/// Fits a camera to points of any number of poses, exactly and in one pass.
class CameraFit {
 public:
  explicit CameraFit(const Eigen::Matrix3d& R_world_camera, const FrameOptions& options = {});
  void include(const std::vector<Eigen::Vector3d>& points_world_mm);
  /// The nearest camera that has every point in the filled part of the image: points touch its left and right
  /// or its top and bottom border. Requires at least one point; the depth range must be set by
  /// with_depth_range().
  Camera camera() const;

 private:
  /// Bounds for the two opposite side planes of the view frustum.
  struct Wedge {
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -std::numeric_limits<double>::infinity();
  };
  Eigen::Matrix3d R_world_camera_;
  FrameOptions options_;
  double half_height_tangent_ = 0.0;
  Wedge wide_, tall_;
};

/// `camera` with near and far planes that enclose everything visible in front of it, at the present
/// placement.
Camera with_depth_range(Camera camera, const Scene& scene);

/// Column-major OpenGL projection matrix.
Eigen::Matrix4d projection(const Camera& camera);

// Pointer navigation (thesis 6.2.1). The camera moves instead of the object, so that the lights, which are
// attached to the camera, stay fixed on screen.

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

/// `next` of a camera that moves straight ahead from `gaze`, at most to `least_depth_mm` (or the near plane)
/// in front of what it sees of the visible bodies about the middle of its picture.
OrbitCamera before_surface(const OrbitCamera& gaze, OrbitCamera next, const Scene& scene);

/// Moves the camera so that the point is centred at its present depth and becomes the pivot.
OrbitCamera centred_on(const OrbitCamera& gaze, const Eigen::Vector3d& point_world_mm);

/// The nearest point of the visible bodies under a pixel, world; empty if none exists.
std::optional<Eigen::Vector3d> point_under(const Scene& scene, const Camera& camera, const Viewport& viewport,
                                           const Eigen::Vector2d& pointer_px);

/// The drawable of a structure under a pixel: the nearest one that is at least half opaque, else the nearest.
/// A bundle of fibres counts within `reach_px`.
struct Pick {
  std::size_t drawable = 0;
  Eigen::Vector3d point_world_mm = Eigen::Vector3d::Zero();
};
std::optional<Pick> picked(const Scene& scene, const Camera& camera, const Viewport& viewport,
                           const Eigen::Vector2d& pointer_px, double reach_px);

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
