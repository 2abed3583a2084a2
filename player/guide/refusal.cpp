#include "guide/refusal.hpp"

#include <algorithm>

#include "calibration/viewport_fit.hpp"
#include "guide/marks.hpp"
#include "guide/task.hpp"

namespace vrda {
namespace {

bool is_first(Edge edge)
{
  return edge == Edge::left || edge == Edge::top;
}

Edge opposite(Edge edge)
{
  switch (edge) {
    case Edge::left:
      return Edge::right;
    case Edge::right:
      return Edge::left;
    case Edge::top:
      return Edge::bottom;
    case Edge::bottom:
      return Edge::top;
  }
  return edge;
}

struct ScannedLine {
  std::string task;
  double at_px = 0.0;
};

/// Marked scans of an edge, for the eye of `task`.
std::vector<ScannedLine> scans_of(Edge edge, const Task& task, const std::vector<Task>& tasks,
                                  const CalibrationRecord& record)
{
  std::vector<ScannedLine> scans;
  for (const Task& t : tasks) {
    if (t.kind != TaskKind::scan_line || t.is_right != task.is_right || t.index != static_cast<int>(edge))
      continue;
    if (const CalibrationMark* mark = mark_of(record, t.name)) scans.push_back({t.name, mark->rows[0][0]});
  }
  return scans;
}

}  // namespace

void require_uncrossed(const std::vector<Task>& tasks, const CalibrationRecord& record, std::size_t done,
                       const std::string& path)
{
  const Task& last = tasks[done];
  if (last.kind != TaskKind::scan_line) return;
  const auto edge = static_cast<Edge>(last.index);
  const double at_px = mark_of(record, last.name)->rows[0][0];
  std::vector<ScannedLine> scans = scans_of(opposite(edge), last, tasks, record);
  const bool is_crossed = std::any_of(scans.begin(), scans.end(), [&](const ScannedLine& other) {
    return is_first(edge) ? at_px >= other.at_px : at_px <= other.at_px;
  });
  if (!is_crossed) return;
  std::vector<std::string> rejected;
  for (const ScannedLine& scan : scans) rejected.push_back(scan.task);
  for (const ScannedLine& scan : scans_of(edge, last, tasks, record)) rejected.push_back(scan.task);
  throw PartRefusal({path, name_of(CalibrationPart::viewport),
                     "crossed edges of the " + eye_text(last.is_right) + ": " + name_of(edge) + " beyond " +
                         name_of(opposite(edge)),
                     "left before right and top before bottom; scan both edges again"},
                    std::move(rejected));
}

std::string words_of(const InputError& error)
{
  const InputError::Facts& facts = error.facts();
  return (facts.field.empty() ? "" : facts.field + ": ") + "found " + facts.found + ", wanted " +
         facts.wanted;
}

}  // namespace vrda
