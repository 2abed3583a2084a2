/// What the operator is asked to do for a part, from its first task to its last.
#pragma once

#include "guide/task.hpp"

namespace vrda {

/// The same for the same bench and what earlier parts found. Names and `index`, by part:
/// viewport: "left eye, left edge, 2" (index: Edge), then "left eye, width" (0) and "left eye, height" (1)
/// of the screen; distortion: "left eye, node -3, 2" or "left eye, grid 2"; eyepoints: "left eye, rectangle
/// 1, 2" (index 0: the first rectangle, second time); ipd: "pupillary distance" (0), "left arm" (1), "right
/// arm" (2), "image distance" (3), "look"; rails: "x rail", "z rail"; stop: "stop"; probe: "sweep"; subject:
/// the name of the landmarks' distance; bullseye, head: "left eye, place 1" (index 0); leg, femur, tibia: the
/// point's name, or "place 1".
std::vector<Task> tasks_of(CalibrationPart part, const BenchFile& bench, const Calibration& calibration);

/// Where the marker of a bull's-eye is to be: -1, 0 or 1 for left to right, low to high, near to far. Six in
/// a row from the first spread in every direction.
Eigen::Vector3i marker_place(int index);

/// Tasks that are looked at together once they are done: those of an eye, a rail's, or all of the part.
struct TaskRound {
  std::size_t begin = 0, end = 0;
};
TaskRound round_of(CalibrationPart part, const std::vector<Task>& tasks, std::size_t task);

}  // namespace vrda
