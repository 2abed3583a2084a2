/// Everything that the user of a window can set, and what each action makes of it.
#pragma once

#include <cstddef>
#include <optional>

#include "core/units.hpp"
#include "motion/poses.hpp"
#include "scene/camera.hpp"
#include "scene/joint_layers.hpp"
#include "scene/lighting.hpp"
#include "scene/scene.hpp"
#include "view/keys.hpp"

namespace vrda {

enum class LoopMode {
  once,   ///< stops at the end
  wrap,   ///< goes on from the other end
  bounce  ///< turns round
};

const char* name_of(LoopMode mode);

inline constexpr double slowest_rad_s = rad_from_deg(1.0), fastest_rad_s = rad_from_deg(360.0);

struct Timeline {
  double first_rad = 0.0, last_rad = 0.0;   ///< first <= last
  double flexion_rad = 0.0;                 ///< within them
  double speed_rad_s = rad_from_deg(30.0);  ///< within slowest and fastest
  int direction = 1;                        ///< 1 or -1; -1 only on the way back of a bounce
  bool is_playing = false;
  LoopMode loop = LoopMode::bounce;
};

/// After `elapsed_s` (not negative; a huge one is a valid one). Exact for any length: two halves of a time
/// lead where the whole of it does, to rounding.
Timeline advanced(Timeline timeline, double elapsed_s);

/// Played or paused the other way; at the end of `once` it begins again.
Timeline toggled(Timeline timeline);

/// Paused, further by `by_rad`, within the range.
Timeline stepped(Timeline timeline, double by_rad);

/// At `flexion_rad`, within the range; plays on if it plays.
Timeline moved_to(Timeline timeline, double flexion_rad);

/// With another range: flexion is kept where it can be.
Timeline with_range(Timeline timeline, double first_rad, double last_rad);

/// The next speed up or down of 1, 2, 5, 10, 20, 30, 45, 60, 90, 180, 360 degrees a second.
Timeline faster(Timeline timeline);
Timeline slower(Timeline timeline);

/// Everything that the user of a window can set, and what each action makes of it.
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
