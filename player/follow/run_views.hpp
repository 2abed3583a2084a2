/// Several looks at one joint, side by side, as the job wants them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "render/renderer.hpp"
#include "scene/camera.hpp"

namespace vrda {

struct RunView {
  std::string name;
  Eigen::Matrix3d R_world_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_camera_mm = Eigen::Vector3d::Zero();  ///< of the joint, on screen
};

RunView named_view(const std::string& name, View view, Side side);

/// The front view with the joint turned about X, then Y, then Z and shifted, all along the axes of that view:
/// X to the right of the picture (the subject's left), Y up, Z towards the viewer.
/// Source: ORIENTATION_MODEL and SHIFT_MODEL of the thesis's appendix B; the order of the turns is ours.
RunView turned_view(const std::string& name, const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& shift_mm,
                    Side side);

/// The parts of `area` for `n` views, row by row: as large as they can be, none much wider than a picture.
std::vector<Viewport> tiles(std::size_t n, const Viewport& area);

/// One camera a tile with room for the points; `zoom` above 1 is nearer.
std::vector<Shot> fitted_shots(const std::vector<RunView>& views, const std::vector<Viewport>& areas,
                               const std::vector<Eigen::Vector3d>& points_world_mm, double zoom);

/// How the job wants to be seen: its table [player] (schemas/job.schema.json).
struct JobView {
  int number = 0;
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d orientation_deg = Eigen::Vector3d::Zero();
};

struct JobViews {
  std::vector<JobView> views;  ///< as they stand in the job
  double zoom = 1.0;
  int width_px = 0, height_px = 0;  ///< of the display; 0 where the job does not say
  std::string render;               ///< "fill", "wire" or nothing
};

/// Of a resolved job as a motion model keeps it: one key a line, as `vrda` writes it, so that no reader of
/// jobs is needed. What is not of that form, or not there, is left at its default.
JobViews job_views(std::string_view resolved_job);

}  // namespace vrda
