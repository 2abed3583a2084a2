/// Motion models and traces as sealed HDF5 files, changed by a recipe in one of the ways above.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace vrda::test {

struct ChangedFile {
  std::string bytes;
  bool is_trace = false;
};

/// Variant `k` of the recipe: another base, other offsets and values.
ChangedFile changed_file(const std::uint8_t* recipe, std::size_t size, std::size_t k);

}  // namespace vrda::test
