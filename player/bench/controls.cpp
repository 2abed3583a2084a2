#include "bench/controls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/text.hpp"

namespace vrda {
namespace {

constexpr double many = 10.0;  // steps, with Shift
constexpr double usual_prediction_ms = 30.0;

constexpr std::array key_lines{
    HelpLine{"Up, Down", "previous, next parameter; with Shift the next of another kind"},
    HelpLine{"Left, Right", "decrease, increase by a step; with Shift by ten"},
    HelpLine{"F, V, I", "select flexion, varus (rigid leg), inter-pupillary distance"},
    HelpLine{"P", "prediction on and off"},
    HelpLine{"E", "filter of the leg's angles on and off"},
    HelpLine{"Z", "zero the parallax stage at its stop"},
    HelpLine{"W", "write the calibration file"},
    HelpLine{"T", "panel with devices and timing"},
    HelpLine{"S", "screenshot (PNG, in the current folder)"},
    HelpLine{"H or ?", "this page"},
    HelpLine{"Q or Esc", "quit"},
};

/// "left" for "left.k1".
std::string kind_of(std::size_t parameter)
{
  const std::string& name = parameters()[parameter].name;
  return name.substr(0, name.find('.'));
}

void select_by(BenchState& state, bool is_forward, bool is_other_kind)
{
  const std::size_t n = parameters().size();
  const std::size_t step = is_forward ? 1 : n - 1;
  const auto is_passed = [&](std::size_t parameter) {
    const bool is_same_kind = is_other_kind && kind_of(parameter) == kind_of(state.selected());
    return is_same_kind || !is_used(parameter, state.bench());
  };
  std::size_t next = (state.selected() + step) % n;
  while (is_passed(next)) next = (next + step) % n;
  state.select(next);
}

void select_named(BenchState& state, const char* name)
{
  const std::optional<std::size_t> parameter = parameter_named(name);
  if (parameter && is_used(*parameter, state.bench())) state.select(*parameter);
}

void change_by(BenchState& state, double steps)
{
  const std::size_t selected = state.selected();
  const double step = parameters()[selected].step;
  // In multiples of the step, so that opposite key presses restore the value.
  const double value = value_of(state.values(), selected);
  set_value(state.values(), selected, (std::round(value / step * 1e3) / 1e3 + steps) * step);
  state.select(selected);
}

void toggle_prediction(BenchState& state)
{
  double& ms = state.values().prediction_ms;
  const double usual = state.bench().prediction_ms > 0.0 ? state.bench().prediction_ms : usual_prediction_ms;
  ms = ms > 0.0 ? 0.0 : usual;
}

struct Binding {
  Key key = Key::none;
  BenchRequest request = BenchRequest::none;
  void (*act)(BenchState&, const KeyPress&) = nullptr;
};

double steps_of(const KeyPress& press)
{
  return press.has_shift ? many : 1.0;
}

constexpr BenchRequest nothing = BenchRequest::none;
constexpr std::array bindings{
    Binding{Key::up, nothing, [](BenchState& s, const KeyPress& p) { select_by(s, false, p.has_shift); }},
    Binding{Key::down, nothing, [](BenchState& s, const KeyPress& p) { select_by(s, true, p.has_shift); }},
    Binding{Key::left, nothing, [](BenchState& s, const KeyPress& p) { change_by(s, -steps_of(p)); }},
    Binding{Key::right, nothing, [](BenchState& s, const KeyPress& p) { change_by(s, steps_of(p)); }},
    Binding{key_of('F'), nothing, [](BenchState& s, const KeyPress&) { select_named(s, "flexion"); }},
    Binding{key_of('V'), nothing, [](BenchState& s, const KeyPress&) { select_named(s, "varus"); }},
    Binding{key_of('I'), nothing,
            [](BenchState& s, const KeyPress&) { select_named(s, "eyes.distance_apart"); }},
    Binding{key_of('P'), nothing, [](BenchState& s, const KeyPress&) { toggle_prediction(s); }},
    Binding{key_of('E'), nothing, [](BenchState& s, const KeyPress&) { s.set_filter(!s.is_filtered()); }},
    Binding{key_of('Z'), BenchRequest::zero_stage},
    Binding{key_of('W'), BenchRequest::write_calibration},
    Binding{key_of('T'), BenchRequest::show_panel},
    Binding{key_of('S'), BenchRequest::screenshot},
    Binding{key_of('H'), BenchRequest::show_help},
    Binding{key_of('?'), BenchRequest::show_help},
    Binding{key_of('Q'), BenchRequest::quit},
    Binding{Key::escape, BenchRequest::quit},
};

}  // namespace

BenchRequest press_key(BenchState& state, const KeyPress& press)
{
  const auto* const binding =
      std::find_if(bindings.begin(), bindings.end(), [&](const Binding& b) { return b.key == press.key; });
  if (binding == bindings.end()) return BenchRequest::none;
  if (binding->act != nullptr) binding->act(state, press);
  return binding->request;
}

std::span<const HelpLine> bench_key_lines()
{
  return key_lines;
}

std::string parameter_text(const BenchState& state, std::size_t parameter)
{
  const Parameter& p = parameters()[parameter];
  // Rounded to a hundredth of a step.
  const double grain = p.step / 100.0;
  const double value = std::round(value_of(state.values(), parameter) / grain) * grain;
  const double shown = std::round(value * 1e6) / 1e6;
  return p.name + " " + shortest(shown) + (p.unit.empty() ? "" : " " + p.unit);
}

}  // namespace vrda
