/// The motion model and its HDF5 file. schemas/motion-model.md specifies the file.
#pragma once

#include <string>
#include <vector>

#include "store/finding.hpp"
#include "store/motion_model.hpp"

namespace vrda {

inline constexpr const char* format_name = "vrda motion model";
inline constexpr const char* format_version = "1.5";
/// The minor version that readers need; a later one adds objects, which they ignore.
inline constexpr int format_minor_version = 5;

/// Writes `model` to `path`: under a temporary name in the same folder, flushed to the disk, then renamed,
/// so that `path` holds the old file or the new one, whole. Equal models give equal bytes.
/// Every grid must have the shape of the axes and row_start one entry more than there are cells; the values
/// themselves are not judged here (validate_hdf5 does). Throws InputError when the file cannot be
/// written, InternalError when the model's shapes do not agree.
void write_motion_model(const std::string& path, const MotionModel& model);

/// Reads a motion model that follows the specification, in a process of its own (store/read_apart.hpp).
/// Throws InputError naming the file and the first object that does not, or how that process ended. Another
/// thread must not be using HDF5 meanwhile.
MotionModel read_motion_model(const std::string& path);

/// Everything in which the motion model or trace departs from its specification; empty: nothing. Read as
/// above; throws InputError when the file is absent, is no HDF5 file or is damaged beyond listing.
std::vector<Finding> validate_hdf5(const std::string& path);

}  // namespace vrda
