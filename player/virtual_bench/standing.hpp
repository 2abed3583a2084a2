/// Where everything on the bench stands while somebody does a task, and what a tracker and an encoder would
/// send of it.
#pragma once

#include "devices/sample.hpp"
#include "setup/calibration_record.hpp"
#include "simulation/draws.hpp"
#include "virtual_bench/truth.hpp"

namespace vrda {

struct Standing {
  double stage_mm = 0.0;  ///< from the stop
  Pose X_tracker_eyes = Pose::Identity();
  Pose X_tracker_headbody = Pose::Identity();
  Pose X_tracker_tool = Pose::Identity();  ///< of the tool that the task is about
};

/// Nobody moves anything: the head at the stop of its stage.
Standing at_rest(const VirtualTruth& truth);

/// The marker on the carriage of the x rail, which is the stage's, or of the z rail; `way` of the sweep from
/// 0 to 1, to the viewer's right or towards the viewer.
Standing on_x_rail(const VirtualTruth& truth, double way);
Standing on_z_rail(const VirtualTruth& truth, double way);

/// The probe's tip rests on a point of the table, the probe turns by 40 degrees about two axes.
Standing pivoting(const VirtualTruth& truth, double way);

/// Place `index` of the marker (guide/task.hpp: marker_place), seen by both eyes; the head a little
/// elsewhere each time.
Standing at_bullseye(const BenchFile& bench, const VirtualTruth& truth, int index);

/// The probe's tip on `p_model_mm` of the model that the leg is; held another way at each `index`. The tip
/// rests `off_mm` (tracker's axes) beside the point.
struct Touched {
  BodyRole role = BodyRole::leg;
  Eigen::Vector3d p_model_mm = Eigen::Vector3d::Zero();
  int index = 0;
  Eigen::Vector3d off_mm = Eigen::Vector3d::Zero();
};
Standing touching(const VirtualTruth& truth, const Touched& touched);

/// Of the body that carries the model.
const Pose& X_tracker_body(const VirtualTruth& truth, BodyRole role);

/// A pose as the tracker says, with its noise.
Pose measured(const Pose& X, const VirtualNoise& noise, Draws& draws);

struct FrameFacts {
  std::int64_t time_ns = 0;
  std::string tool;  ///< that Standing::X_tracker_tool is of
  /// Of the encoder, before it was zeroed at the stop.
  double stage_offset_mm = 0.0;
  bool is_stage_zeroed = false;
  VirtualNoise noise;
};

/// The stage's count, then every tool of the tracker in its order; tools that nobody uses are not seen.
std::vector<Sample> tracker_frame(const BenchFile& bench, const VirtualTruth& truth, const Standing& standing,
                                  const FrameFacts& facts, Draws& draws);

}  // namespace vrda
