// The options of `simulate`.
#include <CLI/CLI.hpp>

#include "app/options.hpp"

namespace vrda {

CLI::App* add_simulate(CLI::App& app, SimulateOptions& options)
{
  CLI::App* simulate = app.add_subcommand(
      "simulate",
      "Stand in for a bench's tracker and board: a leg that bends, with noise, occlusions, drop-outs");
  simulate->add_option("BENCH", options.bench, "Bench file with or without [simulation] (schemas/bench.md)")
      ->required();
  simulate
      ->add_option("--model", options.model,
                   "Motion model the simulated tibia follows (default: it only turns)")
      ->type_name("FILE.h5");
  simulate
      ->add_option("--address", options.address,
                   "To listen on; others than 127.0.0.1 are reached from outside (default: the bench file's "
                   "simulation.address, else 127.0.0.1)")
      ->type_name("ADDRESS");
  simulate->add_option("--seconds", options.seconds, "How long (default: until Ctrl-C)")
      ->type_name("S")
      ->check(CLI::Range(0.1, 1e6));
  simulate->add_flag("--quiet", options.is_quiet, "Only the addresses");
  simulate->footer(
      "Example:\n  vrda-player simulate jobs/bench-desk.toml &\n"
      "  vrda-player bench knee.h5 --bench jobs/bench-desk.toml");
  return simulate;
}

}  // namespace vrda
