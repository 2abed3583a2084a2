// vrda-player: parses the command line, runs a mode, converts exceptions to one message and an exit code.
#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/options.hpp"
#include "bench/bench_run.hpp"
#include "calibration/operator.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "store/read_separately.hpp"
#include "view/keys.hpp"

namespace {

/// README.md of this room describes them.
enum ExitCode { done = 0, bad_input = 2, unsolved_attitudes = 3, interrupted = 4, internal_error = 5 };

/// Reports an unknown option before a missing one; CLI11 reports the missing one first.
void parse(CLI::App& app, int argc, char** argv)
{
  try {
    app.parse(argc, argv);
  } catch (const CLI::RequiredError&) {
    const std::vector<std::string> unknown = app.remaining(true);
    if (unknown.empty()) throw;
    throw CLI::ExtrasError(unknown);
  }
}

/// Serves the page; with a bench file the bench, too.
void run_web(vrda::app::WebMode& mode)
{
  using namespace vrda;
  std::optional<bench::LiveBench> bench;
  std::optional<web::LiveFeed> feed;
  if (mode.bench.bench.empty() && !(mode.bench.calibration.empty() && mode.bench.set.empty()))
    view::refuse_option(mode.bench.set.empty() ? "--calibration" : "--set", "no --bench",
                        "--bench with a bench file");
  if (!mode.bench.bench.empty()) {
    mode.bench.file = mode.web.file;
    bench.emplace(mode.bench);
    feed = web::LiveFeed{bench->greeting(), [&bench] { return bench->next(); }, bench->interval_s()};
  }
  web::serve_web(mode.web, feed, std::cout, std::cerr);
}

int run(int argc, char** argv)
{
  CLI::App app("Shows the motion of a joint from a motion model", "vrda-player");
  app.add_flag_callback(
      "--unsealed", [] { vrda::store::accept_unsealed_files(); },
      "Accept files without a seal, written or changed by another program (must precede the mode)");
  vrda::store::on_unconfined_read([](const std::string& why) {
    std::cerr << "vrda-player: this system does not sandbox the process that reads HDF5 (" << why
              << "); its resource limits still apply\n";
  });
  app.set_version_flag("--version", "vrda-player " VRDA_VERSION);
  app.require_subcommand(0, 1);
  app.footer(
      "Example:\n  vrda-player show knee.h5\n\n"
      "Exit codes: 0 success, 2 invalid input, 3 unsolved attitudes (or a device that does not answer), 4 "
      "stopped before the followed run or the calibration was complete (the same command resumes), 5 "
      "internal error");
  using namespace vrda;
  const show::Streams streams{std::cout, std::cerr};
  show::ShowOptions show;
  app::WebMode web;
  show::FollowOptions follow;
  bench::BenchOptions bench;
  bench::ServeOptions serve;
  bench::DevicesOptions devices;
  bench::MeasureBodyOptions body;
  bench::SimulateOptions simulate;
  calibration::CalibrateOptions calibrate;
  const std::vector<std::pair<const CLI::App*, std::function<int()>>> modes{
      {app::add_show(app, show),
       [&] { return show::show(show, streams).n_unsolved > 0 ? unsolved_attitudes : done; }},
      {app::add_web(app, web), [&] { return run_web(web), done; }},
      {app::add_follow(app, follow),
       [&] { return show::follow(follow, streams) == show::FollowEnd::finished ? done : interrupted; }},
      {app::add_bench(app, bench), [&] { return bench::run_bench(bench, streams), done; }},
      {app::add_serve(app, serve), [&] { return bench::serve(serve, streams), done; }},
      {app::add_devices(app, devices),
       [&] { return bench::list_devices(devices, streams) > 0 ? unsolved_attitudes : done; }},
      {app::add_measure_body(app, body), [&] { return bench::measure_body(body, streams), done; }},
      {app::add_simulate(app, simulate),
       [&] {
         simulate.rehearse.empty() ? bench::simulate(simulate, streams)
                                   : calibration::rehearse(simulate, streams);
         return done;
       }},
      {app::add_calibrate(app, calibrate), [&] {
         const calibration::CalibrateEnd end = calibration::calibrate(calibrate, streams);
         return end == calibration::CalibrateEnd::finished ? done : interrupted;
       }}};
  try {
    parse(app, argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::cerr << "vrda-player: " << error.what() << " (see vrda-player --help)\n";
    return bad_input;
  }
  for (const auto& [mode, run_mode] : modes) {
    if (mode->parsed()) return run_mode();
  }
  std::cerr
      << "vrda-player: found no mode, wanted show, follow, web, bench, serve, calibrate, body, simulate "
         "or devices (see vrda-player --help)\n";
  return bad_input;
}

int refused(const vrda::InputError& error)
{
  std::cerr << "vrda-player: " << error.what() << "\n";
  return bad_input;
}

}  // namespace

int main(int argc, char** argv)
{
  try {
    return run(argc, argv);
  } catch (const vrda::InputError& error) {
    return refused(error);
  } catch (const std::filesystem::filesystem_error& error) {
    return refused(vrda::input_error_of(error));
  } catch (const std::exception& error) {
    std::cerr << "vrda-player: internal error: " << error.what()
              << "\nPlease report it with the command line and the file.\n";
    return internal_error;
  }
}
