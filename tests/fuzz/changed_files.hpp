/// Motion models and traces as sealed HDF5 files, changed by a recipe in each of our manners.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace vrda::test {

struct ChangedFile {
  std::string bytes;
  bool is_trace = false;
};

/// Variant `k` of the recipe: of another base, and with other places and values.
ChangedFile changed_file(const std::uint8_t* recipe, std::size_t size, std::size_t k);

}  // namespace vrda::test
