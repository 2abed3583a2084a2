#include "store/seal.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "core/error.hpp"
#include "core/open_file.hpp"

namespace vrda::store {
namespace {

constexpr std::string_view magic = "VRDASEAL";
constexpr std::size_t seal_bytes = 16;
std::atomic<bool> accepts_unsealed = false;

std::uint64_t little_endian(std::string_view bytes)
{
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// End of the HDF5 content from its superblock (version 2 or 3); 0 for another version.
std::uint64_t content_end(std::string_view bytes)
{
  if (bytes.size() < 36 || (bytes[8] != 2 && bytes[8] != 3)) return 0;
  return little_endian(bytes.substr(28, 8));
}

std::string bytes_of_file(const std::string& file)
{
  const auto refuse = [&](const std::string& found) { throw InputError({file, "", found, intact_file}); };
  const OpenFile open_file(
      open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // does not block on a FIFO
  struct stat status = {};
  if (!open_file.is_open() || fstat(open_file.get(), &status) != 0) refuse(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) refuse("not a regular file");
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t n_read = 0; n_read < bytes.size();) {
    const ssize_t n = read(open_file.get(), bytes.data() + n_read, bytes.size() - n_read);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) refuse(std::string("a read error (") + std::strerror(errno) + ")");
    if (n == 0) refuse("a file that was truncated while being read");
    n_read += static_cast<std::size_t>(n);
  }
  return bytes;
}

/// The HDF5 content must begin at byte 0: an HDF5 "user block" before it would not be checked.
void require_signature(const std::string& file, std::string_view bytes)
{
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  if (bytes.substr(0, signature.size()) == signature) return;
  throw InputError(
      {file, "", std::to_string(bytes.size()) + " bytes that are not an HDF5 file", intact_file});
}

void require_whole(const std::string& file, std::string_view bytes)
{
  const std::uint64_t end = content_end(bytes);
  if (end == 0 || end == bytes.size()) return;
  const char* problem = bytes.size() < end ? " bytes, a truncated file" : " bytes, a damaged end of file";
  throw InputError({file, "", std::to_string(bytes.size()) + problem,
                    intact_file + std::string(" of ") + std::to_string(end) + " bytes"});
}

}  // namespace

std::string seal_of(std::string_view content)
{
  // CRC-32 of ISO 3309.
  const uLong crc = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
  std::string bytes(magic);
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(crc >> shift & 0xffu));
  bytes.resize(seal_bytes, '\0');
  return bytes;
}

void accept_unsealed_files(bool accepts)
{
  accepts_unsealed = accepts;
}

Hdf5Content read_hdf5(const std::string& file)
{
  std::string bytes = bytes_of_file(file);
  require_signature(file, bytes);
  const std::size_t sealed = bytes.size() < seal_bytes ? 0 : bytes.size() - seal_bytes;
  const std::string tail = bytes.substr(sealed);
  if (tail.compare(0, magic.size(), magic) == 0) {
    bytes.resize(sealed);
    if (tail == seal_of(bytes)) return {file, std::move(bytes)};
    throw InputError({file, "", "a damaged file (its checksum does not match)", intact_file});
  }
  require_whole(file, bytes);
  if (accepts_unsealed) return {file, std::move(bytes)};
  throw InputError({file, "", "a file without a seal, written or changed by another program",
                    "a sealed motion model or trace, or the option --unsealed"});
}

}  // namespace vrda::store
