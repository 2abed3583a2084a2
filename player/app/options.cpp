#include "app/options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

#include "core/text.hpp"

namespace vrda::app {
namespace {

std::string unknown_choice(const std::string& word, const std::map<std::string, int>& choices)
{
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  return "found '" + word + "', wanted " + join_alternatives(names);
}

}  // namespace

CLI::Validator named_choice(const std::map<std::string, int>& choices)
{
  return {[choices](std::string& word) {
            const auto chosen = choices.find(word);
            if (chosen == choices.end()) return unknown_choice(word, choices);
            word = std::to_string(chosen->second);
            return std::string();
          },
          "NAME"};
}

std::string empty_value_error(const std::string& text)
{
  return text.empty() ? "found nothing, wanted a name" : "";
}

std::string key_help_text(std::span<const navigation::HelpLine> lines, std::size_t column)
{
  std::string text = "Keys:\n";
  for (const navigation::HelpLine& line : lines) {
    std::string keys = line.keys;
    keys.resize(std::max(column, keys.size() + 2), ' ');
    text += "  " + keys + line.description + "\n";
  }
  return text;
}

}  // namespace vrda::app
