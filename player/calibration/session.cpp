#include "calibration/session.hpp"

#include <algorithm>
#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/drawing.hpp"
#include "core/text.hpp"

namespace vrda::calibration {

namespace {

/// As in bench/bench_state.cpp: range of the ten-bit converter, steps per turn.
constexpr double most_count = 1023.0, steps_a_turn = 200.0;
constexpr bench::OneEuroOptions potentiometer_options{1.0, 0.05, 2.0};

/// Removes accumulated rounding errors of many small steps.
double rounded_value(double value)
{
  constexpr double parts = 1e9;
  return std::round(value * parts) / parts;
}

}  // namespace

Dials::Dials(const Task& task)
    : dials_(task.dials),
      is_cross_(task.kind != nullptr && task.kind->traits().is_cross),
      is_row_(task.is_row),
      filter_(potentiometer_options)
{
  for (const Dial& dial : dials_) values_.push_back(std::clamp(dial.value, dial.minimum, dial.maximum));
  touched_.resize(values_.size());
}

void Dials::select(std::size_t dial)
{
  if (dial == selected_) return;
  selected_ = dial;
  start_count_.reset();
}

void Dials::change(std::size_t dial, double steps)
{
  if (dial < dials_.size()) set(dial, values_[dial] + steps * dials_[dial].step);
}

void Dials::assign(std::size_t dial, double value)
{
  touched_[dial] = true;
  // A step and back gives exactly the start value.
  const Dial& limits = dials_[dial];
  const double rounded = rounded_value(value);
  values_[dial] = std::clamp(rounded == rounded_value(limits.value) ? limits.value : rounded, limits.minimum,
                             limits.maximum);
}

void Dials::set(std::size_t dial, double value)
{
  select(dial);
  assign(dial, value);
  // The potentiometer continues from the value that was set.
  start_count_.reset();
}

void Dials::drag(const DialDrag& drag)
{
  if (drag_start_.empty()) return;
  constexpr double fine = 0.1;
  const auto move = [&](std::size_t k, double px) {
    const Dial& dial = dials_[k];
    const double steps = (drag.is_fine ? fine : 1.0) * px / (dial.unit == "px" ? dial.step : 1.0);
    set(k, drag_start_[k] + std::round(steps) * dial.step);
  };
  if (is_cross_) {
    move(0, drag.moved_px.x());
    move(1, drag.moved_px.y());
  } else {
    const std::size_t k = dials_.size() > 2 ? selected_ : drag.is_second ? dials_.size() - 1 : 0;
    move(k, is_row_ ? drag.moved_px.y() : drag.moved_px.x());
  }
}

void Dials::press(const view::KeyPress& press)
{
  const double n = press.has_control ? 100.0 : (press.has_shift ? 10.0 : 1.0);
  const bool is_many = dials_.size() > 2;
  switch (press.key) {
    case view::Key::left:
      return change(is_many ? selected_ : 0, -n);
    case view::Key::right:
      return change(is_many ? selected_ : 0, n);
    case view::Key::up:
      if (is_many) return select((selected_ + dials_.size() - 1) % dials_.size());
      return change(1, is_cross_ ? -n : n);
    case view::Key::down:
      if (is_many) return select((selected_ + 1) % dials_.size());
      return change(1, is_cross_ ? n : -n);
    default:
      return;
  }
}

void Dials::turn(int count, double time_s)
{
  if (dials_.empty()) return;
  const double filtered = filter_.filtered(count, time_s);
  if (!start_count_) {
    start_count_ = filtered;
    start_value_ = values_[selected_];
    last_steps_ = 0.0;
  }
  // Whole steps suppress the noise of a potentiometer at rest.
  const double steps = std::round((filtered - *start_count_) / most_count * steps_a_turn);
  if (steps == last_steps_) return;
  last_steps_ = steps;
  assign(selected_, start_value_ + steps * dials_[selected_].step);
}

// Rows of numbers for a task, from tracker and board samples.

namespace {

double rounded(double value, double parts)
{
  const double number = std::round(value * parts) / parts;
  // Avoids "-0" in files.
  return number == 0.0 ? 0.0 : number;
}

void add_position(std::vector<double>& row, const bench::ToolPose& place)
{
  for (const double x : place.position_mm) row.push_back(rounded_mm(x));
}

void add_place(std::vector<double>& row, const bench::ToolPose& place)
{
  add_position(row, place);
  for (const double x : place.rotation) row.push_back(rounded(x, 1e8));
}

bool is_finite(const bench::ToolPose& place)
{
  const auto finite = [](double x) { return std::isfinite(x); };
  return std::all_of(std::begin(place.position_mm), std::end(place.position_mm), finite) &&
         std::all_of(std::begin(place.rotation), std::end(place.rotation), finite);
}

constexpr const char* silent_stage =
    "No message from the stage's board: check that it is switched on and plugged in.";

}  // namespace

double rounded_mm(double value)
{
  return rounded(value, 1e5);
}

void SampleCollector::begin(const Task& task)
{
  const std::vector<std::string>& tools = bench_.tracker->tools;
  const auto found = std::ranges::find(tools, task.tool);
  check(found != tools.end(), "the tool of a task is a tool of the tracker");
  tool_ = static_cast<std::size_t>(found - tools.begin());
  samples_ = task.kind->traits().samples;
  role_ = task.body;
  rows_.clear();
  thigh_before_.reset();
  thigh_.reset();
  shank_.reset();
  is_taking_ = true;
}

bool SampleCollector::take(const bench::Sample& sample)
{
  switch (sample.kind) {
    case bench::SampleKind::stage:
      stage_mm_ = rounded_mm(bench_.stage_mm_per_count * sample.count);
      is_stage_zeroed_ = (sample.state & bench::stage_zeroed) != 0;
      return false;
    case bench::SampleKind::link:
      if (static_cast<bench::LinkState>(sample.state) == bench::LinkState::up) return false;
      if (static_cast<bench::DeviceId>(sample.source) == bench::DeviceId::board) stage_mm_.reset();
      if (static_cast<bench::DeviceId>(sample.source) == bench::DeviceId::tracker) trackers_.disconnect();
      return false;
    case bench::SampleKind::tool_pose:
      return take_place(sample);
    case bench::SampleKind::potentiometer:
    case bench::SampleKind::offset:
      return false;
  }
  return false;
}

const bench::BodyTracker* SampleCollector::fresh_body(double time_s)
{
  bench::BodyTracker& tracker = *trackers_[*role_];
  tracker.end_message();
  const double oldest_s = bench_.tracker->stale_after_ms / 1000.0;
  return tracker.is_live() && std::abs(time_s - tracker.seen_s()) <= oldest_s ? &tracker : nullptr;
}

void SampleCollector::end_message(BodyRole role)
{
  bench::BodyTracker& tracker = *trackers_[role];
  if (!tracker.end_message() || samples_ != TaskKind::Samples::leg) return;
  const bench::TimedPose pose{tracker.seen_s(), tracker.last()};
  if (role == BodyRole::femur) thigh_before_ = std::exchange(thigh_, pose);
  if (role == BodyRole::tibia) shank_ = pose;
}

/// Adds the shank's pose with that of the thigh at its time: the leg moves, so poses of different messages
/// are interpolated.
bool SampleCollector::take_leg()
{
  constexpr double same_s = 1e-4;
  if (!shank_ || !thigh_ || thigh_->time_s < shank_->time_s - same_s) return false;
  Pose X_tracker_thigh = thigh_->X;
  if (thigh_->time_s > shank_->time_s + same_s) {
    const double oldest_s = bench_.tracker->stale_after_ms / 1000.0;
    const bool is_between = thigh_before_ && thigh_before_->time_s <= shank_->time_s + same_s &&
                            thigh_->time_s - thigh_before_->time_s <= oldest_s;
    if (!is_between) {
      shank_.reset();
      return false;
    }
    X_tracker_thigh =
        bench::between(thigh_before_->X, thigh_->X,
                       (shank_->time_s - thigh_before_->time_s) / (thigh_->time_s - thigh_before_->time_s));
  }
  std::vector<double> row;
  add_place(row, bench::place_of(X_tracker_thigh));
  add_place(row, bench::place_of(shank_->X));
  rows_.push_back(std::move(row));
  shank_.reset();
  return true;
}

bool SampleCollector::take_place(const bench::Sample& sample)
{
  const bool is_seen = sample.is(bench::ToolVisibility::seen) && is_finite(sample.tool_pose);
  const double time_s = trackers_.take(sample, [this](BodyRole role) { end_message(role); });
  if (is_taking_ && samples_ == TaskKind::Samples::leg) return take_leg();
  if (!is_taking_ || !is_seen || sample.source != tool_) return false;
  std::vector<double> row;
  if (samples_ == TaskKind::Samples::position) {
    add_position(row, sample.tool_pose);
  } else {
    add_place(row, sample.tool_pose);
  }
  if (role_) {
    const bench::BodyTracker* body = fresh_body(time_s);
    if (body == nullptr) return false;
    add_place(row, bench::place_of(body->last()));
  }
  if (samples_ == TaskKind::Samples::sweep && stage_mm_) row.push_back(*stage_mm_);
  rows_.push_back(std::move(row));
  return true;
}

CalibrationSession::CalibrationSession(const BenchFile& bench, const Calibration& begun,
                                       const CalibrationSessionOptions& options)
    : bench_(bench), calibration_(begun), options_(options), collector_(bench)
{
  if (options_.is_repeated) mark_requested_outdated();
  require_ready_parts(options_.parts, input());
  next_part();
}

/// Outdates the requested parts in the file, so that a resumed session repeats them without --anew.
void CalibrationSession::mark_requested_outdated()
{
  for (const CalibrationPart part : options_.parts) {
    const auto record = calibration_.records.find(part);
    if (record == calibration_.records.end() || record->second.is_outdated) continue;
    record->second.is_outdated = true;
    ++revision_;
  }
}

void CalibrationSession::next_part()
{
  tasks_.clear();
  at_task_ = 0;
  looked_at_.reset();
  while (n_begun_ < options_.parts.size()) {
    const CalibrationPart part = options_.parts[n_begun_++];
    if (is_done(calibration_, part)) continue;
    begin_part(part);
    return;
  }
}

CalibrationRecord CalibrationSession::record_so_far() const
{
  const CalibrationRecord* found = find_record(calibration_, progress_.part);
  return is_fresh_ || found == nullptr ? CalibrationRecord{} : *found;
}

void CalibrationSession::begin_part(CalibrationPart part)
{
  progress_.part = part;
  progress_.n_parts = static_cast<int>(options_.parts.size());
  progress_.number = static_cast<int>(n_begun_);
  const CalibrationRecord* begun = find_record(calibration_, part);
  is_fresh_ = begun != nullptr && (begun->estimate || begun->is_outdated);
  tasks_ = tasks_of(part, bench_, calibration_);
  const CalibrationRecord so_far = record_so_far();
  progress_.n_tasks = static_cast<int>(tasks_.size());
  if (const std::string words = part_object(part).introduction(bench_, calibration_); !words.empty())
    progress_.messages.push_back(words);
  // The session was interrupted after the last mark and before solving.
  if (next_task(tasks_, so_far) == tasks_.size()) return solve();
  next_task_of_part();
}

void CalibrationSession::next_task_of_part()
{
  const CalibrationRecord so_far = record_so_far();
  at_task_ = next_task(tasks_, so_far);
  progress_.n_done = static_cast<int>(so_far.marks.size());
  progress_.typical_left_s = typical_left_s();
  progress_.n_samples = 0;
  progress_.is_sampling = false;
  collector_.end();
  dials_ = Dials(tasks_[at_task_]);
  implausible_.clear();
  looked_at_.reset();
  if (!tasks_[at_task_].kind->traits().shows_result) return;
  // A look checks the result before the part is confirmed, so the part is solved here for drawing only.
  try {
    looked_at_ = solve_part(progress_.part, input());
  } catch (const PartRefusal& refusal) {
    show_error(screen_message(refusal));
  }
}

/// Of the tasks without a mark, those of later parts by the results so far.
double CalibrationSession::typical_left_s() const
{
  double left_s = 0.0;
  const auto add = [&](const std::vector<Task>& tasks, const CalibrationRecord& so_far) {
    for (const Task& task : tasks)
      if (find_mark(so_far, task.name) == nullptr) left_s += task.kind->traits().typical_s;
  };
  add(tasks_, record_so_far());
  for (std::size_t k = n_begun_; k < options_.parts.size(); ++k) {
    const CalibrationPart part = options_.parts[k];
    const CalibrationRecord* const found = find_record(calibration_, part);
    const bool is_begun = found != nullptr && !found->is_outdated;
    if (is_begun && found->estimate) continue;
    add(tasks_of(part, bench_, calibration_), is_begun ? *found : CalibrationRecord{});
  }
  return left_s;
}

void CalibrationSession::show(std::vector<std::string> messages)
{
  progress_.messages = std::move(messages);
  progress_.has_error = false;
}

void CalibrationSession::show_error(const std::string& why)
{
  show({why});
  progress_.has_error = true;
  ++revision_;
}

/// To the dials as they are; empty: none. Crossed edges are refused with both edges later.
std::string CalibrationSession::objection_to(const Task& current) const
{
  if (const std::string untouched = untouched_text(current, dials_.touched()); !untouched.empty())
    return untouched;
  if (std::ranges::equal(implausible_, dials_.values()) || current.n_samples > 0) return {};
  try {
    CalibrationRecord tried = record_so_far();
    insert_mark(tried, tasks_,
                {current.name, {current.kind->mark_row(current, dials_.values(), calibration_)}});
    require_edge_order(tasks_, tried, at_task_, options_.path);
  } catch (const PartRefusal&) {
    return {};
  }
  return implausible_text(current, dials_.values());
}

void CalibrationSession::confirm()
{
  const Task& current = *task();
  const TaskKind::Traits& kind = current.kind->traits();
  const bool is_position = kind.samples == TaskKind::Samples::position;
  if (kind.uses_stage && has_stage(bench_)) {
    if (!collector_.stage_mm()) return show_error(silent_stage);
    if (is_position && !collector_.is_stage_zeroed())
      return show_error(
          "The stage was not zeroed since its board was switched on: push the stage against its stop and "
          "press Z.");
  }
  if (!current.dials.empty()) {
    const std::string objection = objection_to(current);
    implausible_.assign(dials_.values().begin(), dials_.values().end());
    if (!objection.empty()) return show_error(objection);
  }
  if (current.n_samples > 0) {
    if (is_position) {
      cross_ = current.kind->mark_row(current, dials_.values(), calibration_);
      cross_.push_back(has_stage(bench_) ? *collector_.stage_mm() : 0.0);
    }
    collector_.begin(current);
    progress_.is_sampling = true;
    progress_.n_samples = 0;
    progress_.messages.clear();
    progress_.has_error = false;
    return;
  }
  if (kind.uses_stage) {
    const double before_mm = *collector_.stage_mm();
    zero();
    return finish({{before_mm}});
  }
  finish({current.kind->mark_row(current, dials_.values(), calibration_)});
}

void CalibrationSession::take_row()
{
  progress_.n_samples = static_cast<int>(collector_.rows().size());
  if (progress_.n_samples < task()->n_samples) return;
  std::vector<std::vector<double>> rows = collector_.rows();
  collector_.end();
  progress_.is_sampling = false;
  if (task()->kind->traits().samples == TaskKind::Samples::position) {
    constexpr double stage_moved_mm = 0.05;
    const double then_mm = cross_.back();
    const double now_mm = has_stage(bench_) ? collector_.stage_mm().value_or(then_mm) : 0.0;
    if (std::abs(now_mm - then_mm) > stage_moved_mm)
      return show_error("The stage moved during sampling: hold it still, align again and press Enter.");
    rows.insert(rows.begin(), cross_);
  }
  finish(std::move(rows));
}

void CalibrationSession::put(CalibrationMark mark)
{
  if (is_fresh_) {
    record() = {};
    outdate_dependents(calibration_, progress_.part, bench_);
    is_fresh_ = false;
  }
  CalibrationRecord& now = record();
  if (now.marks.empty()) now.made_with = part_object(progress_.part).made_with(input()).value();
  now.date = options_.date;
  insert_mark(now, tasks_, std::move(mark));
}

void CalibrationSession::finish(std::vector<std::vector<double>> rows)
{
  const CalibrationMark mark{task()->name, std::move(rows)};
  show({});
  ++revision_;
  if (const std::string same = same_place_text(tasks_, record_so_far(), *task(), mark); !same.empty()) {
    progress_.n_samples = 0;
    return show_error(same);
  }
  try {
    require_static(progress_.part, *task(), mark, options_.path);
  } catch (const PartRefusal& refusal) {
    // The dials keep their values.
    progress_.n_samples = 0;
    return show_error(screen_message(refusal));
  }
  const std::size_t done = at_task_;
  put(mark);
  validate_and_solve(done);
}

/// Checks the mark of task `done`, its group when complete, and solves the part when all tasks are done.
void CalibrationSession::validate_and_solve(std::size_t done)
{
  const TaskGroup round = task_group_of(progress_.part, tasks_, done);
  const bool is_round_done =
      std::all_of(tasks_.begin() + static_cast<std::ptrdiff_t>(round.begin),
                  tasks_.begin() + static_cast<std::ptrdiff_t>(round.end),
                  [&](const Task& t) { return find_mark(record(), t.name) != nullptr; });
  try {
    require_edge_order(tasks_, record(), done, options_.path);
    if (next_task(tasks_, record()) == tasks_.size()) return solve();
    if (is_round_done) progress_.messages = part_object(progress_.part).remarks(tasks_[done], input());
  } catch (const PartRefusal& refusal) {
    refuse(refusal, round);
  }
  next_task_of_part();
}

void CalibrationSession::solve()
{
  try {
    Calibration solved = solve_part(progress_.part, input());
    const CalibrationRecord& done = solved.records.at(progress_.part);
    const std::string unexpected =
        unexpected_text(tasks_, done, *done.estimate, bench::nominal_calibration(bench_));
    if (!unexpected.empty() && repeated_parts_.insert(progress_.part).second) {
      record().marks.clear();
      next_task_of_part();
      return show_error(unexpected);
    }
    calibration_ = std::move(solved);
    record().is_outdated = false;
    outdate_dependents(calibration_, progress_.part, bench_);
    ++revision_;
    show(result_lines(progress_.part, *record().estimate));
    progress_.n_done = progress_.n_tasks;
    progress_.is_sampling = false;
    next_part();
  } catch (const PartRefusal& refusal) {
    refuse(refusal, {0, tasks_.size()});
    next_task_of_part();
  }
}

void CalibrationSession::refuse(const PartRefusal& refusal, const TaskGroup& round)
{
  for (const std::string& task : refusal.tasks()) erase_mark(task);
  if (refusal.tasks().empty())
    for (std::size_t k = round.begin; k < round.end; ++k) erase_mark(tasks_[k].name);
  show_error(screen_message(refusal));
}

void CalibrationSession::erase_mark(const std::string& task)
{
  std::erase_if(record().marks, [&](const CalibrationMark& m) { return m.task == task; });
}

void CalibrationSession::previous_task()
{
  if (progress_.is_sampling) return next_task_of_part();
  if (at_task_ == 0 || is_fresh_)
    return show(
        {std::string("This is the first task of the part. An earlier part is repeated by "
                     "`vrda-player calibrate PART --anew`.")});
  erase_mark(tasks_[at_task_ - 1].name);
  show({});
  ++revision_;
  next_task_of_part();
}

void CalibrationSession::restart_part()
{
  if (!is_fresh_ && calibration_.records.contains(progress_.part)) {
    record().marks.clear();
    ++revision_;
  }
  show({});
  next_task_of_part();
}

void CalibrationSession::zero()
{
  must_zero_ = true;
  collector_.zero_stage();
}

/// Zeroes the stage after a restart of the board; marks and parts stay valid.
void CalibrationSession::zero_by_key()
{
  if (!has_stage(bench_)) return;
  if (!collector_.stage_mm()) return show_error(silent_stage);
  show({"The stage is zeroed; it was at " + short_decimal(*collector_.stage_mm(), 2) + " mm."});
  ++revision_;
  zero();
}

void CalibrationSession::take(const view::KeyPress& key)
{
  if (key.key == view::key_of('Q')) {
    has_quit_ = true;
    collector_.end();
    progress_.is_sampling = false;
    return;
  }
  if (task() == nullptr) return;
  if (key.key == view::key_of('R')) return restart_part();
  if (key.key == view::Key::backspace) return previous_task();
  // The alignment must not change during sampling.
  if (progress_.is_sampling) return;
  if (key.key == view::Key::enter) return confirm();
  if (key.key == view::key_of('Z')) return zero_by_key();
  dials_.press(key);
}

void CalibrationSession::begin_drag()
{
  if (task() != nullptr && !progress_.is_sampling) dials_.begin_drag();
}

void CalibrationSession::take(const DialDrag& drag)
{
  if (task() != nullptr && !progress_.is_sampling) dials_.drag(drag);
}

void CalibrationSession::take(const bench::Sample& sample)
{
  if (sample.kind == bench::SampleKind::potentiometer && task() != nullptr && !progress_.is_sampling) {
    dials_.turn(sample.count, static_cast<double>(sample.arrival_ns) * 1e-9);
    return;
  }
  if (collector_.take(sample) && task() != nullptr) take_row();
}

view::KeyPress press_of_wheel(bool is_away, bool has_shift, bool has_control)
{
  const view::Key away = has_shift ? view::Key::up : view::Key::right;
  const view::Key back = has_shift ? view::Key::down : view::Key::left;
  return {is_away ? away : back, false, has_control};
}

double overall_progress(const CalibrationProgress& progress)
{
  if (progress.n_parts == 0 || progress.n_tasks == 0) return 0.0;
  const double part = static_cast<double>(progress.n_done) / progress.n_tasks;
  return (progress.number - 1 + part) / progress.n_parts;
}

double time_left_s(const Pace& pace, double typical_left_s)
{
  constexpr double prior_s = 120.0;  // the typical pace counts as much as this time of observation
  return typical_left_s * (prior_s + pace.used_s) / (prior_s + pace.typical_s);
}

std::span<const view::HelpLine> session_key_lines()
{
  static constexpr std::array<view::HelpLine, 13> lines{
      {{"Left, Right", "decrease, increase the first (or the selected) number"},
       {"Up, Down", "increase, decrease the second number (cross: up, down), or select a number"},
       {"Shift, Control", "10, 100 steps at once"},
       {"Wheel", "as Right and Left; with Shift as Up and Down"},
       {"Left drag",
        "moves the line or cross with the pointer (right drag: the second line); Shift: a tenth"},
       {"Middle button", "as Enter"},
       {"Gamepad", "stick and cross: the numbers; shoulders: Shift, Control; A: Enter; B: Backspace; Y: H"},
       {"Enter", "confirm, or start sampling"},
       {"Backspace", "repeat the previous task; during sampling: stop it"},
       {"R", "repeat this part from its first task"},
       {"Z", "zero the stage at its stop, also after its board was switched on again"},
       {"Esc", "close this page"},
       {"Q", "quit; finished tasks are kept"}}};
  return lines;
}

}  // namespace vrda::calibration
