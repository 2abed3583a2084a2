/// Key bindings: one table (keys.json) for the window, the page, their help and that of the command line. In:
/// key presses by their unshifted character. Out: an action, or nothing for an unused key.
#pragma once

#include <span>
#include <string>

#include "view/input.hpp"

namespace vrda::view {

using view::Key;
using view::key_of;

struct KeyPress {
  Key key = Key::none;
  bool has_shift = false;
  bool has_control = false;
};

enum class Action {
  none,
  play_pause,
  step_forward,
  step_back,
  leap_forward,
  leap_back,
  go_to_first,
  go_to_last,
  varus_up,
  varus_down,
  varus_balanced,
  faster,
  slower,
  next_loop,
  next_set,
  previous_set,
  next_mode,
  next_backdrop,
  next_fixed_object,
  show_contacts,
  show_normals,
  show_axes,
  show_helical_axis,
  show_gap_map,
  show_ligaments,
  show_contact_paths,
  show_labels,
  show_band,
  view_front,
  view_back,
  view_medial,
  view_lateral,
  view_top,
  view_oblique,
  reset_view,
  show_panel,
  show_numbers,
  screenshot,
  full_screen,
  show_help,
  leave,  ///< closes the help page, else the window
  quit
};

/// The action of a key press; Action::none if it has none.
Action action_of(const KeyPress& press);

/// True for steps, which repeat while their key is held; false for toggles.
bool repeats_while_held(Action action);

struct HelpLine {
  const char* keys;
  const char* description;
};

/// All keys in display order, and the mouse actions.
std::span<const HelpLine> key_help();
std::span<const HelpLine> mouse_help();

/// Both as two columns of text for a terminal.
std::string help_text();

}  // namespace vrda::view
