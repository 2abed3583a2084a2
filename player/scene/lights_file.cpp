#include "scene/lights_file.hpp"

#include <string>

#include "documents/schema.hpp"

namespace vrda::scene {

const documents::DocumentSchema& lights_schema();  // schemas/lights.schema.json

namespace {

Eigen::Vector3f three(const documents::DocumentValue& root, const char* key)
{
  return documents::vector3_at(root, key).cast<float>();
}

Light light_of(const documents::Document& document, const documents::DocumentValue& value,
               const std::string& key)
{
  constexpr float shortest_direction = 1e-3F;
  const Eigen::Vector3f towards = three(value, "towards");
  if (towards.norm() < shortest_direction)
    document.refuse(key + ".towards", "no direction", "a non-zero vector");
  Light light;
  light.towards_camera = towards.normalized();
  light.colour = three(value, "colour");
  return light;
}

}  // namespace

Lights parsed_lights(const std::string& text, const std::string& name)
{
  const documents::Document document = lights_schema().read(text, name);
  const documents::DocumentValue& root = document.root;
  Lights lights;
  lights.lighting.sky = three(root, "hemisphere.sky");
  lights.lighting.ground = three(root, "hemisphere.ground");
  for (const documents::DocumentValue& light : documents::list_or_empty(root, "light")) {
    const std::string key = "light." + std::to_string(lights.lighting.lights.size());
    lights.lighting.lights.push_back(light_of(document, light, key));
  }
  if (root.find("background") != nullptr)
    lights.background = Background{three(root, "background.top"), three(root, "background.bottom")};
  return lights;
}

Lights read_lights(const std::string& path)
{
  return parsed_lights(documents::read_document_text(path, "a lights file (schemas/lights.md)"), path);
}

}  // namespace vrda::scene
