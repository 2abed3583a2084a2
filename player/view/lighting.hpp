/// Lights and backgrounds. Colours are linear RGB on [0, 1].
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace vrda::view {

struct Light {
  Eigen::Vector3f towards_camera{0.0F, 0.0F, 1.0F};  ///< unit direction to the light in camera axes
  Eigen::Vector3f colour{1.0F, 1.0F, 1.0F};
};

/// Hemisphere light along world Y, plus directional lights attached to the camera.
struct Lighting {
  Eigen::Vector3f sky{0.2F, 0.2F, 0.2F};
  Eigen::Vector3f ground{0.1F, 0.1F, 0.1F};
  std::vector<Light> lights;  ///< at most 4
};
inline constexpr std::size_t most_lights = 4;

/// Vertical gradient.
struct Background {
  Eigen::Vector3f top{0.0F, 0.0F, 0.0F};
  Eigen::Vector3f bottom{0.0F, 0.0F, 0.0F};
};

/// Key light from the upper left, a cooler fill light, a rim light from behind.
Lighting studio_lighting();

enum class Backdrop {
  studio,  ///< light grey
  night,   ///< dark blue grey
  black,   ///< transparent on the bench's display
};
Background background_of(Backdrop backdrop);

struct Lights {
  Lighting lighting;
  std::optional<Background> background;  ///< if the file has one
};

/// Reads a TOML file (schemas/lights.md). Throws InputError naming the file and the key.
Lights read_lights(const std::string& path);

/// Parses the text of a lights file; `name` is used in errors.
Lights parsed_lights(const std::string& text, const std::string& name);

}  // namespace vrda::view
