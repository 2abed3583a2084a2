#include "app/options.hpp"

#include <algorithm>

namespace vrda::app {

std::string empty_value_error(const std::string& text)
{
  return text.empty() ? "found nothing, wanted a name" : "";
}

std::string key_help_text(std::span<const view::HelpLine> lines, std::size_t column)
{
  std::string text = "Keys:\n";
  for (const view::HelpLine& line : lines) {
    std::string keys = line.keys;
    keys.resize(std::max(column, keys.size() + 2), ' ');
    text += "  " + keys + line.description + "\n";
  }
  return text;
}

}  // namespace vrda::app
