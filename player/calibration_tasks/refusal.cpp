#include "calibration_tasks/refusal.hpp"

#include <algorithm>

#include "calibration/viewport_fit.hpp"
#include "calibration_tasks/marks.hpp"
#include "calibration_tasks/task.hpp"

namespace vrda::calibration_tasks {
namespace {

bool is_first(calibration::Edge edge)
{
  return edge == calibration::Edge::left || edge == calibration::Edge::top;
}

calibration::Edge opposite(calibration::Edge edge)
{
  switch (edge) {
    case calibration::Edge::left:
      return calibration::Edge::right;
    case calibration::Edge::right:
      return calibration::Edge::left;
    case calibration::Edge::top:
      return calibration::Edge::bottom;
    case calibration::Edge::bottom:
      return calibration::Edge::top;
  }
  return edge;
}

struct ScannedLine {
  std::string task;
  double at_px = 0.0;
};

/// Marked scans of an edge, for the eye of `task`.
std::vector<ScannedLine> scans_of(calibration::Edge edge, const Task& task, const std::vector<Task>& tasks,
                                  const CalibrationRecord& record)
{
  std::vector<ScannedLine> scans;
  for (const Task& t : tasks) {
    if (t.kind != TaskKind::scan_line || t.is_right != task.is_right || t.index != static_cast<int>(edge))
      continue;
    if (const CalibrationMark* mark = find_mark(record, t.name)) scans.push_back({t.name, mark->rows[0][0]});
  }
  return scans;
}

}  // namespace

void require_edge_order(const std::vector<Task>& tasks, const CalibrationRecord& record, std::size_t done,
                        const std::string& path)
{
  const Task& last = tasks[done];
  if (last.kind != TaskKind::scan_line) return;
  const auto edge = static_cast<calibration::Edge>(last.index);
  const double at_px = find_mark(record, last.name)->rows[0][0];
  std::vector<ScannedLine> scans = scans_of(opposite(edge), last, tasks, record);
  const bool is_crossed = std::any_of(scans.begin(), scans.end(), [&](const ScannedLine& other) {
    return is_first(edge) ? at_px >= other.at_px : at_px <= other.at_px;
  });
  if (!is_crossed) return;
  std::vector<std::string> rejected;
  for (const ScannedLine& scan : scans) rejected.push_back(scan.task);
  for (const ScannedLine& scan : scans_of(edge, last, tasks, record)) rejected.push_back(scan.task);
  throw PartRefusal({path, bench_files::name_of(CalibrationPart::viewport),
                     "crossed edges of the " + eye_text(last.is_right) + ": " + calibration::name_of(edge) +
                         " beyond " + calibration::name_of(opposite(edge)),
                     "left before right and top before bottom; scan both edges again"},
                    std::move(rejected));
}

std::string screen_message(const InputError& error)
{
  const InputError::Facts& facts = error.facts();
  return (facts.field.empty() ? "" : facts.field + ": ") + "found " + facts.found + ", wanted " +
         facts.wanted;
}

}  // namespace vrda::calibration_tasks
