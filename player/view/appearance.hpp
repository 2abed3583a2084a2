/// The appearance of a scene: options shared by the modes that draw.
#pragma once

#include <string>
#include <vector>

#include "view/joint_layers.hpp"
#include "view/scene.hpp"

namespace vrda::view {

/// The options of the command line.
struct AppearanceOptions {
  /// Names separated by commas; "none" or empty for none; "default": ligaments, if the model has them.
  std::string layers = "default";
  view::DrawMode mode = view::DrawMode::textured;
  std::string texture;             ///< PNG file for bone; empty: mottled
  double texture_scale_mm = 40.0;  ///< width of one tile
  std::string lights;              ///< TOML file (schemas/lights.md); empty: studio_lighting()
  std::string see_through;         ///< "reference", "moving", one's name, or "both"; empty for none
  std::string hidden;              ///< "reference", "moving" or one's name; empty for none
};

/// What the cameras are fitted to.
enum class Framing {
  joint,  ///< the region of contact; long shafts are cropped
  all     ///< both objects completely
};
/// The points to be framed at the present placement, world.
std::vector<Eigen::Vector3d> framed_points(const view::Scene& scene, Framing framed);

/// Parses AppearanceOptions::layers. Throws InputError for an unknown or repeated one.
view::LayerSet parsed_layers(const std::string& text);

/// Applies draw mode, texture, lights, transparency and visibility to `scene`; must precede Renderer::load.
/// Throws InputError for an invalid option or file.
void apply_appearance(view::Scene& scene, const AppearanceOptions& look);

}  // namespace vrda::view
