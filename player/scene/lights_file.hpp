/// Reads lights and background from a file.
#pragma once

#include <optional>
#include <string>

#include "scene/lighting.hpp"

namespace vrda::scene {

struct Lights {
  Lighting lighting;
  std::optional<Background> background;  ///< if the file has one
};

/// Reads a TOML file (schemas/lights.md). Throws InputError naming the file and the key.
Lights read_lights(const std::string& path);

/// Parses the text of a lights file; `name` is used in errors.
Lights parsed_lights(const std::string& text, const std::string& name);

}  // namespace vrda::scene
