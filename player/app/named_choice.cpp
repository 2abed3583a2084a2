#include "app/named_choice.hpp"

#include <CLI/CLI.hpp>

namespace vrda {
namespace {

std::string refusal(const std::string& word, const std::map<std::string, int>& choices)
{
  std::string text = "found '" + word + "', wanted ";
  std::size_t i = 0;
  for (const auto& [name, value] : choices) {
    if (i > 0) text += i + 1 == choices.size() ? " or " : ", ";
    text += name;
    ++i;
  }
  return text;
}

}  // namespace

CLI::Validator named_choice(const std::map<std::string, int>& choices)
{
  return {[choices](std::string& word) {
            const auto chosen = choices.find(word);
            if (chosen == choices.end()) return refusal(word, choices);
            word = std::to_string(chosen->second);
            return std::string();
          },
          "NAME"};
}

}  // namespace vrda
