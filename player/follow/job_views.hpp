/// How the job wants to be seen: its table [player] (schemas/job.schema.json).
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace vrda {

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
