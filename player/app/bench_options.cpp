// The options of `bench` and `devices`.
#include <CLI/CLI.hpp>

#include "app/options.hpp"
#include "bench/controls.hpp"
#include "guide/session.hpp"

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

// The options of `calibrate`.

namespace {

void add_virtual(CLI::App* calibrate, CalibrateOptions& options)
{
  calibrate->add_flag("--virtual", options.is_virtual,
                      "A bench and a person that exist in numbers: in a window to train, with --headless (or "
                      "without a screen, where no --calibration is kept) they do every task themselves");
  calibrate->add_option("--seed", options.seed, "Which virtual bench; a calibration is of one seed")
      ->type_name("N")
      ->capture_default_str();
  calibrate->add_option("--head", options.head, "What carries the virtual bench's display, without --bench")
      ->type_name("stage|tracker")
      ->capture_default_str();
  calibrate
      ->add_option("--benches", options.n_benches,
                   "So many virtual benches from --seed on: how often the truth lies within the intervals; "
                   "nothing else is kept")
      ->type_name("N")
      ->check(CLI::Range(1, 100000));
  calibrate
      ->add_option("--pictures", options.pictures,
                   "Folder for pictures of what a virtual bench found (--headless), or of each task of a "
                   "script")
      ->type_name("DIR");
}

}  // namespace

CLI::App* add_calibrate(CLI::App& app, CalibrateOptions& options)
{
  CLI::App* calibrate = app.add_subcommand(
      "calibrate", "Calibrate a bench and whoever looks through it, guided step by step, with intervals");
  calibrate
      ->add_option("STEP", options.step,
                   "viewport, distortion, eyepoints, ipd, tracking, head, subject, or one part of them; all; "
                   "bench, person: what is once a bench, once a person; status: what is known so far; solve: "
                   "all anew from the marks in the file")
      ->required();
  calibrate->add_option("--bench", options.bench, "Display, tracker and board (schemas/bench.md)")
      ->type_name("BENCH.toml");
  calibrate
      ->add_option(
          "--calibration", options.calibration,
          "What was found, kept after every mark (schemas/calibration.md); it goes on where it was left")
      ->type_name("FILE.toml");
  calibrate
      ->add_option("--bench-from", options.bench_from,
                   "Another person's calibration, whose once-per-bench parts a new FILE begins with")
      ->type_name("FILE.toml");
  calibrate->add_flag("--anew", options.is_anew,
                      "STEP's parts from their first tasks; once begun so, it goes on without --anew");
  calibrate
      ->add_option("--model", options.model,
                   "Motion model, where its place is adjusted by eye, and for pictures")
      ->type_name("FILE.h5");
  calibrate
      ->add_option("--set", options.set, "Of the model: raw, degree_N, ... (default: what show shows first)")
      ->type_name("SET");
  calibrate->add_flag("--headless", options.is_headless, "Without a window");
  calibrate
      ->add_option("--script", options.script, "Keys from a file: lines \"press Right 12\", \"wait 0.5\"")
      ->type_name("FILE");
  calibrate->add_option("--samples", options.samples, "Samples a pixel")
      ->type_name("1|2|4")
      ->check(CLI::IsMember({1, 2, 4}))
      ->option_text("1|2|4=1");
  add_virtual(calibrate, options);
  calibrate->add_flag("--json", options.has_json, "For programs");
  calibrate->add_flag("--quiet", options.is_quiet, "Only warnings");
  calibrate->footer(
      keys_text(guide_key_lines(), 24) +
      "Exit code 4: left before all that was asked for is done; the same command goes on there.\n"
      "Examples:\n  vrda-player calibrate all --bench bench.toml --calibration anna.toml\n"
      "  vrda-player calibrate person --bench bench.toml --calibration bob.toml --bench-from anna.toml\n"
      "  vrda-player calibrate status --bench bench.toml --calibration anna.toml\n"
      "  vrda-player calibrate all --virtual");
  return calibrate;
}

// The options of `body`.

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

// The options of `simulate`.

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
