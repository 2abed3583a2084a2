/// Parses HDF5 content in this process: for files that were just written, for tests, and for the confined
/// process started by read_motion_model and read_trace (store/read_separately.hpp).
#pragma once

#include <vector>

#include "store/dataset.hpp"
#include "store/motion_model.hpp"
#include "store/seal.hpp"
#include "store/trace.hpp"

namespace vrda::store {

/// Throw InputError naming the file and the first object that violates the specification.
MotionModel parse_motion_model(const Hdf5Content& content);
Trace parse_trace(const Hdf5Content& content);

/// All violations of the specification of a trace or motion model, chosen by the `format` attribute. Throws
/// InputError when the content is not an HDF5 file or too damaged to be listed.
std::vector<Finding> findings_in(const Hdf5Content& content);

}  // namespace vrda::store
