/// Input events of a window as plain values.
#pragma once

#include <array>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "store/motion.hpp"

namespace vrda::view {

/// Printable keys have the code of their character in the US layout, letters in upper case.
enum class Key : int {
  none = 0,  ///< every key not listed
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
  f11,
  f7,  // after f11: recordings contain the numbers
  f8
};

constexpr Key key_of(char character)
{
  return static_cast<Key>(character);
}

enum class MouseButton { left, right, middle };

enum class InputKind {
  motion,     ///< x_px, y_px
  press,      ///< button, n_clicks
  release,    ///< button
  wheel,      ///< wheel: notches, positive away from the user
  key_press,  ///< key; repeated while it is held
  key_release,
  focus_lost,
  drop,   ///< of files: see Window::dropped_files
  redraw  ///< a new size (which the renderer already has), the focus or the pointer has changed
};

/// Positions are in pixels from the top left corner of the window, for all kinds.
struct InputEvent {
  InputKind kind = InputKind::motion;
  double x_px = 0.0, y_px = 0.0;
  double wheel = 0.0;
  MouseButton button = MouseButton::left;
  int n_clicks = 1;     ///< 2 for the second of a double click
  Key key = Key::none;  ///< without shift: '/', not '?'
  bool has_shift = false, has_control = false;
};

/// State of a gamepad in the layout of an Xbox controller. Axes from -1 to 1: right and down are positive.
struct Gamepad {
  bool has_a = false, has_b = false, has_y = false;  ///< pressed buttons
  bool has_left_shoulder = false, has_right_shoulder = false;
  bool has_up = false, has_down = false, has_left = false, has_right = false;  ///< of the directional pad
  double stick_x = 0.0, stick_y = 0.0;                                         ///< left stick
};

// Key bindings: one table (keys.json) for the window, the page, their help and that of the command line. In:
// key presses by their unshifted character. Out: an action, or nothing for an unused key.

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
  next_structure,
  previous_structure,
  switch_structure,  ///< the highlighted one: shows or hides it
  show_all_structures,
  isolate_structure,
  fade_other_structures,
  less_opaque,
  more_opaque,
  next_section,
  section_forward,
  section_back,
  section_leap_forward,
  section_leap_back,
  show_structures,
  save_view,
  show_panel,
  show_numbers,
  screenshot,
  full_screen,
  show_help,
  leave,  ///< closes an open menu, else the help page, else leaves full screen
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

// Key presses from the state of a gamepad, so that it turns the same numbers as keys and wheel.

class GamepadKeys {
 public:
  /// Key presses since the previous call, `elapsed_s` ago; valid until the next. The directional pad presses
  /// arrow keys, repeated while it is held, with the left shoulder as Shift and the right one as Control. The
  /// stick presses Left and Right up to 60 times a second, and, if it is `is_plane`, Up and Down. A is Enter,
  /// B Backspace, Y H.
  const std::vector<KeyPress>& keys(const Gamepad& pad, double elapsed_s, bool is_plane);

 private:
  static constexpr std::size_t n_buttons = 7;
  std::vector<KeyPress> keys_;
  std::array<double, n_buttons> held_s_{};  ///< since the press; negative: not pressed
  std::array<double, 2> due_{};             ///< parts of a press by the stick: x, y
  bool was_used_ = false;
};

// Parsers of option values.

struct AngleRange {
  double first_deg = 0.0;
  double last_deg = 0.0;
  double step_deg = 1.0;
};

/// The parts between separators, including empty ones; at least one.
std::vector<std::string> split(const std::string& text, char separator);

/// The number, if the whole text is one.
std::optional<double> parsed_number(const std::string& text);

/// Throws InputError for an option.
[[noreturn]] void refuse_option(const char* option, const std::string& found, const std::string& wanted);

/// Parses "A:B:STEP" or one angle "A", in degrees. Throws InputError for another form, a reversed range, a
/// step below 0.001, or more than 10,000 angles.
AngleRange parsed_angles(const std::string& option, const std::string& text);

/// Throws InputError unless it is a number from -360 to 360.
void require_angle(const std::string& option, double angle_deg);

/// first, first + step, ... up to last (with a tolerance of a millionth of a step).
std::vector<double> angles_deg(const AngleRange& range);

struct PictureSize {
  int width = 1280;
  int height = 960;
};

/// Parses "WxH" in pixels. Throws InputError unless both are from 16 to 4096.
PictureSize parsed_size(const std::string& text);

/// Parses view names separated by commas. Throws InputError for an unknown, repeated or missing one.
std::vector<std::string> parsed_views(const std::string& text);

/// The label of one angle without zero padding: "-5".
std::string plain_label(double angle_rad);

/// Reports, as options, the angles of `wanted` that the motion does not have at `pose`, the nearest one.
/// `used`: "drawn", "sent".
void report_clamped(const store::Motion& motion, const store::JointPose& pose, const Attitude& wanted,
                    const char* used, std::ostream& messages);

/// Formats the angle with the decimals (at most three) that it and `others_deg` need, zero-padded: "005",
/// "-05", "007.5".
std::string angle_label(double angle_deg, const std::vector<double>& others_deg);

}  // namespace vrda::view
