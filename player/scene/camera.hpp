/// Where a scene is seen from.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/frames.hpp"
#include "scene/scene.hpp"

namespace vrda {

/// Camera axes: X to the right of the picture, Y up, Z towards the viewer.
struct Camera {
  Pose X_world_camera = Pose::Identity();
  double half_height_tangent = 0.25;  ///< tangent of half the vertical field of view
  double aspect = 4.0 / 3.0;          ///< width by height
  double near_mm = 1.0;
  double far_mm = 1000.0;
};

/// The side of the subject that faces the viewer. `inverted` is oblique with the subject upside down: a push
/// upward is seen as a fall, and a hollow that opens downward as a bowl.
enum class View { front, back, left, right, medial, lateral, top, oblique, inverted };

/// The names accepted on the command line, in the order of the enum.
const std::vector<std::string>& view_names();
std::optional<View> view_named(const std::string& name);

struct FrameOptions {
  double vertical_field_of_view_rad = rad_from_deg(22.0);  ///< a knee at arm's length and a half
  double aspect = 4.0 / 3.0;
  double filled = 0.9;  ///< part of the half height or half width the outermost point may reach
};

/// Rotation of the camera: columns are its axes in world W (canonical axes).
Eigen::Matrix3d view_rotation(View view, Side side);

/// Fits a camera to points, exactly and in one pass, however many poses they come from.
class CameraFit {
 public:
  explicit CameraFit(const Eigen::Matrix3d& R_world_camera, const FrameOptions& options = {});
  void include(const std::vector<Eigen::Vector3d>& points_world_mm);
  /// The nearest camera that has every point in the filled part of the picture: points touch its border
  /// at the left and right, or at the top and bottom. Wants at least one point; depth range still to be set.
  Camera camera() const;

 private:
  /// Bounds that the two planes on opposite sides of the picture must pass.
  struct Wedge {
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -std::numeric_limits<double>::infinity();
  };
  Eigen::Matrix3d R_world_camera_;
  FrameOptions options_;
  double half_height_tangent_ = 0.0;
  Wedge wide_, tall_;
};

/// `camera` with near and far planes around everything shown in front of it, as placed.
Camera with_depth_range(Camera camera, const Scene& scene);

/// Column-major OpenGL projection matrix.
Eigen::Matrix4d projection(const Camera& camera);

}  // namespace vrda
