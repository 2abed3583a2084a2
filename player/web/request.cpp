#include "web/request.hpp"

#include <algorithm>
#include <charconv>

namespace vrda {
namespace {

constexpr std::string_view blanks = " \t";

std::string_view trimmed(std::string_view text)
{
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string lower(std::string_view text)
{
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

/// The text up to `end`, which is cut off `rest` with it; everything when there is none.
std::string_view taken(std::string_view& rest, std::string_view end)
{
  const std::size_t at = rest.find(end);
  const std::string_view found = rest.substr(0, at);
  rest = at == std::string_view::npos ? std::string_view{} : rest.substr(at + end.size());
  return found;
}

bool is_plain(std::string_view text)
{
  return std::all_of(text.begin(), text.end(), [](char c) { return (c >= ' ' && c != 0x7f) || c == '\t'; });
}

/// False where the text is not a number; true and nothing where it is empty.
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
  if (!value.starts_with(unit)) return std::nullopt;
  std::string_view rest = value.substr(unit.size());
  if (rest.find('-') == std::string_view::npos) return std::nullopt;
  const std::string_view first = taken(rest, "-");
  ByteRange range;
  if (!read_number(first, range.first) || !read_number(rest, range.last)) return std::nullopt;
  if (!range.first && !range.last) return std::nullopt;
  if (range.first && range.last && *range.last < *range.first) return std::nullopt;
  return range;
}

bool read_first_line(std::string_view line, Request& request)
{
  request.method = std::string(taken(line, " "));
  request.target = std::string(taken(line, " "));
  return !request.method.empty() && request.target.starts_with('/') &&
         (line == "HTTP/1.1" || line == "HTTP/1.0");
}

}  // namespace

std::optional<Request> parsed_request(std::string_view head)
{
  Request request;
  std::string_view rest = head;
  const std::string_view first_line = taken(rest, "\r\n");
  if (!is_plain(first_line) || !read_first_line(first_line, request)) return std::nullopt;
  while (!rest.empty()) {
    std::string_view line = taken(rest, "\r\n");
    const std::size_t colon = line.find(':');
    if (!is_plain(line) || colon == std::string_view::npos || colon == 0) return std::nullopt;
    const std::string name = lower(taken(line, ":"));
    if (name.find_first_of(blanks) != std::string::npos) return std::nullopt;
    const std::string_view value = trimmed(line);
    if (name == "host") {
      if (!request.host.empty() || value.empty()) return std::nullopt;
      request.host = lower(value);
    } else if (name == "range") {
      request.range = parsed_range(value);
    }
  }
  if (request.host.empty()) return std::nullopt;
  return request;
}

}  // namespace vrda
