// Options of the modes `bench`, `serve`, `devices`, `calibrate`, `body` and `simulate`.
#include <CLI/CLI.hpp>

#include "app/options.hpp"
#include "bench/bench_run.hpp"
#include "calibration/session.hpp"

namespace vrda::app {

namespace {

void add_igtl(CLI::App* mode, bench::IgtlOptions& options)
{
  add(mode, "--igtl", "PORT", options.port,
      "Send the joint to OpenIGTLink programs such as 3D Slicer that connect to this port; 0: any free port")
      ->check(CLI::Range(0, 65535));
  add(mode, "--igtl-address", "ADDRESS", options.address,
      "Listen address of --igtl; any but 127.0.0.1 is reachable from other machines")
      ->capture_default_str();
}

}  // namespace

CLI::App* add_serve(CLI::App& app, bench::ServeOptions& options)
{
  CLI::App* serve = app.add_subcommand(
      "serve", "Send a joint to other programs by OpenIGTLink: a motion, or the leg tracked by a bench");
  serve->add_option("FILE", options.file, "Motion model (.h5)")->required();
  add_igtl(serve, options.igtl);
  add(serve, "--set", "SET", options.set, "raw, degree_N, ... (default: the default set of show)");
  add(serve, "--rate", "HZ", options.rate_hz, "Frames a second")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  CLI::Option* held = add(serve, "--flexion", "DEG", options.flexion_deg,
                          "Held flexion (default: to and fro over the model's range)");
  add(serve, "--varus", "DEG", options.varus_deg, "Held varus (default: balanced)");
  add(serve, "--period", "S", options.period_s, "Duration of a bend and a stretch")
      ->check(CLI::Range(0.1, 1e6))
      ->excludes(held)
      ->capture_default_str();
  add(serve, "--bench", "BENCH.toml", options.bench,
      "Send the leg tracked by this bench (schemas/bench.md), without a picture");
  add(serve, "--calibration", "FILE.toml", options.calibration,
      "Calibration file of the bench, which must exist (default: nominal values)");
  add(serve, "--seconds", "S", options.seconds, "Duration (default: until Ctrl-C)")
      ->check(CLI::Range(0.1, 1e6));
  serve->add_flag("--quiet", options.is_quiet, "Print only the address");
  serve->footer(
      "Each client receives both meshes once (POLYDATA), then per frame the poses of the bones, of the eyes\n"
      "and of the probe (TRANSFORM, mm) and the angles (STRING). Hidden bodies are left out.\n"
      "Examples:\n  vrda-player serve knee.h5 --igtl 18944\n"
      "  vrda-player serve knee.h5 --igtl 18944 --bench bench.toml --calibration anna.toml");
  return serve;
}

CLI::App* add_bench(CLI::App& app, bench::BenchOptions& options)
{
  CLI::App* bench = app.add_subcommand(
      "bench", "Drive the see-through stereoscopic bench from its tracker, parallax stage and potentiometer");
  options.look.mode = view::DrawMode::smooth;
  bench->add_option("FILE", options.file, "Motion model (.h5)")->required();
  add(bench, "--bench", "BENCH.toml", options.bench,
      "Bench file: display, tracker and board (schemas/bench.md)");
  add(bench, "--calibration", "FILE.toml", options.calibration,
      "Calibration file (schemas/calibration.md); the key W writes it (default: nominal values)");
  add(bench, "--set", "SET", options.set, "raw, degree_N, ... (default: the default set of show)");
  bench->add_flag("--headless", options.is_headless, "Render to memory, without a window");
  add(bench, "--seconds", "S", options.seconds, "Duration of the run")->check(CLI::Range(0.1, 1e6));
  add(bench, "--pictures", "DIR", options.pictures, "Folder for the displayed frames, as PNG files");
  add(bench, "--video", "FILE.mp4", options.video, "Video file of the displayed frames");
  add(bench, "--every", "N", options.every, "Keep every N-th frame for --pictures and --video")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  add(bench, "--record", "LOG", options.record, "Record every device sample and key in a new file");
  add(bench, "--replay", "LOG", options.replay, "Replay a recording instead of reading the devices");
  add(bench, "--from", "S", options.from_s, "Start time of the replay in the recording")
      ->check(CLI::Range(0.0, 1e6));
  add(bench, "--speed", "X", options.speed,
      "Replay speed factor (default: 1 in a window, unlimited without a window)");
  add(bench, "--timing", "FILE.json", options.timing, "Write latency, jitter and counts as JSON");
  add_igtl(bench, options.igtl);
  add(bench, "--samples", "1|2|4", options.samples, "Samples per pixel")
      ->check(CLI::IsMember({1, 2, 4}))
      ->option_text("1|2|4=4");
  // A callback, because CLI11 also stores false in a bound flag when the option is absent.
  bench->add_flag_function(
      "--panel,!--no-panel", [&options](std::int64_t given) { options.has_panel = given > 0; },
      "Show the operator's panel at the start (default: only in a window)");
  add_appearance_options(*bench, options.look);
  bench->add_flag("--quiet", options.is_quiet, "Print only warnings");
  bench->footer(key_help_text(bench::bench_key_lines(), 16) +
                "During a replay: Space pauses, Left and Right skip 5 s, + and - change the speed.\n"
                "Examples:\n  vrda-player bench knee.h5 --bench bench.toml --calibration anna.toml\n"
                "  vrda-player bench knee.h5 --replay monday.log --headless --video monday.mp4");
  return bench;
}

CLI::App* add_devices(CLI::App& app, bench::DevicesOptions& options)
{
  CLI::App* devices = app.add_subcommand(
      "devices", "List the devices of a bench: whether each answers, its sample rate, its last values");
  devices->add_option("BENCH", options.bench, "Bench file (schemas/bench.md)")->required();
  add(devices, "--seconds", "S", options.seconds, "Duration of the measurement")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  devices->add_flag("--json", options.has_json, "Print JSON");
  devices->footer("Example:\n  vrda-player devices bench.toml");
  return devices;
}

namespace {

void add_virtual(CLI::App* calibrate, calibration::CalibrateOptions& options)
{
  calibrate->add_flag("--virtual", options.is_virtual,
                      "Use a simulated bench and person: in a window for training; with --headless (or "
                      "with neither screen nor --calibration) a simulated operator does every task");
  add(calibrate, "--seed", "N", options.seed, "Seed of the virtual bench; a calibration belongs to one seed")
      ->check([](const std::string& text) {  // would wrap around
        return text.starts_with('-') ? "found " + text + ", wanted a whole number from 0" : "";
      })
      ->capture_default_str();
  add(calibrate, "--head", "stage|tracker", options.head,
      "Mount of the virtual bench's display, without --bench")
      ->capture_default_str();
  add(calibrate, "--benches", "N", options.n_benches,
      "Calibrate N virtual benches, seeds from --seed on, and report how often the intervals "
      "contain the true values; nothing else is written")
      ->check(CLI::Range(1, 100000));
  add(calibrate, "--noise", "NAME=X,...", options.noise,
      "Standard deviations of the virtual bench: alignment_px, touch_mm, landmark_mm, tracker_mm, "
      "tracker_deg, model_mm, model_deg, ...");
  add(calibrate, "--pictures", "DIR", options.pictures,
      "Folder for images of the calibrated virtual bench (--headless) or of each task of a "
      "script");
}

}  // namespace

CLI::App* add_calibrate(CLI::App& app, calibration::CalibrateOptions& options)
{
  CLI::App* calibrate = app.add_subcommand(
      "calibrate", "Calibrate a bench and its user step by step, with confidence intervals");
  calibrate
      ->add_option("STEP", options.step,
                   "viewport, distortion, eyepoints, ipd, tracking, head, subject, or one part of them; all; "
                   "functional: refines femur and tibia by bending the leg (--model); "
                   "bench, person: the steps done once per bench or per person; status: report the current "
                   "results; solve: recompute all results from the marks in the file")
      ->required();
  add(calibrate, "--bench", "BENCH.toml", options.bench,
      "Bench file: display, tracker and board (schemas/bench.md)");
  add(calibrate, "--calibration", "FILE.toml", options.calibration,
      "Calibration file, written after every mark (schemas/calibration.md); an existing one is resumed");
  add(calibrate, "--bench-from", "FILE.toml", options.bench_from,
      "Calibration of another person; its per-bench parts are copied to a new FILE");
  calibrate->add_flag("--anew", options.is_repeated,
                      "Restart the parts of STEP from their first task; omit it to resume them");
  add(calibrate, "--model", "FILE.h5", options.model,
      "Motion model, for functional, visual adjustment of its placement and images");
  add(calibrate, "--set", "SET", options.set, "Set of the model: raw, degree_N, ... (default: that of show)");
  calibrate->add_flag("--headless", options.is_headless, "Run without a window");
  add(calibrate, "--script", "FILE", options.script,
      "Read keys from a file: lines \"press Right 12\", \"wait 0.5\"");
  add(calibrate, "--samples", "1|2|4", options.samples, "Samples per pixel")
      ->check(CLI::IsMember({1, 2, 4}))
      ->option_text("1|2|4=1");
  add_virtual(calibrate, options);
  calibrate->add_flag("--json", options.has_json, "Print JSON");
  calibrate->add_flag("--quiet", options.is_quiet, "Print only warnings");
  calibrate->footer(
      key_help_text(calibration::session_key_lines(), 24) +
      "Exit code 4: stopped before STEP was complete; the same command resumes it.\n"
      "Examples:\n  vrda-player calibrate all --bench bench.toml --calibration anna.toml\n"
      "  vrda-player calibrate person --bench bench.toml --calibration bob.toml --bench-from anna.toml\n"
      "  vrda-player calibrate status --bench bench.toml --calibration anna.toml\n"
      "  vrda-player calibrate all --virtual");
  return calibrate;
}

CLI::App* add_measure_body(CLI::App& app, bench::MeasureBodyOptions& options)
{
  CLI::App* body = app.add_subcommand(
      "body", "Measure a marker body with the bench's tracker and print its lines for the bench file");
  body->add_option("ROLE", options.role,
                   "Body in the bench file that has marker names: leg, femur, tibia, head")
      ->required();
  add(body, "--bench", "BENCH.toml", options.bench,
      "Bench file (schemas/bench.md); markers_mm may be missing")
      ->required();
  add(body, "--seconds", "S", options.seconds, "Duration of the measurement")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  body->add_flag("--quiet", options.is_quiet, "Print only the lines");
  body->footer("Example:\n  vrda-player body femur --bench bench.toml");
  return body;
}

CLI::App* add_simulate(CLI::App& app, bench::SimulateOptions& options)
{
  CLI::App* simulate = app.add_subcommand(
      "simulate", "Simulate a bench's tracker and board: a bending leg with noise, occlusions and drop-outs");
  simulate->add_option("BENCH", options.bench, "Bench file with or without [simulation] (schemas/bench.md)")
      ->required();
  add(simulate, "--model", "FILE.h5", options.model,
      "Motion model that the simulated tibia follows (default: rotation only)");
  add(simulate, "--rehearse", "FILE.toml", options.rehearse,
      "Rehearse a calibration: follow FILE, which calibrate --bench writes, move probe, marker and stage as "
      "its "
      "next task requires, and print where a person would align the lines");
  add(simulate, "--address", "ADDRESS", options.address,
      "Listen address; any but 127.0.0.1 is reachable from other machines (default: the bench "
      "file's simulation.address, else 127.0.0.1)");
  add(simulate, "--seconds", "S", options.seconds, "Duration (default: until Ctrl-C)")
      ->check(CLI::Range(0.1, 1e6));
  simulate->add_flag("--quiet", options.is_quiet, "Print only the addresses");
  simulate->footer(
      "Example:\n  vrda-player simulate jobs/bench-desk.toml &\n"
      "  vrda-player bench knee.h5 --bench jobs/bench-desk.toml");
  return simulate;
}

}  // namespace vrda::app
