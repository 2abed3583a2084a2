/// What a browser asks for: the head of an HTTP/1.1 request.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vrda {

/// Bytes `first` to `last` of a file, both included; what the header left out is empty.
struct ByteRange {
  std::optional<std::uint64_t> first;
  std::optional<std::uint64_t> last;  ///< without `first`: so many bytes at the end
};

struct Request {
  std::string method;
  std::string target;  ///< as sent: path and query, not decoded
  std::string host;    ///< with its port, lower case
  std::optional<ByteRange> range;
};

/// A head longer than this is refused; a browser's own stay below 2 KB.
inline constexpr std::size_t longest_request_head = 16384;

/// The request of a head, which ends before the empty line. Nothing where it is none: a malformed line, no or
/// two Host headers, control characters, another version than HTTP/1.0 and 1.1. A range that is not one range
/// of bytes is left out, as the standard allows.
/// Source: RFC 9110 and RFC 9112.
std::optional<Request> parsed_request(std::string_view head);

}  // namespace vrda
