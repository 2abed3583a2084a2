#include "guide/marks.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "devices/sample.hpp"

namespace vrda {
namespace {

/// What rows of a kind have.
struct RowShape {
  std::size_t first = 0;         ///< numbers of the first row
  std::vector<std::size_t> all;  ///< of the others, any of these
};

RowShape shape_of(TaskKind kind)
{
  switch (kind) {
    case TaskKind::scan_line:
    case TaskKind::number:
    case TaskKind::stop:
      return {1, {}};
    case TaskKind::point:
      return {2, {}};
    case TaskKind::sides:
      return {4, {}};
    case TaskKind::grid:
      return {8, {}};
    case TaskKind::place:
      return {6, {}};
    case TaskKind::look:
      return {0, {}};
    case TaskKind::sweep:
      return {0, {7, 8}};
    case TaskKind::hold:
      return {14, {14}};
    case TaskKind::bullseye:
      return {3, {3, 10}};
  }
  return {};
}

bool is_of_shape(const CalibrationMark& mark, TaskKind kind)
{
  const RowShape shape = shape_of(kind);
  if (mark.rows.empty() || (shape.all.empty() && mark.rows.size() != 1)) return false;
  for (std::size_t k = 0; k < mark.rows.size(); ++k) {
    const std::size_t n = mark.rows[k].size();
    const bool is_first = k == 0 && kind != TaskKind::sweep;
    if (is_first ? n != shape.first : std::find(shape.all.begin(), shape.all.end(), n) == shape.all.end())
      return false;
  }
  // The cross, then samples.
  return kind != TaskKind::bullseye || mark.rows.size() > 1;
}

std::ptrdiff_t place_of_task(const std::vector<Task>& tasks, const std::string& name)
{
  const auto found =
      std::find_if(tasks.begin(), tasks.end(), [&](const Task& task) { return task.name == name; });
  return found - tasks.begin();
}

}  // namespace

const CalibrationMark* mark_of(const CalibrationRecord& record, const std::string& task)
{
  const auto found = std::find_if(record.marks.begin(), record.marks.end(),
                                  [&](const CalibrationMark& mark) { return mark.task == task; });
  return found == record.marks.end() ? nullptr : &*found;
}

std::size_t next_task(const std::vector<Task>& tasks, const CalibrationRecord& record)
{
  std::size_t at = 0;
  while (at < tasks.size() && mark_of(record, tasks[at].name) != nullptr) ++at;
  return at;
}

void put_mark(CalibrationRecord& record, const std::vector<Task>& tasks, CalibrationMark mark)
{
  std::erase_if(record.marks, [&](const CalibrationMark& m) { return m.task == mark.task; });
  const std::ptrdiff_t at = place_of_task(tasks, mark.task);
  const auto later = std::find_if(record.marks.begin(), record.marks.end(), [&](const CalibrationMark& m) {
    return place_of_task(tasks, m.task) > at;
  });
  record.marks.insert(later, std::move(mark));
}

void require_of_tasks(const CalibrationRecord& record, const std::vector<Task>& tasks,
                      const std::string& place, const std::string& path)
{
  for (const CalibrationMark& mark : record.marks) {
    const auto at = static_cast<std::size_t>(place_of_task(tasks, mark.task));
    if (at == tasks.size()) {
      throw InputError({path, place, "a mark of '" + mark.task + "', which the bench file does not ask for",
                        "marks of its tasks: has [calibration] changed? Do the part anew"});
    }
    if (!is_of_shape(mark, tasks[at].kind)) {
      throw InputError({path, place, "rows of '" + mark.task + "' that no such task makes",
                        "those of schemas/calibration.md: do the part anew"});
    }
  }
}

Pose sampled_pose(std::span<const double> row, std::size_t at)
{
  Place place;
  std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(at), 3, place.position_mm);
  std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(at) + 3, 4, place.rotation);
  return pose_of(place);
}

Eigen::Vector3d sampled_position(std::span<const double> row)
{
  return {row[0], row[1], row[2]};
}

}  // namespace vrda
