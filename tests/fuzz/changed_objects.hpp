/// Motion models changed through HDF5 itself: whole files that say something else, which no flip of bits
/// makes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vrda::test {

/// Paths of all groups and datasets in the HDF5 file `bytes`, without its root.
std::vector<std::string> object_paths(const std::string& bytes);

/// `bytes`, an HDF5 file with objects at `paths`, after the changes in `recipe`: eight bytes each, of which
/// the first chooses between links cut, moved, made symbolic, external or cyclic, datasets of other shapes,
/// types, layouts and filters, other attributes and other values. Changes that HDF5 refuses are left out. No
/// seal.
std::string with_changed_objects(const std::string& bytes, const std::vector<std::string>& paths,
                                 const std::uint8_t* recipe, std::size_t size);

}  // namespace vrda::test
