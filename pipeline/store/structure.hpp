/// Check of a file's structure against the registry.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "store/dataset.hpp"
#include "store/h5_reader.hpp"
#include "store/motion_model.hpp"
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

}  // namespace vrda::store
