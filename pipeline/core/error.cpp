#include "core/error.hpp"

#include <string_view>
#include <utility>

namespace vrda {
namespace {

/// Longer than any path Linux takes; a key or word of a damaged file can have megabytes.
constexpr std::size_t longest_fact = 5000;

/// Without what would end the line or steer a terminal: a fact may quote any bytes of a file.
std::string printable(std::string_view fact)
{
  constexpr std::string_view hex = "0123456789abcdef";
  std::string out;
  for (const char c : fact.substr(0, longest_fact)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      out += c;
    } else {
      out += "\\x";
      out += hex[byte >> 4U];
      out += hex[byte & 15U];
    }
  }
  return fact.size() > longest_fact ? out + "..." : out;
}

std::string message(const InputError::Facts& facts)
{
  std::string text = printable(facts.file);
  if (!facts.field.empty()) text += (text.empty() ? "" : ": ") + printable(facts.field);
  text += (text.empty() ? "found " : ": found ") + printable(facts.found);
  if (!facts.wanted.empty()) text += ", wanted " + printable(facts.wanted);
  return text;
}

}  // namespace

InputError::InputError(Facts facts) : std::runtime_error(message(facts)), facts_(std::move(facts)) {}

void check(bool condition, const char* why)
{
  if (!condition) throw InternalError(why);
}

}  // namespace vrda
