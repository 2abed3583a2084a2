// The page is embedded as xz, which is a quarter smaller than gzip; browsers accept gzip.
#include <lzma.h>
#include <zlib.h>

#include <limits>
#include <string>

#include "core/error.hpp"
#include "web/response.hpp"

namespace vrda::web {
namespace {

std::string unpacked(std::string_view xz)
{
  std::string text;
  constexpr std::size_t piece = 1U << 20U;
  lzma_stream stream = LZMA_STREAM_INIT;
  lzma_ret state = lzma_stream_decoder(&stream, std::numeric_limits<std::uint64_t>::max(), 0);
  stream.next_in = reinterpret_cast<const std::uint8_t*>(xz.data());
  stream.avail_in = xz.size();
  while (state == LZMA_OK) {
    const std::size_t n = text.size();
    text.resize(n + piece);
    stream.next_out = reinterpret_cast<std::uint8_t*>(text.data() + n);
    stream.avail_out = piece;
    state = lzma_code(&stream, LZMA_FINISH);
    text.resize(n + piece - stream.avail_out);
  }
  lzma_end(&stream);
  check(state == LZMA_STREAM_END, "the embedded page can be unpacked");
  return text;
}

std::string gzipped(const std::string& text)
{
  constexpr int level = 6, gzip_window_bits = 15 + 16, usual_memory = 8;
  z_stream stream{};
  check(deflateInit2(&stream, level, Z_DEFLATED, gzip_window_bits, usual_memory, Z_DEFAULT_STRATEGY) == Z_OK,
        "zlib starts");
  std::string packed(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // zlib only reads
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int state = deflate(&stream, Z_FINISH);
  packed.resize(packed.size() - stream.avail_out);
  deflateEnd(&stream);
  check(state == Z_STREAM_END, "the page fits its bound");
  return packed;
}

}  // namespace

std::string_view compressed_page()
{
  static const std::string page = gzipped(unpacked(embedded_page()));
  return page;
}

}  // namespace vrda::web
