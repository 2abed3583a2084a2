#include "core/json_file.hpp"

#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/depth.hpp"

namespace vrda::inline core {

JsonFile::JsonFile(std::string file, std::string_view text, const std::string& wanted)
    : file_(std::move(file))
{
  require_shallow(text, file_, Syntax::json);
  root_ = Json::parse(text, nullptr, false);
  if (!root_.is_object()) refuse("", "another kind of file", wanted);
}

void JsonFile::refuse(const std::string& path, const std::string& found, const std::string& wanted) const
{
  throw InputError({file_, path, found, wanted});
}

const JsonFile::Json& JsonFile::at(const std::string& path) const
{
  const Json::json_pointer pointer("/" + path);
  if (!root_.contains(pointer)) refuse(path, "nothing", "a value");
  return root_.at(pointer);
}

double JsonFile::number(const std::string& path) const
{
  const Json& value = at(path);
  if (!value.is_number()) refuse(path, shown(value), "a number");
  return value.get<double>();
}

std::string JsonFile::text(const std::string& path) const
{
  const Json& value = at(path);
  if (!value.is_string()) refuse(path, shown(value), "text");
  return value.get<std::string>();
}

std::vector<double> JsonFile::numbers(const std::string& path, std::size_t n, double if_null) const
{
  std::vector<double> values;
  for (const Json& value : list(path, n)) {
    if (!value.is_number() && !(value.is_null() && std::isnan(if_null)))
      refuse(path, shown(value), "numbers");
    values.push_back(value.is_null() ? if_null : value.get<double>());
  }
  return values;
}

std::vector<std::string> JsonFile::texts(const std::string& path) const
{
  std::vector<std::string> values;
  for (const Json& value : list(path, 0)) {
    if (!value.is_string()) refuse(path, shown(value), "a list of texts");
    values.push_back(value.get<std::string>());
  }
  return values;
}

const JsonFile::Json& JsonFile::list(const std::string& path, std::size_t n) const
{
  const Json& value = at(path);
  if (!value.is_array()) refuse(path, shown(value), "a list");
  if (n > 0 && value.size() != n) refuse(path, std::to_string(value.size()) + " entries", std::to_string(n));
  return value;
}

std::string shown(const nlohmann::ordered_json& value)
{
  if (value.is_array()) return "a list";
  if (value.is_object()) return "a table";
  return json_text(value, -1);
}

}  // namespace vrda::inline core
