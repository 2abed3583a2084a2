/// The appearance of a scene: options shared by the modes that draw.
#pragma once

#include <string>
#include <vector>

#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"

namespace vrda {

/// The options of the command line.
struct LookOptions {
  std::string layers;  ///< names separated by commas; empty for none
  DrawMode mode = DrawMode::textured;
  std::string texture;             ///< PNG file for bone; empty: mottled
  double texture_scale_mm = 40.0;  ///< width of one tile
  std::string lights;              ///< TOML file (schemas/lights.md); empty: studio_lighting()
  std::string see_through;         ///< "reference", "moving" or "both"; empty for none
  std::string hidden;              ///< "reference" or "moving"; empty for none
};

/// What the cameras are fitted to.
enum class Framed {
  joint,  ///< the region of contact; long shafts are cropped
  all     ///< both objects completely
};
/// The points to be framed at the present placement, world.
std::vector<Eigen::Vector3d> framed_points(const Scene& scene, Framed framed);

/// Parses layer names separated by commas. Throws InputError for an unknown or repeated one.
LayerSet parsed_layers(const std::string& text);

/// Applies draw mode, texture, lights, transparency and visibility to `scene`; must precede Renderer::load.
/// Throws InputError for an invalid option or file.
void dress(Scene& scene, const LookOptions& look);

}  // namespace vrda
