#include <algorithm>

#include "guide/marks.hpp"
#include "guide/parts.hpp"
#include "guide/plan.hpp"
#include "guide/session.hpp"
#include "guide/solve_part.hpp"
#include "guide/tasks.hpp"

namespace vrda {

Calibration solved_again(const BenchFile& bench, const Calibration& calibration, const std::string& path)
{
  Calibration solved = calibration;
  const auto has_estimate = [&](CalibrationPart below) {
    const auto found = solved.records.find(below);
    return found != solved.records.end() && found->second.estimate;
  };
  for (const CalibrationPart part : parts_of(bench)) {
    const auto record = solved.records.find(part);
    if (record == solved.records.end() || record->second.marks.empty()) continue;
    take_numbers(record->second, part, bench);
    // Parts that rest on this one read its marks, too, whether it is solved or not.
    require_of_plan(part, bench, solved, path);
    // What it rests on is being done anew.
    const std::vector<CalibrationPart> below = rests_on(part, bench);
    if (!std::all_of(below.begin(), below.end(), has_estimate)) continue;
    const std::vector<Task> tasks = tasks_of(part, bench, solved);
    if (next_task(tasks, record->second) < tasks.size()) continue;
    solved = solved_part(part, bench, solved, path);
  }
  return solved;
}

}  // namespace vrda
