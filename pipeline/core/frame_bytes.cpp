#include "core/frame_bytes.hpp"

#include <zlib.h>

#include "core/little_endian.hpp"

namespace vrda::inline core {
namespace {

/// A key has 64 digits; a much larger length means a damaged header.
constexpr std::uint32_t longest_key = 4096;

std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0)
{
  const uLong crc = crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  return static_cast<std::uint32_t>(crc);
}

}  // namespace

std::string header_bytes(const std::string& key, const FrameFormat& format)
{
  std::string bytes(format.magic);
  append_u32(bytes, format.version);
  append_u32(bytes, static_cast<std::uint32_t>(key.size()));
  bytes += key;
  append_u32(bytes, crc_of(bytes));
  return bytes;
}

FrameHeader parse_header(std::string_view bytes, const FrameFormat& format)
{
  const std::size_t fixed = format.magic.size() + 8;
  if (bytes.substr(0, format.magic.size()) != format.magic || bytes.size() < fixed) {
    return {"", 0, "header", "not a journal (" + std::to_string(bytes.size()) + " bytes)",
            "a journal of vrda"};
  }
  const std::uint32_t found_version = u32_at(bytes, format.magic.size());
  const std::uint32_t key_bytes = u32_at(bytes, format.magic.size() + 4);
  const bool is_whole = key_bytes <= longest_key && bytes.size() >= fixed + key_bytes + 4;
  const std::size_t end = is_whole ? fixed + key_bytes : 0;
  if (!is_whole || u32_at(bytes, end) != crc_of(bytes.substr(0, end))) {
    return {"", 0, "header", "a damaged header", std::string("an intact header, or ") + start_over_remedy};
  }
  if (found_version != format.version) {
    return {"", 0, "format version", std::to_string(found_version),
            std::to_string(format.version) + ", or " + start_over_remedy};
  }
  return {std::string(bytes.substr(fixed, key_bytes)), end + 4, "", "", ""};
}

std::string frame_of(std::string_view content)
{
  std::string bytes;
  bytes.reserve(frame_head_bytes + content.size());
  append_u32(bytes, static_cast<std::uint32_t>(content.size()));
  append_u32(bytes, crc_of(content, crc_of(bytes)));
  return bytes.append(content);
}

ParsedFrame parse_frame(std::string_view rest, const FrameFormat& format)
{
  const std::string name = format.frame_name;
  if (rest.size() < frame_head_bytes) return {{}, 0, "a torn frame", frame_head_bytes};
  const std::uint32_t length = u32_at(rest, 0);
  if (length > format.longest_content) return {{}, 0, "a frame of " + std::to_string(length) + " bytes", 0};
  if (rest.size() - frame_head_bytes < length) return {{}, 0, "a torn " + name, frame_head_bytes + length};
  const std::string_view content = rest.substr(frame_head_bytes, length);
  if (crc_of(content, crc_of(rest.substr(0, 4))) != u32_at(rest, 4)) {
    return {{}, 0, "a " + name + " with a wrong checksum", 0};
  }
  return {content, frame_head_bytes + length, {}, 0};
}

}  // namespace vrda::inline core
