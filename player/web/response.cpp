#include "web/response.hpp"

#include <algorithm>

namespace vrda {
namespace {

const char* reason_of(int status)
{
  switch (status) {
    case 200:
      return "OK";
    case 206:
      return "Partial Content";
    case 302:
      return "Found";
    case 400:
      return "Bad Request";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    default:
      return "Range Not Satisfiable";
  }
}

/// First line and what every answer says: nothing is kept, shown in another page's frame or read by it.
std::string head_of(int status, std::uint64_t n_bytes, const std::string& more)
{
  return "HTTP/1.1 " + std::to_string(status) + " " + reason_of(status) + "\r\n" +
         "Content-Length: " + std::to_string(n_bytes) + "\r\n" + more +
         "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
         "Cross-Origin-Resource-Policy: same-origin\r\nReferrer-Policy: no-referrer\r\n"
         "Content-Security-Policy: frame-ancestors 'none'\r\nConnection: close\r\n\r\n";
}

Response told(int status, const std::string& text, const std::string& more = "")
{
  Response response;
  response.status = status;
  response.text = text + "\n";
  response.n_bytes = response.text.size();
  response.head = head_of(status, response.n_bytes, "Content-Type: text/plain; charset=utf-8\r\n" + more);
  return response;
}

Response page(const Site& site)
{
  Response response;
  response.content = Content::page;
  response.n_bytes = site.page_size;
  response.head =
      head_of(200, site.page_size, "Content-Type: text/html; charset=utf-8\r\nContent-Encoding: gzip\r\n");
  return response;
}

/// Bytes of UTF-8, all but letters and digits as %XX (RFC 8187).
std::string percent_encoded(const std::string& text)
{
  constexpr const char* digits = "0123456789ABCDEF";
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                          c == '-' || c == '.' || c == '_';
    if (is_plain) {
      result += c;
    } else {
      result += '%';
      result += digits[byte >> 4U];
      result += digits[byte & 15U];
    }
  }
  return result;
}

Response model(const std::optional<ByteRange>& range, const Site& site)
{
  const std::uint64_t size = *site.model_size;
  Response response;
  response.content = Content::model;
  response.n_bytes = size;
  std::string more =
      "Content-Type: application/x-hdf5\r\nAccept-Ranges: bytes\r\nContent-Disposition: inline; "
      "filename*=UTF-8''" +
      percent_encoded(site.model_name) + "\r\n";
  if (range) {
    const std::uint64_t wanted_last = range->last.value_or(size);
    response.first_byte = range->first ? *range->first : size - std::min(size, wanted_last);
    const std::uint64_t end = range->first && wanted_last < size ? wanted_last + 1 : size;
    if (response.first_byte >= end)
      return told(416, "found a range beyond the end",
                  "Content-Range: bytes */" + std::to_string(size) + "\r\n");
    response.status = 206;
    response.n_bytes = end - response.first_byte;
    more += "Content-Range: bytes " + std::to_string(response.first_byte) + "-" + std::to_string(end - 1) +
            "/" + std::to_string(size) + "\r\n";
  }
  response.head = head_of(response.status, response.n_bytes, more);
  return response;
}

bool is_own_host(const std::string& host, int port)
{
  const std::string own_port = ":" + std::to_string(port);
  // Browsers leave out a port that is the scheme's own.
  const bool is_plain = port == 80 && (host == "127.0.0.1" || host == "localhost");
  return is_plain || host == "127.0.0.1" + own_port || host == "localhost" + own_port;
}

}  // namespace

Response response_to(const std::optional<Request>& request, const Site& site)
{
  if (!request) return told(400, "found no request that could be read");
  if (!is_own_host(request->host, site.port))
    return told(403, "found another host, wanted 127.0.0.1 or localhost with this server's port");
  if (request->method != "GET") return told(405, "found another method, wanted GET", "Allow: GET\r\n");
  if (request->target == "/") return told(302, page_target, std::string("Location: ") + page_target + "\r\n");
  if (request->target == page_target) return page(site);
  if (request->target == model_target && site.model_size) return model(request->range, site);
  return told(404, "not found");
}

}  // namespace vrda
