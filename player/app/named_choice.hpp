/// Options whose values have names.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

namespace vrda {

/// From a name of `choices` to its value; any other is refused as "found X, wanted A, B or C".
template <typename Value>
CLI::Validator named_choice(const std::map<std::string, Value>& choices)
{
  return CLI::Validator(
      [choices](std::string& word) {
        const auto chosen = choices.find(word);
        if (chosen != choices.end()) {
          word = std::to_string(static_cast<int>(chosen->second));
          return std::string();
        }
        std::string error = "found '" + word + "', wanted ";
        std::size_t i = 0;
        for (const auto& [name, value] : choices) {
          if (i > 0) error += i + 1 == choices.size() ? " or " : ", ";
          error += name;
          ++i;
        }
        return error;
      },
      "NAME");
}

}  // namespace vrda
