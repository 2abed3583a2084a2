// The options of `bench` and `devices`.
#include "app/options.hpp"

#include <CLI/CLI.hpp>

#include "app/named_choice.hpp"
#include "bench/controls.hpp"

namespace vrda {
CLI::App* add_bench(CLI::App& app, BenchOptions& options)
{
  CLI::App* bench = app.add_subcommand(
      "bench",
      "Drive the see-through stereoscopic bench: tracker, parallax stage and potentiometer move the joint");
  options.look.mode = DrawMode::smooth;
  bench->add_option("FILE", options.file, "Motion model (.h5)")->required();
  bench->add_option("--bench", options.bench, "Display, tracker and board (schemas/bench.md)")
      ->type_name("BENCH.toml");
  bench
      ->add_option("--calibration", options.calibration,
                   "What calibration found (schemas/calibration.md); W writes it (default: a nominal one)")
      ->type_name("FILE.toml");
  bench->add_option("--set", options.set, "raw, degree_N, ... (default: what show shows first)")
      ->type_name("SET");
  bench->add_flag("--headless", options.is_headless, "Draw into memory, without a window");
  bench->add_option("--seconds", options.seconds, "How long to run")
      ->type_name("S")
      ->check(CLI::Range(0.1, 1e6));
  bench->add_option("--pictures", options.pictures, "Folder for what is shown, as PNG files")
      ->type_name("DIR");
  bench->add_option("--video", options.video, "A film of what is shown")->type_name("FILE.mp4");
  bench->add_option("--every", options.every, "Of the pictures and film: one of so many")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  bench->add_option("--record", options.record, "Keep every device sample and key in a new file")
      ->type_name("LOG");
  bench->add_option("--replay", options.replay, "Show a recording again instead of the devices")
      ->type_name("LOG");
  bench->add_option("--from", options.from_s, "Second of the recording to begin at")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  bench
      ->add_option("--speed", options.speed,
                   "Of a replay (default: 1 in a window, without one as fast as it goes)")
      ->type_name("X");
  bench->add_option("--timing", options.timing, "Write latency, jitter and counts as JSON")
      ->type_name("FILE.json");
  bench->add_option("--samples", options.samples, "Samples a pixel")
      ->type_name("1|2|4")
      ->check(CLI::IsMember({1, 2, 4}))
      ->option_text("1|2|4=1");
  // As a function: a flag that stores its value does so, as false, when it is absent, too.
  bench->add_flag_function(
      "--panel,!--no-panel", [&options](std::int64_t given) { options.has_panel = given > 0; },
      "Begin with the operator's panel (default: in a window)");
  add_look(*bench, options.look);
  bench->add_flag("--quiet", options.is_quiet, "Only warnings");
  bench->footer(
      keys_text(bench_key_lines(), 16) +
      "While a recording plays: Space pauses, Left and Right leap by 5 s, + and - change the speed.\n"
      "Examples:\n  vrda-player bench knee.h5 --bench bench.toml --calibration anna.toml\n"
      "  vrda-player bench knee.h5 --replay monday.log --headless --video monday.mp4");
  return bench;
}

CLI::App* add_devices(CLI::App& app, DevicesOptions& options)
{
  CLI::App* devices = app.add_subcommand(
      "devices", "List a bench's devices: whether each answers, its rate, its last values");
  devices->add_option("BENCH", options.bench, "Bench file (schemas/bench.md)")->required();
  devices->add_option("--seconds", options.seconds, "How long to listen")
      ->type_name("S")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  devices->add_flag("--json", options.has_json, "For programs");
  devices->footer("Example:\n  vrda-player devices bench.toml");
  return devices;
}

}  // namespace vrda
