#include "store/seal.hpp"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace vrda {
namespace {

constexpr std::string_view magic = "VRDASEAL";
constexpr std::size_t seal_bytes = 16;
constexpr const char* wanted_intact = "an intact motion model or trace (HDF5)";

/// CRC-32 of ISO 3309, the one of zlib and PNG, a byte at a time.
class Crc32 {
 public:
  Crc32()
  {
    for (std::uint32_t n = 0; n < table_.size(); ++n) {
      std::uint32_t value = n;
      for (int bit = 0; bit < 8; ++bit) value = (value & 1u) != 0u ? 0xedb88320u ^ (value >> 1) : value >> 1;
      table_[n] = value;
    }
  }

  void add(std::string_view bytes)
  {
    for (const char byte : bytes) {
      state_ = table_[(state_ ^ static_cast<unsigned char>(byte)) & 0xffu] ^ (state_ >> 8);
    }
  }

  std::uint32_t value() const { return ~state_; }

 private:
  std::array<std::uint32_t, 256> table_{};
  std::uint32_t state_ = 0xffffffffu;
};

std::uint64_t little_endian(std::string_view bytes)
{
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

std::string read_at(std::ifstream& stream, std::uint64_t offset, std::size_t n_bytes)
{
  std::string bytes(n_bytes, '\0');
  stream.clear();
  stream.seekg(static_cast<std::streamoff>(offset));
  stream.read(bytes.data(), static_cast<std::streamsize>(n_bytes));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

/// Checksum of the first `n_bytes` of the file.
std::uint32_t checksum(const std::string& path, std::uint64_t n_bytes)
{
  std::ifstream stream(path, std::ios::binary);
  Crc32 crc;
  std::vector<char> block(std::size_t{1} << 20);
  std::uint64_t left = n_bytes;
  while (left > 0) {
    const std::uint64_t wanted = left < block.size() ? left : block.size();
    stream.read(block.data(), static_cast<std::streamsize>(wanted));
    if (static_cast<std::uint64_t>(stream.gcount()) != wanted) {
      throw InputError({path, "", "a file that cannot be read to its end", wanted_intact});
    }
    crc.add({block.data(), static_cast<std::size_t>(wanted)});
    left -= wanted;
  }
  return crc.value();
}

std::string seal_with(std::uint32_t crc)
{
  std::string bytes(magic);
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(crc >> shift & 0xffu));
  bytes.resize(seal_bytes, '\0');
  return bytes;
}

/// Where the HDF5 content ends, as its superblock (version 2 or 3) says; 0 for another version.
std::uint64_t content_end(std::ifstream& stream)
{
  const std::string superblock = read_at(stream, 0, 36);
  if (superblock.size() < 36 || (superblock[8] != 2 && superblock[8] != 3)) return 0;
  return little_endian(std::string_view(superblock).substr(28, 8));
}

}  // namespace

std::string seal_of(std::string_view content)
{
  Crc32 crc;
  crc.add(content);
  return seal_with(crc.value());
}

void require_sound(const std::string& path)
{
  const std::uint64_t size = std::filesystem::file_size(path);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError({path, "", std::strerror(errno), wanted_intact});
  const std::uint64_t sealed = size < seal_bytes ? 0 : size - seal_bytes;
  const std::string tail = read_at(stream, sealed, seal_bytes);
  if (tail.substr(0, magic.size()) == magic) {
    if (tail == seal_with(checksum(path, sealed))) return;
    throw InputError({path, "", "a damaged file (its checksum does not match)", wanted_intact});
  }
  const std::uint64_t end = content_end(stream);
  if (end == 0 || end == size) return;
  throw InputError({path, "",
                    std::to_string(size) + " bytes, " + (size < end ? "a truncated file" : "a damaged end"),
                    wanted_intact + std::string(" of ") + std::to_string(end) + " bytes"});
}

}  // namespace vrda
