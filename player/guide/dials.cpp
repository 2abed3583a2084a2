#include "guide/dials.hpp"

#include <algorithm>
#include <cmath>

namespace vrda {
namespace {

/// As on the bench (bench/bench_state.cpp): counts of a ten-bit converter, steps a turn.
constexpr double most_count = 1023.0, steps_a_turn = 200.0;
constexpr OneEuroOptions potentiometer_options{1.0, 0.05, 2.0};

/// Without the dust of many small steps.
double tidy(double value)
{
  constexpr double parts = 1e9;
  return std::round(value * parts) / parts;
}

}  // namespace

Dials::Dials(const Task& task)
    : dials_(task.dials),
      is_cross_(task.kind == TaskKind::point || task.kind == TaskKind::bullseye),
      filter_(potentiometer_options)
{
  for (const Dial& dial : dials_) values_.push_back(std::clamp(dial.value, dial.least, dial.most));
}

void Dials::select(std::size_t dial)
{
  if (dial == selected_) return;
  selected_ = dial;
  potentiometer_was_.reset();
}

void Dials::change(std::size_t dial, double steps)
{
  if (dial >= dials_.size()) return;
  select(dial);
  const Dial& facts = dials_[dial];
  values_[dial] = std::clamp(tidy(values_[dial] + steps * facts.step), facts.least, facts.most);
  // What keys did stays when the potentiometer goes on.
  potentiometer_was_.reset();
}

void Dials::press(const KeyPress& press)
{
  const double n = press.has_control ? 100.0 : (press.has_shift ? 10.0 : 1.0);
  const bool is_many = dials_.size() > 2;
  switch (press.key) {
    case Key::left:
      return change(is_many ? selected_ : 0, -n);
    case Key::right:
      return change(is_many ? selected_ : 0, n);
    case Key::up:
      if (is_many) return select((selected_ + dials_.size() - 1) % dials_.size());
      return change(1, is_cross_ ? -n : n);
    case Key::down:
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
  if (!potentiometer_was_) {
    potentiometer_was_ = filtered;
    value_was_ = values_[selected_];
    steps_was_ = 0.0;
  }
  // Whole steps: what is not touched stays as it is.
  const double steps = std::round((filtered - *potentiometer_was_) / most_count * steps_a_turn);
  if (steps == steps_was_) return;
  steps_was_ = steps;
  const Dial& facts = dials_[selected_];
  values_[selected_] = std::clamp(tidy(value_was_ + steps * facts.step), facts.least, facts.most);
}

}  // namespace vrda
