/// A task's numbers under the operator's keys and potentiometer, and the mark's row that they make.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "guide/task.hpp"
#include "tracking/one_euro.hpp"
#include "view/keys.hpp"

namespace vrda {

class Dials {
 public:
  Dials() : Dials(Task{}) {}
  explicit Dials(const Task& task);

  std::span<const double> values() const { return values_; }
  std::size_t selected() const { return selected_; }

  /// Arrow keys, as guide/session.hpp says; others mean nothing here.
  void press(const KeyPress& press);
  /// The potentiometer stands at `count`: 200 steps a turn from where it stood when the dial was selected.
  void turn(int count, double time_s);

 private:
  void change(std::size_t dial, double steps);
  void select(std::size_t dial);

  std::vector<Dial> dials_;
  bool is_cross_ = false;  ///< up is where y is less
  std::vector<double> values_;
  std::size_t selected_ = 0;
  OneEuroFilter filter_;
  std::optional<double> potentiometer_was_;
  double value_was_ = 0.0;  ///< of the selected dial, at potentiometer_was_
  double steps_was_ = 0.0;
};

/// Of a task that takes no samples, as its kind says.
std::vector<double> row_of(const Task& task, std::span<const double> values, const Calibration& calibration);

/// Of a bull's-eye: where its cross is drawn.
Eigen::Vector2d drawn_cross(const Task& task, std::span<const double> values, const Calibration& calibration);

/// Whose place is wanted beside the task's tool.
std::optional<BodyRole> body_beside(CalibrationPart part, const Task& task);

}  // namespace vrda
