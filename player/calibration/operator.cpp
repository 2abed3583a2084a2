#include "calibration/operator.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <ostream>

#include "bench/simulated_devices.hpp"
#include "calibration/calibration_mode.hpp"
#include "calibration/parts.hpp"
#include "core/text.hpp"
#include "show/session.hpp"
#include "store/motion_model.hpp"

namespace vrda::calibration {

namespace {

constexpr std::int64_t frame_ns = 16'666'667;
/// Offset of the encoder before it is zeroed.
constexpr double stage_offset_mm = 37.0;

/// FNV-1a; makes noise depend on the task only, not on earlier tasks.
std::uint64_t number_of(const std::string& text)
{
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

void press(CalibrationSession& session, view::Key key, bool has_shift = false, bool has_control = false)
{
  session.take(view::KeyPress{key, has_shift, has_control});
}

/// Presses for 1, 10 or 100 steps, whichever does not overshoot.
void press_towards(CalibrationSession& session, view::Key key, long long n_steps)
{
  press(session, key, n_steps >= 10 && n_steps < 100, n_steps >= 100);
}

void select_dial(CalibrationSession& session, std::size_t k)
{
  const std::size_t n = session.values().size();
  for (std::size_t step = 0; step < n && session.selected_dial() != k; ++step)
    press(session, view::Key::down);
  check(session.selected_dial() == k, "the down key must select every dial in turn");
}

/// Presses keys until dial `k` is within half a step of `wanted`, or at the limit of its range. Whether a key
/// was needed.
bool set_dial(CalibrationSession& session, const Task& task, std::size_t k, double wanted)
{
  const bool is_selected = task.dials.size() > 2;
  if (is_selected) select_dial(session, k);
  view::Key up = is_selected || k == 0 ? view::Key::right : view::Key::up,
            down = is_selected || k == 0 ? view::Key::left : view::Key::down;
  const double step = task.dials[k].step;
  constexpr int most_presses = 1000;
  for (int n = 0; n < most_presses; ++n) {
    const double before = session.values()[k];
    const long long n_steps = std::llround((wanted - before) / step);
    if (n_steps == 0) return n > 0;
    press_towards(session, n_steps > 0 ? up : down, std::llabs(n_steps));
    const double moved = session.values()[k] - before;
    if (moved == 0.0) return true;
    // For crosses the up key decreases y.
    if ((moved > 0.0) != (n_steps > 0)) std::swap(up, down);
  }
  throw InternalError("a dial must reach the required value");
}

/// A step and back: a dial that is right as it is must be touched, or the reading is refused.
void touch_dial(CalibrationSession& session, const Task& task, std::size_t k)
{
  const double wanted = session.values()[k];
  const double step = task.dials[k].step;
  set_dial(session, task, k, wanted + step <= task.dials[k].maximum ? wanted + step : wanted - step);
  set_dial(session, task, k, wanted);
}

std::string key_of(const CalibrationSession& session)
{
  return std::string(bench::name_of(session.progress().part)) + "/" + session.task()->name;
}

}  // namespace

/// Index of the current task's noise; differs when the task is repeated.
std::uint64_t VirtualOperator::draws_index(const CalibrationSession& session) const
{
  const std::string key = key_of(session);
  const auto done = n_done_.find(key);
  return number_of(key + "/" + std::to_string(done == n_done_.end() ? 0 : done->second));
}

RandomSequence VirtualOperator::hand(const CalibrationSession& session) const
{
  return {truth_.seed, bench::RandomPurpose::virtual_hand, draws_index(session)};
}

BenchPoses VirtualOperator::standing(const CalibrationSession& session) const
{
  const int n = std::max(2, session.task()->n_samples);
  return poses(session, std::min(1.0, static_cast<double>(session.progress().n_samples) / (n - 1)));
}

TaskContext VirtualOperator::context(const CalibrationSession& session, RandomSequence& draws) const
{
  return {*session.task(), session.calibration(), bench_, truth_, noise_, draws};
}

BenchPoses VirtualOperator::poses(const CalibrationSession& session, double way) const
{
  RandomSequence draws = hand(session);
  return session.task()->kind->poses(context(session, draws), way);
}

std::vector<bench::Sample> VirtualOperator::samples(const CalibrationSession& session,
                                                    const BenchPoses& poses, std::uint64_t frame) const
{
  FrameFacts facts;
  facts.time_ns = time_ns_;
  facts.noise = noise_;
  facts.tool = session.task()->tool;
  facts.is_stage_zeroed = is_stage_zeroed_;
  facts.stage_offset_mm = facts.is_stage_zeroed ? 0.0 : stage_offset_mm;
  RandomSequence draws(truth_.seed, bench::RandomPurpose::virtual_tracker, draws_index(session) + frame);
  return tracker_frame(bench_, truth_, poses, facts, draws);
}

void VirtualOperator::send_frame(CalibrationSession& session, const BenchPoses& poses)
{
  for (const bench::Sample& sample : samples(session, poses, n_frames_)) session.take(sample);
  time_ns_ += frame_ns;
  ++n_frames_;
}

void VirtualOperator::handle_zeroing(CalibrationSession& session)
{
  if (session.take_zero_request()) is_stage_zeroed_ = true;
}

/// In a resumed session with a restarted board: moves the stage to its stop and presses Z. Resets the frame
/// count, so that the task's noise_ equals that of an uninterrupted session.
void VirtualOperator::zero_stage(CalibrationSession& session)
{
  const bool needs_zero = session.task()->kind->traits().samples == TaskKind::Samples::position;
  if (!needs_zero || !has_stage(bench_) || is_stage_zeroed_) return;
  send_frame(session, resting_poses(truth_));
  press(session, vrda::view::key_of('Z'));
  handle_zeroing(session);
  n_frames_ = 0;
}

void VirtualOperator::take_samples(CalibrationSession& session)
{
  const std::uint64_t most_frames = 10 * static_cast<std::uint64_t>(session.task()->n_samples) + 100;
  while (session.progress().is_sampling && n_frames_ < most_frames) send_frame(session, standing(session));
  check(!session.progress().is_sampling, "a task must end after the required samples");
}

void VirtualOperator::do_task(CalibrationSession& session)
{
  check(session.task() != nullptr, "do_task needs a current task");
  const Task task = *session.task();
  const std::string key = key_of(session);
  constexpr int most_refusals = 20;
  if (n_done_[key] > most_refusals) {
    throw InputError({bench_.path, key,
                      "more than " + std::to_string(most_refusals) + " refusals: " +
                          (session.progress().messages.empty() ? "" : session.progress().messages.front()),
                      "marks that the calibration accepts"});
  }
  n_frames_ = 0;
  zero_stage(session);
  RandomSequence draws = hand(session);
  const std::vector<double> wanted = task.kind->aligned_values(context(session, draws));
  std::size_t n_moved = 0;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const bool is_moved = set_dial(session, task, k, wanted[k]);
    if (!is_moved && task.kind->traits().has_two_lines) touch_dial(session, task, k);
    n_moved += is_moved ? 1 : 0;
  }
  if (!wanted.empty() && n_moved == 0) touch_dial(session, task, 0);
  const bool wants_samples = task.n_samples > 0;
  if (wants_samples || task.kind->traits().uses_stage) send_frame(session, standing(session));
  press(session, view::Key::enter);
  if (wants_samples) take_samples(session);
  handle_zeroing(session);
  ++n_done_[key];
  if (session.progress().has_error) ++n_refusals_;
}

void VirtualOperator::send_samples(CalibrationSession& session)
{
  handle_zeroing(session);
  const Task* task = session.task();
  if (task == nullptr || (task->n_samples == 0 && !task->kind->traits().uses_stage)) return;
  if (session.progress().n_samples == 0 && !session.progress().is_sampling) n_frames_ = 0;
  send_frame(session, standing(session));
}

std::optional<double> VirtualOperator::reading(const CalibrationSession& session) const
{
  const Task* task = session.task();
  const bool is_read = task != nullptr && task->kind->traits().is_reading && !task->kind->traits().is_seen;
  return is_read ? std::optional(aligned_values(session)[0]) : std::nullopt;
}

std::vector<double> VirtualOperator::aligned_values(const CalibrationSession& session) const
{
  RandomSequence draws = hand(session);
  return session.task()->kind->aligned_values(context(session, draws));
}

std::optional<Deviation> VirtualOperator::deviation(const CalibrationSession& session) const
{
  const Task* task = session.task();
  if (task == nullptr || task->dials.empty()) return std::nullopt;
  constexpr VirtualNoise none{0, 0, 0, 0, 0, 0, 0, 0, 0};
  RandomSequence draws = hand(session);
  return task->kind->deviation({*task, session.calibration(), bench_, truth_, none, draws}, session.values());
}

std::vector<DrawnLine> VirtualOperator::seen(const CalibrationSession& session) const
{
  const Task& task = *session.task();
  std::vector<DrawnLine> lines = task.kind->outlines(task, bench_, truth_);
  const std::vector<DrawnLine> drawn =
      task.kind->draw_simulated(task, session.values(), session.drawing_calibration(), bench_, truth_);
  for (DrawnLine& line : seen_lines(drawn, truth_)) lines.push_back(std::move(line));
  return lines;
}

// Devices that follow a calibration, for an operator with a real session.

namespace {

/// A sweep of a rail: rest, forwards, rest, back. Sampling takes half the time of the forward motion, so that
/// all samples have one direction if Enter is pressed during its first half.
constexpr double still_s = 2.0, back_s = 1.5;

double sweep_s(const Task& task, const BenchFile& bench)
{
  return 2.0 * std::max(1, task.n_samples) / bench.simulation.rate_hz;
}

bool is_rail(const Task& task)
{
  return task.kind->traits().samples == TaskKind::Samples::sweep && task.name.ends_with("rail");
}

double cycle_s(const Task& task, const BenchFile& bench)
{
  return still_s + sweep_s(task, bench) + still_s + back_s;
}

}  // namespace

Rehearsal::Rehearsal(const BenchFile& bench, std::vector<CalibrationPart> parts, std::uint64_t seed)
    : bench_(bench),
      parts_(std::move(parts)),
      truth_(virtual_truth(bench, seed)),
      operator_(bench, truth_, VirtualNoise{})
{
  follow(bench::nominal_calibration(bench), 0.0);
  task_.clear();  // not yet printed
}

std::string Rehearsal::follow(const Calibration& so_far, double now_s)
{
  const std::lock_guard lock(mutex_);
  session_.emplace(bench_, so_far, CalibrationSessionOptions{parts_, false, "", "rehearsal"});
  const Task* const task = session_->task();
  const std::string name =
      task == nullptr ? "done" : std::string(bench::name_of(session_->progress().part)) + ", " + task->name;
  if (name == std::exchange(task_, name)) return {};
  begun_s_ = now_s;
  prompted_ = -1;
  if (task == nullptr) return "all parts are done";
  std::string words;
  const std::vector<double> values = operator_.aligned_values(*session_);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const Dial& dial = task->dials[k];
    const double value =
        std::clamp(std::round(values[k] / dial.step) * dial.step, dial.minimum, dial.maximum);
    words += (k == 0 ? ": " : ", ") + dial_text(dial, value);
  }
  return name + words;
}

/// Progress of the current sweep; poses of other tasks do not depend on it.
double Rehearsal::way(double now_s) const
{
  const Task& task = *session_->task();
  const double s = now_s - begun_s_;
  if (!is_rail(task)) return std::fmod(s / sweep_s(task, bench_), 1.0);
  const double at_s = std::fmod(s, cycle_s(task, bench_)), along_s = sweep_s(task, bench_);
  if (at_s < still_s + along_s) return std::clamp((at_s - still_s) / along_s, 0.0, 1.0);
  return std::clamp(1.0 - (at_s - 2.0 * still_s - along_s) / back_s, 0.0, 1.0);
}

int Rehearsal::sweep_number(double now_s) const
{
  return static_cast<int>(std::floor((now_s - begun_s_ - still_s) / cycle_s(*session_->task(), bench_)));
}

std::string Rehearsal::prompt(double now_s)
{
  const std::lock_guard lock(mutex_);
  if (session_->task() == nullptr || !is_rail(*session_->task())) return {};
  const int number = sweep_number(now_s);
  if (number < 0 || number == std::exchange(prompted_, number)) return {};
  return "the marker moves: press Enter now";
}

BenchPoses Rehearsal::poses(double now_s) const
{
  return session_->task() == nullptr ? resting_poses(truth_) : operator_.poses(*session_, way(now_s));
}

bench::IgtlMessage Rehearsal::message(std::uint64_t k, double now_s) const
{
  const std::lock_guard lock(mutex_);
  bench::IgtlMessage message;
  message.kind = bench::IgtlKind::tdata;
  message.device = "Tracker";
  constexpr double ns_per_s = 1e9;
  message.device_ns =
      static_cast<std::int64_t>(ns_per_s * static_cast<double>(k + 1) / bench_.simulation.rate_hz);
  if (session_->task() == nullptr) return message;
  for (const bench::Sample& sample : operator_.samples(*session_, poses(now_s), k)) {
    if (sample.is(bench::ToolVisibility::seen))
      message.tools.push_back({bench_.tracker->tools[sample.source], bench::ToolVisibility::seen,
                               bench::pose_of(sample.tool_pose)});
  }
  return message;
}

int Rehearsal::stage_count(double now_s) const
{
  const std::lock_guard lock(mutex_);
  return static_cast<int>(std::lround(poses(now_s).stage_mm / bench_.stage_mm_per_count));
}

void rehearse(const bench::SimulateOptions& options, const show::Streams& streams)
{
  const BenchFile bench = bench::read_bench_file(options.bench);
  const std::vector<CalibrationPart> parts = parts_of_step("all", bench);
  for (const CalibrationPart part : parts) require_bench_data(part, bench);
  Rehearsal rehearsal(bench, parts, bench.simulation.seed);
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const auto now_s = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  show::StopSignals stop;
  bench::TrackerServerOptions server_options;
  server_options.address = options.address.empty() ? bench.simulation_address : options.address;
  server_options.port = bench.tracker->port;
  server_options.rate_hz = bench.simulation.rate_hz;
  const bench::TrackerServer server(server_options, [&](std::uint64_t tick) {
    return std::vector<bench::IgtlMessage>{rehearsal.message(tick, now_s())};
  });
  std::unique_ptr<bench::PtyBoard> board;
  if (bench.board) {
    bench::PtyBoardOptions board_options;
    board_options.link = bench.board->port;
    constexpr int half_way = 512;  // at rest it changes nothing
    board_options.potentiometer = [] { return half_way; };
    board_options.stage_count = [&] { return rehearsal.stage_count(now_s()); };
    board = std::make_unique<bench::PtyBoard>(board_options);
  }
  streams.data << "tracker " << server_options.address << ":" << server.port() << std::endl;
  if (board) streams.data << "board " << board->path() << std::endl;
  constexpr std::chrono::milliseconds between{50};
  constexpr double a_year_s = 3.2e7;
  std::filesystem::file_time_type read_at{};
  bool is_read = false;
  while (now_s() < options.seconds.value_or(a_year_s) && !stop.wait_until(Clock::now() + between)) {
    std::error_code no_file;
    const auto written_at = std::filesystem::last_write_time(options.rehearse, no_file);
    std::string words;
    if (!no_file && (!is_read || written_at != read_at)) {
      read_at = written_at;
      is_read = true;
      // A file of another bench must not stop the tracker.
      const auto refused = show::catch_input_error(
          [&] { words = rehearsal.follow(bench::read_calibration(options.rehearse, bench), now_s()); });
      if (refused) words = refused->what();
    } else if (no_file && !std::exchange(is_read, true)) {
      words = "waits for " + options.rehearse + "\n" +
              rehearsal.follow(bench::nominal_calibration(bench), now_s());
    }
    if (words.empty()) words = rehearsal.prompt(now_s());
    if (!words.empty()) streams.data << words << std::endl;
  }
}

}  // namespace vrda::calibration
