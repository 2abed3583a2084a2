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

}  // namespace vrda::test
