#include "scene/layer_set.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace vrda {

const std::vector<std::string>& layer_names()
{
  static const std::vector<std::string> names{"contacts",     "normals", "axes",
                                              "helical-axis", "gaps",    "ligaments"};
  return names;
}

const std::string& name_of(Layer layer)
{
  check(layer != Layer::bodies, "the bodies are no layer that comes and goes");
  return layer_names()[static_cast<std::size_t>(layer) - 1];
}

std::optional<Layer> layer_named(const std::string& name)
{
  const auto found = std::find(layer_names().begin(), layer_names().end(), name);
  if (found == layer_names().end()) return std::nullopt;
  return static_cast<Layer>(found - layer_names().begin() + 1);
}

}  // namespace vrda
