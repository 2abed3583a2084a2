/// Responses of the web server, independent of sockets and the HTTP library.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vrda::web {

/// Two digits, upper case.
std::string hex_digits(unsigned char byte);

/// 128 random bits of the kernel as 32 hexadecimal digits.
std::string random_token();

/// Constant-time comparison for texts of the token's length, against timing attacks.
bool is_same_token(std::string_view given, std::string_view token);

/// The embedded HTML page, gzip-compressed.
std::string_view compressed_page();
/// The same, compressed by xz, as embedded in the program.
std::string_view embedded_page();

struct Request {
  std::string method;
  std::string target;       ///< as sent: path and query, not decoded
  std::string host;         ///< with port
  std::string range;        ///< value of the Range header, or empty
  std::string origin = {};  ///< value of the Origin header, or empty
  bool is_upgrade = false;  ///< asks for a WebSocket
};

/// `live`: the connection becomes a WebSocket.
enum class Content { text, page, model, live };

struct Response {
  unsigned status = 200;
  std::vector<std::pair<std::string, std::string>> fields;  ///< header fields with Content-Length
  Content content = Content::text;
  std::string text;              ///< for Content::text
  std::uint64_t first_byte = 0;  ///< for Content::model
  std::uint64_t n_bytes = 0;
};

/// The served content at the time of a request.
struct Site {
  int port = 0;
  std::string token;                                         ///< first segment of every valid path
  std::uint64_t page_size = 0;                               ///< bytes, gzip-compressed
  std::string model_name;                                    ///< file name for display
  std::optional<std::uint64_t> model_size;                   ///< bytes; empty if the file is missing
  bool is_secure = false;                                    ///< https
  bool is_live = false;                                      ///< there is a bench to stream
  std::vector<std::string> hosts{"127.0.0.1", "localhost"};  ///< valid names of this server
};

/// Path and query of the page below the token; "/TOKEN/" redirects to it.
std::string page_target(const Site& site);
inline constexpr const char* model_target = "/model.h5";
inline constexpr const char* live_target = "/live";  ///< WebSocket

/// Serves only GET of the three targets above below the token, for the site's hosts with the server's port
/// (against DNS rebinding), and WebSockets only to pages of this server. A Range header other than a single
/// byte range is ignored, as RFC 9110 allows.
Response response_to(const Request& request, const Site& site);

/// The responses 400, 408 and 503.
Response bad_request();
Response request_timeout();
Response too_many_viewers();

}  // namespace vrda::web
