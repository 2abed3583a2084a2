/// [coordinates] and [frames] of a job: roles of the joint's six coordinates and their values.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "job/case.hpp"
#include "job/job.hpp"

namespace vrda::job {

/// [coordinates] and [frames], parsed; absent if the job has neither.
std::optional<CoordinatesJob> coordinates_of(const Job& job);

/// Tables over the driving coordinate become tables over flexion where that drives. Refuses them where
/// nothing drives, a direction over another coordinate, and loads over a flexion that is free.
void resolve_driving_tables(Job& job);

/// Flexion driven, varus driven or free, the rest free: what [grid] expresses.
bool is_plain_grid(const CoordinatesJob& coordinates);

/// Roles, values and, of a sequence of frames, keys.
struct LoadedCoordinates {
  CoordinateRows rows;  ///< over the path's flexions, or one per frame
  GridAxes grid;        ///< flexion of each frame (0 where free), or the job's grid
  std::vector<double> path_flexion_deg;
  std::vector<LoadedInput> inputs;
  PushJob push;  ///< of the job, with the columns of the frames
};

/// Reads the tables. Throws InputError naming file, line and column; for a combination that the method or the
/// frame cannot solve it names the key.
LoadedCoordinates load_coordinates(const Job& job, const CoordinatesJob& coordinates,
                                   const std::string& data_directory);

/// The grid's flexions with as many between them as keep steps of at most 1 degree.
std::vector<double> path_of(const std::vector<double>& flexion_deg);

}  // namespace vrda::job
