#include "app/printing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/document.hpp"
#include "core/text.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

const Json& value_at(const Json& values, const std::string& path)
{
  const std::size_t dot = path.find('.');
  const std::string key = path.substr(0, dot);
  const Json& value = values.is_array() ? values.at(std::stoul(key)) : values.at(key);
  return dot == std::string::npos ? value : value_at(value, path.substr(dot + 1));
}

std::string text_of(const Json& value, const std::string& conversion)
{
  if (value.is_null()) return "none";
  if (value.is_string() && conversion.empty()) return value.get<std::string>();
  if (value.is_string()) return printed(conversion.c_str(), value.get<std::string>().c_str());
  if (conversion.empty()) return std::to_string(value.get<std::int64_t>());
  if (conversion.back() != 'd') return printed(conversion.c_str(), value.get<double>());
  return printed((conversion.substr(0, conversion.size() - 1) + "ld").c_str(), value.get<long>());
}

}  // namespace

core::ExitCode print_json(const Json& json)
{
  std::printf("%s\n", core::json_text(json, 2).c_str());
  return core::ExitCode::done;
}

std::string formatted(const char* conversion, double value)
{
  return std::isnan(value) ? "-" : printed(conversion, value);
}

std::string filled(const char* text, const Json& values)
{
  std::string out;
  const std::string all = text;
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t open = std::min(all.find('{', at), all.size()), close = all.find('}', open);
    out += all.substr(at, open - at);
    if (open == all.size()) break;
    const std::string inside = all.substr(open + 1, close - open - 1);
    const std::size_t percent = std::min(inside.find('%'), inside.size());
    out += text_of(value_at(values, inside.substr(0, percent)), inside.substr(percent));
    at = close + 1;
  }
  return out;
}

void print_filled(const char* text, const Json& values)
{
  std::printf("%s", filled(text, values).c_str());
}

}  // namespace vrda::app
