/// Options whose values have names.
#pragma once

#include <map>
#include <string>

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

}  // namespace vrda
