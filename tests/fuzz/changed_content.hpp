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

}  // namespace vrda::test
