/// What the server answers: decided here, without a socket.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "web/request.hpp"

namespace vrda {

enum class Content { text, page, model };

struct Response {
  int status = 200;
  std::string head;  ///< with the empty line
  Content content = Content::text;
  std::string text;              ///< of Content::text
  std::uint64_t first_byte = 0;  ///< of the page or model
  std::uint64_t n_bytes = 0;
};

/// What there is to serve at the moment of a request.
struct Site {
  int port = 0;
  std::uint64_t page_size = 0;              ///< bytes, compressed by gzip
  std::string model_name;                   ///< file name, for the reader's eyes
  std::optional<std::uint64_t> model_size;  ///< bytes; nothing when the file is not there
};

/// Path and query of the page, which "/" leads to.
inline constexpr const char* page_target = "/?model=model.h5";
inline constexpr const char* model_target = "/model.h5";

/// The answer to a request, or to none (`nullopt`): to what was not understood. Only GET, only the two
/// targets above, only for the hosts 127.0.0.1 and localhost with the server's port: another site whose name
/// was made to lead here (DNS rebinding) is refused.
Response response_to(const std::optional<Request>& request, const Site& site);

}  // namespace vrda
