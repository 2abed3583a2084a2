// The mutator of a fuzzer whose input has checksums: every second change has repaired ones, since changes
// that a checksum detects test little. Included by the fuzzer's one source.
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace vrda::test {

/// Of the fuzzer's input.
void repair_checksums(std::uint8_t* data, std::size_t size);

}  // namespace vrda::test

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed)
{
  size = LLVMFuzzerMutate(data, size, max_size);
  if (seed % 2 == 0) vrda::test::repair_checksums(data, size);
  return size;
}
