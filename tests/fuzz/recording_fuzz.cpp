// Recordings of the bench. Every second change has its checksums mended, as of journals.
#include <zlib.h>

#include "fuzz/outcome.hpp"
#include "journal/frame_bytes.hpp"
#include "journal/little_endian.hpp"
#include "recording/recording.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

constexpr std::size_t fixed_header_bytes = 16;  // magic, version, length of the key

std::uint32_t crc_of(const std::uint8_t* data, std::size_t size, std::uint32_t before = 0)
{
  return static_cast<std::uint32_t>(crc32_z(before, data, size));
}

void put(std::uint8_t* at, std::uint32_t value)
{
  for (int k = 0; k < 4; ++k) at[k] = static_cast<std::uint8_t>(value >> (8 * k));
}

// Goes along the lengths as the reader does; stops where they leave the data.
void mend_checksums(std::uint8_t* data, std::size_t size)
{
  const std::string bytes = vrda::test::text_of(data, size);
  if (size < fixed_header_bytes + 4) return;
  const std::size_t key_end = fixed_header_bytes + vrda::u32_at(bytes, fixed_header_bytes - 4);
  if (key_end + 4 > size) return;
  put(data + key_end, crc_of(data, key_end));
  for (std::size_t at = key_end + 4; at + vrda::frame_head_bytes <= size;) {
    const std::size_t length = vrda::u32_at(bytes, at);
    if (length > size - at - vrda::frame_head_bytes) return;
    put(data + at + 4, crc_of(data + at + vrda::frame_head_bytes, length, crc_of(data + at, 4)));
    at += vrda::frame_head_bytes + length;
  }
}

// What is kept is written again as it stood.
void read(const std::string& bytes)
{
  using namespace vrda;
  const Recording recording = parsed_recording("a.log", bytes);
  test::require(recording.dropped_why.empty() == (recording.dropped_bytes == 0),
                "bytes dropped without a reason");
  std::string again = frame_of(bytes_of(recording.facts));
  for (const RecordedPicture& picture : recording.pictures)
    again += frame_of(bytes_of(picture.now_ns, picture.keys, picture.samples));
  test::require(again.size() + recording.dropped_bytes < bytes.size(),
                "bytes that are neither kept nor dropped");
  const std::size_t begin = bytes.size() - static_cast<std::size_t>(recording.dropped_bytes) - again.size();
  test::require(bytes.compare(begin, again.size(), again) == 0, "a recording that is written otherwise");
  test::require(begin == fixed_header_bytes + u32_at(bytes, fixed_header_bytes - 4) + 4,
                "pictures that do not fill the valid bytes");
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed)
{
  const std::size_t changed = LLVMFuzzerMutate(data, size, max_size);
  if (seed % 2 == 0) mend_checksums(data, changed);
  return changed;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string bytes = vrda::test::text_of(data, size);
  vrda::test::read_or_refuse([&] { read(bytes); });
  return 0;
}
