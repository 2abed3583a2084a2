/// What the keys do. One table for the window, its help page and the command line's help.
#pragma once

#include <span>
#include <string>

namespace vrda {

/// Printable keys are their character, letters in upper case.
enum class Key : int {
  none = 0,
  backspace = 8,
  enter = 13,
  escape = 27,
  space = ' ',
  up = 256,
  down,
  left,
  right,
  page_up,
  page_down,
  home,
  end,
  f1,
  f2,
  f3,
  f4,
  f5,
  f6,
  f11
};

constexpr Key key_of(char character)
{
  return static_cast<Key>(character);
}

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
  next_held,
  show_contacts,
  show_normals,
  show_axes,
  show_helical_axis,
  show_gap_map,
  show_ligaments,
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

/// Action::none for a press that means nothing.
Action action_of(const KeyPress& press);

/// Steps go on while their key is held; switches turn once.
bool goes_on_while_held(Action action);

struct HelpLine {
  const char* keys;
  const char* does;
};

/// Every key, in reading order; then what the mouse does.
std::span<const HelpLine> key_help();
std::span<const HelpLine> mouse_help();

/// Both as the text of a terminal, two columns.
std::string help_text();

}  // namespace vrda
