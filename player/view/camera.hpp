/// Cameras, anatomical views, and fitting a camera to points.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "model/frames.hpp"
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

}  // namespace vrda::view
