#include "view/player_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"

namespace vrda::view {
namespace {

constexpr std::array speeds_steps_s{slowest_steps_s, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 180.0,
                                    fastest_steps_s};

/// The timeline after `travel` along a path that bounces between its ends.
Timeline bounced(Timeline timeline, double travel)
{
  const double length = timeline.last - timeline.first;
  const double done = timeline.position - timeline.first;
  // Unfolded: the return path follows beyond the far end.
  const double unfolded = timeline.direction > 0 ? done : 2.0 * length - done;
  const double at = std::fmod(unfolded + travel, 2.0 * length);
  timeline.direction = at < length ? 1 : -1;
  timeline.position = timeline.first + (at < length ? at : 2.0 * length - at);
  return timeline;
}

}  // namespace

const char* name_of(LoopMode mode)
{
  return std::array{"once", "loop", "to and fro"}.at(static_cast<std::size_t>(mode));
}

Timeline advanced(Timeline timeline, double elapsed_s)
{
  check(elapsed_s >= 0.0, "the elapsed time is not negative");
  const double length = timeline.last - timeline.first;
  if (!timeline.is_playing || length <= 0.0) return timeline;
  const double travel = position_of_steps(timeline.axis, timeline.speed_steps_s) * elapsed_s;
  switch (timeline.loop) {
    case LoopMode::once:
      timeline.position += travel;
      timeline.is_playing = timeline.position < timeline.last;
      break;
    case LoopMode::wrap:
      timeline.position = timeline.first + std::fmod(timeline.position - timeline.first + travel, length);
      break;
    case LoopMode::bounce:
      timeline = bounced(timeline, travel);
      break;
  }
  timeline.position = std::clamp(timeline.position, timeline.first, timeline.last);
  return timeline;
}

Timeline toggled(Timeline timeline)
{
  timeline.is_playing = !timeline.is_playing;
  if (timeline.loop != LoopMode::bounce) timeline.direction = 1;
  const bool is_over = timeline.loop == LoopMode::once && timeline.position >= timeline.last;
  if (timeline.is_playing && is_over) timeline.position = timeline.first;
  return timeline;
}

Timeline stepped(Timeline timeline, double n_steps)
{
  timeline.is_playing = false;
  return moved_to(timeline, timeline.position + position_of_steps(timeline.axis, n_steps));
}

Timeline moved_to(Timeline timeline, double position)
{
  timeline.position = std::clamp(position, timeline.first, timeline.last);
  return timeline;
}

Timeline with_range(Timeline timeline, double first, double last)
{
  check(first <= last, "the range of a timeline ascends");
  timeline.first = first;
  timeline.last = last;
  return moved_to(timeline, timeline.position);
}

Timeline faster(Timeline timeline)
{
  const auto next = std::ranges::upper_bound(speeds_steps_s, timeline.speed_steps_s);
  if (next != speeds_steps_s.end()) timeline.speed_steps_s = *next;
  return timeline;
}

Timeline slower(Timeline timeline)
{
  const auto same = std::ranges::lower_bound(speeds_steps_s, timeline.speed_steps_s);
  if (same != speeds_steps_s.begin()) timeline.speed_steps_s = *(same - 1);
  return timeline;
}

namespace {

constexpr double leap_steps = 10.0;
constexpr double varus_step_rad = rad_from_deg(1.0);

/// The next of the enum values 0 ... last, cyclically.
template <typename Enum>
Enum next_of(Enum value, Enum last)
{
  return value == last ? Enum{} : static_cast<Enum>(static_cast<int>(value) + 1);
}

PlayerState with_varus_by(PlayerState state, double by_rad, const PlayerRange& range)
{
  if (range.is_varus_free) return state;
  const double varus_rad = state.varus_rad.value_or(range.balanced_varus_rad) + by_rad;
  state.varus_rad = std::clamp(varus_rad, range.first_varus_rad, range.last_varus_rad);
  return state;
}

/// The actions of the layers have their order.
PlayerState with_layer_toggled(PlayerState state, Action action, const PlayerRange& range)
{
  const auto layer =
      static_cast<view::Layer>(1 + static_cast<int>(action) - static_cast<int>(Action::show_contacts));
  state.layers.set(layer, range.available.has(layer) && !state.layers.has(layer));
  return state;
}

PlayerState left(PlayerState state)
{
  state.is_done = !state.shows_help;
  state.shows_help = false;
  return state;
}

}  // namespace

// A flat switch over the actions. NOLINTNEXTLINE(readability-function-size)
PlayerState apply_action(PlayerState state, Action action, const PlayerRange& range)
{
  Timeline& timeline = state.timeline;
  switch (action) {
    case Action::play_pause:
      timeline = toggled(timeline);
      break;
    case Action::step_forward:
      timeline = stepped(timeline, 1.0);
      break;
    case Action::step_back:
      timeline = stepped(timeline, -1.0);
      break;
    case Action::leap_forward:
      timeline = stepped(timeline, leap_steps);
      break;
    case Action::leap_back:
      timeline = stepped(timeline, -leap_steps);
      break;
    case Action::go_to_first:
      timeline = moved_to(timeline, timeline.first);
      break;
    case Action::go_to_last:
      timeline = moved_to(timeline, timeline.last);
      break;
    case Action::varus_up:
      return with_varus_by(state, varus_step_rad, range);
    case Action::varus_down:
      return with_varus_by(state, -varus_step_rad, range);
    case Action::varus_balanced:
      state.varus_rad.reset();
      break;
    case Action::faster:
      timeline = faster(timeline);
      break;
    case Action::slower:
      timeline = slower(timeline);
      break;
    case Action::next_loop:
      timeline.loop = next_of(timeline.loop, LoopMode::bounce);
      if (timeline.loop != LoopMode::bounce) timeline.direction = 1;
      break;
    case Action::next_set:
      state.set = (state.set + 1) % range.n_sets;
      break;
    case Action::previous_set:
      state.set = (state.set + range.n_sets - 1) % range.n_sets;
      break;
    case Action::next_mode:
      state.mode = next_of(state.mode, view::DrawMode::textured);
      break;
    case Action::next_backdrop:
      state.backdrop = next_of(state.backdrop, view::Backdrop::black);
      break;
    case Action::next_fixed_object:
      state.fixed_object = next_of(state.fixed_object, view::FixedObject::push);
      break;
    case Action::show_contacts:
    case Action::show_normals:
    case Action::show_axes:
    case Action::show_helical_axis:
    case Action::show_gap_map:
    case Action::show_ligaments:
    case Action::show_contact_paths:
    case Action::show_labels:
    case Action::show_band:
      return with_layer_toggled(state, action, range);
    case Action::show_panel:
      state.shows_panel = !state.shows_panel;
      break;
    case Action::show_numbers:
      state.shows_numbers = !state.shows_numbers;
      break;
    case Action::show_help:
      state.shows_help = !state.shows_help;
      break;
    case Action::leave:
      return left(state);
    case Action::quit:
      state.is_done = true;
      break;
    default:
      break;
  }
  return state;
}

double wanted_varus_rad(const PlayerState& state, const PlayerRange& range)
{
  const double varus_rad =
      range.is_varus_free ? range.balanced_varus_rad : state.varus_rad.value_or(range.balanced_varus_rad);
  return std::clamp(varus_rad, range.first_varus_rad, range.last_varus_rad);
}

Timeline timeline_over(const store::Motion& motion)
{
  Timeline timeline;
  if (!motion.is_sequence())
    return with_range(timeline, motion.first_flexion_rad(), motion.last_flexion_rad());
  timeline.axis = TimelineAxis::frames;
  return with_range(timeline, 0.0, static_cast<double>(motion.keys().size() - 1));
}

store::JointPose pose_at(const store::Motion& motion, double position, double varus_rad)
{
  return motion.is_sequence() ? motion.at_frame(motion.key_at(position)) : motion.at({position, varus_rad});
}

std::optional<view::View> view_of(Action action)
{
  constexpr std::array views{view::View::front,   view::View::back, view::View::medial,
                             view::View::lateral, view::View::top,  view::View::oblique};
  if (action < Action::view_front || action > Action::view_oblique) return std::nullopt;
  return views.at(static_cast<std::size_t>(action) - static_cast<std::size_t>(Action::view_front));
}

const char* name_of(view::DrawMode mode)
{
  return std::array{"wire", "hidden lines", "flat", "smooth", "textured"}.at(static_cast<std::size_t>(mode));
}

const char* name_of(view::Backdrop backdrop)
{
  return std::array{"studio", "night", "black"}.at(static_cast<std::size_t>(backdrop));
}

}  // namespace vrda::view
