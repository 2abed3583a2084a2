/// Everything that the user of a window can set, and what each action makes of it.
#pragma once

#include <cstddef>
#include <optional>

#include "motion/poses.hpp"
#include "scene/camera.hpp"
#include "scene/layer_set.hpp"
#include "scene/lighting.hpp"
#include "scene/scene.hpp"
#include "view/keys.hpp"
#include "view/timeline.hpp"

namespace vrda {

struct PlayerState {
  Timeline timeline;
  std::optional<double> varus_rad;  ///< none: where the compartments balance
  std::size_t set = 0;              ///< row of the sets
  DrawMode mode = DrawMode::textured;
  LayerSet layers;
  Backdrop backdrop = Backdrop::studio;
  Held held = Held::moving;
  bool shows_numbers = true;
  bool shows_panel = true;
  bool shows_help = false;
  bool is_done = false;  ///< the window is to close
};

/// What the joint at hand allows.
struct PlayerRange {
  std::size_t n_sets = 1;
  double first_varus_rad = 0.0, last_varus_rad = 0.0;  ///< of the set
  bool is_varus_free = false;                          ///< the set has a varus of its own
  double balanced_varus_rad = 0.0;                     ///< at the flexion
  LayerSet available;
};

/// `state` once `action` happened. Views, screenshots and the full screen are no part of it and change
/// nothing here. Allocates nothing.
PlayerState after(PlayerState state, Action action, const PlayerRange& range);

/// The attitude to show: varus within the range.
Attitude wanted_attitude(const PlayerState& state, const PlayerRange& range);

/// What a key or button says of the view, if it says anything of it.
std::optional<View> view_of(Action action);

const char* name_of(DrawMode mode);
const char* name_of(Backdrop backdrop);

}  // namespace vrda
