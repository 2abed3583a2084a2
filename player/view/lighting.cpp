#include "view/lighting.hpp"

#include "core/error.hpp"
#include "core/schema.hpp"

namespace vrda::view {

Lighting studio_lighting()
{
  Lighting lighting;
  lighting.sky = {0.19F, 0.21F, 0.25F};
  lighting.ground = {0.075F, 0.065F, 0.060F};
  lighting.lights.push_back({Eigen::Vector3f(-0.50F, 0.70F, 0.70F).normalized(), {0.80F, 0.775F, 0.72F}});
  lighting.lights.push_back({Eigen::Vector3f(0.85F, 0.05F, 0.50F).normalized(), {0.19F, 0.22F, 0.27F}});
  lighting.lights.push_back({Eigen::Vector3f(0.25F, 0.55F, -0.80F).normalized(), {0.40F, 0.42F, 0.46F}});
  return lighting;
}

Background background_of(Backdrop backdrop)
{
  switch (backdrop) {
    case Backdrop::studio:
      return {Eigen::Vector3f(0.745F, 0.791F, 0.839F), Eigen::Vector3f(0.371F, 0.434F, 0.503F)};
    case Backdrop::night:
      return {Eigen::Vector3f(0.034F, 0.045F, 0.061F), Eigen::Vector3f(0.007F, 0.009F, 0.013F)};
    case Backdrop::black:
      return {};
  }
  throw InternalError("unknown backdrop");
}

const core::DocumentSchema& lights_schema();  // schemas/lights.schema.json

namespace {

Eigen::Vector3f three(const core::DocumentValue& root, const char* key)
{
  return core::vector3_at(root, key).cast<float>();
}

Light light_of(const core::Document& document, const core::DocumentValue& value,
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
  const core::Document document = lights_schema().read(text, name);
  const core::DocumentValue& root = document.root;
  Lights lights;
  lights.lighting.sky = three(root, "hemisphere.sky");
  lights.lighting.ground = three(root, "hemisphere.ground");
  for (const core::DocumentValue& light : core::list_or_empty(root, "light")) {
    const std::string key = "light." + std::to_string(lights.lighting.lights.size());
    lights.lighting.lights.push_back(light_of(document, light, key));
  }
  if (root.find("background") != nullptr)
    lights.background = Background{three(root, "background.top"), three(root, "background.bottom")};
  return lights;
}

Lights read_lights(const std::string& path)
{
  return parsed_lights(core::read_document_text(path, "a lights file (schemas/lights.md)"), path);
}

}  // namespace vrda::view
