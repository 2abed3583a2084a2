#include "geometry/shapes.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "core/error.hpp"
#include "core/text.hpp"
#include "geometry/catalogue.hpp"

namespace vrda::geometry {
namespace {

using Entry = CatalogueEntry;
using Values = ShapeValues;

// "one of a, b, c; the nearest is b"
std::string one_of(const std::string& word, const std::vector<std::string>& known)
{
  if (known.empty()) return "no parameter";
  std::string list;
  for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
  return "one of " + list + "; the nearest is " + nearest_word(word, known);
}

std::string text(double number)
{
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", number);
  return buffer;
}

const Entry& entry(const std::string& shape)
{
  for (const Entry& candidate : shape_catalogue()) {
    if (candidate.name == shape) return candidate;
  }
  throw InputError({"shape", "name", "\"" + shape + "\"", one_of(shape, shape_names())});
}

const ShapeParameter& parameter(const Entry& chosen, const std::string& name)
{
  std::vector<std::string> known;
  for (const ShapeParameter& candidate : chosen.parameters) {
    if (candidate.name == name) return candidate;
    known.push_back(candidate.name);
  }
  throw InputError({"shape " + chosen.name, "parameters", "\"" + name + "\"", one_of(name, known)});
}

void set_number(Values& values, const Entry& chosen, const std::string& name, double value)
{
  const ShapeParameter& wanted = parameter(chosen, name);
  if (!wanted.choices.empty()) {
    throw InputError({"shape " + chosen.name, name, text(value), one_of("", wanted.choices)});
  }
  const bool is_in_range = value >= wanted.lowest && value <= wanted.highest;  // false for NaN
  const bool is_allowed = is_in_range && (!wanted.is_integer || value == std::floor(value));
  if (!is_allowed) {
    throw InputError({"shape " + chosen.name, name, text(value),
                      std::string(wanted.is_integer ? "a whole number" : "a number") + " from " +
                          text(wanted.lowest) + " to " + text(wanted.highest) +
                          (wanted.unit.empty() ? "" : " " + wanted.unit)});
  }
  values.set(name, value);
}

void set_word(Values& values, const Entry& chosen, const std::string& name, const std::string& value)
{
  const ShapeParameter& wanted = parameter(chosen, name);
  if (wanted.choices.empty()) {
    throw InputError({"shape " + chosen.name, name, "\"" + value + "\"", "a number"});
  }
  if (std::find(wanted.choices.begin(), wanted.choices.end(), value) == wanted.choices.end()) {
    throw InputError({"shape " + chosen.name, name, "\"" + value + "\"", one_of(value, wanted.choices)});
  }
  values.set(name, value);
}

// In the fewest digits that read back as the same double.
std::string exact_text(double number)
{
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, number);
  check(error == std::errc(), "a number longer than any double");
  return {buffer, end};
}

const Entry& entry_with_fibres(const std::string& shape)
{
  const Entry& chosen = entry(shape);
  if (chosen.fibres != nullptr) return chosen;
  std::vector<std::string> able;
  for (const Entry& each : shape_catalogue()) {
    if (each.fibres != nullptr) able.push_back(each.name);
  }
  throw InputError({"shape", "name", "\"" + shape + "\", which has no ligaments", one_of(shape, able)});
}

Values values_of(const ShapeRequest& request, const Entry& chosen)
{
  Values values;
  for (const ShapeParameter& each : chosen.parameters) {
    if (each.choices.empty()) values.set(each.name, each.default_number);
    if (!each.choices.empty()) values.set(each.name, each.choices.front());
  }
  for (const auto& [name, value] : request.numbers) set_number(values, chosen, name, value);
  for (const auto& [name, value] : request.words) set_word(values, chosen, name, value);
  return values;
}

}  // namespace

std::vector<std::string> shape_names()
{
  std::vector<std::string> names;
  for (const Entry& each : shape_catalogue()) names.push_back(each.name);
  return names;
}

std::string shape_summary(const std::string& shape)
{
  return entry(shape).summary;
}

std::vector<ShapeParameter> shape_parameters(const std::string& shape)
{
  return entry(shape).parameters;
}

Shape generate_shape(const ShapeRequest& request)
{
  const Entry& chosen = entry(request.shape);
  return chosen.build(values_of(request, chosen));
}

std::vector<ShapeFibre> generate_fibres(const ShapeRequest& request)
{
  const Entry& chosen = entry_with_fibres(request.shape);
  return chosen.fibres(values_of(request, chosen));
}

std::string fibre_table(const ShapeRequest& request)
{
  std::string table = entry_with_fibres(request.shape).fibre_sources;
  table +=
      "name,bundle,reference_x_mm,reference_y_mm,reference_z_mm,moving_x_mm,moving_y_mm,moving_z_mm,"
      "stiffness_n_per_strain,slack_length_mm\n";
  for (const ShapeFibre& fibre : generate_fibres(request)) {
    table += fibre.name + "," + fibre.bundle;
    for (const Eigen::Vector3d& p_mm : {fibre.reference_mm, fibre.moving_mm}) {
      for (const double x_mm : p_mm) table += "," + exact_text(x_mm);
    }
    table += "," + exact_text(fibre.stiffness_n) + "," + exact_text(fibre.slack_length_mm) + "\n";
  }
  return table;
}

}  // namespace vrda::geometry
