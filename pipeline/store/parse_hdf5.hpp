/// HDF5 content as a motion model or trace, in this process: for files that were just written, for tests, and
/// for the confined process that read_motion_model and read_trace start (store/read_apart.hpp).
#pragma once

#include <vector>

#include "store/finding.hpp"
#include "store/motion_model.hpp"
#include "store/seal.hpp"
#include "store/trace.hpp"

namespace vrda {

/// Throw InputError naming the file and the first object that does not follow the specification.
MotionModel parse_motion_model(const Hdf5Content& content);
Trace parse_trace(const Hdf5Content& content);

/// Everything in which the content departs from the specification, that of a trace where it says that it is
/// one. Throws InputError when it is no HDF5 file or is damaged beyond listing.
std::vector<Finding> findings_in(const Hdf5Content& content);

}  // namespace vrda
