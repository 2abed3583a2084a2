/// HDF5 file of the motion model (schemas/motion-model.md).
#pragma once

#include <string>
#include <vector>

#include "store/dataset.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

inline constexpr const char* format_name = "vrda motion model";
inline constexpr const char* format_version = "1.10";
inline constexpr int format_minor_version = 10;
/// Smallest minor version that readers accept; later ones add objects, which are ignored.
inline constexpr int least_minor_version = 7;

/// Writes `model` to `path`: under a temporary name in the same folder, flushed to the disk, then renamed,
/// so `path` is always a complete old or new file. Equal models give equal bytes.
/// Every grid must have the shape of the axes, and row_start one entry more than there are cells. Values are
/// not checked here (see validate_hdf5). Throws InputError when the file cannot be written, InternalError
/// when the model's shapes are inconsistent.
void write_motion_model(const std::string& path, const MotionModel& model);

/// Reads a motion model in a separate process (store/read_separately.hpp). Throws InputError naming the file
/// and the first object that violates the specification, or how that process ended. No other thread may use
/// HDF5 meanwhile.
MotionModel read_motion_model(const std::string& path);

/// All violations of the specification by a motion model or trace; empty if it is valid. Reads as above;
/// throws InputError when the file is absent, not an HDF5 file, or too damaged to be listed.
std::vector<Finding> validate_hdf5(const std::string& path);

}  // namespace vrda::store
