#include "core/error.hpp"

#include <utility>

namespace vrda {
namespace {

std::string message(const InputError::Facts& facts)
{
  std::string text = facts.file;
  if (!facts.field.empty()) text += (text.empty() ? "" : ": ") + facts.field;
  text += (text.empty() ? "found " : ": found ") + facts.found;
  if (!facts.wanted.empty()) text += ", wanted " + facts.wanted;
  return text;
}

}  // namespace

InputError::InputError(Facts facts) : std::runtime_error(message(facts)), facts_(std::move(facts)) {}

void check(bool condition, const char* why)
{
  if (!condition) throw InternalError(why);
}

}  // namespace vrda
