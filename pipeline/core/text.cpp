#include "core/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <utility>

namespace vrda::inline core {
namespace {

/// The smallest code point that needs this many continuation bytes.
constexpr std::array<std::uint32_t, 4> smallest{0, 0x80, 0x800, 0x10000};

/// Number of continuation bytes after `first`; 4 where it is not a lead byte.
std::size_t n_following(unsigned char first)
{
  if (first < 0x80) return 0;
  if (first >= 0xc0 && first < 0xe0) return 1;
  if (first >= 0xe0 && first < 0xf0) return 2;
  return first >= 0xf0 && first < 0xf8 ? 3 : 4;
}

/// Length in bytes of the control character at `at`; 0 without one.
std::size_t control_bytes(std::string_view text, std::size_t at)
{
  const auto byte = static_cast<unsigned char>(text[at]);
  if (byte < 0x20 || byte == 0x7f) return 1;
  if (byte != 0xc2 || at + 1 == text.size()) return 0;
  const auto next = static_cast<unsigned char>(text[at + 1]);
  return next >= 0x80 && next < 0xa0 ? 2 : 0;
}

}  // namespace

bool is_utf8(std::string_view bytes)
{
  for (std::size_t at = 0; at < bytes.size();) {
    const auto first = static_cast<unsigned char>(bytes[at++]);
    const std::size_t n = n_following(first);
    if (n == 0) continue;
    if (n > 3 || bytes.size() - at < n) return false;
    std::uint32_t character = first & (0x3fu >> n);
    for (std::size_t k = 0; k < n; ++k, ++at) {
      const auto next = static_cast<unsigned char>(bytes[at]);
      if ((next & 0xc0u) != 0x80u) return false;
      character = character << 6 | (next & 0x3fu);
    }
    const bool is_surrogate = character >= 0xd800 && character <= 0xdfff;
    if (character < smallest[n] || character > 0x10ffff || is_surrogate) return false;
  }
  return true;
}

bool has_control_characters(std::string_view text, std::string_view allowed)
{
  for (std::size_t at = 0; at < text.size(); ++at)
    if (control_bytes(text, at) > 0 && allowed.find(text[at]) == std::string_view::npos) return true;
  return false;
}

std::string escape_control_characters(std::string_view text)
{
  constexpr std::string_view hex = "0123456789abcdef";
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t n_control = control_bytes(text, at);
    if (n_control == 0) out += text[at++];
    for (const std::size_t end = at + n_control; at < end; ++at) {
      const auto byte = static_cast<unsigned char>(text[at]);
      out += "\\x";
      out += hex[byte >> 4U];
      out += hex[byte & 15U];
    }
  }
  return out;
}

std::string escape_markup(std::string_view text)
{
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string quoted_text(std::string_view text)
{
  constexpr std::string_view hex = "0123456789ABCDEF";
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      out += "\\u00";
      out += hex[byte >> 4U];
      out += hex[byte & 15U];
    } else {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
  }
  return out + '"';
}

std::string quoted_csv(std::string_view text)
{
  std::string out = "\"";
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  return out + '"';
}

std::string csv_field(std::string_view text)
{
  return text.find_first_of(",\"\n\r") == std::string_view::npos ? std::string(text) : quoted_csv(text);
}

std::string shortest_decimal(double value)
{
  std::array<char, 32> digits{};
  const std::to_chars_result end = std::to_chars(digits.data(), digits.data() + digits.size(), value + 0.0);
  return {digits.data(), end.ptr};
}

std::string rounded_text(double value, int n_digits)
{
  return printed("%.*g", n_digits, value);
}

std::string short_decimal(double value, int most_decimals)
{
  double steps = 1.0;
  for (int k = 0; k < most_decimals; ++k) steps *= 10.0;
  return shortest_decimal(std::round(value * steps) / steps);
}

std::string csv_number(double value)
{
  return std::isfinite(value) ? shortest_decimal(value) : "";
}

std::string fixed_text(double value, int n_decimals)
{
  return printed("%.*f", n_decimals, value);
}

std::size_t edit_distance(std::string_view a, std::string_view b)
{
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& known)
{
  const auto best =
      std::min_element(known.begin(), known.end(), [&](const std::string& a, const std::string& b) {
        return edit_distance(word, a) < edit_distance(word, b);
      });
  return best == known.end() ? "" : *best;
}

std::string lower_case(std::string text)
{
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

std::string printed(const char* format, ...)
{
  std::va_list values, again;
  va_start(values, format);
  va_copy(again, values);
  const int n = std::vsnprintf(nullptr, 0, format, values);
  std::string text(static_cast<std::size_t>(std::max(n, 0)), '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  va_end(values);
  return text;
}

std::string joined(const std::vector<std::string>& words, std::string_view separator)
{
  std::string text;
  for (const std::string& word : words) {
    if (&word != &words.front()) text += separator;
    text += word;
  }
  return text;
}

std::string join_alternatives(const std::vector<std::string>& words, std::string_view last)
{
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? last : ", ";
    text += words[i];
  }
  return text;
}

namespace {

/// Longer than any Linux path; a key or word of a damaged file can have megabytes.
constexpr std::size_t longest_fact = 5000;

/// Escaped and truncated, since a fact may quote any bytes of a file.
std::string shown(std::string_view fact)
{
  return escape_control_characters(fact.substr(0, longest_fact)) + (fact.size() > longest_fact ? "..." : "");
}

std::string message(const InputError::Facts& facts)
{
  std::string text = shown(facts.file);
  std::string place = facts.line > 0 ? "line " + std::to_string(facts.line) : "";
  if (!facts.field.empty()) place += (place.empty() ? "" : ", ") + shown(facts.field);
  if (!place.empty()) text += (text.empty() ? "" : ": ") + place;
  text += (text.empty() ? "found " : ": found ") + shown(facts.found);
  if (!facts.wanted.empty()) text += ", wanted " + shown(facts.wanted);
  return text;
}

}  // namespace

InputError::InputError(Facts facts) : std::runtime_error(message(facts)), facts_(std::move(facts)) {}

void check(bool condition, const char* why)
{
  if (!condition) throw InternalError(why);
}

// The rule for names of the key of a sequence of frames ("time_s").

bool is_key_name(const std::string& name)
{
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  return !name.empty() && name.size() <= 40 && is_letter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

}  // namespace vrda::inline core
