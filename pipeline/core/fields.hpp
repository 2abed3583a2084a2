/// The fields of a struct, listed once: the name in files, the unit, the meaning and the member. Files,
/// journals, tables and the Python module follow from the list.
///
/// A struct is described by one function next to it, found by its argument; an enum by a table of its values:
///
///   constexpr auto fields_of(const Contact*)
///   {
///     return std::tuple{Field{"distance_mm", &Contact::distance_mm, unit::mm, "from surface to surface"},
///                       Field{"triangle", &Contact::triangle, unit::one, "row of the triangles"}};
///   }
///   inline constexpr Named<Kind> kind_names[] = {{Kind::row, "row", "solved outward"}, {Kind::spine,
///   "spine"}}; constexpr const auto& names_of(Kind) { return kind_names; }  // then name_of(Kind::row) is
///   "row"
///
/// Users: fields_json.hpp (JSON), append_fields() and take_fields() in framed_file.hpp (journals), csv_text()
/// below. A field whose name is empty stands for all fields of the struct that it holds.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::inline core {

struct Unit {
  const char* name;         ///< as in files
  int length_power = 0;     ///< power of a uniform length scale, at equal forces: 1, 0 or -1
  bool is_radians = false;  ///< in the program; degrees in files
};
namespace unit {
inline constexpr Unit none{""}, one{"1"}, mm{"mm", 1}, degree{"degree"}, radian{"degree", 0, true}, n{"N"},
    nmm{"N mm", 1}, nmm_per_radian{"N mm rad-1", 1}, n_per_mm{"N mm-1", -1};
/// Distances between landmarks: input to the scaling, not its result.
inline constexpr Unit landmark_mm{"mm"};
}  // namespace unit

/// One value of an enum: its name in files and on screen, and what it means.
template <typename Enum>
struct Named {
  Enum value;
  const char* name;
  const char* meaning = "";
};

/// An enum with a table of names.
template <typename Type>
concept Listed = std::is_enum_v<Type> && requires(Type value)
{
  names_of(value);
};

/// The entry of `value`. Throws InternalError if the table has none.
template <Listed Enum>
constexpr const Named<Enum>& named(Enum value)
{
  for (const Named<Enum>& one : names_of(value))
    if (one.value == value) return one;
  throw InternalError("a value without a name");
}
template <Listed Enum>
constexpr const char* name_of(Enum value)
{
  return named(value).name;
}
/// One-line description.
template <Listed Enum>
constexpr const char* meaning_of(Enum value)
{
  return named(value).meaning;
}

/// The value that has this name; empty if none has.
template <Listed Enum>
constexpr std::optional<Enum> value_named(std::string_view name)
{
  for (const Named<Enum>& one : names_of(Enum{}))
    if (one.name == name) return one.value;
  return std::nullopt;
}

/// Whether `value`, read from bytes, is one of its enum.
template <Listed Enum>
bool is_listed(Enum value)
{
  for (const Named<Enum>& one : names_of(value))
    if (one.value == value) return true;
  return false;
}

/// The values of a table, in its order.
template <typename Enum, std::size_t n>
constexpr std::array<Enum, n> values_in(const Named<Enum> (&names)[n])
{
  std::array<Enum, n> values{};
  for (std::size_t k = 0; k < n; ++k) values[k] = names[k].value;
  return values;
}

/// Whether a field may be absent from a JSON object: where it has the value of a new object.
enum class Presence { required, unless_new };

/// One field of `Struct`. `name`, `meaning`: literals.
template <typename Struct, typename Member>
struct Field {
  constexpr Field(const char* of_name, Member Struct::*of_member, const Unit& of_units = unit::none,
                  const char* of_meaning = "", Presence of_presence = Presence::required)
      : name(of_name), member(of_member), units(of_units), meaning(of_meaning), presence(of_presence)
  {
  }

  const char* name;
  Member Struct::*member;
  Unit units;
  const char* meaning;
  Presence presence;

  constexpr bool is_flattened() const { return name[0] == '\0'; }
};

/// A struct with a list of fields.
template <typename Type>
concept Described = requires(const std::remove_const_t<Type>* type)
{
  fields_of(type);
};

/// Calls `visit(field)` for each field of `Struct`, in the order of the list.
template <Described Struct, typename Visit>
constexpr void for_each_field(Visit&& visit)
{
  std::apply([&](const auto&... field) { (visit(field), ...); },
             fields_of(static_cast<const Struct*>(nullptr)));
}

/// Calls `visit(field, member)` for each field of `value`, whose members may be changed unless it is const.
template <Described Struct, typename Visit>
constexpr void for_each_field(Struct& value, Visit&& visit)
{
  for_each_field<std::remove_const_t<Struct>>([&](const auto& field) { visit(field, value.*field.member); });
}

/// The number in files: an angle in radians as degrees.
inline double value_in_file(double value, const Unit& units)
{
  return units.is_radians ? deg_from_rad(value) : value;
}

/// Multiplies the lengths, energies and moments of `value` by `factor`: a scaled joint at equal forces.
template <typename Value>
void scale_lengths(Value& value, double factor, const Unit& units = unit::none)
{
  if constexpr (Described<Value>) {
    for_each_field(value,
                   [&](const auto& field, auto& member) { scale_lengths(member, factor, field.units); });
  } else if constexpr (requires { value.has_value(); }) {
    if (value) scale_lengths(*value, factor, units);
  } else if constexpr (requires { value.begin(); } && !std::is_same_v<Value, std::string>) {
    for (auto& element : value) scale_lengths(element, factor, units);
  } else if constexpr (std::is_floating_point_v<Value>) {
    if (units.length_power == 1) value *= factor;
  }
}

// CSV: one column a field, numbers in the fewest digits that read back as the same double.

/// The text of one cell; a number that is not finite is empty.
template <typename Value>
std::string csv_cell(const Value& value, const Unit& units)
{
  if constexpr (std::is_same_v<Value, std::string>) {
    return value;
  } else if constexpr (Listed<Value>) {
    return name_of(value);
  } else if constexpr (std::is_same_v<Value, bool>) {
    return value ? "1" : "0";
  } else if constexpr (std::is_integral_v<Value>) {
    return std::to_string(value);
  } else {
    static_assert(std::is_same_v<Value, double>);
    return std::isfinite(value) ? shortest_decimal(value_in_file(value, units)) : "";
  }
}

/// The names of the columns, or with `row` the cells of one, with commas between them.
template <Described Row>
std::string csv_heading()
{
  std::string line;
  for_each_field<Row>([&]<typename Member>(const Field<Row, Member>& field) {
    if (!line.empty()) line += ',';
    if constexpr (Described<Member>) {
      line += csv_heading<Member>();
    } else {
      line += field.name;
    }
  });
  return line;
}
template <Described Row>
std::string csv_line(const Row& row)
{
  std::string line;
  bool is_first = true;
  for_each_field(row, [&]<typename Member>(const auto& field, const Member& member) {
    if (!std::exchange(is_first, false)) line += ',';
    if constexpr (Described<Member>) {
      line += csv_line(member);
    } else {
      line += csv_cell(member, field.units);
    }
  });
  return line;
}

/// Heading and rows. Cells must not contain commas, quotes or line ends.
template <Described Row>
std::string csv_text(const std::vector<Row>& rows)
{
  std::string text = csv_heading<Row>() + '\n';
  for (const Row& row : rows) text += csv_line(row) + '\n';
  return text;
}

}  // namespace vrda::inline core
