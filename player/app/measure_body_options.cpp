// The options of `body`.
#include <CLI/CLI.hpp>

#include "app/options.hpp"

namespace vrda {

CLI::App* add_measure_body(CLI::App& app, MeasureBodyOptions& options)
{
  CLI::App* body = app.add_subcommand(
      "body", "Measure a body of markers with the bench's tracker: its lines for the bench file");
  body->add_option("ROLE", options.role,
                   "Body of the bench file whose markers are named: leg, femur, tibia, head")
      ->required();
  body->add_option("--bench", options.bench, "Bench file (schemas/bench.md); markers_mm may be missing")
      ->type_name("BENCH.toml")
      ->required();
  body->add_option("--seconds", options.seconds, "How long to listen")
      ->type_name("S")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  body->add_flag("--quiet", options.is_quiet, "Only the lines");
  body->footer("Example:\n  vrda-player body femur --bench bench.toml");
  return body;
}

}  // namespace vrda
