#include "guide/task_row.hpp"

#include "core/error.hpp"
#include "core/units.hpp"
#include "guide/optics_tasks.hpp"
#include "guide/parts.hpp"

namespace vrda {

Eigen::Vector2d drawn_cross(const Task& task, std::span<const double> values, const Calibration& calibration)
{
  return drawn_px(eye_of(calibration, task.is_right).distortion, Eigen::Vector2d(values[0], values[1]));
}

std::vector<double> row_of(const Task& task, std::span<const double> values, const Calibration& calibration)
{
  std::vector<double> row(values.begin(), values.end());
  const Eye& eye = eye_of(calibration, task.is_right);
  switch (task.kind) {
    case TaskKind::sides: {
      // Where each line crosses the height of the sight: the rest of it says the same.
      row.clear();
      for (const double x : values) {
        const Eigen::Vector2d drawn = drawn_px(eye.distortion, Eigen::Vector2d(x, eye.sight_px.y()));
        row.insert(row.end(), {drawn.x(), drawn.y()});
      }
      return row;
    }
    case TaskKind::grid:
      row.back() = rad_from_deg(row.back());
      return row;
    case TaskKind::place:
      for (std::size_t k = 3; k < row.size(); ++k) row[k] = rad_from_deg(row[k]);
      return row;
    case TaskKind::scan_line:
    case TaskKind::point:
    case TaskKind::number:
    case TaskKind::look:
      return row;
    case TaskKind::sweep:
    case TaskKind::hold:
    case TaskKind::bullseye:
    case TaskKind::stop:
      break;
  }
  throw InternalError("what takes samples has no row of its dials");
}

std::optional<BodyRole> body_beside(CalibrationPart part, const Task& task)
{
  if (task.kind == TaskKind::hold) return role_of(part);
  if (part == CalibrationPart::head) return BodyRole::head;
  return std::nullopt;
}

}  // namespace vrda
