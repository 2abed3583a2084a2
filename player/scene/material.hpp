/// How surfaces, lights and the backdrop look. Colours are linear RGB on [0, 1].
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace vrda {

struct Material {
  Eigen::Vector3f colour{0.5F, 0.5F, 0.5F};
  float opacity = 1.0F;     ///< below 1 drawn after everything opaque
  float specular = 0.1F;    ///< strength of the highlight
  float shininess = 30.0F;  ///< Blinn-Phong exponent
  float mottling = 0.0F;    ///< amplitude of the colour's variation over the surface, as a part of it
};

struct Light {
  Eigen::Vector3f towards_camera{0.0F, 0.0F, 1.0F};  ///< unit direction to the light in camera axes
  Eigen::Vector3f colour{1.0F, 1.0F, 1.0F};
};

/// Hemisphere light along world Y, plus lights that hang on the camera.
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

/// By the name a motion model gives: "bone", "cartilage", "meniscus"; neutral otherwise.
Material material_of(const std::string& name);

/// Key light from the upper left of the viewer, a cooler fill, a rim from behind.
Lighting studio_lighting();

enum class Backdrop {
  studio,  ///< calm light grey
  night,   ///< dark blue grey
  black,   ///< transparent on the bench's display
};
Background background_of(Backdrop backdrop);

}  // namespace vrda
