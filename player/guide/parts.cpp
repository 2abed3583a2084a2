#include "guide/parts.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "guide/marks.hpp"
#include "guide/solve_part.hpp"
#include "guide/task.hpp"
#include "settings/settings_text.hpp"
#include "setup/record_text.hpp"

namespace vrda {
namespace {

bool is_part_of(CalibrationPart part, const BenchFile& bench)
{
  const bool is_on_stage = bench.head == HeadKind::stage;
  const bool is_touched = !bench.calibration.is_model_adjusted;
  switch (part) {
    case CalibrationPart::rails:
    case CalibrationPart::bullseye:
      return is_on_stage;
    case CalibrationPart::stop:
      return has_stage(bench);
    case CalibrationPart::probe:
      return is_touched;
    case CalibrationPart::head:
      return !is_on_stage;
    case CalibrationPart::subject:
      return !bench.calibration.landmarks.empty();
    case CalibrationPart::leg:
      return bench.leg == LegKind::rigid;
    case CalibrationPart::femur:
    case CalibrationPart::tibia:
      return bench.leg == LegKind::two_bodies;
    default:
      return true;
  }
}

/// Possible dependencies, including parts that the bench does not have.
std::vector<CalibrationPart> possible_dependencies(CalibrationPart part, const BenchFile& bench)
{
  switch (part) {
    case CalibrationPart::distortion:
      return {CalibrationPart::viewport};
    case CalibrationPart::eyepoints:
      return {CalibrationPart::distortion};
    case CalibrationPart::ipd:
      return {CalibrationPart::eyepoints};
    case CalibrationPart::bullseye:
      return {CalibrationPart::rails, CalibrationPart::stop, CalibrationPart::eyepoints,
              CalibrationPart::ipd};
    case CalibrationPart::head:
      return {CalibrationPart::eyepoints, CalibrationPart::ipd};
    case CalibrationPart::leg:
    case CalibrationPart::femur:
    case CalibrationPart::tibia:
      // Adjustment by eye depends on the whole optical calibration.
      if (bench.calibration.is_model_adjusted)
        return {CalibrationPart::subject, CalibrationPart::bullseye, CalibrationPart::head};
      return {CalibrationPart::probe, CalibrationPart::subject};
    default:
      return {};
  }
}

/// All valid steps of the bench, for a message.
std::string step_names(const BenchFile& bench)
{
  return "all, bench, person, tracking, status, solve, " + names_of(parts_of(bench));
}

}  // namespace

std::string names_of(std::span<const CalibrationPart> parts)
{
  std::string text;
  for (const CalibrationPart part : parts) text += (text.empty() ? "" : ", ") + std::string(name_of(part));
  return text;
}

bool is_model_part(CalibrationPart part)
{
  return part == CalibrationPart::leg || part == CalibrationPart::femur || part == CalibrationPart::tibia;
}

bool has_stage(const BenchFile& bench)
{
  return bench.head == HeadKind::stage && bench.board && bench.board->has_stage;
}

std::vector<CalibrationPart> parts_of(const BenchFile& bench)
{
  std::vector<CalibrationPart> parts;
  for (std::size_t k = 0; k < n_calibration_parts; ++k) {
    if (is_part_of(static_cast<CalibrationPart>(k), bench)) parts.push_back(static_cast<CalibrationPart>(k));
  }
  return parts;
}

std::vector<CalibrationPart> rests_on(CalibrationPart part, const BenchFile& bench)
{
  std::vector<CalibrationPart> parts = possible_dependencies(part, bench);
  std::erase_if(parts, [&](CalibrationPart p) { return !is_part_of(p, bench); });
  return parts;
}

bool is_done(const Calibration& calibration, CalibrationPart part)
{
  const auto found = calibration.records.find(part);
  return found != calibration.records.end() && found->second.estimate && !found->second.is_outdated;
}

void outdate_after(Calibration& calibration, CalibrationPart part, const BenchFile& bench)
{
  for (const CalibrationPart later : parts_of(bench)) {
    const std::vector<CalibrationPart> below = rests_on(later, bench);
    if (std::find(below.begin(), below.end(), part) == below.end()) continue;
    const auto record = calibration.records.find(later);
    if (record != calibration.records.end()) record->second.is_outdated = true;
    outdate_after(calibration, later, bench);
  }
}

std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench)
{
  const std::vector<CalibrationPart> all = parts_of(bench);
  if (step == "all") return all;
  std::vector<CalibrationPart> wanted;
  for (std::size_t k = 0; k < n_calibration_parts; ++k) {
    const auto part = static_cast<CalibrationPart>(k);
    const bool is_tracking = part == CalibrationPart::rails || part == CalibrationPart::stop ||
                             part == CalibrationPart::probe || part == CalibrationPart::bullseye ||
                             is_model_part(part);
    const bool is_group = (step == "tracking" && is_tracking) || (step == "bench" && is_once_a_bench(part)) ||
                          (step == "person" && !is_once_a_bench(part));
    if (step == name_of(part) || is_group) wanted.push_back(part);
  }
  if (wanted.empty())
    throw InputError({"calibrate", "STEP", "'" + step + "'", "one of " + step_names(bench)});
  if (wanted.size() == 1 && !is_part_of(wanted.front(), bench)) {
    require_wanted(wanted.front(), bench);
    throw InputError({"calibrate", "STEP", "'" + step + "', which does not apply to " + bench.path,
                      "one of " + step_names(bench)});
  }
  std::erase_if(wanted, [&](CalibrationPart part) { return !is_part_of(part, bench); });
  return wanted;
}

void require_wanted(CalibrationPart part, const BenchFile& bench)
{
  const CalibrationSettings& settings = bench.calibration;
  const auto refuse = [&](const std::string& key, const std::string& found, const std::string& wanted) {
    throw InputError({bench.path, key, found, wanted + ", for " + name_of(part)});
  };
  if (!settings.is_present) refuse("calibration", "nothing", "a table [calibration]");
  constexpr std::size_t least_distances = 3, least_fiducials = 4;
  if (part == CalibrationPart::subject && settings.landmarks.size() < least_distances) {
    refuse("calibration.landmarks", std::to_string(settings.landmarks.size()) + " distances",
           "three or more distances between landmarks");
  }
  if (!is_model_part(part) || settings.is_model_adjusted) return;
  const std::vector<CalibrationPoint>& points = points_of(part, settings);
  const auto n = std::count_if(points.begin(), points.end(),
                               [](const CalibrationPoint& point) { return !point.is_target; });
  if (n < static_cast<std::ptrdiff_t>(least_fiducials)) {
    refuse(part == CalibrationPart::tibia ? "calibration.tibia_point" : "calibration.point",
           std::to_string(n) + " points that are not targets", "four or more, not coplanar");
  }
}

BodyRole role_of(CalibrationPart part)
{
  check(is_model_part(part), "only model parts have a body");
  return part == CalibrationPart::leg ? BodyRole::leg
                                      : (part == CalibrationPart::femur ? BodyRole::femur : BodyRole::tibia);
}

const std::vector<CalibrationPoint>& points_of(CalibrationPart part, const CalibrationSettings& settings)
{
  return part == CalibrationPart::tibia ? settings.tibia_points : settings.points;
}

namespace {

CalibrationRecords bench_records(const Calibration& calibration)
{
  CalibrationRecords records;
  for (const auto& [part, record] : calibration.records) {
    if (is_once_a_bench(part)) records[part] = record;
  }
  return records;
}

}  // namespace

Calibration begun_from(const Calibration& other, const BenchFile& bench, const std::string& other_path)
{
  for (const CalibrationPart part : parts_of_step("bench", bench)) {
    if (is_done(other, part)) continue;
    throw InputError({other_path, std::string("per_bench.") + name_of(part),
                      other.records.contains(part) ? "a part that must be repeated" : "nothing",
                      "all per-bench parts done; run vrda-player calibrate bench"});
  }
  Calibration begun = nominal_calibration(bench);
  begun.records = bench_records(other);
  // The eyes of `other` include its person's bull's-eye fit, so they are rebuilt from the per-bench parts.
  begun.eyes = eyes_before(CalibrationPart::eyepoints, bench, begun);
  begun.X_tracker_table = other.X_tracker_table;
  begun.stage_direction_table = other.stage_direction_table;
  return begun;
}

void require_same_bench_parts(const Calibration& begun, const std::string& path, const Calibration& other,
                              const std::string& other_path)
{
  if (records_text(bench_records(begun)) == records_text(bench_records(other))) return;
  throw InputError({path, "per_bench", "per-bench parts that differ from those of " + other_path,
                    "a new file, or one that was started from " + other_path});
}

namespace {

/// Bench file key of bench_numbers_of().
const char* bench_key(CalibrationPart part)
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

std::string record_key(CalibrationPart part)
{
  return std::string(is_once_a_bench(part) ? "per_bench." : "per_person.") + name_of(part);
}

/// Whether the stored rows depend on the bench numbers: stage samples are stored in mm.
bool is_scaled_by_bench(CalibrationPart part)
{
  return part == CalibrationPart::bullseye;
}

void require_numbers(const CalibrationRecord& record, CalibrationPart part, const BenchFile& bench,
                     const std::string& path)
{
  const std::vector<double> now = bench_numbers_of(part, bench);
  const std::vector<double>& then = record.made_with;
  // Files without these values are accepted.
  if (record.marks.empty() || then.empty() || then == now) return;
  const auto differ = std::mismatch(then.begin(), then.end(), now.begin(), now.end());
  const auto text = [](const std::vector<double>& list, std::vector<double>::const_iterator at) {
    return at == list.end() ? "nothing" : number_text(*at);
  };
  const std::string key = bench_key(part);
  const std::string solve_remedy =
      is_scaled_by_bench(part) ? "" : "; if the old values were wrong, run calibrate solve";
  throw InputError({path, record_key(part),
                    "marks made with " + text(then, differ.first) + " in " + key + ", which now has " +
                        text(now, differ.second),
                    "the values of " + bench.path + "; restore them or repeat " + name_of(part) +
                        " with --anew" + solve_remedy});
}

bool is_kept(CalibrationPart part, const Calibration& begun)
{
  const auto record = begun.records.find(part);
  return record != begun.records.end() && !record->second.is_outdated;
}

/// Checks a part and its dependencies. Outdated parts are repeated, so their old marks are not checked.
void require_plan_of_all(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                         const std::string& path)
{
  if (is_kept(part, begun)) require_of_plan(part, bench, begun, path);
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
  require_of_tasks(record, tasks_of(part, bench, begun), record_key(part), path);
  require_numbers(record, part, bench, path);
}

void take_numbers(CalibrationRecord& record, CalibrationPart part, const BenchFile& bench)
{
  if (!record.made_with.empty() && !is_scaled_by_bench(part))
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
           std::string(name_of(below)) + " done first, because " + name_of(part) + " depends on it"});
    }
    require_plan_of_all(part, bench, begun, path);
    if (is_all_done && !is_done(begun, part)) require_earlier_marks(part, bench, begun, path);
  }
}

}  // namespace vrda
