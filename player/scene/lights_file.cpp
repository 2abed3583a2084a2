#include "scene/lights_file.hpp"

#include <string>
#include <vector>

#include "core/error.hpp"
#include "settings/settings_table.hpp"

namespace vrda {
namespace {

/// Brighter is a slip; directions may be of any length up to this.
constexpr double brightest = 10.0, longest = 1e6;

Eigen::Vector3f three(const SettingsTable& table, const char* name, const NumberRange& range)
{
  const std::vector<double> v = table.numbers(name, 3, range);
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

Eigen::Vector3f colour(const SettingsTable& table, const char* name)
{
  return three(table, name, {0.0, brightest});
}

Light light_of(const SettingsTable& table)
{
  constexpr float shortest_direction = 1e-3F;
  table.require_known({"towards", "colour"});
  Light light;
  const Eigen::Vector3f towards = three(table, "towards", {-longest, longest});
  if (towards.norm() < shortest_direction) table.refuse("towards", "no direction", "a vector that is not 0");
  light.towards_camera = towards.normalized();
  light.colour = colour(table, "colour");
  return light;
}

Lights lights_in(const SettingsTable& root)
{
  root.require_known({"hemisphere", "light", "background"});
  Lights lights;
  const SettingsTable hemisphere = root.table("hemisphere");
  hemisphere.require_known({"sky", "ground"});
  lights.lighting.sky = colour(hemisphere, "sky");
  lights.lighting.ground = colour(hemisphere, "ground");
  for (const SettingsTable& light : root.tables("light", most_lights))
    lights.lighting.lights.push_back(light_of(light));
  if (!root.has("background")) return lights;
  const SettingsTable background = root.table("background");
  background.require_known({"top", "bottom"});
  lights.background =
      Background{three(background, "top", {0.0, 1.0}), three(background, "bottom", {0.0, 1.0})};
  return lights;
}

}  // namespace

Lights parsed_lights(const std::string& text, const std::string& name)
{
  return lights_in(SettingsTable::parsed(text, name));
}

Lights read_lights(const std::string& path)
{
  return lights_in(SettingsTable::read(path, "a file of lights (schemas/lights.md)"));
}

}  // namespace vrda
