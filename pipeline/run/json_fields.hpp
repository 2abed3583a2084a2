/// Structs as JSON objects: `name_fields(fields, value)` lists members and keys, for both directions.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>

#include "core/error.hpp"
#include "core/json_file.hpp"

namespace vrda::run {

struct JsonWriter {
  nlohmann::ordered_json& json;

  template <typename Value>
  void operator()(const char* key, const Value& value) const
  {
    json[key] = value;
  }
  /// A key that is absent where the value is that of a new object.
  template <typename Value>
  void optional(const char* key, const Value& value) const
  {
    if (value != Value{}) json[key] = value;
  }
};

/// A key that is missing or has a value of another type.
struct FieldError : nlohmann::json::exception {
  FieldError(std::string key, std::string what, std::string kind)
      : nlohmann::json::exception(501, "a field"),
        field(std::move(key)),
        found(std::move(what)),
        wanted(std::move(kind))
  {
  }
  std::string field, found, wanted;
};

template <typename Value>
std::string kind_of()
{
  if constexpr (std::is_same_v<Value, std::string>) {
    return "text";
  } else if constexpr (std::is_arithmetic_v<Value>) {
    return "a number";
  } else {
    return "a list or table";
  }
}

/// Throws FieldError.
struct JsonReader {
  const nlohmann::ordered_json& json;

  template <typename Value>
  void operator()(const char* key, Value& value) const
  {
    if (!json.contains(key)) throw FieldError(key, "nothing", kind_of<Value>());
    try {
      value = json.at(key).template get<Value>();
    } catch (FieldError& error) {
      error.field = std::string(key) + '.' + error.field;
      throw;
    } catch (const nlohmann::json::exception&) {
      throw FieldError(key, core::shown(json.at(key)), kind_of<Value>());
    }
  }
  template <typename Value>
  void optional(const char* key, Value& value) const
  {
    value = Value{};
    if (json.contains(key)) (*this)(key, value);
  }
};

/// The value of the file `path`. Throws InputError naming it and the field.
template <typename Value>
Value value_in(const core::JsonFile& file, const std::string& path)
{
  try {
    return file.root().get<Value>();
  } catch (const FieldError& error) {
    throw InputError({path, error.field, error.found, error.wanted});
  }
}

/// Called by the JSON library for every type with name_fields().
template <typename Value>
auto to_json(nlohmann::ordered_json& json, const Value& value)
    -> decltype(name_fields(JsonWriter{json}, const_cast<Value&>(value)))
{
  json = nlohmann::ordered_json::object();
  name_fields(JsonWriter{json}, const_cast<Value&>(value));
}

template <typename Value>
auto from_json(const nlohmann::ordered_json& json, Value& value)
    -> decltype(name_fields(JsonReader{json}, value))
{
  name_fields(JsonReader{json}, value);
}

}  // namespace vrda::run
