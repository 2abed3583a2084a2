#include "show/settings_text.hpp"

#include <cmath>
#include <cstdio>

#include "core/text.hpp"

namespace vrda::show {

std::string quoted_text(std::string_view text)
{
  std::string in_quotes = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      in_quotes += '\\';
      in_quotes += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04X", static_cast<unsigned>(c));
      in_quotes += escape;
    } else {
      in_quotes += c;
    }
  }
  return in_quotes + "\"";
}

std::string number_text(double value)
{
  std::string text = shortest_decimal(value);
  if (text.find_first_of(".ein") == std::string::npos) text += ".0";
  return text;
}

std::string rounded_text(double value, int decimals)
{
  double scale = 1.0;
  for (int k = 0; k < decimals; ++k) scale *= 10.0;
  return shortest_decimal(std::round(value * scale) / scale);
}

std::string list_text(std::span<const double> values)
{
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + number_text(value);
  return text + "]";
}

}  // namespace vrda::show
