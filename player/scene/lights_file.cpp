#include "scene/lights_file.hpp"

#include <toml++/toml.h>
#include <algorithm>
#include <fstream>
#include <initializer_list>
#include <sstream>
#include <string_view>

#include "core/error.hpp"
#include "core/nearest_word.hpp"
#include "core/number_text.hpp"

namespace vrda {
namespace {

/// Brighter is a slip; directions may be of any length up to this.
constexpr double brightest = 10.0, longest = 1e6;
/// A file of lights is a page of text.
constexpr std::size_t most_bytes = 100000;

/// A table of the file, and its place for errors.
struct Place {
  const std::string& file;
  std::string key;

  std::string at(std::string_view name) const
  {
    return key.empty() ? std::string(name) : key + "." + std::string(name);
  }
  [[noreturn]] void refuse(std::string_view name, const std::string& found, const std::string& wanted) const
  {
    throw InputError({file, at(name), found, wanted});
  }
};

void require_known(const toml::table& table, const Place& place, std::initializer_list<const char*> names)
{
  const std::vector<std::string> known(names.begin(), names.end());
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    place.refuse(name, "an unknown key", "such a key as " + nearest_word(name, known));
  }
}

const toml::table& table_at(const toml::table& table, const Place& place, const char* name)
{
  const toml::table* found = table[name].as_table();
  if (found == nullptr) place.refuse(name, table.contains(name) ? "no table" : "nothing", "a table");
  return *found;
}

std::string text_of(const toml::array& list)
{
  std::ostringstream text;
  for (const toml::node& item : list)
    text << (&item == list.get(0) ? "[" : ", ") << toml::node_view<const toml::node>(item);
  return list.empty() ? "[]" : text.str() + "]";
}

Eigen::Vector3f numbers(const toml::table& table, const Place& place, const char* name, double least,
                        double most)
{
  const std::string wanted = "three numbers from " + shortest(least) + " to " + shortest(most);
  const toml::array* list = table[name].as_array();
  if (list == nullptr) place.refuse(name, table.contains(name) ? "no list" : "nothing", wanted);
  if (list->size() != 3) place.refuse(name, text_of(*list), wanted);
  Eigen::Vector3f v;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<double> value = (*list)[k].value<double>();
    if (!value || !(*value >= least && *value <= most)) place.refuse(name, text_of(*list), wanted);
    v[static_cast<Eigen::Index>(k)] = static_cast<float>(*value);
  }
  return v;
}

Eigen::Vector3f colour(const toml::table& table, const Place& place, const char* name)
{
  return numbers(table, place, name, 0.0, brightest);
}

Light light_of(const toml::table& table, const Place& place)
{
  constexpr float shortest_direction = 1e-3F;
  require_known(table, place, {"towards", "colour"});
  Light light;
  const Eigen::Vector3f towards = numbers(table, place, "towards", -longest, longest);
  if (towards.norm() < shortest_direction) place.refuse("towards", "no direction", "a vector that is not 0");
  light.towards_camera = towards.normalized();
  light.colour = colour(table, place, "colour");
  return light;
}

std::vector<Light> lights_of(const toml::table& table, const Place& place)
{
  std::vector<Light> lights;
  if (!table.contains("light")) return lights;
  const toml::array* list = table["light"].as_array();
  if (list == nullptr) place.refuse("light", "no list", "a list of tables: [[light]]");
  if (list->size() > most_lights) {
    place.refuse("light", std::to_string(list->size()) + " lights", "at most " + std::to_string(most_lights));
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Place here{place.file, "light." + std::to_string(i)};
    const toml::table* light = (*list)[i].as_table();
    if (light == nullptr) place.refuse("light", "an item that is no table", "a list of tables: [[light]]");
    lights.push_back(light_of(*light, here));
  }
  return lights;
}

Lights lights_in(const toml::table& table, const Place& root)
{
  require_known(table, root, {"hemisphere", "light", "background"});
  Lights lights;
  const toml::table& hemisphere = table_at(table, root, "hemisphere");
  const Place of_hemisphere{root.file, "hemisphere"};
  require_known(hemisphere, of_hemisphere, {"sky", "ground"});
  lights.lighting.sky = colour(hemisphere, of_hemisphere, "sky");
  lights.lighting.ground = colour(hemisphere, of_hemisphere, "ground");
  lights.lighting.lights = lights_of(table, root);
  if (!table.contains("background")) return lights;
  const toml::table& background = table_at(table, root, "background");
  const Place of_background{root.file, "background"};
  require_known(background, of_background, {"top", "bottom"});
  lights.background = Background{numbers(background, of_background, "top", 0.0, 1.0),
                                 numbers(background, of_background, "bottom", 0.0, 1.0)};
  return lights;
}

}  // namespace

Lights parsed_lights(const std::string& text, const std::string& name)
{
  try {
    return lights_in(toml::parse(text), {name, ""});
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw InputError({name, "line " + std::to_string(at.line) + ", column " + std::to_string(at.column),
                      std::string(error.description()), "valid TOML"});
  }
}

Lights read_lights(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError({path, "", "no file that can be read", "a file of lights (schemas/lights.md)"});
  std::string text(most_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > most_bytes)
    throw InputError({path, "", "more than 100000 bytes", "a file of lights (schemas/lights.md)"});
  return parsed_lights(text, path);
}

}  // namespace vrda
