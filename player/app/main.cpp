// vrda-player: parses the command line, runs a mode, converts exceptions to one message and an exit code.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "app/options.hpp"
#include "core/error.hpp"
#include "store/read_separately.hpp"
#include "store/seal.hpp"

namespace {

/// DESIGN.md 7.
enum ExitCode { done = 0, bad_input = 2, unsolved_attitudes = 3, interrupted = 4, our_mistake = 5 };

/// The modes that use a bench file.
struct BenchModes {
  vrda::bench::BenchOptions options;
  vrda::bench::DevicesOptions devices_options;
  vrda::bench::MeasureBodyOptions body_options;
  vrda::bench::SimulateOptions simulate_options;
  vrda::calibrate::CalibrateOptions calibrate_options;
  const CLI::App *bench = nullptr, *devices = nullptr, *body = nullptr, *simulate = nullptr,
                 *calibrate = nullptr;

  void add_to(CLI::App& app)
  {
    bench = vrda::app::add_bench(app, options);
    devices = vrda::app::add_devices(app, devices_options);
    body = vrda::app::add_measure_body(app, body_options);
    simulate = vrda::app::add_simulate(app, simulate_options);
    calibrate = vrda::app::add_calibrate(app, calibrate_options);
  }
  /// Runs the chosen mode and returns its exit code; empty if none of these modes was chosen.
  std::optional<int> run() const
  {
    if (bench->parsed()) {
      vrda::bench::run_bench(options, {std::cout, std::cerr});
      return done;
    }
    if (devices->parsed()) {
      const int n_silent = vrda::bench::list_devices(devices_options, {std::cout, std::cerr});
      return n_silent > 0 ? unsolved_attitudes : done;
    }
    if (body->parsed()) {
      vrda::bench::measure_body(body_options, {std::cout, std::cerr});
      return done;
    }
    if (simulate->parsed()) {
      vrda::bench::simulate(simulate_options, {std::cout, std::cerr});
      return done;
    }
    if (calibrate->parsed()) {
      const vrda::calibrate::CalibrateEnd end =
          vrda::calibrate::calibrate(calibrate_options, {std::cout, std::cerr});
      return end == vrda::calibrate::CalibrateEnd::finished ? done : interrupted;
    }
    return std::nullopt;
  }
};

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
      "Exit codes: 0 success, 2 invalid input, 3 unsolved attitudes (or silent devices), 4 stopped before "
      "the "
      "followed run or the calibration was complete, 5 internal error");
  vrda::show::ShowOptions options;
  vrda::app::add_show(app, options);
  vrda::web::WebOptions web_options;
  const CLI::App* web = vrda::app::add_web(app, web_options);
  vrda::follow::FollowOptions follow_options;
  const CLI::App* follow = vrda::app::add_follow(app, follow_options);
  BenchModes bench;
  bench.add_to(app);
  try {
    parse(app, argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    std::cerr << "vrda-player: " << error.what() << " (see vrda-player --help)\n";
    return bad_input;
  }
  if (app.get_subcommands().empty()) {
    std::cerr << "vrda-player: found no mode, wanted show, follow, web, bench, calibrate, body, simulate or "
                 "devices "
                 "(see vrda-player --help)\n";
    return bad_input;
  }
  if (web->parsed()) {
    vrda::web::serve_web(web_options, std::cout, std::cerr);
    return done;
  }
  if (follow->parsed()) {
    const vrda::follow::FollowEnd end = vrda::follow::follow(follow_options, {std::cout, std::cerr});
    return end == vrda::follow::FollowEnd::finished ? done : interrupted;
  }
  if (const std::optional<int> code = bench.run()) return *code;
  const vrda::show::ShowSummary summary = vrda::show::show(options, {std::cout, std::cerr});
  return summary.n_unsolved > 0 ? unsolved_attitudes : done;
}

}  // namespace

int main(int argc, char** argv)
{
  try {
    return run(argc, argv);
  } catch (const vrda::InputError& error) {
    std::cerr << "vrda-player: " << error.what() << "\n";
    return bad_input;
  } catch (const std::exception& error) {
    std::cerr << "vrda-player: a mistake of the program: " << error.what()
              << "\nPlease report it with the command line and the file.\n";
    return our_mistake;
  }
}
