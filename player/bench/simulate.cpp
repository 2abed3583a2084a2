// `vrda-player simulate`: sends tracker and board data of a simulated bench.
#include "bench/bench_run.hpp"

#include <chrono>
#include <memory>
#include <ostream>

#include "bench/bench_file.hpp"
#include "core/error.hpp"
#include "bench/pty_board.hpp"
#include "bench/tracker_server.hpp"
#include "bench/simulation.hpp"
#include "store/motion_model_file.hpp"

namespace vrda::bench {
namespace {

/// A simulated tool that is sent, with its name in the bench file.
struct SentTool {
  std::size_t simulated = 0;
  std::string name;
};

std::vector<SentTool> sent_tools(const bench::BenchFile& bench,
                                 const bench::Simulation& simulation)
{
  std::vector<SentTool> sent;
  std::size_t at = 0;
  const auto add = [&](const std::optional<bench::BodySettings>& settings) {
    if (!settings->tool.empty()) sent.push_back({at, settings->tool});
    ++at;
    for (const std::string& marker : settings->markers) sent.push_back({at++, marker});
  };
  const auto settings = [&](bench::BodyRole role) {
    return bench.bodies[static_cast<std::size_t>(role)];
  };
  if (bench.leg == bench::LegKind::rigid) {
    add(settings(bench::BodyRole::leg));
    ++at;  // the tibia, which is not tracked
  } else {
    add(settings(bench::BodyRole::femur));
    add(settings(bench::BodyRole::tibia));
  }
  if (bench.head == bench::HeadKind::tracker) add(settings(bench::BodyRole::head));
  check(at == simulation.tools().size(), "every simulated tool is assigned");
  return sent;
}

/// One TDATA message a tick, without hidden tools.
std::vector<bench::IgtlMessage> messages_of(const bench::SimulatedFrame& frame,
                                           const std::vector<SentTool>& sent)
{
  if (frame.is_dropped) return {};
  bench::IgtlMessage message;
  message.kind = bench::IgtlKind::tdata;
  message.device = "Tracker";
  message.device_ns = frame.device_ns;
  for (const SentTool& tool : sent) {
    const bench::SimulatedTool& simulated = frame.tools[tool.simulated];
    if (simulated.is_seen)
      message.tools.push_back({tool.name, bench::ToolVisibility::seen, simulated.X_tracker_tool});
  }
  return {message};
}

std::optional<store::Motion> motion_of(const std::string& path)
{
  if (path.empty()) return std::nullopt;
  const store::MotionModel model = store::read_motion_model(path);
  store::require_grid(model, path, "a simulated bench");
  return store::Motion(model, store::default_motion(model).set);
}

std::unique_ptr<bench::PtyBoard> open_board(const bench::BenchFile& bench,
                                              const bench::Simulation& simulation)
{
  if (!bench.board) return nullptr;
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const auto now_s = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  bench::PtyBoardOptions options;
  options.link = bench.board->port;
  options.potentiometer = [&simulation, now_s] { return simulation.potentiometer_count(now_s()); };
  options.stage_count = [&simulation, now_s] { return static_cast<int>(simulation.stage_count(now_s())); };
  return std::make_unique<bench::PtyBoard>(options);
}

}  // namespace

void simulate(const SimulateOptions& options, const show::Streams& streams)
{
  const bench::BenchFile bench = bench::read_bench_file(options.bench);
  if (bench.camera)
    throw InputError(
        {options.bench, "tracker", "\"aruco\", a webcam", "a tracker of OpenIGTLink to simulate"});
  const bench::Simulation simulation(bench.simulation, motion_of(options.model), options.bench);
  if (const auto beyond = simulation.beyond_motion(options.bench))
    streams.messages << "vrda-player: " << InputError(*beyond).what() << "\n";
  const std::vector<SentTool> sent = sent_tools(bench, simulation);
  show::StopSignals stop;
  bench::TrackerServerOptions server_options;
  server_options.address = options.address.empty() ? bench.simulation_address : options.address;
  server_options.port = bench.tracker->port;
  server_options.rate_hz = bench.simulation.rate_hz;
  server_options.jitter_ms = bench.simulation.jitter_ms;
  server_options.seed = bench.simulation.seed;
  const bench::TrackerServer server(
      server_options, [&](std::uint64_t tick) { return messages_of(simulation.frame(tick), sent); });
  // After the port is bound: a second simulation of the same bench ends before it touches the link.
  const std::unique_ptr<bench::PtyBoard> board = open_board(bench, simulation);
  streams.data << "tracker " << server_options.address << ":" << server.port() << std::endl;
  if (board) streams.data << "board " << board->path() << std::endl;
  if (!options.is_quiet && !options.seconds) streams.messages << "Ctrl-C ends the simulation\n";
  using Clock = std::chrono::steady_clock;
  constexpr double a_year_s = 3.2e7;
  const std::chrono::duration<double> time(options.seconds.value_or(a_year_s));
  stop.wait_until(Clock::now() + std::chrono::duration_cast<Clock::duration>(time));
}

}  // namespace vrda::bench
