#include "calibration/parts.hpp"

#include <algorithm>
#include <map>

#include "bench/calibration_file.hpp"
#include "calibration/marks.hpp"
#include "calibration/solve_part.hpp"
#include "calibration/task.hpp"
#include "core/text.hpp"
#include "show/session.hpp"

namespace vrda::calibration {
namespace {

bool is_part_of(CalibrationPart part, const BenchFile& bench)
{
  using enum CalibrationPart;
  const bool is_on_stage = bench.head == bench::HeadKind::stage;
  const bool is_rigid = bench.leg == bench::LegKind::rigid;
  const std::map<CalibrationPart, bool> conditions{
      {rails, is_on_stage},     {bullseye, is_on_stage},
      {stop, has_stage(bench)}, {probe, !bench.calibration.is_model_adjusted},
      {head, !is_on_stage},     {subject, !bench.calibration.landmarks.empty()},
      {leg, is_rigid},          {femur, !is_rigid},
      {tibia, !is_rigid},       {functional, !is_rigid}};
  const auto condition = conditions.find(part);
  return condition == conditions.end() || condition->second;
}

/// Possible dependencies, including parts that the bench does not have.
std::vector<CalibrationPart> possible_dependencies(CalibrationPart part, const BenchFile& bench)
{
  using enum CalibrationPart;
  if (is_model_part(part)) {
    // Adjustment by eye depends on the whole optical calibration.
    if (bench.calibration.is_model_adjusted) return {subject, bullseye, head};
    return {probe, subject};
  }
  static const std::map<CalibrationPart, std::vector<CalibrationPart>> below{
      {distortion, {viewport}}, {eyepoints, {distortion}},
      {ipd, {eyepoints}},       {bullseye, {rails, stop, eyepoints, ipd}},
      {head, {eyepoints, ipd}}, {functional, {femur, tibia}}};
  const auto found = below.find(part);
  return found == below.end() ? std::vector<CalibrationPart>{} : found->second;
}

/// Bench file key of bench_numbers_of().
const char* bench_key(CalibrationPart part)
{
  if (part == CalibrationPart::eyepoints) return "calibration.rectangles";
  if (part == CalibrationPart::subject) return "calibration.landmarks";
  if (part == CalibrationPart::bullseye) return "board.stage_mm_per_count";
  if (part == CalibrationPart::functional) return "the motion of --model";
  return part == CalibrationPart::tibia ? "calibration.tibia_point" : "calibration.point";
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
  for (const CalibrationPart part : parts)
    text += (text.empty() ? "" : ", ") + std::string(bench::name_of(part));
  return text;
}

bool is_optional(CalibrationPart part)
{
  return part == CalibrationPart::functional;
}

bool is_model_part(CalibrationPart part)
{
  return part == CalibrationPart::leg || part == CalibrationPart::femur || part == CalibrationPart::tibia;
}

bool has_stage(const BenchFile& bench)
{
  return bench.head == bench::HeadKind::stage && bench.board && bench.board->has_stage;
}

std::vector<CalibrationPart> parts_of(const BenchFile& bench)
{
  std::vector<CalibrationPart> parts;
  for (std::size_t k = 0; k < bench::n_calibration_parts; ++k) {
    const auto part = static_cast<CalibrationPart>(k);
    if (is_part_of(part, bench)) parts.push_back(part);
  }
  return parts;
}

std::vector<CalibrationPart> dependencies_of(CalibrationPart part, const BenchFile& bench)
{
  std::vector<CalibrationPart> parts = possible_dependencies(part, bench);
  std::erase_if(parts, [&](CalibrationPart p) { return !is_part_of(p, bench); });
  return parts;
}

bool is_done(const Calibration& calibration, CalibrationPart part)
{
  const CalibrationRecord* record = find_record(calibration, part);
  return record != nullptr && record->estimate && !record->is_outdated;
}

void outdate_dependents(Calibration& calibration, CalibrationPart part, const BenchFile& bench)
{
  for (const CalibrationPart later : parts_of(bench)) {
    const std::vector<CalibrationPart> below = dependencies_of(later, bench);
    if (std::ranges::find(below, part) == below.end()) continue;
    const auto record = calibration.records.find(later);
    if (record != calibration.records.end()) record->second.is_outdated = true;
    outdate_dependents(calibration, later, bench);
  }
}

std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench)
{
  std::vector<CalibrationPart> wanted;
  if (step == "all") {
    wanted = parts_of(bench);
    std::erase_if(wanted, is_optional);
    return wanted;
  }
  for (std::size_t k = 0; k < bench::n_calibration_parts; ++k) {
    const auto part = static_cast<CalibrationPart>(k);
    const bool is_tracking = part == CalibrationPart::rails || part == CalibrationPart::stop ||
                             part == CalibrationPart::probe || part == CalibrationPart::bullseye ||
                             is_model_part(part);
    const bool is_group = !is_optional(part) && ((step == "tracking" && is_tracking) ||
                                                 (step == "bench" && bench::is_per_bench(part)) ||
                                                 (step == "person" && !bench::is_per_bench(part)));
    if (step == bench::name_of(part) || is_group) wanted.push_back(part);
  }
  if (wanted.empty())
    throw InputError({"calibrate", "STEP", "'" + step + "'", "one of " + step_names(bench)});
  if (wanted.size() == 1 && !is_part_of(wanted.front(), bench)) {
    require_bench_data(wanted.front(), bench);
    throw InputError({"calibrate", "STEP", "'" + step + "', which does not apply to " + bench.path,
                      "one of " + step_names(bench)});
  }
  std::erase_if(wanted, [&](CalibrationPart part) { return !is_part_of(part, bench); });
  return wanted;
}

void require_bench_data(CalibrationPart part, const BenchFile& bench)
{
  const CalibrationSettings& settings = bench.calibration;
  const auto refuse = [&](const std::string& key, const std::string& found, const std::string& wanted) {
    throw InputError({bench.path, key, found, wanted + ", for " + bench::name_of(part)});
  };
  if (!settings.is_present) refuse("calibration", "nothing", "a table [calibration]");
  constexpr std::size_t least_distances = 3, least_fiducials = 4;
  if (part == CalibrationPart::subject && settings.landmarks.size() < least_distances) {
    refuse("calibration.landmarks", std::to_string(settings.landmarks.size()) + " distances",
           "three or more distances between landmarks");
  }
  if (!is_model_part(part) || settings.is_model_adjusted) return;
  const std::vector<CalibrationPoint>& points = points_of(part, settings);
  const auto n =
      std::ranges::count_if(points, [](const CalibrationPoint& point) { return !point.is_target; });
  if (n < static_cast<std::ptrdiff_t>(least_fiducials))
    refuse(bench_key(part), std::to_string(n) + " points that are not targets", "four or more, not coplanar");
}

BodyRole role_of(CalibrationPart part)
{
  check(is_model_part(part), "only model parts have a body");
  if (part == CalibrationPart::leg) return BodyRole::leg;
  return part == CalibrationPart::femur ? BodyRole::femur : BodyRole::tibia;
}

const std::vector<CalibrationPoint>& points_of(CalibrationPart part, const CalibrationSettings& settings)
{
  return part == CalibrationPart::tibia ? settings.tibia_points : settings.points;
}

namespace {

bench::CalibrationRecords bench_records(const Calibration& calibration)
{
  bench::CalibrationRecords records;
  for (const auto& [part, record] : calibration.records) {
    if (bench::is_per_bench(part)) records[part] = record;
  }
  return records;
}

}  // namespace

Calibration start_calibration_from(const Calibration& other, const BenchFile& bench,
                                   const std::string& other_path)
{
  for (const CalibrationPart part : parts_of_step("bench", bench)) {
    if (is_done(other, part)) continue;
    throw InputError({other_path, bench::record_key(part),
                      other.records.contains(part) ? "a part that must be repeated" : "nothing",
                      "all per-bench parts done; run vrda-player calibrate bench"});
  }
  Calibration begun = bench::nominal_calibration(bench);
  begun.records = bench_records(other);
  // The eyes of `other` include its person's bull's-eye fit, so they are rebuilt from the per-bench parts.
  begun.eyes = eyes_before(CalibrationPart::eyepoints, {bench, begun, other_path});
  begun.X_tracker_table = other.X_tracker_table;
  begun.stage_direction_table = other.stage_direction_table;
  return begun;
}

void require_same_bench_parts(const Calibration& begun, const std::string& path, const Calibration& other,
                              const std::string& other_path)
{
  if (bench::records_text(bench_records(begun)) == bench::records_text(bench_records(other))) return;
  throw InputError({path, "per_bench", "per-bench parts that differ from those of " + other_path,
                    "a new file, or one that was started from " + other_path});
}

namespace {

/// Whether the stored rows depend on the bench numbers: stage samples are stored in mm.
bool is_scaled_by_bench(CalibrationPart part)
{
  return part == CalibrationPart::bullseye;
}

void require_numbers(const CalibrationRecord& record, CalibrationPart part, const PartInput& in)
{
  const bool is_functional = part == CalibrationPart::functional;
  // Without a model at hand its record keeps its motion.
  if (is_functional && in.joint == nullptr) return;
  const std::vector<double> now =
      is_functional ? calibration::numbers_of(*in.joint) : bench_numbers_of(part, in.bench);
  const std::vector<double>& then = record.made_with;
  // Files without these values are accepted.
  if (record.marks.empty() || then.empty() || then == now) return;
  const auto differ = std::mismatch(then.begin(), then.end(), now.begin(), now.end());
  const auto text = [](const std::vector<double>& list, std::vector<double>::const_iterator at) {
    return at == list.end() ? "nothing" : show::number_text(*at);
  };
  const std::string key = bench_key(part);
  const std::string solve_remedy =
      is_scaled_by_bench(part) || is_functional ? "" : "; if the old values were wrong, run calibrate solve";
  const std::string restore = is_functional
                                  ? "the model and set with which the part was begun; use them or repeat "
                                  : "the values of " + in.bench.path + "; restore them or repeat ";
  throw InputError({in.path, bench::record_key(part),
                    "marks made with " + text(then, differ.first) + " in " + key + ", which now has " +
                        text(now, differ.second),
                    restore + bench::name_of(part) + " with --anew" + solve_remedy});
}

/// Checks a part and its dependencies. Outdated parts are repeated, so their old marks are not checked.
void require_plan_of_all(CalibrationPart part, const PartInput& in)
{
  const CalibrationRecord* record = find_record(in.begun, part);
  if (record != nullptr && !record->is_outdated) require_current_record(part, in);
  for (const CalibrationPart below : dependencies_of(part, in.bench)) require_plan_of_all(below, in);
}

}  // namespace

std::vector<double> bench_numbers_of(CalibrationPart part, const BenchFile& bench)
{
  const CalibrationSettings& settings = bench.calibration;
  std::vector<double> numbers;
  if (part == CalibrationPart::eyepoints) {
    for (const CalibrationRectangle& r : settings.rectangles)
      numbers.insert(numbers.end(), {r.width_mm, r.depth_mm});
  } else if (part == CalibrationPart::subject) {
    for (const CalibrationLandmarks& pair : settings.landmarks) numbers.push_back(pair.model_mm);
  } else if (part == CalibrationPart::bullseye && has_stage(bench)) {
    numbers.push_back(bench.stage_mm_per_count);
  } else if (is_model_part(part) && !settings.is_model_adjusted) {
    for (const CalibrationPoint& point : points_of(part, settings)) {
      const Eigen::Vector3d& p = point.p_model_mm;
      numbers.insert(numbers.end(), {p.x(), p.y(), p.z(), point.is_target ? 1.0 : 0.0});
    }
  }
  return numbers;
}

void require_current_record(CalibrationPart part, const PartInput& in)
{
  const CalibrationRecord& record = in.begun.records.at(part);
  require_task_marks(record, tasks_of(part, in.bench, in.begun), bench::record_key(part), in.path);
  require_numbers(record, part, in);
}

void update_made_with(CalibrationRecord& record, CalibrationPart part, const BenchFile& bench)
{
  if (!record.made_with.empty() && !is_scaled_by_bench(part) && part != CalibrationPart::functional)
    record.made_with = bench_numbers_of(part, bench);
}

void require_ready_parts(const std::vector<CalibrationPart>& parts, const PartInput& in)
{
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const CalibrationPart part = parts[k];
    require_bench_data(part, in.bench);
    if (part == CalibrationPart::functional && in.joint == nullptr) {
      throw InputError(
          {"calibrate", "--model", "nothing", "the motion model that functional places in thigh and shank"});
    }
    bool is_all_done = true;
    for (const CalibrationPart below : dependencies_of(part, in.bench)) {
      if (is_done(in.begun, below)) continue;
      is_all_done = false;
      const auto so_far = parts.begin() + static_cast<std::ptrdiff_t>(k);
      if (std::find(parts.begin(), so_far, below) != so_far) continue;
      const CalibrationRecord* record = find_record(in.begun, below);
      const bool was_done = record != nullptr && record->is_outdated;
      throw InputError(
          {in.path, bench::name_of(part),
           std::string(bench::name_of(below)) + (was_done ? ", which is outdated" : ", which is not done"),
           std::string(bench::name_of(below)) + " done first, because " + bench::name_of(part) +
               " depends on it"});
    }
    require_plan_of_all(part, in);
    if (is_all_done && !is_done(in.begun, part)) require_earlier_fits(part, in);
  }
}

}  // namespace vrda::calibration
