/// What a file holds, held against the registry.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "store/finding.hpp"
#include "store/h5_reader.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda {

inline constexpr std::uint64_t largest_value_bytes = std::uint64_t{512} << 20;

template <typename Content>
struct Structure {
  Content content;  ///< a model or trace with the attributes, lists and optional parts of the file
  std::vector<std::pair<std::string, std::int64_t>> sizes;  ///< of the counted dimensions
  std::vector<Finding> findings;                            ///< empty: every value can be read
};

/// Check objects, types, shapes, dimension scales, attributes and storage; read no dataset's values. Throw
/// InputError only where the file is damaged so that HDF5 cannot even list it.
Structure<MotionModel> structure_of_model(const H5Reader& reader);
Structure<Trace> structure_of_trace(const H5Reader& reader);

}  // namespace vrda
