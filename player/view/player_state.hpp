/// The state of a window that the user can change (angles in rad), and the effect of each action on it.
/// Values are clamped to the range of the motion model.
#pragma once

#include <cstddef>
#include <optional>

#include "core/units.hpp"
#include "store/poses.hpp"
#include "view/keys.hpp"
#include "view/camera.hpp"
#include "view/joint_layers.hpp"
#include "view/lighting.hpp"
#include "view/scene.hpp"

namespace vrda::view {

enum class LoopMode {
  once,   ///< stops at the end
  wrap,   ///< continues from the first end
  bounce  ///< reverses at the ends
};

const char* name_of(LoopMode mode);

/// What the positions of a timeline are.
enum class TimelineAxis {
  flexion,  ///< rad
  frames    ///< of a sequence, counted from 0
};

/// The user's steps are degrees, or frames; speeds are shown in them.
constexpr double position_of_steps(TimelineAxis axis, double n_steps)
{
  return axis == TimelineAxis::flexion ? rad_from_deg(n_steps) : n_steps;
}
constexpr double steps_of_position(TimelineAxis axis, double position)
{
  return axis == TimelineAxis::flexion ? deg_from_rad(position) : position;
}

inline constexpr double slowest_steps_s = 1.0, fastest_steps_s = 360.0;

struct Timeline {
  TimelineAxis axis = TimelineAxis::flexion;
  double first = 0.0, last = 0.0;  ///< first <= last
  double position = 0.0;           ///< within first and last
  double speed_steps_s = 30.0;     ///< within slowest and fastest
  int direction = 1;               ///< 1, or -1 on the return of a bounce
  bool is_playing = false;
  LoopMode loop = LoopMode::bounce;
};

/// Advances by `elapsed_s` (not negative, arbitrarily large) in closed form: splitting the time gives the
/// same result up to rounding.
Timeline advanced(Timeline timeline, double elapsed_s);

/// Toggles play and pause; at the end of `once`, play restarts.
Timeline toggled(Timeline timeline);

/// Pauses and moves by degrees or frames, clamped to the range.
Timeline stepped(Timeline timeline, double n_steps);

/// Moves to `position`, clamped to the range; keeps playing.
Timeline moved_to(Timeline timeline, double position);

/// Sets another range and clamps the position to it.
Timeline with_range(Timeline timeline, double first, double last);

/// The next higher or lower of 1, 2, 5, 10, 20, 30, 45, 60, 90, 180, 360 steps per second.
Timeline faster(Timeline timeline);
Timeline slower(Timeline timeline);

struct PlayerState {
  Timeline timeline;
  std::optional<double> varus_rad;  ///< empty: the balanced varus
  std::size_t set = 0;              ///< index of the set
  view::DrawMode mode = view::DrawMode::textured;
  view::LayerSet layers;
  view::Backdrop backdrop = view::Backdrop::studio;
  view::FixedObject fixed_object = view::FixedObject::moving;
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
  const char* key_name = nullptr;                      ///< of a sequence of frames; else null
  view::LayerSet available;
};

/// Applies `action` to `state`. View, screenshot and full-screen actions have no effect here. Allocates
/// nothing.
PlayerState apply_action(PlayerState state, Action action, const PlayerRange& range);

/// The varus to show, clamped to the range.
double wanted_varus_rad(const PlayerState& state, const PlayerRange& range);

/// The timeline's range for a motion.
Timeline timeline_over(const store::Motion& motion);

/// The pose at a position of the motion's timeline: at this flexion and the varus, or at this frame.
store::JointPose pose_at(const store::Motion& motion, double position, double varus_rad);

/// The view selected by an action; empty for other actions.
std::optional<view::View> view_of(Action action);

const char* name_of(view::DrawMode mode);
const char* name_of(view::Backdrop backdrop);

}  // namespace vrda::view
