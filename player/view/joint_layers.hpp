/// Optional layers (contacts, forces, axes, gaps, ligaments) and colour palettes.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "store/poses.hpp"
#include "view/scene.hpp"
#include "store/motion_model.hpp"

namespace vrda::view {

/// Evenly spaced colours from the lowest to the highest value.
using Palette = std::array<VertexColour, 11>;

/// The colour scale of a layer.
struct Legend {
  std::string title;  ///< with the unit: "strain, %"
  double lowest = 0.0;
  double highest = 1.0;
  Palette palette{};
  VertexColour below{};      ///< colour of values below the lowest
  std::string below_label;   ///< empty: no such colour
  std::string beyond_label;  ///< label for values above the highest
};

/// The colour of `value`, interpolated in the palette and clamped at its ends.
VertexColour colour_of(const Legend& legend, double value);

/// Linear interpolation from a (`part` = 0) to b (`part` = 1), in sRGB.
VertexColour interpolated_colour(const VertexColour& a, const VertexColour& b, double part);

/// Conversion of linear light to sRGB and back, both on [0, 1]; of a colour to opaque sRGB and back.
double srgb_of(double linear);
double linear_of(double srgb);
VertexColour srgb_from_linear(const Eigen::Vector3f& linear);
Eigen::Vector3f linear_from_srgb(const VertexColour& colour);

/// For gaps: bright is close, with uniformly decreasing lightness, also for colour-blind viewers.
/// Source: "plasma" of matplotlib (Smith and van der Walt, CC0).
const Palette& gap_palette();

/// For strains: diverging from blue over grey to red.
/// Source: Moreland (2009), Diverging color maps for scientific visualization.
const Palette& strain_palette();

inline constexpr std::size_t n_layers = 10;

class LayerSet {
 public:
  bool has(Layer layer) const { return is_on_[static_cast<std::size_t>(layer)]; }
  void set(Layer layer, bool is_on) { is_on_[static_cast<std::size_t>(layer)] = is_on; }
  bool operator==(const LayerSet&) const = default;

 private:
  std::array<bool, n_layers> is_on_{};
};

/// "contacts", "normals", "axes", "helical-axis", "gaps", "ligaments", "contact-paths", "labels", "band": the
/// names of Layer without the bodies.
const std::vector<std::string>& layer_names();
const std::string& name_of(Layer layer);  ///< not of the bodies
std::optional<Layer> layer_named(const std::string& name);

/// An entry of a colour key.
struct Label {
  std::string name;
  VertexColour colour{};
};

/// A pose to display, its frames, and the visible layers.
struct DisplayedPose {
  store::JointPose pose;
  JointFrames frames;  ///< of `pose`
  LayerSet layers;
};

/// The layers of one motion model in one scene. Built once; updating allocates nothing.
class JointLayers {
 public:
  /// Appends the layers' drawables, hidden, to `scene`, whose order must not change afterwards. Copies the
  /// required data of the model.
  JointLayers(const store::MotionModel& model, Scene& scene);
  ~JointLayers();
  JointLayers(JointLayers&&) noexcept;
  JointLayers& operator=(JointLayers&&) noexcept;

  /// Shows `shown.layers` at a pose of `motion` and hides the others (all if the pose is not solved). Must be
  /// called after place(), since it moves only the layers. A mesh and its revision change only if necessary;
  /// mesh sizes are constant.
  void update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown);

  /// The layers for which the model has data.
  const LayerSet& available() const { return available_; }
  const Legend& gap_legend() const;     ///< mm
  const Legend& strain_legend() const;  ///< percent
  /// The colours of the axes: those of layer "axes", then of "helical-axis".
  static const std::vector<Label>& axis_labels();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  LayerSet available_;
};

}  // namespace vrda::view
