/// Which layers are wanted.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace vrda {

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

}  // namespace vrda
