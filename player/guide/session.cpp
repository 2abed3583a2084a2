#include "guide/session.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "guide/dials.hpp"
#include "guide/marks.hpp"
#include "guide/parts.hpp"
#include "guide/refusal.hpp"
#include "guide/sample_taker.hpp"
#include "guide/solve_part.hpp"
#include "guide/task.hpp"
#include "settings/settings_text.hpp"

namespace vrda {
namespace {

constexpr const char* silent_stage =
    "No message from the stage's board: check that it is switched on and plugged in.";

}  // namespace

struct GuideSession::Inner {
  Inner(const BenchFile& wanted_bench, const Calibration& begun, const GuideOptions& wanted)
      : bench(wanted_bench), calibration(begun), options(wanted), taker(wanted_bench)
  {
    if (options.is_anew) outdate_asked();
    require_order(options.parts, bench, calibration, options.path);
    next_part();
  }

  const Task* task() const { return at_task < tasks.size() ? &tasks[at_task] : nullptr; }
  CalibrationRecord& record() { return calibration.records[progress.part]; }
  CalibrationRecord record_so_far() const
  {
    const auto found = calibration.records.find(progress.part);
    return is_fresh || found == calibration.records.end() ? CalibrationRecord{} : found->second;
  }

  void outdate_asked();
  void next_part();
  void begin_part(CalibrationPart part);
  void next_task_of_part();
  void prepare_look();
  void enter();
  void finish(std::vector<std::vector<double>> rows);
  void put(CalibrationMark mark);
  void solve();
  void refuse(const PartRefusal& refusal, const TaskRound& round);
  void show_error(const std::string& why);
  void forget(const std::string& task);
  void judge(std::size_t done);
  void back();
  void again();
  void zero();
  void zero_by_key();
  void press(const KeyPress& key);
  void take_row();

  BenchFile bench;
  Calibration calibration;
  GuideOptions options;
  SampleTaker taker;
  std::size_t n_begun = 0;  ///< requested parts that were started or skipped
  std::vector<Task> tasks;
  std::size_t at_task = 0;
  bool is_fresh = false;  ///< the first new mark will replace all old marks of the part
  Dials dials;
  std::optional<Calibration> looked_at;  ///< calibration for drawing a look
  std::optional<Eigen::Vector3d> cross;  ///< bull's-eye being sampled: x, y as drawn, stage mm
  GuideProgress progress;
  std::uint64_t revision = 0;
  bool zeroes = false, is_left = false;
};

/// Outdates the requested parts in the file, so that a resumed session repeats them without --anew.
void GuideSession::Inner::outdate_asked()
{
  for (const CalibrationPart part : options.parts) {
    const auto record = calibration.records.find(part);
    if (record == calibration.records.end() || record->second.is_outdated) continue;
    record->second.is_outdated = true;
    ++revision;
  }
}

void GuideSession::Inner::next_part()
{
  tasks.clear();
  at_task = 0;
  looked_at.reset();
  while (n_begun < options.parts.size()) {
    const CalibrationPart part = options.parts[n_begun++];
    if (is_done(calibration, part)) continue;
    begin_part(part);
    return;
  }
}

void GuideSession::Inner::begin_part(CalibrationPart part)
{
  progress.part = part;
  const auto found = calibration.records.find(part);
  const bool is_under_way =
      found != calibration.records.end() && !found->second.estimate && !found->second.is_outdated;
  is_fresh = found != calibration.records.end() && !is_under_way;
  tasks = tasks_of(part, bench, calibration);
  const CalibrationRecord so_far = record_so_far();
  progress.n_tasks = static_cast<int>(tasks.size());
  for (std::string& line : words_before(part, bench, calibration)) progress.words.push_back(std::move(line));
  // The session was interrupted after the last mark and before solving.
  if (next_task(tasks, so_far) == tasks.size()) return solve();
  next_task_of_part();
}

void GuideSession::Inner::next_task_of_part()
{
  const CalibrationRecord so_far = record_so_far();
  at_task = next_task(tasks, so_far);
  progress.n_done = static_cast<int>(so_far.marks.size());
  progress.n_samples = 0;
  progress.is_taking = false;
  taker.end();
  dials = Dials(tasks[at_task]);
  looked_at.reset();
  if (tasks[at_task].kind == TaskKind::look) prepare_look();
}

/// A look checks the result before the part is confirmed, so the part is solved here for drawing only.
void GuideSession::Inner::prepare_look()
{
  try {
    looked_at = solved_part(progress.part, bench, calibration, options.path);
  } catch (const PartRefusal& refusal) {
    show_error(words_of(refusal));
  }
}

void GuideSession::Inner::show_error(const std::string& why)
{
  progress.words = {why};
  progress.is_refused = true;
  ++revision;
}

void GuideSession::Inner::enter()
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
    taker.begin(asked, body_beside(progress.part, asked));
    progress.is_taking = true;
    progress.n_samples = 0;
    progress.words.clear();
    progress.is_refused = false;
    return;
  }
  if (asked.kind == TaskKind::stop) {
    const double before_mm = *taker.stage_mm();
    zero();
    return finish({{before_mm}});
  }
  finish({row_of(asked, dials.values(), calibration)});
}

void GuideSession::Inner::take_row()
{
  progress.n_samples = static_cast<int>(taker.rows().size());
  if (progress.n_samples < task()->n_samples) return;
  std::vector<std::vector<double>> rows = taker.rows();
  taker.end();
  progress.is_taking = false;
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

void GuideSession::Inner::put(CalibrationMark mark)
{
  if (is_fresh) {
    record() = {};
    outdate_after(calibration, progress.part, bench);
    is_fresh = false;
  }
  CalibrationRecord& now = record();
  if (now.marks.empty()) now.made_with = bench_numbers_of(progress.part, bench);
  now.date = options.date;
  put_mark(now, tasks, std::move(mark));
}

void GuideSession::Inner::finish(std::vector<std::vector<double>> rows)
{
  const CalibrationMark mark{task()->name, std::move(rows)};
  progress.words.clear();
  progress.is_refused = false;
  ++revision;
  try {
    require_still(progress.part, *task(), mark, options.path);
  } catch (const PartRefusal& refusal) {
    // The dials keep their values.
    progress.n_samples = 0;
    return show_error(words_of(refusal));
  }
  const std::size_t done = at_task;
  put(mark);
  judge(done);
}

/// Checks the mark of task `done`, its group when complete, and solves the part when all tasks are done.
void GuideSession::Inner::judge(std::size_t done)
{
  const TaskRound round = round_of(progress.part, tasks, done);
  const bool is_round_done = std::all_of(tasks.begin() + static_cast<std::ptrdiff_t>(round.begin),
                                         tasks.begin() + static_cast<std::ptrdiff_t>(round.end),
                                         [&](const Task& t) { return mark_of(record(), t.name) != nullptr; });
  try {
    require_uncrossed(tasks, record(), done, options.path);
    if (next_task(tasks, record()) == tasks.size()) return solve();
    if (is_round_done)
      progress.words = round_remarks(progress.part, bench, calibration, tasks[done], options.path);
  } catch (const PartRefusal& refusal) {
    refuse(refusal, round);
  }
  next_task_of_part();
}

void GuideSession::Inner::solve()
{
  try {
    calibration = solved_part(progress.part, bench, calibration, options.path);
    record().is_outdated = false;
    outdate_after(calibration, progress.part, bench);
    ++revision;
    progress.words = words_after(progress.part, *record().estimate);
    progress.is_refused = false;
    progress.n_done = progress.n_tasks;
    progress.is_taking = false;
    next_part();
  } catch (const PartRefusal& refusal) {
    refuse(refusal, {0, tasks.size()});
    next_task_of_part();
  }
}

void GuideSession::Inner::refuse(const PartRefusal& refusal, const TaskRound& round)
{
  progress.words = {words_of(refusal)};
  progress.is_refused = true;
  for (const std::string& task : refusal.tasks()) forget(task);
  if (refusal.tasks().empty())
    for (std::size_t k = round.begin; k < round.end; ++k) forget(tasks[k].name);
  ++revision;
}

void GuideSession::Inner::forget(const std::string& task)
{
  std::erase_if(record().marks, [&](const CalibrationMark& m) { return m.task == task; });
}

void GuideSession::Inner::back()
{
  if (progress.is_taking) return next_task_of_part();
  if (at_task == 0 || is_fresh) return;
  forget(tasks[at_task - 1].name);
  progress.words.clear();
  progress.is_refused = false;
  ++revision;
  next_task_of_part();
}

void GuideSession::Inner::again()
{
  if (!is_fresh && calibration.records.contains(progress.part)) {
    record().marks.clear();
    ++revision;
  }
  progress.words.clear();
  progress.is_refused = false;
  next_task_of_part();
}

void GuideSession::Inner::zero()
{
  zeroes = true;
  taker.zero_stage();
}

/// Zeroes the stage after a restart of the board; marks and parts stay valid.
void GuideSession::Inner::zero_by_key()
{
  if (!has_stage(bench)) return;
  if (!taker.stage_mm()) return show_error(silent_stage);
  progress.words = {"The stage is zeroed; it was at " + rounded_text(*taker.stage_mm(), 2) + " mm."};
  progress.is_refused = false;
  ++revision;
  zero();
}

void GuideSession::Inner::press(const KeyPress& key)
{
  if (key.key == Key::escape || key.key == key_of('Q')) {
    is_left = true;
    taker.end();
    progress.is_taking = false;
    return;
  }
  if (task() == nullptr) return;
  if (key.key == key_of('R')) return again();
  if (key.key == Key::backspace) return back();
  // The alignment must not change during sampling.
  if (progress.is_taking) return;
  if (key.key == Key::enter) return enter();
  if (key.key == key_of('Z')) return zero_by_key();
  dials.press(key);
}

GuideSession::GuideSession(const BenchFile& bench, const Calibration& begun, const GuideOptions& options)
    : inner_(std::make_unique<Inner>(bench, begun, options))
{
}

GuideSession::~GuideSession() = default;

const Task* GuideSession::task() const
{
  return inner_->task();
}

std::span<const double> GuideSession::values() const
{
  return inner_->dials.values();
}

std::size_t GuideSession::selected_dial() const
{
  return inner_->dials.selected();
}

const GuideProgress& GuideSession::progress() const
{
  return inner_->progress;
}

void GuideSession::take(const KeyPress& press)
{
  inner_->press(press);
}

void GuideSession::take(const Sample& sample)
{
  if (sample.kind == SampleKind::potentiometer && inner_->task() != nullptr && !inner_->progress.is_taking) {
    inner_->dials.turn(sample.count, static_cast<double>(sample.arrival_ns) * 1e-9);
    return;
  }
  if (inner_->taker.take(sample) && inner_->task() != nullptr) inner_->take_row();
}

bool GuideSession::zeroes_stage()
{
  return std::exchange(inner_->zeroes, false);
}

bool GuideSession::is_left() const
{
  return inner_->is_left;
}

const Calibration& GuideSession::calibration() const
{
  return inner_->calibration;
}

const Calibration& GuideSession::drawn_by() const
{
  return inner_->looked_at ? *inner_->looked_at : inner_->calibration;
}

std::uint64_t GuideSession::revision() const
{
  return inner_->revision;
}

std::span<const HelpLine> guide_key_lines()
{
  static constexpr std::array<HelpLine, 8> lines{
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

}  // namespace vrda
