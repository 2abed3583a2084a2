#include "calibration/rehearsal.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <ostream>

#include "bench/simulated_devices.hpp"
#include "calibration/calibration_mode.hpp"
#include "calibration/parts.hpp"
#include "show/session.hpp"
#include "store/motion_model.hpp"

namespace vrda::calibration {
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
