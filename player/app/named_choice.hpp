/// Options whose values have names, and keys in help texts.
#pragma once

#include <map>
#include <span>
#include <string>

#include "view/keys.hpp"

namespace CLI {
class Validator;
}

namespace vrda {

/// The values of an enum as numbers.
template <typename Value>
std::map<std::string, int> numbers_of(const std::map<std::string, Value>& choices)
{
  std::map<std::string, int> numbers;
  for (const auto& [name, value] : choices) numbers[name] = static_cast<int>(value);
  return numbers;
}

/// From a name of `choices` to its number; any other is refused as "found X, wanted A, B or C".
CLI::Validator named_choice(const std::map<std::string, int>& choices);

/// For CLI::Option::check: what is wrong with an empty name, else nothing.
std::string refusal_of_nothing(const std::string& text);

/// "Keys:" and a line each, what they do from `column` on.
std::string keys_text(std::span<const HelpLine> lines, std::size_t column);

}  // namespace vrda
