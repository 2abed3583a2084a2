/// JSON that the program itself writes and reads again: results, not jobs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace vrda::inline core {

/// A JSON file whose values are read by their path ("limits/strain"); every failure is an InputError that
/// names file and path, the value found and the one wanted.
class JsonFile {
 public:
  using Json = nlohmann::ordered_json;

  /// Throws InputError with `wanted` unless the text is a JSON object of at most 40 levels.
  JsonFile(std::string file, std::string_view text, const std::string& wanted);

  const Json& root() const { return root_; }
  const Json& at(const std::string& path) const;
  double number(const std::string& path) const;
  std::string text(const std::string& path) const;
  std::vector<std::string> texts(const std::string& path) const;
  /// `n`: number of entries; 0: any. Without `if_null`, that is NaN, null is refused.
  std::vector<double> numbers(const std::string& path, std::size_t n, double if_null) const;

  [[noreturn]] void refuse(const std::string& path, const std::string& found,
                           const std::string& wanted) const;

 private:
  const Json& list(const std::string& path, std::size_t n) const;

  std::string file_;
  Json root_;
};

/// A value for messages: a table or list by its type.
std::string shown(const nlohmann::ordered_json& value);

/// The text of `json`; invalid UTF-8, which a path may contain, is replaced.
template <typename Json>
std::string json_text(const Json& json, int indent)
{
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace vrda::inline core
