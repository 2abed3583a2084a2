#include "view/keys.hpp"

#include <algorithm>
#include <array>

namespace vrda::view {
namespace {

struct Binding {
  Key key = Key::none;
  Action action = Action::none;
  Action with_shift = Action::none;  ///< none: shift makes no difference
};

// Generated from keys.json: bindings, key_lines, mouse_lines. Characters that some layouts need shift for (+)
// are listed without it.
#include "view/key_table.hpp"

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

}  // namespace vrda::view
