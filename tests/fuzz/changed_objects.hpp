/// Motion models changed through HDF5: intact files with other content, which bit flips cannot produce.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vrda::test {

/// Paths of all groups and datasets in the HDF5 file `bytes`, except the root.
std::vector<std::string> object_paths(const std::string& bytes);

/// `bytes`, an HDF5 file with objects at `paths`, after the changes in `recipe` of eight bytes each. The
/// first byte selects removed, moved, symbolic, external or cyclic links, datasets of other shapes, types,
/// layouts and filters, other attributes or other values. Changes that HDF5 rejects are skipped. No seal.
std::string with_changed_objects(const std::string& bytes, const std::vector<std::string>& paths,
                                 const std::uint8_t* recipe, std::size_t size);

}  // namespace vrda::test
