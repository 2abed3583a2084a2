/// How surfaces look, by the material that a motion model names. Colours are linear RGB on [0, 1].
#pragma once

#include <Eigen/Core>
#include <string>

namespace vrda {

struct Material {
  Eigen::Vector3f colour{0.5F, 0.5F, 0.5F};
  float opacity = 1.0F;     ///< below 1 drawn after everything opaque
  float specular = 0.1F;    ///< strength of the highlight
  float shininess = 30.0F;  ///< Blinn-Phong exponent
  float mottling = 0.0F;    ///< amplitude of the colour's variation over the surface, as a part of it
};

/// "bone", "cartilage", "meniscus"; neutral otherwise.
Material material_of(const std::string& name);

}  // namespace vrda
