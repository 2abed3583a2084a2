#include "navigation/keys.hpp"

#include <algorithm>
#include <array>

namespace vrda::navigation {
namespace {

struct Binding {
  Key key = Key::none;
  Action action = Action::none;
  Action with_shift = Action::none;  ///< none: shift makes no difference
};

// Characters that some layouts need shift for (+) are listed without it.
constexpr std::array bindings{
    Binding{Key::space, Action::play_pause},
    Binding{Key::right, Action::step_forward, Action::leap_forward},
    Binding{Key::left, Action::step_back, Action::leap_back},
    Binding{Key::page_up, Action::leap_forward},
    Binding{Key::page_down, Action::leap_back},
    Binding{Key::home, Action::go_to_first},
    Binding{Key::end, Action::go_to_last},
    Binding{Key::up, Action::varus_up},
    Binding{Key::down, Action::varus_down},
    Binding{key_of('B'), Action::varus_balanced},
    Binding{key_of('+'), Action::faster},
    Binding{key_of('='), Action::faster},
    Binding{key_of('-'), Action::slower},
    Binding{key_of('L'), Action::next_loop},
    Binding{key_of('S'), Action::next_set, Action::previous_set},
    Binding{key_of('M'), Action::next_mode},
    Binding{key_of('K'), Action::next_backdrop},
    Binding{key_of('O'), Action::next_fixed_object},
    Binding{Key::f1, Action::show_contacts},
    Binding{Key::f2, Action::show_normals},
    Binding{Key::f3, Action::show_axes},
    Binding{Key::f4, Action::show_helical_axis},
    Binding{Key::f5, Action::show_gap_map},
    Binding{Key::f6, Action::show_ligaments},
    Binding{key_of('1'), Action::view_front},
    Binding{key_of('2'), Action::view_back},
    Binding{key_of('3'), Action::view_medial},
    Binding{key_of('4'), Action::view_lateral},
    Binding{key_of('5'), Action::view_top},
    Binding{key_of('6'), Action::view_oblique},
    Binding{key_of('R'), Action::reset_view},
    Binding{key_of('N'), Action::show_numbers},
    Binding{key_of('T'), Action::show_panel},
    Binding{key_of('P'), Action::screenshot},
    Binding{key_of('F'), Action::full_screen},
    Binding{Key::f11, Action::full_screen},
    Binding{key_of('H'), Action::show_help},
    Binding{key_of('?'), Action::show_help},
    Binding{Key::escape, Action::leave},
    Binding{key_of('Q'), Action::quit},
};

constexpr std::array key_lines{
    HelpLine{"Space", "play or pause"},
    HelpLine{"Left, Right", "flexion by 1 degree; with Shift, or Page keys, by 10"},
    HelpLine{"Home, End", "to the first or last flexion"},
    HelpLine{"Up, Down", "varus by 1 degree"},
    HelpLine{"B", "varus where both compartments balance"},
    HelpLine{"+, -", "faster, slower"},
    HelpLine{"L", "play once, in a loop, to and fro"},
    HelpLine{"S, Shift S", "next, previous set: raw, smoothed, recontacted ..."},
    HelpLine{"M", "textured, wire, hidden lines, flat, smooth"},
    HelpLine{"F1 ... F6", "contacts, normals, axes, helical axis, gap map, ligaments"},
    HelpLine{"1 ... 6", "from the front, back, medial, lateral, top, oblique"},
    HelpLine{"R", "reset the view"},
    HelpLine{"O", "fix the other object on screen"},
    HelpLine{"K", "background: studio, night, black"},
    HelpLine{"N, T", "numbers, controls on and off"},
    HelpLine{"P", "screenshot (PNG, in the current folder)"},
    HelpLine{"F or F11", "full screen"},
    HelpLine{"H or ?", "this page"},
    HelpLine{"Q or Esc", "quit"},
};

constexpr std::array mouse_lines{
    HelpLine{"Left drag", "move in the image plane"},
    HelpLine{"Middle drag", "turn; also Ctrl and left drag"},
    HelpLine{"Right drag", "move in depth; also Shift and left drag"},
    HelpLine{"Wheel", "move in depth"},
    HelpLine{"Double click", "centre on the point and turn about it"},
};

void append(std::string& text, std::span<const HelpLine> lines)
{
  constexpr std::size_t column = 14;
  for (const HelpLine& line : lines) {
    const std::string keys = line.keys;
    text += "  " + keys + std::string(column - keys.size(), ' ') + line.description + "\n";
  }
}

}  // namespace

Action action_of(const KeyPress& press)
{
  if (press.has_control) return Action::none;
  const auto found = std::ranges::find(bindings, press.key, &Binding::key);
  if (found == bindings.end()) return Action::none;
  return press.has_shift && found->with_shift != Action::none ? found->with_shift : found->action;
}

bool repeats_while_held(Action action)
{
  constexpr std::array steps{Action::step_forward, Action::step_back, Action::leap_forward,
                             Action::leap_back,    Action::varus_up,  Action::varus_down};
  return std::ranges::find(steps, action) != steps.end();
}

std::span<const HelpLine> key_help()
{
  return key_lines;
}

std::span<const HelpLine> mouse_help()
{
  return mouse_lines;
}

std::string help_text()
{
  std::string text = "Keys of the window:\n";
  append(text, key_lines);
  text += "Mouse:\n";
  append(text, mouse_lines);
  return text;
}

}  // namespace vrda::navigation
