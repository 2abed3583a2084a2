#include "gui/font_file.hpp"

#include <zlib.h>

#include "core/error.hpp"

namespace vrda {
namespace {

/// The last four bytes of a gzip file: how long its content is, little-endian.
std::size_t content_size(std::string_view gzip)
{
  std::size_t size = 0;
  for (std::size_t i = 1; i <= 4; ++i) size = size << 8 | static_cast<unsigned char>(gzip[gzip.size() - i]);
  return size;
}

}  // namespace

std::string font_file()
{
  const std::string_view gzip = compressed_font_file();
  std::string file(content_size(gzip), '\0');
  z_stream stream{};
  // The library only reads its input, but does not say so.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzip.data()));
  stream.avail_in = static_cast<uInt>(gzip.size());
  stream.next_out = reinterpret_cast<Bytef*>(file.data());
  stream.avail_out = static_cast<uInt>(file.size());
  constexpr int gzip_window = 15 + 16;  // the largest window, with a gzip header
  check(inflateInit2(&stream, gzip_window) == Z_OK, "zlib starts");
  const int ended = inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  check(ended == Z_STREAM_END && stream.avail_out == 0, "the font in the program is whole");
  return file;
}

}  // namespace vrda
