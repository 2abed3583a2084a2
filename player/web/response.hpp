/// What the server answers: decided here, without a socket and without the HTTP library.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vrda {

/// 128 bits of the kernel's random source as 32 hexadecimal digits.
std::string random_token();

/// Takes as long for any text of the token's length, so that nobody finds the token digit by digit.
bool is_same_token(std::string_view given, std::string_view token);

/// One HTML file with all it needs, compressed by gzip.
std::string_view compressed_page();

struct Request {
  std::string method;
  std::string target;  ///< as sent: path and query, not decoded
  std::string host;    ///< with its port
  std::string range;   ///< the header's value; empty without one
};

enum class Content { text, page, model };

struct Response {
  unsigned status = 200;
  std::vector<std::pair<std::string, std::string>> fields;  ///< header, with Content-Length
  Content content = Content::text;
  std::string text;              ///< of Content::text
  std::uint64_t first_byte = 0;  ///< of the model
  std::uint64_t n_bytes = 0;
};

/// What there is to serve at the moment of a request.
struct Site {
  int port = 0;
  std::string token;                        ///< first part of every path that is answered
  std::uint64_t page_size = 0;              ///< bytes, compressed by gzip
  std::string model_name;                   ///< file name, for the reader's eyes
  std::optional<std::uint64_t> model_size;  ///< bytes; nothing when the file is not there
};

/// Path and query of the page below the token, which "/TOKEN/" leads to.
inline constexpr const char* page_target = "/?model=model.h5";
inline constexpr const char* model_target = "/model.h5";

/// Only GET, only the two targets above, only below the token, only for the hosts 127.0.0.1 and localhost
/// with the server's port: another site whose name was made to lead here (DNS rebinding) is refused. A range
/// that is not one range of bytes is ignored, as RFC 9110 allows.
Response response_to(const Request& request, const Site& site);

/// The answers to what is not a request, and to what did not become one in time.
Response bad_request();
Response request_timeout();

}  // namespace vrda
