/// Check of a file's structure against the registry.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "store/dataset.hpp"
#include "store/h5_file.hpp"
#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "store/trace.hpp"

namespace vrda::store {

inline constexpr std::uint64_t max_value_bytes = std::uint64_t{512} << 20;

template <typename Content>
struct Structure {
  Content content;  ///< model or trace with the file's attributes, lists and optional parts
  std::vector<std::pair<std::string, std::int64_t>> sizes;  ///< of the counted dimensions
  std::vector<Finding> findings;                            ///< empty: every value can be read
};

/// Check objects, types, shapes, dimension scales, attributes and storage without reading dataset values.
/// Throw InputError only if HDF5 cannot list the file.
Structure<MotionModel> structure_of_model(const H5Reader& reader);
Structure<Trace> structure_of_trace(const H5Reader& reader);

// Checks of the values of motion models and traces.

/// Findings name the datasets of the file, one finding per dataset and rule, with the first wrong entry and
/// the number of wrong entries. All shapes must be consistent, as after reading.
std::vector<Finding> check_values(const MotionModel& model);
std::vector<Finding> check_values(const Trace& trace);

/// Adds the findings about the values of each dataset by the rule of its row.
void check_rows(const MotionModel& model, ValueFindings& findings);
void check_rows(const Trace& trace, ValueFindings& findings);

/// Differences between `trace` and its model: job, attitudes, final poses, triangles. Both must be valid.
std::vector<Finding> compare_trace(const Trace& trace, const MotionModel& model);

/// Throws InputError naming `file` for the first finding; does nothing without findings.
void require_no_findings(const std::vector<Finding>& findings, const std::string& file);

// Parses HDF5 content in this process: for files that were just written, for tests, and for the confined
// process started by read_motion_model and read_trace (store/read_separately.hpp).

/// Throw InputError naming the file and the first object that violates the specification.
MotionModel parse_motion_model(const Hdf5Content& content);
Trace parse_trace(const Hdf5Content& content);

/// All violations of the specification of a trace or motion model, chosen by the `format` attribute. Throws
/// InputError when the content is not an HDF5 file or too damaged to be listed.
std::vector<Finding> findings_in(const Hdf5Content& content);

}  // namespace vrda::store
