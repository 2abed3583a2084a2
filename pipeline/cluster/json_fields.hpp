/// Structs as JSON objects: `name_fields(fields, value)` lists members and keys, for both directions.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace vrda::cluster {

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

/// Throws nlohmann::json::exception for a missing key or a value of another type.
struct JsonReader {
  const nlohmann::ordered_json& json;

  template <typename Value>
  void operator()(const char* key, Value& value) const
  {
    value = json.at(key).template get<Value>();
  }
  template <typename Value>
  void optional(const char* key, Value& value) const
  {
    value = json.value(key, Value{});
  }
};

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

}  // namespace vrda::cluster
