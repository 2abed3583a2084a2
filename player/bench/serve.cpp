// `vrda-player serve`: sends a joint by OpenIGTLink, without a picture.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <ostream>

#include "bench/bench_run.hpp"
#include "bench/joint_stream.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "view/arguments.hpp"
#include "store/motion_model_file.hpp"

namespace vrda::bench {
namespace {

/// Calls `send(seconds)` at the rate until the end or a stop signal. The times are computed from the start,
/// so that they do not drift.
template <typename Send>
void send_regularly(const ServeOptions& options, show::StopSignals& stop, Send send)
{
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  const auto at = [start](double s) {
    return start +
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
  };
  for (std::uint64_t tick = 0;; ++tick) {
    const double s = static_cast<double>(tick) / options.rate_hz;
    if (options.seconds && s > *options.seconds) return;
    if (stop.wait_until(at(s))) return;
    send(s);
  }
}

void announce(const JointStream& stream, const ServeOptions& options, const show::Streams& streams)
{
  streams.data << "igtl " << options.igtl.address << ":" << stream.port() << std::endl;
  if (!options.is_quiet && !options.seconds) streams.messages << "Ctrl-C ends it\n";
}

/// To and fro with a cosine, or held.
double flexion_at(const ServeOptions& options, const store::Motion& motion, double s)
{
  if (options.flexion_deg) return rad_from_deg(*options.flexion_deg);
  const double first = motion.first_flexion_rad(), last = motion.last_flexion_rad();
  const double share = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * s / options.period_s);
  return first + share * (last - first);
}

void serve_motion(const ServeOptions& options, const show::Streams& streams)
{
  const store::MotionModel model = store::read_motion_model(options.file);
  store::require_grid(model, options.file, "serve");
  const store::Motion motion(model, store::chosen_set(model, options.file, options.set));
  const auto attitude_at = [&](double s) -> Attitude {
    const double flexion_rad = flexion_at(options, motion, s);
    return {flexion_rad,
            options.varus_deg ? rad_from_deg(*options.varus_deg) : motion.balanced_varus_rad(flexion_rad)};
  };
  view::report_clamped(motion, motion.at(attitude_at(0.0)), attitude_at(0.0), "sent", streams.messages);
  show::StopSignals stop;
  JointStream stream(options.igtl, model);
  announce(stream, options, streams);
  StreamedFrame streamed;
  send_regularly(options, stop, [&](double s) {
    streamed.frame.pose = motion.at(attitude_at(s));
    streamed.frame.X_tracker_moving = streamed.frame.pose.X_reference_moving;
    streamed.utc_ns = utc_now_ns();
    stream.put(streamed);
  });
}

void serve_bench(const ServeOptions& options, const show::Streams& streams)
{
  BenchOptions bench;
  bench.file = options.file;
  bench.set = options.set;
  bench.bench = options.bench;
  bench.calibration = options.calibration;
  bench.igtl = options.igtl;
  const BenchSetup setup = read_bench_setup(bench);
  BenchState state(setup.bench, setup.calibration, setup.motion, setup.frame);
  ProbeTool probe(setup.bench, setup.calibration);
  show::StopSignals stop;
  bench::Devices devices(setup.bench.tracker, setup.bench.board);
  JointStream stream(options.igtl, setup.model);
  announce(stream, options, streams);
  send_regularly(options, stop, [&](double) {
    for (bench::Sample sample; devices.take(sample);) {
      state.take(sample);
      probe.take(sample);
    }
    const std::int64_t now_ns = devices.now_ns();
    stream.put({state.frame(now_ns), true, probe.X_tracker_probe(), probe.status(now_ns), utc_now_ns(), 0});
  });
}

}  // namespace

void serve(const ServeOptions& options, const show::Streams& streams)
{
  if (!options.igtl.port) view::refuse_option("--igtl", "nothing", "a port, such as 18944");
  if (options.bench.empty()) {
    if (!options.calibration.empty())
      view::refuse_option("--calibration", "no --bench", "--bench with a bench file");
    if (options.flexion_deg) view::require_angle("--flexion", *options.flexion_deg);
    if (options.varus_deg) view::require_angle("--varus", *options.varus_deg);
    return serve_motion(options, streams);
  }
  if (options.flexion_deg || options.varus_deg)
    view::refuse_option(options.flexion_deg ? "--flexion" : "--varus", "--bench",
                              "one of them: the bench measures the angles");
  serve_bench(options, streams);
}

}  // namespace vrda::bench
