/// Motion models changed by a recipe: what libFuzzer makes is not the file, which would be too large and
/// mostly refused at its checksums, but a few changes to one of the files that we keep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vrda::test {

/// Bytes that a checksum follows.
struct Summed {
  std::size_t first = 0;
  std::size_t size = 0;
};

struct BaseContent {
  std::string bytes;
  std::vector<Summed> summed;       ///< blocks of the file's metadata with a checksum behind each
  std::vector<std::size_t> values;  ///< where datasets' values begin
};

/// What HDF5 keeps in the file `bytes`: blocks with checksums and the datasets' values.
BaseContent base_of_hdf5(const std::string& bytes, const std::vector<std::size_t>& values);

/// The base that the recipe's first byte names, with its changes: eight bytes each, of which the first
/// chooses between flips, numbers worth trying, copies, cuts and splices from another base. Checksums and the
/// seal are made right again unless the recipe says otherwise.
std::string changed(const std::vector<BaseContent>& bases, const std::uint8_t* recipe, std::size_t size);

}  // namespace vrda::test
