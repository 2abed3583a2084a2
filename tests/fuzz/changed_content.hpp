/// Motion models changed by a recipe: libFuzzer's input is not the file, which would be too large and mostly
/// rejected by its checksums, but a few changes to one of the base files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vrda::test {

/// Bytes followed by their checksum.
struct ChecksummedBlock {
  std::size_t first = 0;
  std::size_t size = 0;
};

struct BaseContent {
  std::string bytes;
  std::vector<ChecksummedBlock> checksummed;  ///< metadata blocks, each followed by a checksum
  std::vector<std::size_t> values;            ///< offsets of the datasets' values
};

/// Layout of the HDF5 file `bytes`: blocks with checksums and the datasets' values.
BaseContent base_of_hdf5(const std::string& bytes, const std::vector<std::size_t>& values);

/// The base selected by the recipe's first byte, with changes of eight bytes each. The first byte of a change
/// selects flips, special numbers, copies, truncations or splices from another base. Checksums and seal are
/// repaired unless the recipe disables it.
std::string changed(const std::vector<BaseContent>& bases, const std::uint8_t* recipe, std::size_t size);

/// A sealed motion model or trace.
struct ChangedFile {
  std::string bytes;
  bool is_trace = false;
};

/// Variant `k` of the recipe: another base, other offsets and values.
ChangedFile changed_file(const std::uint8_t* recipe, std::size_t size, std::size_t k);

/// Paths of all groups and datasets in the HDF5 file `bytes`, except the root.
std::vector<std::string> object_paths(const std::string& bytes);

/// `bytes`, an HDF5 file with objects at `paths`, after the changes in `recipe` of eight bytes each. The
/// first byte selects removed, moved, symbolic, external or cyclic links, datasets of other shapes, types,
/// layouts and filters, other attributes or other values. Changes that HDF5 rejects are skipped. No seal.
std::string with_changed_objects(const std::string& bytes, const std::vector<std::string>& paths,
                                 const std::uint8_t* recipe, std::size_t size);

}  // namespace vrda::test
