#include "guide/plan.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "guide/marks.hpp"
#include "guide/parts.hpp"
#include "guide/solve_part.hpp"
#include "guide/tasks.hpp"
#include "settings/settings_text.hpp"

namespace vrda {
namespace {

/// The bench file's key of those numbers.
const char* key_of_numbers(CalibrationPart part)
{
  switch (part) {
    case CalibrationPart::eyepoints:
      return "calibration.rectangles";
    case CalibrationPart::subject:
      return "calibration.landmarks";
    case CalibrationPart::tibia:
      return "calibration.tibia_point";
    case CalibrationPart::bullseye:
      return "board.stage_mm_per_count";
    default:
      return "calibration.point";
  }
}

std::string place_of(CalibrationPart part)
{
  return std::string(is_once_a_bench(part) ? "per_bench." : "per_person.") + name_of(part);
}

/// Samples of the stage are kept in mm: its scale is in them.
bool has_numbers_in_rows(CalibrationPart part)
{
  return part == CalibrationPart::bullseye;
}

void require_numbers(const CalibrationRecord& record, CalibrationPart part, const BenchFile& bench,
                     const std::string& path)
{
  const std::vector<double> now = bench_numbers_of(part, bench);
  const std::vector<double>& then = record.made_with;
  // Nothing: of a file that does not tell.
  if (record.marks.empty() || then.empty() || then == now) return;
  const auto differ = std::mismatch(then.begin(), then.end(), now.begin(), now.end());
  const auto text = [](const std::vector<double>& list, std::vector<double>::const_iterator at) {
    return at == list.end() ? "nothing" : number_text(*at);
  };
  const std::string key = key_of_numbers(part);
  const std::string mended =
      has_numbers_in_rows(part) ? "" : "; if they were wrong and are right now, calibrate solve";
  throw InputError(
      {path, place_of(part),
       "marks made when " + key + " had " + text(then, differ.first) + " where it now has " +
           text(now, differ.second),
       "those of " + bench.path + ": put its numbers back, or do " + name_of(part) + " anew" + mended});
}

bool is_left_as_it_is(CalibrationPart part, const Calibration& begun)
{
  const auto record = begun.records.find(part);
  return record != begun.records.end() && !record->second.is_outdated;
}

void require_plan_of_all(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                         const std::string& path)
{
  // What is outdated is done anew.
  if (is_left_as_it_is(part, begun)) require_of_plan(part, bench, begun, path);
  for (const CalibrationPart below : rests_on(part, bench)) require_plan_of_all(below, bench, begun, path);
}

}  // namespace

std::vector<double> bench_numbers_of(CalibrationPart part, const BenchFile& bench)
{
  const CalibrationSettings& settings = bench.calibration;
  std::vector<double> numbers;
  switch (part) {
    case CalibrationPart::eyepoints:
      for (const CalibrationRectangle& r : settings.rectangles)
        numbers.insert(numbers.end(), {r.width_mm, r.depth_mm});
      return numbers;
    case CalibrationPart::subject:
      for (const CalibrationLandmarks& pair : settings.landmarks) numbers.push_back(pair.model_mm);
      return numbers;
    case CalibrationPart::bullseye:
      if (has_stage(bench)) numbers.push_back(bench.stage_mm_per_count);
      return numbers;
    case CalibrationPart::leg:
    case CalibrationPart::femur:
    case CalibrationPart::tibia:
      if (settings.is_model_adjusted) return {};
      for (const CalibrationPoint& point : points_of(part, settings)) {
        const Eigen::Vector3d& p = point.p_model_mm;
        numbers.insert(numbers.end(), {p.x(), p.y(), p.z(), point.is_target ? 1.0 : 0.0});
      }
      return numbers;
    default:
      return numbers;
  }
}

void require_of_plan(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                     const std::string& path)
{
  const CalibrationRecord& record = begun.records.at(part);
  require_of_tasks(record, tasks_of(part, bench, begun), place_of(part), path);
  require_numbers(record, part, bench, path);
}

void take_numbers(CalibrationRecord& record, CalibrationPart part, const BenchFile& bench)
{
  if (!record.made_with.empty() && !has_numbers_in_rows(part))
    record.made_with = bench_numbers_of(part, bench);
}

void require_order(const std::vector<CalibrationPart>& parts, const BenchFile& bench,
                   const Calibration& begun, const std::string& path)
{
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const CalibrationPart part = parts[k];
    require_wanted(part, bench);
    bool is_all_done = true;
    for (const CalibrationPart below : rests_on(part, bench)) {
      if (is_done(begun, below)) continue;
      is_all_done = false;
      const auto so_far = parts.begin() + static_cast<std::ptrdiff_t>(k);
      if (std::find(parts.begin(), so_far, below) != so_far) continue;
      const bool was_done = begun.records.contains(below) && begun.records.at(below).is_outdated;
      throw InputError(
          {path, name_of(part),
           std::string(name_of(below)) + (was_done ? ", which is outdated" : ", which is not done"),
           std::string(name_of(below)) + " first, as " + name_of(part) + " rests on it"});
    }
    require_plan_of_all(part, bench, begun, path);
    if (is_all_done && !is_done(begun, part)) require_earlier_marks(part, bench, begun, path);
  }
}

}  // namespace vrda
