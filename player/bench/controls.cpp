#include "bench/controls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/text.hpp"

namespace vrda::bench {
namespace {

constexpr double many = 10.0;  // steps, with Shift
constexpr double usual_prediction_ms = 30.0;

constexpr std::array key_lines{
    view::HelpLine{"Up, Down", "previous, next parameter; with Shift, the next group"},
    view::HelpLine{"Left, Right", "decrease, increase by a step; with Shift by ten"},
    view::HelpLine{"F, V, I", "select flexion, varus (rigid leg), inter-pupillary distance"},
    view::HelpLine{"P", "prediction on and off"},
    view::HelpLine{"E", "filter of the leg's angles on and off"},
    view::HelpLine{"Z", "zero the parallax stage at its stop"},
    view::HelpLine{"Left, right, middle drag",
                         "turn, move, push the joint off the leg; R puts it back"},
    view::HelpLine{"Gamepad", "stick and cross: as the arrow keys; left shoulder: Shift"},
    view::HelpLine{"W", "write the calibration file"},
    view::HelpLine{"T", "panel with devices and timing"},
    view::HelpLine{"S", "screenshot (PNG, in the current folder)"},
    view::HelpLine{"H or ?", "this page"},
    view::HelpLine{"Q or Esc", "quit"},
};

/// "left" for "left.k1".
std::string kind_of(std::size_t parameter)
{
  const std::string& name = bench::parameters()[parameter].name;
  return name.substr(0, name.find('.'));
}

void select_by(BenchState& state, bool is_forward, bool is_other_kind)
{
  const std::size_t n = bench::parameters().size();
  const std::size_t step = is_forward ? 1 : n - 1;
  const auto is_passed = [&](std::size_t parameter) {
    const bool is_same_kind = is_other_kind && kind_of(parameter) == kind_of(state.selected());
    return is_same_kind || !bench::is_used(parameter, state.bench());
  };
  std::size_t next = (state.selected() + step) % n;
  while (is_passed(next)) next = (next + step) % n;
  state.select(next);
}

void select_named(BenchState& state, const char* name)
{
  const std::optional<std::size_t> parameter = bench::find_parameter(name);
  if (parameter && bench::is_used(*parameter, state.bench())) state.select(*parameter);
}

void change_by(BenchState& state, double steps)
{
  const std::size_t selected = state.selected();
  const double step = bench::parameters()[selected].step;
  // In multiples of the step, so that opposite key presses restore the value.
  const double value = bench::value_of(state.values(), selected);
  bench::set_value(state.values(), selected, (std::round(value / step * 1e3) / 1e3 + steps) * step);
  state.select(selected);
}

void toggle_prediction(BenchState& state)
{
  double& ms = state.values().prediction_ms;
  const double usual = state.bench().prediction_ms > 0.0 ? state.bench().prediction_ms : usual_prediction_ms;
  ms = ms > 0.0 ? 0.0 : usual;
}

using Press = view::KeyPress;

struct Binding {
  view::Key key = view::Key::none;
  void (*act)(BenchState&, const Press&) = nullptr;
  BenchRequest request = BenchRequest::none;
};

double steps_of(const Press& press)
{
  return press.has_shift ? many : 1.0;
}

constexpr std::array bindings{
    Binding{view::Key::up, [](BenchState& s, const Press& p) { select_by(s, false, p.has_shift); }},
    Binding{view::Key::down, [](BenchState& s, const Press& p) { select_by(s, true, p.has_shift); }},
    Binding{view::Key::left, [](BenchState& s, const Press& p) { change_by(s, -steps_of(p)); }},
    Binding{view::Key::right, [](BenchState& s, const Press& p) { change_by(s, steps_of(p)); }},
    Binding{view::key_of('F'), [](BenchState& s, const Press&) { select_named(s, "flexion"); }},
    Binding{view::key_of('V'), [](BenchState& s, const Press&) { select_named(s, "varus"); }},
    Binding{view::key_of('I'),
            [](BenchState& s, const Press&) { select_named(s, "eyes.distance_apart"); }},
    Binding{view::key_of('P'), [](BenchState& s, const Press&) { toggle_prediction(s); }},
    Binding{view::key_of('E'), [](BenchState& s, const Press&) { s.set_filter(!s.is_filtered()); }},
    Binding{view::key_of('R'), [](BenchState& s, const Press&) { s.reset_offset(); }},
    Binding{view::key_of('Z'), nullptr, BenchRequest::zero_stage},
    Binding{view::key_of('W'), nullptr, BenchRequest::write_calibration},
    Binding{view::key_of('T'), nullptr, BenchRequest::show_panel},
    Binding{view::key_of('S'), nullptr, BenchRequest::screenshot},
    Binding{view::key_of('H'), nullptr, BenchRequest::show_help},
    Binding{view::key_of('?'), nullptr, BenchRequest::show_help},
    Binding{view::key_of('Q'), nullptr, BenchRequest::quit},
    Binding{view::Key::escape, nullptr, BenchRequest::quit},
};

}  // namespace

BenchRequest apply_key(BenchState& state, const view::KeyPress& press)
{
  const auto* const binding = std::ranges::find(bindings, press.key, &Binding::key);
  if (binding == bindings.end()) return BenchRequest::none;
  if (binding->act != nullptr) binding->act(state, press);
  return binding->request;
}

std::span<const view::HelpLine> bench_key_lines()
{
  return key_lines;
}

std::string parameter_text(const BenchState& state, std::size_t parameter)
{
  const bench::Parameter& p = bench::parameters()[parameter];
  // Rounded to a hundredth of a step.
  const double grain = p.step / 100.0;
  const double value = std::round(bench::value_of(state.values(), parameter) / grain) * grain;
  const double shown = std::round(value * 1e6) / 1e6;
  return p.name + " " + shortest_decimal(shown) + (p.unit.empty() ? "" : " " + p.unit);
}

}  // namespace vrda::bench
