#include "calibration/dials.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/eyepoint_fit.hpp"
#include "calibration/least_squares.hpp"
#include "calibration/parts.hpp"
#include "calibration/task.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

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
      is_cross_(task.kind == TaskKind::point || task.kind == TaskKind::bullseye),
      is_row_(task.kind == TaskKind::scan_line && !task.is_column),
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

Eigen::Vector2d drawn_cross(const Task& task, std::span<const double> values, const Calibration& calibration)
{
  return view::drawn_px(view::side_of(calibration.eyes, task.is_right).distortion,
                        Eigen::Vector2d(values[0], values[1]));
}

std::vector<double> mark_row(const Task& task, std::span<const double> values, const Calibration& calibration)
{
  check(task.n_samples == 0 && task.kind != TaskKind::stop, "a task with samples has no row of its dials");
  std::vector<double> row(values.begin(), values.end());
  if (task.kind == TaskKind::grid) row.back() = rad_from_deg(row.back());
  if (task.kind == TaskKind::model_pose)
    for (std::size_t k = 3; k < row.size(); ++k) row[k] = rad_from_deg(row[k]);
  if (task.kind != TaskKind::rectangle_sides) return row;
  // One point determines the line: its intersection with the height of the optical axis.
  const view::Eye& eye = view::side_of(calibration.eyes, task.is_right);
  row.clear();
  for (const double x : values) {
    const Eigen::Vector2d drawn = view::drawn_px(eye.distortion, Eigen::Vector2d(x, eye.sight_px.y()));
    row.insert(row.end(), {drawn.x(), drawn.y()});
  }
  return row;
}

std::optional<BodyRole> accompanying_body(CalibrationPart part, const Task& task)
{
  if (task.kind == TaskKind::hold) return role_of(part);
  if (part == CalibrationPart::head) return BodyRole::head;
  return std::nullopt;
}

// Inter-pupillary distance from the rectangles that each eye aligned.

namespace {

/// Centres of the rectangles relative to one eye's optical axis (positive: right), and their derivatives with
/// respect to the given numbers: distance and depth of the eyepoint, optical axis.
struct Middles {
  Eigen::VectorXd right_mm, noise_mm2;
  Eigen::Matrix<double, Eigen::Dynamic, 3> by_known;  ///< derivative by distance, depth and axis
  Eigen::Matrix3d known = Eigen::Matrix3d::Zero();    ///< covariance of the three
};

Middles middles_of(const EyeRectangles& seen, double sight_sd_px)
{
  const auto n = static_cast<Eigen::Index>(seen.marks.size());
  Middles middles;
  middles.right_mm.resize(n);
  middles.noise_mm2.resize(n);
  middles.by_known.resize(n, 3);
  const double distance_px = seen.fit.eyepoint.distance_px;
  for (Eigen::Index k = 0; k < n; ++k) {
    const RectangleMark& mark = seen.marks[static_cast<std::size_t>(k)];
    const double middle_px = 0.5 * (view::shown_px(seen.eye.distortion, mark.left_drawn_px).x() +
                                    view::shown_px(seen.eye.distortion, mark.right_drawn_px).x()) -
                             seen.eye.sight_px.x();
    const double mm_by_px = (seen.fit.eyepoint.depth_mm + mark.depth_mm) / distance_px;
    middles.right_mm(k) = middle_px * mm_by_px;
    middles.noise_mm2(k) =
        0.5 * seen.fit.noise_px * seen.fit.noise_px * mm_by_px * mm_by_px;  // mean of two sides
    middles.by_known.row(k) << -middles.right_mm(k) / distance_px, middle_px / distance_px, -mm_by_px;
  }
  middles.known.topLeftCorner<2, 2>() = seen.fit.estimate.covariance;
  middles.known(2, 2) = sight_sd_px * sight_sd_px;
  return middles;
}

}  // namespace

// A centre is a_left to the right of the left optical axis and a_right to the right of the right one; the
// inter-pupillary distance is a_left - a_right for any position of the rectangle. An axis error s adds
// s (E + Z) / d, which grows with depth, so all rectangles enter one generalised least squares fit.
PupilDistance pupil_distance(const EyeRectangles& left, const EyeRectangles& right, double sight_sd_px)
{
  check(left.marks.size() == right.marks.size() && !left.marks.empty(),
        "both eyes have marks of the same rectangles");
  for (std::size_t k = 0; k < left.marks.size(); ++k)
    check(left.marks[k].width_mm == right.marks[k].width_mm &&
              left.marks[k].depth_mm == right.marks[k].depth_mm,
          "both eyes have marks of the same rectangles");
  const Middles l = middles_of(left, sight_sd_px);
  const Middles r = middles_of(right, sight_sd_px);
  Eigen::MatrixXd V = propagated(l.by_known, l.known) + propagated(r.by_known, r.known);
  // sd_mm has no degrees of freedom, so the noise of t_ratio marks is enlarged by the ratio of Student's t.
  const double dof = std::max(1.0, static_cast<double>(left.marks.size() + right.marks.size()) - 4.0);
  const double t_ratio = bench::t_95(dof) / bench::t_95(std::numeric_limits<double>::infinity());
  V.diagonal() += t_ratio * t_ratio * (l.noise_mm2 + r.noise_mm2);
  // Keeps V invertible without noise and with known eyepoints; a nanometre is negligible otherwise.
  constexpr double regularisation_mm2 = 1e-12;
  V.diagonal().array() += regularisation_mm2;
  const Eigen::VectorXd weights = V.ldlt().solve(Eigen::VectorXd::Ones(V.rows()));
  PupilDistance result;
  result.ipd_mm = weights.dot(l.right_mm - r.right_mm) / weights.sum();
  result.sd_mm = 1.0 / std::sqrt(weights.sum());
  return result;
}

}  // namespace vrda::calibration
