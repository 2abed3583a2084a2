/// Numbers of a task that keys and potentiometer change, and their conversion to a row of a mark.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bench/motion_filter.hpp"
#include "calibration/task.hpp"
#include "view/keys.hpp"

namespace vrda::calibration {

/// A motion of the pointer with a pressed button, from the press: x right, y down, in pixels.
struct DialDrag {
  Eigen::Vector2d moved_px = Eigen::Vector2d::Zero();
  bool is_second = false;  ///< right button: the second of two dials
  bool is_fine = false;    ///< a tenth
};

class Dials {
 public:
  Dials() : Dials(Task{}) {}
  explicit Dials(const Task& task);

  std::span<const double> values() const { return values_; }
  std::size_t selected() const { return selected_; }
  /// Whether each dial was changed by the operator, also if it is back at its start value.
  const std::vector<bool>& touched() const { return touched_; }

  /// Handles arrow keys (session.hpp); ignores others.
  void press(const view::KeyPress& press);
  /// Handles a potentiometer value: 200 steps per turn, relative to its position when the dial was selected.
  void turn(int count, double time_s);
  /// Marks the values from which drag() counts.
  void begin_drag() { drag_start_ = values_; }
  /// Dials in px follow the pointer, others change by a step a pixel: a cross in both directions, a row
  /// vertically, everything else horizontally; of more than two dials the selected one. Ignored without
  /// begin_drag().
  void drag(const DialDrag& drag);

 private:
  void change(std::size_t dial, double steps);
  void set(std::size_t dial, double value);
  void select(std::size_t dial);

  std::vector<Dial> dials_;
  bool is_cross_ = false;  ///< Up decreases y
  bool is_row_ = false;    ///< a scan line that moves vertically
  std::vector<double> values_;
  std::vector<bool> touched_;
  std::vector<double> drag_start_;  ///< empty: no drag
  std::size_t selected_ = 0;
  bench::OneEuroFilter filter_;
  std::optional<double> start_count_;
  double start_value_ = 0.0;  ///< of the selected dial at start_count_
  double last_steps_ = 0.0;
};

}  // namespace vrda::calibration
