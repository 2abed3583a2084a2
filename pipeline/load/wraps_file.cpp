#include "load/wraps_file.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/text.hpp"
#include "load/axis_map.hpp"
#include "load/words.hpp"

namespace vrda {
namespace {

using Json = nlohmann::json;

constexpr std::size_t most_wraps = 1000;
// Up to here the shortest way was always found (pipeline/ligament/README.md).
constexpr double largest_ratio = 5.0;

std::string shown(const Json& value)
{
  constexpr std::size_t longest = 60;
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= longest ? text : text.substr(0, longest) + "...";
}

// One entry of the file, and how messages call it.
struct Entry {
  const std::string& file;
  const Json& json;
  std::string place;

  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& wanted) const
  {
    throw InputError({file, key.empty() ? place : place + ", " + key, found, wanted});
  }

  const Json& at(const std::string& key, const std::string& wanted) const
  {
    if (!json.contains(key)) refuse(key, "nothing", wanted);
    return json.at(key);
  }

  std::string text(const std::string& key, const std::string& wanted) const
  {
    const Json& value = at(key, wanted);
    if (!value.is_string() || value.get<std::string>().empty()) refuse(key, shown(value), wanted);
    return value.get<std::string>();
  }

  // Numbers as JSON, or as the source's text: "1 2 3".
  std::vector<double> numbers(const std::string& key, std::size_t n, const std::string& wanted) const
  {
    const Json& value = at(key, wanted);
    std::vector<double> out;
    if (value.is_string()) {
      const std::string text = value.get<std::string>();
      for (const std::string_view word : words_in(text)) out.push_back(real_in(word).value_or(std::nan("")));
    } else {
      const Json list = value.is_array() ? value : Json::array({value});
      for (const Json& item : list) out.push_back(item.is_number() ? item.get<double>() : std::nan(""));
    }
    constexpr double largest = 1e6;  // a kilometre in mm; false for NaN
    const bool are_numbers =
        std::all_of(out.begin(), out.end(), [](double x) { return std::abs(x) <= largest; });
    if (out.size() != n || !are_numbers) refuse(key, shown(value), wanted);
    return out;
  }

  Eigen::Vector3d vector(const std::string& key, const std::string& wanted) const
  {
    const std::vector<double> n = numbers(key, 3, wanted);
    return {n[0], n[1], n[2]};
  }

  double length(const std::string& key) const
  {
    const std::string wanted = "a length above 0";
    const double value = numbers(key, 1, wanted).front();
    if (!(value > 0.0)) refuse(key, shown(json.at(key)), wanted);
    return value;
  }
};

void check_keys(const Entry& entry, const std::string& type)
{
  std::vector<std::string> known{"name",        "type",     "body", "xyz_body_rotation",
                                 "translation", "quadrant", "unit"};
  if (type == "WrapCylinder") known.insert(known.end(), {"radius", "length"});
  if (type == "WrapEllipsoid") known.emplace_back("dimensions");
  for (const auto& [key, value] : entry.json.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    entry.refuse(key, "an unknown key",
                 "a key of a " + type + "; the nearest is \"" + nearest_word(key, known) + "\"");
  }
}

WrapShape shape_of(const Entry& entry)
{
  const std::string wanted = "\"WrapCylinder\" or \"WrapEllipsoid\"";
  const std::string type = entry.text("type", wanted);
  if (type != "WrapCylinder" && type != "WrapEllipsoid") entry.refuse("type", shown(type), wanted);
  check_keys(entry, type);
  return type == "WrapCylinder" ? WrapShape::cylinder : WrapShape::ellipsoid;
}

WrapBody body_of(const Entry& entry, const BodyNames& bodies)
{
  const std::string wanted = "\"reference\", \"moving\", \"" + bodies.reference + "\", \"" + bodies.moving +
                             "\", or a name that begins with femur or tibia";
  const std::string name = entry.text("body", wanted);
  if (name == bodies.reference || name == "reference") return WrapBody::reference;
  if (name == bodies.moving || name == "moving") return WrapBody::moving;
  if (name.starts_with("femur")) return WrapBody::reference;
  if (name.starts_with("tibia")) return WrapBody::moving;
  entry.refuse("body", shown(name), wanted);
}

double unit_of(const Entry& entry)
{
  if (!entry.json.contains("unit")) return mm_in("m");
  const std::string wanted = R"("mm", "cm" or "m")";
  const std::string unit = entry.text("unit", wanted);
  if (unit != "mm" && unit != "cm" && unit != "m") entry.refuse("unit", shown(unit), wanted);
  return mm_in(unit);
}

Eigen::Vector3d radii_of(const Entry& entry, WrapShape shape)
{
  if (shape == WrapShape::cylinder) {
    const double radius = entry.length("radius");
    return {radius, radius, 0.5 * entry.length("length")};
  }
  const std::string wanted = "three half-axes above 0, the largest at most five times the smallest";
  const Eigen::Vector3d radii = entry.vector("dimensions", wanted);
  if (!(radii.minCoeff() > 0.0) || radii.maxCoeff() > largest_ratio * radii.minCoeff())
    entry.refuse("dimensions", shown(entry.json.at("dimensions")), wanted);
  return radii;
}

Wrap wrap_of(const Entry& entry, const BodyNames& bodies)
{
  Wrap wrap;
  wrap.name = entry.text("name", "a name");
  wrap.shape = shape_of(entry);
  wrap.body = body_of(entry, bodies);
  const double unit_mm = unit_of(entry);
  wrap.radii_mm = unit_mm * radii_of(entry, wrap.shape);
  const Eigen::Vector3d angles_rad =
      entry.vector("xyz_body_rotation", "three angles in rad about the body-fixed X, Y and Z, in that order");
  wrap.X_body_wrap.linear() =
      rotation_x(angles_rad.x()) * rotation_y(angles_rad.y()) * rotation_z(angles_rad.z());
  wrap.X_body_wrap.translation() = unit_mm * entry.vector("translation", "three lengths");
  if (entry.json.contains("quadrant") && entry.json.at("quadrant") != "all") {
    entry.refuse("quadrant", shown(entry.json.at("quadrant")), "\"all\": fibres choose the shorter side");
  }
  return wrap;
}

Json parsed(const std::string& file, const std::string& text)
{
  const std::string wanted = "a list of wraps in JSON";
  // A wrap needs three levels; many more would overflow the stack where values are copied and shown.
  const auto is_shallow = [&](int depth, Json::parse_event_t, Json&) {
    constexpr int deepest = 8;
    if (depth > deepest) throw InputError({file, "", "lists within lists within lists", wanted});
    return true;
  };
  try {
    return Json::parse(text, is_shallow);
  } catch (const Json::parse_error& error) {
    throw InputError({file, "byte " + std::to_string(error.byte), "no JSON", wanted});
  } catch (const Json::out_of_range&) {
    throw InputError({file, "", "a number beyond the range of doubles", wanted});
  }
}

}  // namespace

std::vector<Wrap> read_wraps(const std::string& file, const std::string& text, const BodyNames& bodies)
{
  const Json json = parsed(file, text);
  if (!json.is_array() || json.empty() || json.size() > most_wraps) {
    throw InputError({file, "", json.is_array() ? std::to_string(json.size()) + " wraps" : shown(json),
                      "a list of 1 to " + std::to_string(most_wraps) + " wraps"});
  }
  std::vector<Wrap> wraps;
  for (const Json& item : json) {
    const std::string place = "wrap " + std::to_string(wraps.size() + 1);
    const Entry entry{file, item, place};
    if (!item.is_object()) entry.refuse("", shown(item), "a wrap: { \"name\": ... }");
    Wrap wrap = wrap_of(entry, bodies);
    for (const Wrap& other : wraps) {
      if (other.name == wrap.name)
        entry.refuse("name", shown(wrap.name) + " a second time", "a name of its own");
    }
    wraps.push_back(std::move(wrap));
  }
  return wraps;
}

}  // namespace vrda
