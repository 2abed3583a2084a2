/// How a scene looks: what the modes that draw have in common.
#pragma once

#include <string>
#include <vector>

#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"

namespace vrda {

/// As on the command line.
struct LookOptions {
  std::string layers;  ///< names separated by commas; empty for none
  DrawMode mode = DrawMode::textured;
  std::string texture;             ///< PNG file for bone; empty: mottled
  double texture_scale_mm = 40.0;  ///< width of one repeat
  std::string lights;              ///< TOML file (schemas/lights.md); empty: studio_lighting()
  std::string see_through;         ///< "reference", "moving" or "both"; empty for none
  std::string hidden;              ///< "reference" or "moving"; empty for none
};

/// What every picture has room for.
enum class Framed {
  joint,  ///< where the objects meet: long shafts run out of the picture
  all     ///< both objects, whole
};
/// The points that a picture must have room for, as placed.
std::vector<Eigen::Vector3d> framed_points(const Scene& scene, Framed framed);

/// Throws InputError on an unknown or repeated name.
LayerSet parsed_layers(const std::string& text);

/// Gives `scene` the mode, texture, lights, transparent and hidden objects asked for. Throws InputError for
/// what is wrong with an option or its file. Before the scene is loaded.
void dress(Scene& scene, const LookOptions& look);

}  // namespace vrda
