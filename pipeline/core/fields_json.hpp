/// Structs with a list of fields (fields.hpp) as JSON objects, in both directions: `Json json = value;` and
/// `value_in<Value>(file)`. Numbers that are not finite are null; enums are written by name, angles in
/// degrees; an absent optional value is an absent key.
#pragma once

#include <nlohmann/json.hpp>

#include <cmath>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/document.hpp"
#include "core/fields.hpp"

namespace vrda::inline core {

/// A key that is missing or has a value of another kind.
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

/// What a JSON value of the member's type is called in messages.
template <typename Value>
std::string kind_of()
{
  if constexpr (std::is_same_v<Value, std::string> || Listed<Value>) return "text";
  if constexpr (std::is_arithmetic_v<Value>) return "a number";
  return "a list or table";
}

template <typename Value>
nlohmann::ordered_json json_value(const Value& value, const Unit& units = unit::none)
{
  using Json = nlohmann::ordered_json;
  if constexpr (std::is_floating_point_v<Value>) {
    return std::isfinite(value) ? Json(value_in_file(value, units)) : Json();
  } else if constexpr (Listed<Value>) {
    return name_of(value);
  } else if constexpr (std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string> ||
                       Described<Value>) {
    return value;
  } else if constexpr (requires { value.has_value(); }) {
    return value ? json_value(*value, units) : Json();
  } else {
    Json list = Json::array();
    for (const auto& element : value) list.push_back(json_value(element, units));
    return list;
  }
}

/// Throws nlohmann::json::exception if `json` has another type.
template <typename Value>
void read_json_value(const nlohmann::ordered_json& json, Value& value, const Unit& units = unit::none)
{
  if constexpr (std::is_floating_point_v<Value>) {
    value = json.is_null() ? nan : json.get<Value>();
    if (units.is_radians) value = rad_from_deg(value);
  } else if constexpr (Listed<Value>) {
    const std::optional<Value> found = value_named<Value>(json.get<std::string>());
    if (!found) throw nlohmann::json::other_error::create(501, "an unknown name", nullptr);
    value = *found;
  } else {
    json.get_to(value);
  }
}

template <Described Value>
void write_fields(nlohmann::ordered_json& json, const Value& value)
{
  for_each_field(value, [&]<typename Member>(const auto& field, const Member& member) {
    if constexpr (Described<Member>)
      if (field.is_flattened()) return write_fields(json, member);
    if constexpr (requires { member.has_value(); }) {
      if (member) json[field.name] = json_value(*member, field.units);
    } else if (field.presence == Presence::required || !(member == Value{}.*field.member)) {
      json[field.name] = json_value(member, field.units);
    }
  });
}

/// Throws FieldError.
template <Described Value>
void read_fields(const nlohmann::ordered_json& json, Value& value)
{
  for_each_field(value, [&]<typename Member>(const auto& field, Member& member) {
    if constexpr (Described<Member>)
      if (field.is_flattened()) return read_fields(json, member);
    const bool is_there = json.contains(field.name);
    try {
      if constexpr (requires { member.emplace(); }) {
        member.reset();
        if (is_there) read_json_value(json.at(field.name), member.emplace(), field.units);
      } else if (is_there) {
        read_json_value(json.at(field.name), member, field.units);
      } else if (field.presence == Presence::required) {
        throw FieldError(field.name, "nothing", kind_of<Member>());
      }
    } catch (FieldError& error) {
      if (is_there) error.field = std::string(field.name) + '.' + error.field;
      throw;
    } catch (const nlohmann::json::exception&) {
      throw FieldError(field.name, shown(json.at(field.name)), kind_of<Member>());
    }
  });
}

/// The value of a JSON file. Throws InputError naming `path` and the field.
template <Described Value>
Value value_in(const JsonFile& file, const std::string& path)
{
  try {
    return file.root().get<Value>();
  } catch (const FieldError& error) {
    throw InputError({path, error.field, error.found, error.wanted});
  }
}

}  // namespace vrda::inline core

/// Tells the JSON library about every struct with a list of fields.
template <vrda::Described Value>
struct nlohmann::adl_serializer<Value, void> {
  static void to_json(nlohmann::ordered_json& json, const Value& value)
  {
    json = nlohmann::ordered_json::object();
    vrda::write_fields(json, value);
  }
  static void from_json(const nlohmann::ordered_json& json, Value& value) { vrda::read_fields(json, value); }
};
