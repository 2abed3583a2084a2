#include "calibration_tasks/parts.hpp"

#include <algorithm>

#include "bench_files/record_text.hpp"
#include "calibration_tasks/marks.hpp"
#include "calibration_tasks/solve_part.hpp"
#include "calibration_tasks/task.hpp"
#include "core/error.hpp"
#include "settings/settings_text.hpp"

namespace vrda::calibration_tasks {
namespace {

bool is_part_of(bench_files::CalibrationPart part, const bench_files::BenchFile& bench)
{
  const bool is_on_stage = bench.head == bench_files::HeadKind::stage;
  const bool is_touched = !bench.calibration.is_model_adjusted;
  switch (part) {
    case bench_files::CalibrationPart::rails:
    case bench_files::CalibrationPart::bullseye:
      return is_on_stage;
    case bench_files::CalibrationPart::stop:
      return has_stage(bench);
    case bench_files::CalibrationPart::probe:
      return is_touched;
    case bench_files::CalibrationPart::head:
      return !is_on_stage;
    case bench_files::CalibrationPart::subject:
      return !bench.calibration.landmarks.empty();
    case bench_files::CalibrationPart::leg:
      return bench.leg == bench_files::LegKind::rigid;
    case bench_files::CalibrationPart::femur:
    case bench_files::CalibrationPart::tibia:
      return bench.leg == bench_files::LegKind::two_bodies;
    default:
      return true;
  }
}

/// Possible dependencies, including parts that the bench does not have.
std::vector<bench_files::CalibrationPart> possible_dependencies(bench_files::CalibrationPart part,
                                                                const bench_files::BenchFile& bench)
{
  switch (part) {
    case bench_files::CalibrationPart::distortion:
      return {bench_files::CalibrationPart::viewport};
    case bench_files::CalibrationPart::eyepoints:
      return {bench_files::CalibrationPart::distortion};
    case bench_files::CalibrationPart::ipd:
      return {bench_files::CalibrationPart::eyepoints};
    case bench_files::CalibrationPart::bullseye:
      return {bench_files::CalibrationPart::rails, bench_files::CalibrationPart::stop,
              bench_files::CalibrationPart::eyepoints, bench_files::CalibrationPart::ipd};
    case bench_files::CalibrationPart::head:
      return {bench_files::CalibrationPart::eyepoints, bench_files::CalibrationPart::ipd};
    case bench_files::CalibrationPart::leg:
    case bench_files::CalibrationPart::femur:
    case bench_files::CalibrationPart::tibia:
      // Adjustment by eye depends on the whole optical calibration.
      if (bench.calibration.is_model_adjusted)
        return {bench_files::CalibrationPart::subject, bench_files::CalibrationPart::bullseye,
                bench_files::CalibrationPart::head};
      return {bench_files::CalibrationPart::probe, bench_files::CalibrationPart::subject};
    default:
      return {};
  }
}

/// All valid steps of the bench, for a message.
std::string step_names(const bench_files::BenchFile& bench)
{
  return "all, bench, person, tracking, status, solve, " + names_of(parts_of(bench));
}

}  // namespace

std::string names_of(std::span<const bench_files::CalibrationPart> parts)
{
  std::string text;
  for (const bench_files::CalibrationPart part : parts)
    text += (text.empty() ? "" : ", ") + std::string(bench_files::name_of(part));
  return text;
}

bool is_model_part(bench_files::CalibrationPart part)
{
  return part == bench_files::CalibrationPart::leg || part == bench_files::CalibrationPart::femur ||
         part == bench_files::CalibrationPart::tibia;
}

bool has_stage(const bench_files::BenchFile& bench)
{
  return bench.head == bench_files::HeadKind::stage && bench.board && bench.board->has_stage;
}

std::vector<bench_files::CalibrationPart> parts_of(const bench_files::BenchFile& bench)
{
  std::vector<bench_files::CalibrationPart> parts;
  for (std::size_t k = 0; k < bench_files::n_calibration_parts; ++k) {
    if (is_part_of(static_cast<bench_files::CalibrationPart>(k), bench))
      parts.push_back(static_cast<bench_files::CalibrationPart>(k));
  }
  return parts;
}

std::vector<bench_files::CalibrationPart> dependencies_of(bench_files::CalibrationPart part,
                                                          const bench_files::BenchFile& bench)
{
  std::vector<bench_files::CalibrationPart> parts = possible_dependencies(part, bench);
  std::erase_if(parts, [&](bench_files::CalibrationPart p) { return !is_part_of(p, bench); });
  return parts;
}

bool is_done(const bench_files::Calibration& calibration, bench_files::CalibrationPart part)
{
  const auto found = calibration.records.find(part);
  return found != calibration.records.end() && found->second.estimate && !found->second.is_outdated;
}

void outdate_dependents(bench_files::Calibration& calibration, bench_files::CalibrationPart part,
                        const bench_files::BenchFile& bench)
{
  for (const bench_files::CalibrationPart later : parts_of(bench)) {
    const std::vector<bench_files::CalibrationPart> below = dependencies_of(later, bench);
    if (std::find(below.begin(), below.end(), part) == below.end()) continue;
    const auto record = calibration.records.find(later);
    if (record != calibration.records.end()) record->second.is_outdated = true;
    outdate_dependents(calibration, later, bench);
  }
}

std::vector<bench_files::CalibrationPart> parts_of_step(const std::string& step,
                                                        const bench_files::BenchFile& bench)
{
  const std::vector<bench_files::CalibrationPart> all = parts_of(bench);
  if (step == "all") return all;
  std::vector<bench_files::CalibrationPart> wanted;
  for (std::size_t k = 0; k < bench_files::n_calibration_parts; ++k) {
    const auto part = static_cast<bench_files::CalibrationPart>(k);
    const bool is_tracking = part == bench_files::CalibrationPart::rails ||
                             part == bench_files::CalibrationPart::stop ||
                             part == bench_files::CalibrationPart::probe ||
                             part == bench_files::CalibrationPart::bullseye || is_model_part(part);
    const bool is_group = (step == "tracking" && is_tracking) ||
                          (step == "bench" && bench_files::is_per_bench(part)) ||
                          (step == "person" && !bench_files::is_per_bench(part));
    if (step == bench_files::name_of(part) || is_group) wanted.push_back(part);
  }
  if (wanted.empty())
    throw InputError({"calibrate", "STEP", "'" + step + "'", "one of " + step_names(bench)});
  if (wanted.size() == 1 && !is_part_of(wanted.front(), bench)) {
    require_bench_data(wanted.front(), bench);
    throw InputError({"calibrate", "STEP", "'" + step + "', which does not apply to " + bench.path,
                      "one of " + step_names(bench)});
  }
  std::erase_if(wanted, [&](bench_files::CalibrationPart part) { return !is_part_of(part, bench); });
  return wanted;
}

void require_bench_data(bench_files::CalibrationPart part, const bench_files::BenchFile& bench)
{
  const bench_files::CalibrationSettings& settings = bench.calibration;
  const auto refuse = [&](const std::string& key, const std::string& found, const std::string& wanted) {
    throw InputError({bench.path, key, found, wanted + ", for " + bench_files::name_of(part)});
  };
  if (!settings.is_present) refuse("calibration", "nothing", "a table [calibration]");
  constexpr std::size_t least_distances = 3, least_fiducials = 4;
  if (part == bench_files::CalibrationPart::subject && settings.landmarks.size() < least_distances) {
    refuse("calibration.landmarks", std::to_string(settings.landmarks.size()) + " distances",
           "three or more distances between landmarks");
  }
  if (!is_model_part(part) || settings.is_model_adjusted) return;
  const std::vector<bench_files::CalibrationPoint>& points = points_of(part, settings);
  const auto n = std::count_if(points.begin(), points.end(),
                               [](const bench_files::CalibrationPoint& point) { return !point.is_target; });
  if (n < static_cast<std::ptrdiff_t>(least_fiducials)) {
    refuse(part == bench_files::CalibrationPart::tibia ? "calibration.tibia_point" : "calibration.point",
           std::to_string(n) + " points that are not targets", "four or more, not coplanar");
  }
}

bench_files::BodyRole role_of(bench_files::CalibrationPart part)
{
  check(is_model_part(part), "only model parts have a body");
  return part == bench_files::CalibrationPart::leg
             ? bench_files::BodyRole::leg
             : (part == bench_files::CalibrationPart::femur ? bench_files::BodyRole::femur
                                                            : bench_files::BodyRole::tibia);
}

const std::vector<bench_files::CalibrationPoint>& points_of(bench_files::CalibrationPart part,
                                                            const bench_files::CalibrationSettings& settings)
{
  return part == bench_files::CalibrationPart::tibia ? settings.tibia_points : settings.points;
}

namespace {

bench_files::CalibrationRecords bench_records(const bench_files::Calibration& calibration)
{
  bench_files::CalibrationRecords records;
  for (const auto& [part, record] : calibration.records) {
    if (bench_files::is_per_bench(part)) records[part] = record;
  }
  return records;
}

}  // namespace

bench_files::Calibration start_calibration_from(const bench_files::Calibration& other,
                                                const bench_files::BenchFile& bench,
                                                const std::string& other_path)
{
  for (const bench_files::CalibrationPart part : parts_of_step("bench", bench)) {
    if (is_done(other, part)) continue;
    throw InputError({other_path, std::string("per_bench.") + bench_files::name_of(part),
                      other.records.contains(part) ? "a part that must be repeated" : "nothing",
                      "all per-bench parts done; run vrda-player calibrate bench"});
  }
  bench_files::Calibration begun = bench_files::nominal_calibration(bench);
  begun.records = bench_records(other);
  // The eyes of `other` include its person's bull's-eye fit, so they are rebuilt from the per-bench parts.
  begun.eyes = eyes_before(bench_files::CalibrationPart::eyepoints, bench, begun);
  begun.X_tracker_table = other.X_tracker_table;
  begun.stage_direction_table = other.stage_direction_table;
  return begun;
}

void require_same_bench_parts(const bench_files::Calibration& begun, const std::string& path,
                              const bench_files::Calibration& other, const std::string& other_path)
{
  if (bench_files::records_text(bench_records(begun)) == bench_files::records_text(bench_records(other)))
    return;
  throw InputError({path, "per_bench", "per-bench parts that differ from those of " + other_path,
                    "a new file, or one that was started from " + other_path});
}

namespace {

/// Bench file key of bench_numbers_of().
const char* bench_key(bench_files::CalibrationPart part)
{
  switch (part) {
    case bench_files::CalibrationPart::eyepoints:
      return "calibration.rectangles";
    case bench_files::CalibrationPart::subject:
      return "calibration.landmarks";
    case bench_files::CalibrationPart::tibia:
      return "calibration.tibia_point";
    case bench_files::CalibrationPart::bullseye:
      return "board.stage_mm_per_count";
    default:
      return "calibration.point";
  }
}

std::string record_key(bench_files::CalibrationPart part)
{
  return std::string(bench_files::is_per_bench(part) ? "per_bench." : "per_person.") +
         bench_files::name_of(part);
}

/// Whether the stored rows depend on the bench numbers: stage samples are stored in mm.
bool is_scaled_by_bench(bench_files::CalibrationPart part)
{
  return part == bench_files::CalibrationPart::bullseye;
}

void require_numbers(const bench_files::CalibrationRecord& record, bench_files::CalibrationPart part,
                     const bench_files::BenchFile& bench, const std::string& path)
{
  const std::vector<double> now = bench_numbers_of(part, bench);
  const std::vector<double>& then = record.made_with;
  // Files without these values are accepted.
  if (record.marks.empty() || then.empty() || then == now) return;
  const auto differ = std::mismatch(then.begin(), then.end(), now.begin(), now.end());
  const auto text = [](const std::vector<double>& list, std::vector<double>::const_iterator at) {
    return at == list.end() ? "nothing" : settings::number_text(*at);
  };
  const std::string key = bench_key(part);
  const std::string solve_remedy =
      is_scaled_by_bench(part) ? "" : "; if the old values were wrong, run calibrate solve";
  throw InputError({path, record_key(part),
                    "marks made with " + text(then, differ.first) + " in " + key + ", which now has " +
                        text(now, differ.second),
                    "the values of " + bench.path + "; restore them or repeat " + bench_files::name_of(part) +
                        " with --anew" + solve_remedy});
}

bool is_kept(bench_files::CalibrationPart part, const bench_files::Calibration& begun)
{
  const auto record = begun.records.find(part);
  return record != begun.records.end() && !record->second.is_outdated;
}

/// Checks a part and its dependencies. Outdated parts are repeated, so their old marks are not checked.
void require_plan_of_all(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                         const bench_files::Calibration& begun, const std::string& path)
{
  if (is_kept(part, begun)) require_current_record(part, bench, begun, path);
  for (const bench_files::CalibrationPart below : dependencies_of(part, bench))
    require_plan_of_all(below, bench, begun, path);
}

}  // namespace

std::vector<double> bench_numbers_of(bench_files::CalibrationPart part, const bench_files::BenchFile& bench)
{
  const bench_files::CalibrationSettings& settings = bench.calibration;
  std::vector<double> numbers;
  switch (part) {
    case bench_files::CalibrationPart::eyepoints:
      for (const bench_files::CalibrationRectangle& r : settings.rectangles)
        numbers.insert(numbers.end(), {r.width_mm, r.depth_mm});
      return numbers;
    case bench_files::CalibrationPart::subject:
      for (const bench_files::CalibrationLandmarks& pair : settings.landmarks)
        numbers.push_back(pair.model_mm);
      return numbers;
    case bench_files::CalibrationPart::bullseye:
      if (has_stage(bench)) numbers.push_back(bench.stage_mm_per_count);
      return numbers;
    case bench_files::CalibrationPart::leg:
    case bench_files::CalibrationPart::femur:
    case bench_files::CalibrationPart::tibia:
      if (settings.is_model_adjusted) return {};
      for (const bench_files::CalibrationPoint& point : points_of(part, settings)) {
        const Eigen::Vector3d& p = point.p_model_mm;
        numbers.insert(numbers.end(), {p.x(), p.y(), p.z(), point.is_target ? 1.0 : 0.0});
      }
      return numbers;
    default:
      return numbers;
  }
}

void require_current_record(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                            const bench_files::Calibration& begun, const std::string& path)
{
  const bench_files::CalibrationRecord& record = begun.records.at(part);
  require_task_marks(record, tasks_of(part, bench, begun), record_key(part), path);
  require_numbers(record, part, bench, path);
}

void update_made_with(bench_files::CalibrationRecord& record, bench_files::CalibrationPart part,
                      const bench_files::BenchFile& bench)
{
  if (!record.made_with.empty() && !is_scaled_by_bench(part))
    record.made_with = bench_numbers_of(part, bench);
}

void require_ready_parts(const std::vector<bench_files::CalibrationPart>& parts,
                         const bench_files::BenchFile& bench, const bench_files::Calibration& begun,
                         const std::string& path)
{
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const bench_files::CalibrationPart part = parts[k];
    require_bench_data(part, bench);
    bool is_all_done = true;
    for (const bench_files::CalibrationPart below : dependencies_of(part, bench)) {
      if (is_done(begun, below)) continue;
      is_all_done = false;
      const auto so_far = parts.begin() + static_cast<std::ptrdiff_t>(k);
      if (std::find(parts.begin(), so_far, below) != so_far) continue;
      const bool was_done = begun.records.contains(below) && begun.records.at(below).is_outdated;
      throw InputError({path, bench_files::name_of(part),
                        std::string(bench_files::name_of(below)) +
                            (was_done ? ", which is outdated" : ", which is not done"),
                        std::string(bench_files::name_of(below)) + " done first, because " +
                            bench_files::name_of(part) + " depends on it"});
    }
    require_plan_of_all(part, bench, begun, path);
    if (is_all_done && !is_done(begun, part)) require_earlier_fits(part, bench, begun, path);
  }
}

}  // namespace vrda::calibration_tasks
