#include "calibration/parts.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/marks.hpp"
#include "calibration/virtual_bench.hpp"
#include "core/text.hpp"
#include "show/session.hpp"
#include "view/eye.hpp"

namespace vrda::calibration {

extern const Part& viewport_part;
extern const Part& distortion_part;
extern const Part& rails_part;
extern const Part& stop_part;
extern const Part& probe_part;
extern const Part& eyepoints_part;
extern const Part& ipd_part;
extern const Part& subject_part;
extern const Part& bullseye_part;
extern const Part& head_part;
extern const Part& leg_part;
extern const Part& femur_part;
extern const Part& tibia_part;
extern const Part& functional_part;

const Part& part_object(CalibrationPart id)
{
  // In the order of CalibrationPart, which is that of execution.
  static const std::array<const Part*, bench::n_calibration_parts> parts{
      &viewport_part,  &distortion_part, &rails_part,   &stop_part,      &probe_part,
      &eyepoints_part, &ipd_part,        &subject_part, &bullseye_part,  &head_part,
      &leg_part,       &femur_part,      &tibia_part,   &functional_part};
  return *parts.at(static_cast<std::size_t>(id));
}

// Defaults of the objects.

DrawnLines TaskKind::draw(const Task&, std::span<const double>, const Calibration&) const
{
  return {};
}

DrawnLines TaskKind::draw_simulated(const Task& task, std::span<const double> values,
                                    const Calibration& found, const BenchFile&, const VirtualTruth&) const
{
  return draw(task, values, found);
}

std::vector<double> TaskKind::mark_row(const Task&, std::span<const double> values, const Calibration&) const
{
  return {values.begin(), values.end()};
}

std::vector<double> TaskKind::aligned_values(const TaskContext&) const
{
  return {};
}

Deviation TaskKind::deviation(const TaskContext& context, std::span<const double> values) const
{
  const std::vector<double> wanted = aligned_values(context);
  double value = 0.0;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const double off = std::abs(values[k] - wanted[k]);
    value = traits_.is_cross ? std::hypot(value, off) : std::max(value, off);
  }
  return {value, context.task.dials.front().unit};
}

DrawnLines TaskKind::outlines(const Task&, const BenchFile&, const VirtualTruth&) const
{
  return {};
}

BenchPoses TaskKind::poses(const TaskContext& context, double) const
{
  return resting_poses(context.truth);
}

std::vector<CalibrationPart> Part::below(const BenchFile&) const
{
  std::vector<CalibrationPart> parts;
  for (const std::optional<CalibrationPart>& each : traits_.below)
    if (each) parts.push_back(*each);
  return parts;
}

std::string Part::restore_text(const BenchFile& bench) const
{
  return "the values of " + bench.path + "; restore them or repeat ";
}

void Part::refuse_bench(const BenchFile& bench, const std::string& found, const std::string& wanted) const
{
  throw InputError({bench.path, traits_.bench_key, found, wanted + ", for " + name()});
}

void EyePart::solve(const PartInput& in, Calibration& c) const
{
  Estimate estimate;
  for (const bool is_right : {false, true}) bench::append(estimate, solve_eye(in, is_right));
  apply(c.eyes, estimate);
  c.records.at(id()).estimate = std::move(estimate);
}

std::vector<std::string> EyePart::remarks(const Task& done, const PartInput& in) const
{
  return solve_eye(in, done.is_right).remarks;
}

const char* side_name(bool is_right)
{
  return is_right ? "right" : "left";
}

std::string eye_text(bool is_right)
{
  return side_name(is_right) + std::string(" eye");
}

Dial dial(std::string name, const char* unit, double value, double least, double most, double step)
{
  return {
      .name = std::move(name), .unit = unit, .value = value, .minimum = least, .maximum = most, .step = step};
}

Dial within(Dial dial, double least_plausible, double most_plausible)
{
  dial.least_plausible = least_plausible;
  dial.most_plausible = most_plausible;
  return dial;
}

// Steps and their order.

namespace {

/// Those parts, in order, of which `condition` holds.
template <typename Condition>
std::vector<CalibrationPart> parts_where(Condition condition)
{
  std::vector<CalibrationPart> parts;
  for (std::size_t k = 0; k < bench::n_calibration_parts; ++k) {
    const auto id = static_cast<CalibrationPart>(k);
    if (condition(part_object(id))) parts.push_back(id);
  }
  return parts;
}

/// All valid steps of the bench, for a message.
std::string step_names(const BenchFile& bench)
{
  return "all, bench, person, tracking, status, solve, " + names_of(parts_of(bench));
}

bench::CalibrationRecords bench_records(const Calibration& calibration)
{
  bench::CalibrationRecords records;
  for (const auto& [part, record] : calibration.records) {
    if (bench::is_per_bench(part)) records[part] = record;
  }
  return records;
}

}  // namespace

std::vector<Task> tasks_of(CalibrationPart id, const BenchFile& bench, const Calibration& calibration)
{
  return part_object(id).tasks(bench, calibration);
}

TaskGroup task_group_of(CalibrationPart id, const std::vector<Task>& tasks, std::size_t task)
{
  const Part::Group group = part_object(id).traits().group;
  const auto is_same = [&](std::size_t k) {
    if (group == Part::Group::eye) return tasks[k].is_right == tasks[task].is_right;
    return group == Part::Group::part || k == task;
  };
  TaskGroup round{0, tasks.size()};
  while (!is_same(round.begin)) ++round.begin;
  while (!is_same(round.end - 1)) --round.end;
  return round;
}

std::string names_of(std::span<const CalibrationPart> parts)
{
  std::vector<std::string> names;
  for (const CalibrationPart id : parts) names.emplace_back(bench::name_of(id));
  return joined(names);
}

bool has_stage(const BenchFile& bench)
{
  return bench.head == HeadKind::stage && bench.board && bench.board->has_stage;
}

bool is_model_part(CalibrationPart id)
{
  return id == CalibrationPart::leg || id == CalibrationPart::femur || id == CalibrationPart::tibia;
}

BodyRole role_of(CalibrationPart part)
{
  check(is_model_part(part), "only model parts have a body");
  if (part == CalibrationPart::leg) return BodyRole::leg;
  return part == CalibrationPart::femur ? BodyRole::femur : BodyRole::tibia;
}

const std::vector<CalibrationPoint>& points_of(BodyRole role, const CalibrationSettings& settings)
{
  return role == BodyRole::tibia ? settings.tibia_points : settings.points;
}

std::vector<CalibrationPart> parts_of(const BenchFile& bench)
{
  return parts_where([&](const Part& each) { return each.applies_to(bench); });
}

std::vector<CalibrationPart> dependencies_of(CalibrationPart id, const BenchFile& bench)
{
  std::vector<CalibrationPart> parts = part_object(id).below(bench);
  std::erase_if(parts, [&](CalibrationPart p) { return !part_object(p).applies_to(bench); });
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
  const auto is_in_group = [&](const Part& each) {
    if (each.traits().is_optional) return false;
    const bool is_per_bench = bench::is_per_bench(each.id());
    return step == "all" || (step == "tracking" && each.traits().is_tracking) ||
           (step == "bench" && is_per_bench) || (step == "person" && !is_per_bench);
  };
  std::vector<CalibrationPart> wanted =
      parts_where([&](const Part& each) { return step == each.name() || is_in_group(each); });
  if (wanted.empty())
    throw InputError({"calibrate", "STEP", "'" + step + "'", "one of " + step_names(bench)});
  if (wanted.size() == 1 && !part_object(wanted.front()).applies_to(bench)) {
    require_bench_data(wanted.front(), bench);
    throw InputError({"calibrate", "STEP", "'" + step + "', which does not apply to " + bench.path,
                      "one of " + step_names(bench)});
  }
  std::erase_if(wanted, [&](CalibrationPart id) { return !part_object(id).applies_to(bench); });
  return wanted;
}

void require_bench_data(CalibrationPart id, const BenchFile& bench)
{
  if (!bench.calibration.is_present)
    throw InputError({bench.path, "calibration", "nothing",
                      std::string("a table [calibration], for ") + part_object(id).name()});
  part_object(id).require_bench_data(bench);
}

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

void require_numbers(const CalibrationRecord& record, const Part& of, const PartInput& in)
{
  const std::optional<std::vector<double>> known = of.made_with(in);
  if (!known) return;
  const std::vector<double>& now = *known;
  const std::vector<double>& then = record.made_with;
  // Files without these values are accepted.
  if (record.marks.empty() || then.empty() || then == now) return;
  const auto differ = std::mismatch(then.begin(), then.end(), now.begin(), now.end());
  const auto text = [](const std::vector<double>& list, std::vector<double>::const_iterator at) {
    return at == list.end() ? "nothing" : show::number_text(*at);
  };
  const std::string key = of.traits().bench_key;
  const std::string solve_remedy =
      of.traits().is_made_of_them ? "" : "; if the old values were wrong, run calibrate solve";
  throw InputError({in.path, bench::record_key(of.id()),
                    "marks made with " + text(then, differ.first) + " in " + key + ", which now has " +
                        text(now, differ.second),
                    of.restore_text(in.bench) + of.name() + " with --anew" + solve_remedy});
}

/// Throws InputError with the part if a mark belongs to no task, its rows do not match the task kind, or the
/// bench file had other values.
void require_current_record(const Part& of, const PartInput& in)
{
  const CalibrationRecord& record = in.begun.records.at(of.id());
  require_task_marks(record, of.tasks(in.bench, in.begun), bench::record_key(of.id()), in.path);
  require_numbers(record, of, in);
}

/// Checks a part and its dependencies. Outdated parts are repeated, so their old marks are not checked.
void require_plan_of_all(CalibrationPart id, const PartInput& in)
{
  const CalibrationRecord* record = find_record(in.begun, id);
  if (record != nullptr && !record->is_outdated) require_current_record(part_object(id), in);
  for (const CalibrationPart below : dependencies_of(id, in.bench)) require_plan_of_all(below, in);
}

/// Checks the fits of earlier marks that solving the part repeats.
void require_earlier_fits(const Part& of, const PartInput& in)
{
  if (!of.uses_rectangles(in.bench)) return;
  try {
    for (const bool is_right : {false, true}) solve_eye_rectangles(in, is_right);
  } catch (const PartRefusal& refusal) {
    const InputError::Facts& facts = refusal.facts();
    throw InputError(
        {facts.file, "per_person.eyepoints: " + facts.field, facts.found,
         facts.wanted + ". Repeat eyepoints with --anew, because " + of.name() + " depends on it"});
  }
}

}  // namespace

void require_ready_parts(const std::vector<CalibrationPart>& parts, const PartInput& in)
{
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const CalibrationPart id = parts[k];
    const Part& of = part_object(id);
    require_bench_data(id, in.bench);
    if (!of.made_with(in)) {
      throw InputError(
          {"calibrate", "--model", "nothing", "the motion model that functional places in thigh and shank"});
    }
    bool is_all_done = true;
    for (const CalibrationPart below : dependencies_of(id, in.bench)) {
      if (is_done(in.begun, below)) continue;
      is_all_done = false;
      const auto so_far = parts.begin() + static_cast<std::ptrdiff_t>(k);
      if (std::find(parts.begin(), so_far, below) != so_far) continue;
      const CalibrationRecord* record = find_record(in.begun, below);
      const bool was_done = record != nullptr && record->is_outdated;
      throw InputError(
          {in.path, of.name(),
           std::string(bench::name_of(below)) + (was_done ? ", which is outdated" : ", which is not done"),
           std::string(bench::name_of(below)) + " done first, because " + of.name() + " depends on it"});
    }
    require_plan_of_all(id, in);
    if (is_all_done && !is_done(in.begun, id)) require_earlier_fits(of, in);
  }
}

Calibration solve_part(CalibrationPart id, const PartInput& in)
{
  Calibration solved = in.begun;
  part_object(id).solve(in, solved);
  if (const std::optional<InputError::Facts> facts = view::usability_error(solved.eyes, in.path))
    throw PartRefusal(*facts);
  return solved;
}

Calibration solve_again(const BenchFile& bench, const Calibration& calibration, const std::string& path)
{
  Calibration solved = calibration;
  const PartInput in{bench, solved, path};
  const auto has_estimate = [&](CalibrationPart below) { return find_estimate(solved, below) != nullptr; };
  for (const CalibrationPart id : parts_of(bench)) {
    if (!solved.records.contains(id) || solved.records[id].marks.empty()) continue;
    CalibrationRecord& record = solved.records[id];
    // The marks belong to the bench file as it is now, unless their rows depend on it.
    if (!record.made_with.empty() && !part_object(id).traits().is_made_of_them)
      record.made_with = part_object(id).made_with(in).value();
    // Dependent parts also read the marks of an unsolved part.
    require_current_record(part_object(id), in);
    // A dependency without an estimate is being repeated.
    if (!std::ranges::all_of(dependencies_of(id, bench), has_estimate)) continue;
    const std::vector<Task> tasks = tasks_of(id, bench, solved);
    if (next_task(tasks, record) < tasks.size()) continue;
    solved = solve_part(id, in);
  }
  return solved;
}

std::vector<std::string> result_lines(CalibrationPart id, const Estimate& estimate)
{
  std::vector<std::string> lines{std::string(part_object(id).name()) + " is done:"};
  for (Eigen::Index k = 0; k < estimate.values.size(); ++k)
    lines.push_back(estimate.names[static_cast<std::size_t>(k)] + " " + bench::interval_text(estimate, k));
  if (!estimate.residuals.empty()) {
    lines.push_back("residual " + bench::text(estimate.residual_rms, 3, estimate.residual_unit) +
                    " (root mean square)");
  }
  lines.insert(lines.end(), estimate.remarks.begin(), estimate.remarks.end());
  return lines;
}

}  // namespace vrda::calibration
