#include "core/error.hpp"

#include <string_view>
#include <utility>

#include "core/text.hpp"

namespace vrda::inline core {
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

}  // namespace vrda::inline core
