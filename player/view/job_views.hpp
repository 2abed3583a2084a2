/// Views, size and zoom of a job's table [player] (schemas/job.schema.json), which `show` and `follow` use where
/// the command line has none.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "model/side.hpp"
#include "view/camera.hpp"

namespace vrda::view {

struct CameraView {
  std::string name;
  Eigen::Matrix3d R_world_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_camera_mm = Eigen::Vector3d::Zero();  ///< shift of the joint, camera axes
};

CameraView named_view(const std::string& name, view::View view, Side side);

/// The front view with the joint rotated about X, then Y, then Z and shifted, all in the axes of that view:
/// X right on screen (the subject's left), Y up, Z towards the viewer.
/// Source: ORIENTATION_MODEL and SHIFT_MODEL, thesis appendix B, which does not state the order of rotations.
CameraView turned_view(const std::string& name, const Eigen::Vector3d& turn_rad,
                       const Eigen::Vector3d& shift_mm, Side side);

/// The camera fitted to the joint, shifted as the view, with the field of view divided by `zoom`.
view::Camera placed_camera(const view::CameraFit& fit, const CameraView& view, double zoom);

/// A view of the job's table [player] (schemas/job.schema.json).
struct JobView {
  int number = 0;
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d orientation_deg = Eigen::Vector3d::Zero();
};

struct JobViews {
  std::vector<JobView> views;  ///< in the job's order
  double zoom = 1.0;
  int width_px = 0, height_px = 0;  ///< display size; 0 if not given
  std::string render;               ///< "fill", "wire" or empty
};

/// Reads the resolved job of a motion model. Missing entries and those of another type keep their defaults,
/// as does all of a text that is not TOML.
JobViews job_views(std::string_view resolved_job);

/// The job's views as cameras; "view 2".
std::vector<CameraView> camera_views(const JobViews& job, Side side);

/// Whether the display size is within the limits of images; a historic one may exceed them.
bool has_usable_size(const JobViews& job);

}  // namespace vrda::view
