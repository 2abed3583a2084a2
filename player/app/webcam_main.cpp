// vrda-webcam: the tracker of a bench with `tracker = "aruco"`; vrda-player starts it.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <exception>
#include <iostream>
#include <string>

#include "bench/webcam.hpp"
#include "core/files.hpp"
#include "core/text.hpp"

namespace {

enum ExitCode { done = 0, bad_input = 2, internal_error = 5 };

/// False once the reader has closed its end.
bool write_all(const std::string& bytes)
{
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = ::write(STDOUT_FILENO, bytes.data() + at, bytes.size() - at);
    if (n < 0 && errno != EINTR) return false;
    if (n > 0) at += static_cast<std::size_t>(n);
  }
  return true;
}

int run(int argc, char** argv)
{
  using namespace vrda;
  CLI::App app("Tracks printed bodies with a webcam, for vrda-player", "vrda-webcam");
  app.set_version_flag("--version", "vrda-webcam " VRDA_VERSION);
  app.require_subcommand(1);
  app.add_flag_callback(
      "--no-lock", [] { permit_missing_locks([](const std::string& why) { std::cerr << why << "\n"; }); },
      "Go on where the file system has no locks (flock): no other process may write the same output");
  app.fallthrough();
  app.footer("Exit codes: 0 success, 2 invalid input or no camera, 5 internal error");
  std::string bench, pdf;
  bench::CalibrateOptions calibrate;
  CLI::App* track =
      app.add_subcommand("track", "Write OpenIGTLink messages to standard output; vrda-player starts this");
  track->add_option("BENCH", bench, "Bench file with tracker = \"aruco\" (schemas/bench.md)")->required();
  CLI::App* sheet =
      app.add_subcommand("sheet", "Write the sheets to print: the bodies, and the board for the calibration");
  sheet->add_option("BENCH", bench, "Bench file with tracker = \"aruco\"")->required();
  sheet->add_option("-o,--output", pdf, "PDF file")->required()->type_name("FILE.pdf");
  CLI::App* calibration =
      app.add_subcommand("calibrate", "Calibrate the camera: show it the board from all sides");
  calibration->add_option("BENCH", calibrate.bench, "Bench file with tracker = \"aruco\"")->required();
  calibration
      ->add_option("-o,--output", calibrate.output,
                   "Camera file (default: camera.calibration of the bench file)")
      ->type_name("FILE.toml");
  calibration->add_option("--views", calibrate.n_views, "Views to take")
      ->check(CLI::Range(5, 200))
      ->capture_default_str()
      ->type_name("N");
  calibration->add_option("--seconds", calibrate.seconds, "Longest duration")
      ->check(CLI::Range(0.1, 1e5))
      ->capture_default_str()
      ->type_name("S");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::cerr << "vrda-webcam: " << error.what() << " (see vrda-webcam --help)\n";
    return bad_input;
  }
  try {
    if (track->parsed()) bench::track(bench, write_all);
    if (sheet->parsed()) bench::write_sheets(bench, pdf);
    if (calibration->parsed()) bench::calibrate(calibrate, std::cerr);
    return done;
  } catch (const InputError& error) {
    std::cerr << "vrda-webcam: " << error.what() << "\n";
    if (track->parsed()) write_all(bench::error_message(error.what()));
    return bad_input;
  }
}

}  // namespace

int main(int argc, char** argv)
{
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "vrda-webcam: internal error: " << error.what() << "\n";
    return internal_error;
  }
}
