/// What a file holds, held against its layout.
#pragma once

#include <vector>

#include "store/finding.hpp"
#include "store/h5_reader.hpp"
#include "store/layout.hpp"

namespace vrda {

struct Structure {
  FileShape shape;                ///< as far as the findings let it be known
  FileLayout layout;              ///< of `shape`
  std::vector<Finding> findings;  ///< empty: every value can be read
};

/// Checks objects, types, shapes, dimension scales, attributes and storage; reads no dataset's values.
/// Throws InputError only where the file is damaged so that HDF5 cannot even list it.
Structure structure_of(const H5Reader& reader);

/// The same for a trace; `shape` of the result stays empty.
Structure trace_structure_of(const H5Reader& reader);

}  // namespace vrda
