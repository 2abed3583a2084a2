/// What can be shown beside the bodies: contacts, forces, axes, gaps, ligaments; numbers as colours.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "motion/poses.hpp"
#include "scene/scene.hpp"
#include "store/motion_model.hpp"

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

inline constexpr std::size_t n_layers = 7;

class LayerSet {
 public:
  bool has(Layer layer) const { return is_on_[static_cast<std::size_t>(layer)]; }
  void set(Layer layer, bool is_on) { is_on_[static_cast<std::size_t>(layer)] = is_on; }
  bool operator==(const LayerSet&) const = default;

 private:
  std::array<bool, n_layers> is_on_{};
};

/// "contacts", "normals", "axes", "helical-axis", "gaps", "ligaments": Layer's, without the bodies.
const std::vector<std::string>& layer_names();
const std::string& name_of(Layer layer);  ///< not of the bodies
std::optional<Layer> layer_named(const std::string& name);

/// A word and the colour that stands for it.
struct Label {
  std::string name;
  VertexColour colour{};
};

/// Where a joint is, and how the screen shows it.
struct Shown {
  JointPose pose;
  JointFrames frames;  ///< of `pose`
  LayerSet layers;
};

/// The layers of one motion model in one scene. Made once; a frame updates them without allocating.
class JointLayers {
 public:
  /// Appends the layers' drawables, hidden, to `scene`, which keeps its order from then on. Copies what it
  /// needs of the model.
  JointLayers(const MotionModel& model, Scene& scene);
  ~JointLayers();
  JointLayers(JointLayers&&) noexcept;
  JointLayers& operator=(JointLayers&&) noexcept;

  /// Shows the wanted layers at a pose of `motion`, hides the others; all of them where the pose is not
  /// solved. After place(): it moves only the layers'. A mesh changes, and its revision rises, only when it
  /// must: with the pose, the cell, or not at all. Sizes stay those made.
  void update(Scene& scene, const Motion& motion, const Shown& shown);

  /// Those that the model has something for.
  const LayerSet& available() const { return available_; }
  const Legend& gap_legend() const;     ///< mm
  const Legend& strain_legend() const;  ///< percent
  /// The axes' colours: of "axes", then of "helical-axis".
  static const std::vector<Label>& axis_labels();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  LayerSet available_;
};

/// Opacity of one object's bodies: `part` of their materials' own. To look through to what lies behind.
void see_through(Scene& scene, Owner owner, float part);
/// One object's bodies out of sight; its layers stay.
void hide(Scene& scene, Owner owner);

}  // namespace vrda
