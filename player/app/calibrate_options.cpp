// The options of `calibrate`.
#include "app/options.hpp"

#include <CLI/CLI.hpp>

#include "app/named_choice.hpp"
#include "guide/session.hpp"

namespace vrda {
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

}  // namespace vrda
