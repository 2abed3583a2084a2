/// Lights and background from a file.
#pragma once

#include <optional>
#include <string>

#include "scene/lighting.hpp"

namespace vrda {

struct Lights {
  Lighting lighting;
  std::optional<Background> background;  ///< where the file has one
};

/// Reads a TOML file as schemas/lights.md describes it. Throws InputError naming the file and the key.
Lights read_lights(const std::string& path);

/// The same from the text of a file; `name` is for errors.
Lights parsed_lights(const std::string& text, const std::string& name);

}  // namespace vrda
