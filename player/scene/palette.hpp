/// Numbers as colours, and what a legend says of them.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "scene/scene.hpp"

namespace vrda {

/// Evenly spaced colours from the lowest to the highest value.
using Palette = std::array<VertexColour, 11>;

/// A layer's colours in words and numbers.
struct Legend {
  std::string title;  ///< with the unit: "strain, %"
  double lowest = 0.0;
  double highest = 1.0;
  Palette palette{};
  VertexColour below{};      ///< of values under the lowest
  std::string below_label;   ///< empty: none are
  std::string beyond_label;  ///< of values above the highest
};

/// The colour of `value`: between the two nearest of the palette, held at its ends.
VertexColour colour_of(const Legend& legend, double value);

/// `part` of the way from a to b, in sRGB.
VertexColour mixed(const VertexColour& a, const VertexColour& b, double part);

/// The sRGB colour nearest to a material's, opaque.
VertexColour encoded(const Eigen::Vector3f& linear);
Eigen::Vector3f decoded(const VertexColour& colour);

/// Bright where things are close, dark far away: lightness falls evenly, to colour-blind eyes too.
/// Source: "plasma" of matplotlib (Smith and van der Walt, CC0).
const Palette& closeness_palette();

/// Blue by way of grey to red, of even lightness on either side.
/// Source: Moreland (2009), Diverging color maps for scientific visualization.
const Palette& tension_palette();

}  // namespace vrda
