#include "job/wraps_file.hpp"

#include <optional>
#include <set>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/schema.hpp"
#include "job/axis_map.hpp"
#include "job/words.hpp"

namespace vrda::job {

const core::DocumentSchema& wraps_schema();  // schemas/wraps.schema.json

namespace {

// Largest ratio of half-axes for which the shortest path was always found (pipeline/ligament/README.md).
constexpr double largest_ratio = 5.0;

// Converts a text such as "1 2 3" to a list of numbers; any other text stays unchanged.
void read_numbers(core::DocumentValue& value)
{
  if (value.text() == nullptr) return;
  core::DocumentValue::List numbers;
  for (const std::string_view word : split_words(*value.text())) {
    const std::optional<double> number = parse_real(word);
    if (!number) return;
    numbers.push_back({*number});
  }
  value.data = numbers;
}

// Converts the numeric keys; a list of one number becomes that number for radius and length.
void read_all_numbers(core::DocumentValue& wrap)
{
  for (const char* key : {"xyz_body_rotation", "translation", "dimensions", "radius", "length"}) {
    if (core::DocumentValue* value = wrap.find(key)) read_numbers(*value);
  }
  for (const char* key : {"radius", "length"}) {
    const core::DocumentValue* value = wrap.find(key);
    if (value == nullptr || value->list() == nullptr || value->list()->size() != 1) continue;
    *wrap.find(key) = core::DocumentValue(value->list()->front());
  }
}

// A wrap of the validated document and its index, for messages.
struct Entry {
  const core::Document& document;
  const core::DocumentValue& value;
  std::string index;

  std::string key(const std::string& name) const { return index + "." + name; }

  Eigen::Vector3d vector(const std::string& name) const
  {
    return Eigen::Vector3d::Map(core::numbers_at(value, name).data());
  }
};

model::WrapShape shape_of(const Entry& entry)
{
  const std::string& type = core::text_at(entry.value, "type");
  const bool is_cylinder = type == "WrapCylinder";
  for (const char* name : {"radius", "length", "dimensions"}) {
    const bool is_wanted = is_cylinder == (name != std::string("dimensions"));
    const bool is_given = entry.value.find(name) != nullptr;
    if (is_wanted == is_given) continue;
    entry.document.refuse(
        entry.key(name), is_given ? "a key of the other type" : "nothing",
        "for a " + type + (is_cylinder ? " radius and length" : " three dimensions") + ", lengths above 0");
  }
  return is_cylinder ? model::WrapShape::cylinder : model::WrapShape::ellipsoid;
}

model::WrapBody body_of(const Entry& entry, const BodyNames& bodies)
{
  const std::string& name = core::text_at(entry.value, "body");
  if (name == bodies.reference || name == "reference") return model::WrapBody::reference;
  if (name == bodies.moving || name == "moving") return model::WrapBody::moving;
  if (name.starts_with("femur")) return model::WrapBody::reference;
  if (name.starts_with("tibia")) return model::WrapBody::moving;
  entry.document.refuse_value(entry.key("body"), "\"reference\", \"moving\", \"" + bodies.reference +
                                                     "\", \"" + bodies.moving +
                                                     "\", or a name that begins with femur or tibia");
}

Eigen::Vector3d radii_of(const Entry& entry, model::WrapShape shape)
{
  if (shape == model::WrapShape::cylinder) {
    const double radius = core::number_at(entry.value, "radius");
    return {radius, radius, 0.5 * core::number_at(entry.value, "length")};
  }
  const Eigen::Vector3d radii = entry.vector("dimensions");
  if (radii.maxCoeff() > largest_ratio * radii.minCoeff()) {
    entry.document.refuse_value(entry.key("dimensions"),
                                "three half-axes above 0, the largest at most five times the smallest");
  }
  return radii;
}

model::Wrap wrap_of(const Entry& entry, const BodyNames& bodies)
{
  model::Wrap wrap;
  wrap.name = core::text_at(entry.value, "name");
  wrap.shape = shape_of(entry);
  wrap.body = body_of(entry, bodies);
  const double unit_mm = mm_per_unit(core::text_at(entry.value, "unit"));
  wrap.radii_mm = unit_mm * radii_of(entry, wrap.shape);
  const Eigen::Vector3d angles_rad = entry.vector("xyz_body_rotation");
  wrap.X_body_wrap.linear() =
      rotation_x(angles_rad.x()) * rotation_y(angles_rad.y()) * rotation_z(angles_rad.z());
  wrap.X_body_wrap.translation() = unit_mm * entry.vector("translation");
  return wrap;
}

}  // namespace

std::vector<model::Wrap> read_wraps(const std::string& file, const std::string& text,
                                       const BodyNames& bodies)
{
  core::Document document{
      file, core::parse_json(text, file, "a list of wraps in JSON"), {}, "wrap."};
  if (auto* list = std::get_if<core::DocumentValue::List>(&document.root.data)) {
    for (core::DocumentValue& wrap : *list) read_all_numbers(wrap);
  }
  document.root = wraps_schema().checked(document);
  std::vector<model::Wrap> wraps;
  std::set<std::string> names;
  for (const core::DocumentValue& value : *document.root.list()) {
    const Entry entry{document, value, std::to_string(wraps.size())};
    wraps.push_back(wrap_of(entry, bodies));
    if (!names.insert(wraps.back().name).second)
      document.refuse(entry.key("name"),
                      core::shown(core::value_at(value, "name")) + " a second time",
                      "a unique name");
  }
  return wraps;
}

}  // namespace vrda::job
