#include "calibration_tasks/session.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "calibration_tasks/dials.hpp"
#include "calibration_tasks/marks.hpp"
#include "calibration_tasks/parts.hpp"
#include "calibration_tasks/refusal.hpp"
#include "calibration_tasks/sample_collector.hpp"
#include "calibration_tasks/solve_part.hpp"
#include "calibration_tasks/task.hpp"
#include "settings/settings_text.hpp"

namespace vrda::calibration_tasks {
namespace {

constexpr const char* silent_stage =
    "No message from the stage's board: check that it is switched on and plugged in.";

}  // namespace

struct CalibrationSession::Inner {
  Inner(const bench_files::BenchFile& wanted_bench, const bench_files::Calibration& begun,
        const CalibrationSessionOptions& wanted)
      : bench(wanted_bench), calibration(begun), options(wanted), taker(wanted_bench)
  {
    if (options.is_repeated) outdate_asked();
    require_ready_parts(options.parts, bench, calibration, options.path);
    next_part();
  }

  const Task* task() const { return at_task < tasks.size() ? &tasks[at_task] : nullptr; }
  bench_files::CalibrationRecord& record() { return calibration.records[progress.part]; }
  bench_files::CalibrationRecord record_so_far() const
  {
    const auto found = calibration.records.find(progress.part);
    return is_fresh || found == calibration.records.end() ? bench_files::CalibrationRecord{} : found->second;
  }

  void outdate_asked();
  void next_part();
  void begin_part(bench_files::CalibrationPart part);
  void next_task_of_part();
  void prepare_look();
  void enter();
  void finish(std::vector<std::vector<double>> rows);
  void put(bench_files::CalibrationMark mark);
  void solve();
  void refuse(const PartRefusal& refusal, const TaskGroup& round);
  void show_error(const std::string& why);
  void forget(const std::string& task);
  void judge(std::size_t done);
  void back();
  void again();
  void zero();
  void zero_by_key();
  void press(const navigation::KeyPress& key);
  void take_row();

  bench_files::BenchFile bench;
  bench_files::Calibration calibration;
  CalibrationSessionOptions options;
  SampleCollector taker;
  std::size_t n_begun = 0;  ///< requested parts that were started or skipped
  std::vector<Task> tasks;
  std::size_t at_task = 0;
  bool is_fresh = false;  ///< the first new mark will replace all old marks of the part
  Dials dials;
  std::optional<bench_files::Calibration> looked_at;  ///< calibration for drawing a look
  std::optional<Eigen::Vector3d> cross;               ///< bull's-eye being sampled: x, y as drawn, stage mm
  CalibrationProgress progress;
  std::uint64_t revision = 0;
  bool zeroes = false, is_left = false;
};

/// Outdates the requested parts in the file, so that a resumed session repeats them without --anew.
void CalibrationSession::Inner::outdate_asked()
{
  for (const bench_files::CalibrationPart part : options.parts) {
    const auto record = calibration.records.find(part);
    if (record == calibration.records.end() || record->second.is_outdated) continue;
    record->second.is_outdated = true;
    ++revision;
  }
}

void CalibrationSession::Inner::next_part()
{
  tasks.clear();
  at_task = 0;
  looked_at.reset();
  while (n_begun < options.parts.size()) {
    const bench_files::CalibrationPart part = options.parts[n_begun++];
    if (is_done(calibration, part)) continue;
    begin_part(part);
    return;
  }
}

void CalibrationSession::Inner::begin_part(bench_files::CalibrationPart part)
{
  progress.part = part;
  const auto found = calibration.records.find(part);
  const bool is_under_way =
      found != calibration.records.end() && !found->second.estimate && !found->second.is_outdated;
  is_fresh = found != calibration.records.end() && !is_under_way;
  tasks = tasks_of(part, bench, calibration);
  const bench_files::CalibrationRecord so_far = record_so_far();
  progress.n_tasks = static_cast<int>(tasks.size());
  for (std::string& line : intro_messages(part, bench, calibration))
    progress.messages.push_back(std::move(line));
  // The session was interrupted after the last mark and before solving.
  if (next_task(tasks, so_far) == tasks.size()) return solve();
  next_task_of_part();
}

void CalibrationSession::Inner::next_task_of_part()
{
  const bench_files::CalibrationRecord so_far = record_so_far();
  at_task = next_task(tasks, so_far);
  progress.n_done = static_cast<int>(so_far.marks.size());
  progress.n_samples = 0;
  progress.is_sampling = false;
  taker.end();
  dials = Dials(tasks[at_task]);
  looked_at.reset();
  if (tasks[at_task].kind == TaskKind::depth_check) prepare_look();
}

/// A look checks the result before the part is confirmed, so the part is solved here for drawing only.
void CalibrationSession::Inner::prepare_look()
{
  try {
    looked_at = solve_part(progress.part, bench, calibration, options.path);
  } catch (const PartRefusal& refusal) {
    show_error(screen_message(refusal));
  }
}

void CalibrationSession::Inner::show_error(const std::string& why)
{
  progress.messages = {why};
  progress.has_error = true;
  ++revision;
}

void CalibrationSession::Inner::enter()
{
  const Task& asked = *task();
  const bool is_on_stage = asked.kind == TaskKind::bullseye || asked.kind == TaskKind::stop;
  if (is_on_stage && has_stage(bench)) {
    if (!taker.stage_mm()) return show_error(silent_stage);
    if (asked.kind == TaskKind::bullseye && !taker.is_stage_zeroed())
      return show_error(
          "The stage was not zeroed since its board was switched on: push the stage against its stop and "
          "press Z.");
  }
  if (asked.n_samples > 0) {
    if (asked.kind == TaskKind::bullseye) {
      const Eigen::Vector2d drawn = drawn_cross(asked, dials.values(), calibration);
      cross = {drawn.x(), drawn.y(), has_stage(bench) ? *taker.stage_mm() : 0.0};
    }
    taker.begin(asked, accompanying_body(progress.part, asked));
    progress.is_sampling = true;
    progress.n_samples = 0;
    progress.messages.clear();
    progress.has_error = false;
    return;
  }
  if (asked.kind == TaskKind::stop) {
    const double before_mm = *taker.stage_mm();
    zero();
    return finish({{before_mm}});
  }
  finish({mark_row(asked, dials.values(), calibration)});
}

void CalibrationSession::Inner::take_row()
{
  progress.n_samples = static_cast<int>(taker.rows().size());
  if (progress.n_samples < task()->n_samples) return;
  std::vector<std::vector<double>> rows = taker.rows();
  taker.end();
  progress.is_sampling = false;
  if (cross && task()->kind == TaskKind::bullseye) {
    constexpr double stage_moved_mm = 0.05;
    const double now_mm = has_stage(bench) ? taker.stage_mm().value_or((*cross)[2]) : 0.0;
    if (std::abs(now_mm - (*cross)[2]) > stage_moved_mm) {
      return show_error("The stage moved during sampling: hold it still, align again and press Enter.");
    }
    rows.insert(rows.begin(), {(*cross)[0], (*cross)[1], (*cross)[2]});
  }
  cross.reset();
  finish(std::move(rows));
}

void CalibrationSession::Inner::put(bench_files::CalibrationMark mark)
{
  if (is_fresh) {
    record() = {};
    outdate_dependents(calibration, progress.part, bench);
    is_fresh = false;
  }
  bench_files::CalibrationRecord& now = record();
  if (now.marks.empty()) now.made_with = bench_numbers_of(progress.part, bench);
  now.date = options.date;
  insert_mark(now, tasks, std::move(mark));
}

void CalibrationSession::Inner::finish(std::vector<std::vector<double>> rows)
{
  const bench_files::CalibrationMark mark{task()->name, std::move(rows)};
  progress.messages.clear();
  progress.has_error = false;
  ++revision;
  try {
    require_static(progress.part, *task(), mark, options.path);
  } catch (const PartRefusal& refusal) {
    // The dials keep their values.
    progress.n_samples = 0;
    return show_error(screen_message(refusal));
  }
  const std::size_t done = at_task;
  put(mark);
  judge(done);
}

/// Checks the mark of task `done`, its group when complete, and solves the part when all tasks are done.
void CalibrationSession::Inner::judge(std::size_t done)
{
  const TaskGroup round = task_group_of(progress.part, tasks, done);
  const bool is_round_done =
      std::all_of(tasks.begin() + static_cast<std::ptrdiff_t>(round.begin),
                  tasks.begin() + static_cast<std::ptrdiff_t>(round.end),
                  [&](const Task& t) { return find_mark(record(), t.name) != nullptr; });
  try {
    require_edge_order(tasks, record(), done, options.path);
    if (next_task(tasks, record()) == tasks.size()) return solve();
    if (is_round_done)
      progress.messages = group_remarks(progress.part, bench, calibration, tasks[done], options.path);
  } catch (const PartRefusal& refusal) {
    refuse(refusal, round);
  }
  next_task_of_part();
}

void CalibrationSession::Inner::solve()
{
  try {
    calibration = solve_part(progress.part, bench, calibration, options.path);
    record().is_outdated = false;
    outdate_dependents(calibration, progress.part, bench);
    ++revision;
    progress.messages = result_messages(progress.part, *record().estimate);
    progress.has_error = false;
    progress.n_done = progress.n_tasks;
    progress.is_sampling = false;
    next_part();
  } catch (const PartRefusal& refusal) {
    refuse(refusal, {0, tasks.size()});
    next_task_of_part();
  }
}

void CalibrationSession::Inner::refuse(const PartRefusal& refusal, const TaskGroup& round)
{
  progress.messages = {screen_message(refusal)};
  progress.has_error = true;
  for (const std::string& task : refusal.tasks()) forget(task);
  if (refusal.tasks().empty())
    for (std::size_t k = round.begin; k < round.end; ++k) forget(tasks[k].name);
  ++revision;
}

void CalibrationSession::Inner::forget(const std::string& task)
{
  std::erase_if(record().marks, [&](const bench_files::CalibrationMark& m) { return m.task == task; });
}

void CalibrationSession::Inner::back()
{
  if (progress.is_sampling) return next_task_of_part();
  if (at_task == 0 || is_fresh) return;
  forget(tasks[at_task - 1].name);
  progress.messages.clear();
  progress.has_error = false;
  ++revision;
  next_task_of_part();
}

void CalibrationSession::Inner::again()
{
  if (!is_fresh && calibration.records.contains(progress.part)) {
    record().marks.clear();
    ++revision;
  }
  progress.messages.clear();
  progress.has_error = false;
  next_task_of_part();
}

void CalibrationSession::Inner::zero()
{
  zeroes = true;
  taker.zero_stage();
}

/// Zeroes the stage after a restart of the board; marks and parts stay valid.
void CalibrationSession::Inner::zero_by_key()
{
  if (!has_stage(bench)) return;
  if (!taker.stage_mm()) return show_error(silent_stage);
  progress.messages = {"The stage is zeroed; it was at " + settings::rounded_text(*taker.stage_mm(), 2) +
                       " mm."};
  progress.has_error = false;
  ++revision;
  zero();
}

void CalibrationSession::Inner::press(const navigation::KeyPress& key)
{
  if (key.key == navigation::Key::escape || key.key == navigation::key_of('Q')) {
    is_left = true;
    taker.end();
    progress.is_sampling = false;
    return;
  }
  if (task() == nullptr) return;
  if (key.key == navigation::key_of('R')) return again();
  if (key.key == navigation::Key::backspace) return back();
  // The alignment must not change during sampling.
  if (progress.is_sampling) return;
  if (key.key == navigation::Key::enter) return enter();
  if (key.key == navigation::key_of('Z')) return zero_by_key();
  dials.press(key);
}

CalibrationSession::CalibrationSession(const bench_files::BenchFile& bench,
                                       const bench_files::Calibration& begun,
                                       const CalibrationSessionOptions& options)
    : inner_(std::make_unique<Inner>(bench, begun, options))
{
}

CalibrationSession::~CalibrationSession() = default;

const Task* CalibrationSession::task() const
{
  return inner_->task();
}

std::span<const double> CalibrationSession::values() const
{
  return inner_->dials.values();
}

std::size_t CalibrationSession::selected_dial() const
{
  return inner_->dials.selected();
}

const CalibrationProgress& CalibrationSession::progress() const
{
  return inner_->progress;
}

void CalibrationSession::take(const navigation::KeyPress& press)
{
  inner_->press(press);
}

void CalibrationSession::take(const devices::Sample& sample)
{
  if (sample.kind == devices::SampleKind::potentiometer && inner_->task() != nullptr &&
      !inner_->progress.is_sampling) {
    inner_->dials.turn(sample.count, static_cast<double>(sample.arrival_ns) * 1e-9);
    return;
  }
  if (inner_->taker.take(sample) && inner_->task() != nullptr) inner_->take_row();
}

bool CalibrationSession::take_zero_request()
{
  return std::exchange(inner_->zeroes, false);
}

bool CalibrationSession::has_quit() const
{
  return inner_->is_left;
}

const bench_files::Calibration& CalibrationSession::calibration() const
{
  return inner_->calibration;
}

const bench_files::Calibration& CalibrationSession::drawing_calibration() const
{
  return inner_->looked_at ? *inner_->looked_at : inner_->calibration;
}

std::uint64_t CalibrationSession::revision() const
{
  return inner_->revision;
}

std::span<const navigation::HelpLine> session_key_lines()
{
  static constexpr std::array<navigation::HelpLine, 8> lines{
      {{"Left, Right", "decrease, increase the first (or the selected) number"},
       {"Up, Down", "increase, decrease the second number (cross: up, down), or select a number"},
       {"Shift, Control", "10, 100 steps at once"},
       {"Enter", "confirm, or start sampling"},
       {"Backspace", "repeat the previous task; during sampling: stop it"},
       {"R", "repeat this part from its first task"},
       {"Z", "zero the stage at its stop, also after its board was switched on again"},
       {"Escape, Q", "quit; finished tasks are kept"}}};
  return lines;
}

}  // namespace vrda::calibration_tasks
