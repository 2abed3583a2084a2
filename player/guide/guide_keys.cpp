#include <array>

#include "guide/session.hpp"

namespace vrda {

std::span<const HelpLine> guide_key_lines()
{
  static constexpr std::array<HelpLine, 8> lines{
      {{"Left, Right", "first number less, more; of many numbers the selected one"},
       {"Up, Down", "second number more, less (a cross: up, down); of many numbers select another"},
       {"Shift, Control", "ten, a hundred steps at once"},
       {"Enter", "it is aligned, read or held still: goes on, or takes the tracker's samples"},
       {"Backspace", "the task before again; while samples are taken: stops that"},
       {"R", "this part again from its first task"},
       {"Z", "the stage stands against its stop: this is its zero, as after its board was switched on again"},
       {"Escape, Q", "leaves; everything done so far is kept"}}};
  return lines;
}

}  // namespace vrda
