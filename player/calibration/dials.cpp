#include "calibration/dials.hpp"

#include <algorithm>
#include <cmath>

namespace vrda::calibration {
namespace {

/// As in bench/bench_state.cpp: range of the ten-bit converter, steps per turn.
constexpr double most_count = 1023.0, steps_a_turn = 200.0;
constexpr bench::OneEuroOptions potentiometer_options{1.0, 0.05, 2.0};

/// Removes accumulated rounding errors of many small steps.
double rounded_value(double value)
{
  constexpr double parts = 1e9;
  return std::round(value * parts) / parts;
}

}  // namespace

Dials::Dials(const Task& task)
    : dials_(task.dials),
      is_cross_(task.kind != nullptr && task.kind->traits().is_cross),
      is_row_(task.is_row),
      filter_(potentiometer_options)
{
  for (const Dial& dial : dials_) values_.push_back(std::clamp(dial.value, dial.minimum, dial.maximum));
  touched_.resize(values_.size());
}

void Dials::select(std::size_t dial)
{
  if (dial == selected_) return;
  selected_ = dial;
  start_count_.reset();
}

void Dials::change(std::size_t dial, double steps)
{
  if (dial < dials_.size()) set(dial, values_[dial] + steps * dials_[dial].step);
}

void Dials::set(std::size_t dial, double value)
{
  select(dial);
  touched_[dial] = true;
  // A step and back gives exactly the start value.
  const Dial& limits = dials_[dial];
  const double rounded = rounded_value(value);
  values_[dial] = std::clamp(rounded == rounded_value(limits.value) ? limits.value : rounded, limits.minimum,
                             limits.maximum);
  // The potentiometer continues from the value that was set.
  start_count_.reset();
}

void Dials::drag(const DialDrag& drag)
{
  if (drag_start_.empty()) return;
  constexpr double fine = 0.1;
  const auto move = [&](std::size_t k, double px) {
    const Dial& dial = dials_[k];
    const double steps = (drag.is_fine ? fine : 1.0) * px / (dial.unit == "px" ? dial.step : 1.0);
    set(k, drag_start_[k] + std::round(steps) * dial.step);
  };
  if (is_cross_) {
    move(0, drag.moved_px.x());
    move(1, drag.moved_px.y());
  } else {
    const std::size_t k = dials_.size() > 2 ? selected_ : drag.is_second ? dials_.size() - 1 : 0;
    move(k, is_row_ ? drag.moved_px.y() : drag.moved_px.x());
  }
}

void Dials::press(const view::KeyPress& press)
{
  const double n = press.has_control ? 100.0 : (press.has_shift ? 10.0 : 1.0);
  const bool is_many = dials_.size() > 2;
  switch (press.key) {
    case view::Key::left:
      return change(is_many ? selected_ : 0, -n);
    case view::Key::right:
      return change(is_many ? selected_ : 0, n);
    case view::Key::up:
      if (is_many) return select((selected_ + dials_.size() - 1) % dials_.size());
      return change(1, is_cross_ ? -n : n);
    case view::Key::down:
      if (is_many) return select((selected_ + 1) % dials_.size());
      return change(1, is_cross_ ? n : -n);
    default:
      return;
  }
}

void Dials::turn(int count, double time_s)
{
  if (dials_.empty()) return;
  const double filtered = filter_.filtered(count, time_s);
  if (!start_count_) {
    start_count_ = filtered;
    start_value_ = values_[selected_];
    last_steps_ = 0.0;
  }
  // Whole steps suppress the noise of a potentiometer at rest.
  const double steps = std::round((filtered - *start_count_) / most_count * steps_a_turn);
  if (steps == last_steps_) return;
  last_steps_ = steps;
  touched_[selected_] = true;
  const Dial& limits = dials_[selected_];
  values_[selected_] =
      std::clamp(rounded_value(start_value_ + steps * limits.step), limits.minimum, limits.maximum);
}

}  // namespace vrda::calibration
