#include "web/response.hpp"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "core/text.hpp"

namespace vrda::web {

std::string hex_digits(unsigned char byte)
{
  constexpr std::string_view digits = "0123456789ABCDEF";
  return {digits[byte >> 4U], digits[byte & 15U]};
}

std::string random_token()
{
  std::array<unsigned char, 16> bytes{};
  check(getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()),
        "the kernel provides random bytes");
  std::string token;
  for (const unsigned char byte : bytes) token += lower_case(hex_digits(byte));
  return token;
}

bool is_same_token(std::string_view given, std::string_view token)
{
  if (given.size() != token.size()) return false;
  int difference = 0;
  for (std::size_t k = 0; k < token.size(); ++k) difference |= given[k] ^ token[k];
  return difference == 0;
}

namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;

/// Header fields of every response: no caching, no embedding in frames, no cross-origin reading.
Fields fields_of(std::uint64_t n_bytes, const Fields& more)
{
  Fields fields{{"Content-Length", std::to_string(n_bytes)},
                {"Cache-Control", "no-store"},
                {"X-Content-Type-Options", "nosniff"},
                {"Cross-Origin-Resource-Policy", "same-origin"},
                {"Referrer-Policy", "no-referrer"},
                {"Content-Security-Policy", "frame-ancestors 'none'"},
                {"Connection", "close"}};
  fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

Response text_response(unsigned status, const std::string& text, Fields more = {})
{
  Response response;
  response.status = status;
  response.text = text + "\n";
  response.n_bytes = response.text.size();
  more.emplace_back("Content-Type", "text/plain; charset=utf-8");
  response.fields = fields_of(response.n_bytes, more);
  return response;
}

Response page(const Site& site)
{
  Response response;
  response.content = Content::page;
  response.n_bytes = site.page_size;
  response.fields =
      fields_of(site.page_size, {{"Content-Type", "text/html; charset=utf-8"}, {"Content-Encoding", "gzip"}});
  return response;
}

/// Percent-encodes UTF-8 (RFC 8187).
std::string percent_encoded(const std::string& text)
{
  std::string result;
  for (const char c : text) {
    const bool is_plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                          c == '-' || c == '.' || c == '_';
    result += is_plain ? std::string(1, c) : "%" + hex_digits(static_cast<unsigned char>(c));
  }
  return result;
}

/// Bytes `first` to `last` inclusive; parts omitted in the header are empty.
struct ByteRange {
  std::optional<std::uint64_t> first;
  std::optional<std::uint64_t> last;  ///< without `first`: the number of bytes at the end
};

/// Returns false if the text is not a number; leaves `number` empty for an empty text.
bool read_number(std::string_view text, std::optional<std::uint64_t>& number)
{
  if (text.empty()) return true;
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return false;
  number = value;
  return true;
}

std::optional<ByteRange> parsed_range(std::string_view value)
{
  constexpr std::string_view unit = "bytes=";
  const std::size_t dash = value.find('-');
  if (!value.starts_with(unit) || dash == std::string_view::npos) return std::nullopt;
  ByteRange range;
  if (!read_number(value.substr(unit.size(), dash - unit.size()), range.first)) return std::nullopt;
  if (!read_number(value.substr(dash + 1), range.last)) return std::nullopt;
  if (!range.first && !range.last) return std::nullopt;
  if (range.first && range.last && *range.last < *range.first) return std::nullopt;
  return range;
}

Response model(const std::optional<ByteRange>& range, const Site& site)
{
  const std::uint64_t size = *site.model_size;
  const std::string of_size = "/" + std::to_string(size);
  Response response;
  response.content = Content::model;
  response.n_bytes = size;
  Fields more{
      {"Content-Type", "application/x-hdf5"},
      {"Accept-Ranges", "bytes"},
      {"Content-Disposition", "inline; filename*=UTF-8''" + percent_encoded(site.model_name)},
  };
  if (range) {
    const std::uint64_t wanted_last = range->last.value_or(size);
    response.first_byte = range->first ? *range->first : size - std::min(size, wanted_last);
    const std::uint64_t end = range->first && wanted_last < size ? wanted_last + 1 : size;
    if (response.first_byte >= end)
      return text_response(416, "found a range beyond the end of the file",
                           {{"Content-Range", "bytes *" + of_size}});
    response.status = 206;
    response.n_bytes = end - response.first_byte;
    more.emplace_back("Content-Range", "bytes " + std::to_string(response.first_byte) + "-" +
                                           std::to_string(end - 1) + of_size);
  }
  response.fields = fields_of(response.n_bytes, more);
  return response;
}

bool is_same_name(std::string_view a, std::string_view b)
{
  return lower_case(std::string(a)) == lower_case(std::string(b));
}

bool is_own_host(std::string_view host, const Site& site)
{
  const std::string own_port = ":" + std::to_string(site.port);
  const std::string_view name =
      host.substr(0, host.ends_with(own_port) ? host.size() - own_port.size() : host.size());
  // Browsers omit the default port of the scheme.
  if (name.size() == host.size() && site.port != (site.is_secure ? 443 : 80)) return false;
  return std::ranges::any_of(site.hosts, [name](const std::string& own) { return is_same_name(name, own); });
}

/// Browsers send the origin of the page that opens a WebSocket; other programs none.
bool is_own_origin(const Request& request, const Site& site)
{
  return request.origin.empty() ||
         is_same_name(request.origin, (site.is_secure ? "https://" : "http://") + request.host);
}

Response live(const Request& request, const Site& site)
{
  if (!request.is_upgrade)
    return text_response(426, "found no WebSocket, wanted one", {{"Upgrade", "websocket"}});
  if (!is_own_origin(request, site))
    return text_response(403, "found the page of another server, wanted this server's");
  Response response;
  response.status = 101;
  response.content = Content::live;
  return response;
}

}  // namespace

std::string page_target(const Site& site)
{
  return site.is_live ? "/?model=model.h5&live=live" : "/?model=model.h5";
}

Response response_to(const Request& request, const Site& site)
{
  if (request.host.empty() || !request.target.starts_with('/')) return bad_request();
  if (!is_own_host(request.host, site))
    return text_response(403, "found another host, wanted the address that the server printed");
  const std::string_view path = std::string_view(request.target).substr(1);
  const std::string_view token = path.substr(0, path.find_first_of("/?"));
  if (!is_same_token(token, site.token))
    return text_response(403, "found no valid token, wanted the address that the server printed");
  if (request.method != "GET")
    return text_response(405, "found another method, wanted GET", {{"Allow", "GET"}});
  const std::string_view target = path.substr(token.size());
  if (target.empty() || target == "/")
    return text_response(302, page_target(site), {{"Location", "/" + site.token + page_target(site)}});
  if (target == page_target(site)) return page(site);
  if (target == model_target && site.model_size) return model(parsed_range(request.range), site);
  if (target == live_target && site.is_live) return live(request, site);
  return text_response(404, "not found");
}

Response bad_request()
{
  return text_response(400, "found a malformed request");
}

Response request_timeout()
{
  return text_response(408, "found no complete request within the time limit");
}

Response too_many_viewers()
{
  return text_response(503, "found too many viewers, wanted fewer: close one and reload",
                       {{"Retry-After", "5"}});
}

}  // namespace vrda::web
