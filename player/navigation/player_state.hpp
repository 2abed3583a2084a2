/// The state of a window that the user can change (angles in rad, speeds in rad/s), and the effect of each
/// action on it. Values are clamped to the range of the motion model.
#pragma once

#include <cstddef>
#include <optional>

#include "core/units.hpp"
#include "motion/poses.hpp"
#include "navigation/keys.hpp"
#include "scene/camera.hpp"
#include "scene/joint_layers.hpp"
#include "scene/lighting.hpp"
#include "scene/scene.hpp"

namespace vrda::navigation {

enum class LoopMode {
  once,   ///< stops at the end
  wrap,   ///< continues from the first end
  bounce  ///< reverses at the ends
};

const char* name_of(LoopMode mode);

inline constexpr double slowest_rad_s = rad_from_deg(1.0), fastest_rad_s = rad_from_deg(360.0);

/// Over flexion; over a sequence of frames one frame counts as one degree, from 0.
struct Timeline {
  double first_rad = 0.0, last_rad = 0.0;   ///< first <= last
  double flexion_rad = 0.0;                 ///< within first and last
  double speed_rad_s = rad_from_deg(30.0);  ///< within slowest and fastest
  int direction = 1;                        ///< 1, or -1 on the return of a bounce
  bool is_playing = false;
  LoopMode loop = LoopMode::bounce;
};

/// Advances by `elapsed_s` (not negative, arbitrarily large) in closed form: splitting the time gives the
/// same result up to rounding.
Timeline advanced(Timeline timeline, double elapsed_s);

/// Toggles play and pause; at the end of `once`, play restarts.
Timeline toggled(Timeline timeline);

/// Pauses and moves by `by_rad`, clamped to the range.
Timeline stepped(Timeline timeline, double by_rad);

/// Moves to `flexion_rad`, clamped to the range; keeps playing.
Timeline moved_to(Timeline timeline, double flexion_rad);

/// Sets another range and clamps the flexion to it.
Timeline with_range(Timeline timeline, double first_rad, double last_rad);

/// The next higher or lower of 1, 2, 5, 10, 20, 30, 45, 60, 90, 180, 360 degrees per second.
Timeline faster(Timeline timeline);
Timeline slower(Timeline timeline);

struct PlayerState {
  Timeline timeline;
  std::optional<double> varus_rad;  ///< empty: the balanced varus
  std::size_t set = 0;              ///< index of the set
  scene::DrawMode mode = scene::DrawMode::textured;
  scene::LayerSet layers;
  scene::Backdrop backdrop = scene::Backdrop::studio;
  scene::FixedObject fixed_object = scene::FixedObject::moving;
  bool shows_numbers = true;
  bool shows_panel = true;
  bool shows_help = false;
  bool is_done = false;  ///< the window should close
};

/// Limits given by the motion model and the current set.
struct PlayerRange {
  std::size_t n_sets = 1;
  double first_varus_rad = 0.0, last_varus_rad = 0.0;  ///< of the set
  bool is_varus_free = false;                          ///< the set determines the varus
  double balanced_varus_rad = 0.0;                     ///< at the current flexion
  const char* key_name =
      nullptr;  ///< of a sequence of frames, over whose numbers the timeline runs; else null
  scene::LayerSet available;
};

/// Applies `action` to `state`. View, screenshot and full-screen actions have no effect here. Allocates
/// nothing.
PlayerState apply_action(PlayerState state, Action action, const PlayerRange& range);

/// The attitude to show, with varus clamped to the range.
Attitude wanted_attitude(const PlayerState& state, const PlayerRange& range);

/// The timeline's range for a motion.
Timeline timeline_over(const motion::Motion& motion);

/// The pose at a place of the timeline: at the flexion and varus, or at the frame.
motion::JointPose pose_at(const motion::Motion& motion, const Attitude& wanted);

/// The view selected by an action; empty for other actions.
std::optional<scene::View> view_of(Action action);

const char* name_of(scene::DrawMode mode);
const char* name_of(scene::Backdrop backdrop);

}  // namespace vrda::navigation
