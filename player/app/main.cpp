// vrda-player: its modes with their options on the command line and what they run. Exceptions become one
// message and an exit code. Options structs are filled while CLI11 parses; a wrong value is a usage error
// "found X, wanted Y".
#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/bench_run.hpp"
#include "bench/body_tracker.hpp"
#include "calibration/calibrate.hpp"
#include "calibration/operator.hpp"
#include "calibration/session.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "show/follow.hpp"
#include "show/show.hpp"
#include "store/read_separately.hpp"
#include "view/keys.hpp"
#include "web/server.hpp"

namespace vrda::app {
namespace {

enum ExitCode { done = 0, bad_input = 2, unsolved_attitudes = 3, interrupted = 4, internal_error = 5 };

/// README.md of this room describes the exit codes.
struct Mode {
  CLI::App* command = nullptr;
  std::function<ExitCode()> run;  ///< with the parsed options
};
using Modes = std::vector<Mode>;

/// Paths and other results, and messages.
const show::Streams streams{std::cout, std::cerr};

/// Adds a mode with options of its own, which `declare(mode, options)` declares and `run(options)` reads;
/// `run` returns an exit code.
template <typename Options, typename Declare, typename Run>
void add_mode(CLI::App& app, Modes& modes, const char* name, const char* about, const Declare& declare,
              Run run)
{
  CLI::App* const mode = app.add_subcommand(name, about);
  const auto options = std::make_shared<Options>();
  declare(*mode, *options);
  modes.push_back({mode, [options, run] { return run(*options); }});
}

/// Adds an option whose value is called `type` in the help.
template <typename Value>
CLI::Option* add(CLI::App& mode, const char* name, const char* type, Value& value, const std::string& text)
{
  return mode.add_option(name, value, text)->type_name(type);
}

/// For CLI::Option::check: returns an error text for an empty value, otherwise an empty string.
std::string empty_value_error(const std::string& text)
{
  return text.empty() ? "found nothing, wanted a name" : "";
}

/// Adds an option that is one of the names of `choices`; reports any other as "found X, wanted A, B or C".
template <typename Value>
void add_choice(CLI::App& mode, const char* name, const char* type, Value& value,
                const std::map<std::string, Value>& choices, const char* text)
{
  const auto to_number = [choices](std::string& word) {
    std::vector<std::string> names;
    for (const auto& [known, number] : choices) {
      if (known == word) {
        word = std::to_string(static_cast<int>(number));
        return std::string();
      }
      names.push_back(known);
    }
    return "found '" + word + "', wanted " + join_alternatives(names);
  };
  mode.add_option(name, value, text)
      ->transform(CLI::Validator(to_number, "NAME"))
      ->type_name(type)
      ->option_text(type);
}

/// Adds the options of pictures that all modes have that render.
void add_appearance_options(CLI::App& mode, view::AppearanceOptions& look)
{
  add(mode, "--layers", "LAYER,...", look.layers,
      "Layers to show with the bodies: contacts, normals (forces where known), axes, helical-axis, gaps, "
      "ligaments, contact-paths, labels, band; or none (default: ligaments, if the model has them)");
  add_choice<view::DrawMode>(mode, "--mode", "MODE", look.mode,
                             {{"wire", view::DrawMode::wire},
                              {"hidden-line", view::DrawMode::hidden_line},
                              {"flat", view::DrawMode::flat},
                              {"smooth", view::DrawMode::smooth},
                              {"textured", view::DrawMode::textured}},
                             "wire, hidden-line, flat, smooth or textured (default textured)");
  CLI::Option* texture = add(mode, "--texture", "FILE.png", look.texture,
                             "Tiled texture image for bone, with matching edges (default: mottled)");
  add(mode, "--texture-scale", "MM", look.texture_scale_mm, "Width of one tile")
      ->needs(texture)
      ->capture_default_str();
  add(mode, "--lights", "FILE.toml", look.lights, "Lights and background (default: studio)");
  add(mode, "--see-through", "NAME,...", look.see_through,
      "Transparent structures: a bone with its cartilage (femur, talus, ... or reference, moving), both, a "
      "part or a bundle (meniscus_medial, ACLam, ...)");
  add(mode, "--hide", "NAME,...", look.hidden, "Structures to hide; names as for --see-through");
}

// show, web and follow.

void add_trace(CLI::App& mode, show::ShowOptions& options)
{
  add(mode, "--trace", "FILE", options.trace,
      "Trace (.trace.h5) of the motion model: show one search from its seed to its end, one frame per "
      "step, named VIEW_frame_NUMBER.png; --flexion and --varus choose the grid cell (default: the "
      "spine cell of the first flexion)");
  mode.add_flag("--contact-only", options.contact_only,
                "With --trace: only steps in contact, which give a smooth motion");
  add(mode, "--every", "N", options.every, "With --trace: only every N-th frame, and the last")
      ->capture_default_str();
}

void add_video(CLI::App& mode, show::ShowOptions& options)
{
  add(mode, "--video", "FILE", options.video,
      "Video of all views side by side, written by ffmpeg: .mp4, .webm or .gif")
      ->check(empty_value_error);
  add(mode, "--fps", "N", options.frames_per_s, "Frames per second of the video (default 25)");
  add(mode, "--speed", "N", options.speed_deg_s,
      "Degrees per second of the video (default 30; with --flexion one frame per angle)");
  mode.add_flag("--to-and-fro", options.is_to_and_fro, "Play the video forwards, then backwards");
  mode.add_flag("--numbers", options.has_numbers, "Show angles and gaps on images and video");
}

void add_framing(CLI::App& mode, show::ShowOptions& options)
{
  add(mode, "--size", "WxH", options.size,
      "Size of an image or of the window, in pixels (default: the job's [player], else 1280x960)");
  add(mode, "--samples", "1|2|4", options.samples,
      "Samples per pixel: 1 has jagged edges and is several times faster without a graphics card; default: "
      "4, in a window without a graphics card 1")
      ->check(CLI::IsMember({1, 2, 4}))
      ->option_text("1|2|4");
  add_choice<view::Backdrop>(mode, "--background", "NAME", options.backdrop,
                             {{"studio", view::Backdrop::studio},
                              {"night", view::Backdrop::night},
                              {"black", view::Backdrop::black}},
                             "studio, night or black (default studio)");
  add_choice<BodyIndex>(
      mode, "--hold", "NAME", options.fixed_object,
      {{"tibia", BodyIndex::moving},
       {"femur", BodyIndex::reference},
       {"moving", BodyIndex::moving},
       {"reference", BodyIndex::reference},
       {"push", BodyIndex::world}},
      "Fixed on screen: tibia or femur (of other joints moving, reference), which then does not move at all; "
      "or push, the direction of push (default tibia)");
  add_choice<view::Framing>(mode, "--frame", "NAME", options.framing,
                            {{"joint", view::Framing::joint}, {"all", view::Framing::all}},
                            "What the image contains: joint, or all of both objects (default joint)");
}

void declare_show(CLI::App& mode, show::ShowOptions& options)
{
  mode.add_option("FILE", options.file, "Motion model (.h5)")->required();
  mode.add_option(
      "OTHER", options.other.file,
      "Second motion model: both joints side by side, with plots of the differences over flexion");
  add(mode, "--other-set", "SET", options.other.set,
      "Set of the second joint; without OTHER, of the same model again");
  add(mode, "--other-varus", "DEG", options.other.varus_deg,
      "Varus of the second joint minus that of the first");
  add(mode, "--without", "BUNDLE", options.other.without,
      "The second joint is drawn without this bundle; its motion is that of the file")
      ->check(empty_value_error);
  mode.add_flag("--overlay", options.other.is_over, "The second joint over the first, translucent");
  add(mode, "--offscreen", "DIR", options.folder,
      "Folder for images named VIEW_flexion_ANGLE.png, instead of a window")
      ->check(empty_value_error);
  add(mode, "--flexion", "A:B:STEP", options.flexion,
      "Angles in degrees (default: the grid's range in six steps); a window starts at A");
  add(mode, "--key", "A:B:STEP", options.frame,
      "Of a sequence of frames: keys instead of angles (default: seven frames, a video: all); a window "
      "starts at A");
  add(mode, "--varus", "ANGLE", options.varus_deg,
      "Angle in degrees, adduction positive (default: the varus that balances both compartments "
      "at each flexion, interpolated linearly between solved flexions)");
  add(mode, "--set", "SET", options.set,
      "two_sided, raw, degree_N, degree_N_recontacted, zero_varus, bones_alone of a job with a prior, or "
      "quantile_0, 5, 50, 95 or 100 of an "
      "uncertain job (default: the model's default motion, which vrda info names)");
  add(mode, "--views", "VIEW,...", options.views,
      "front, back, left, right, medial, lateral (or side), top, oblique, inverted (oblique and "
      "upside down); default: the views of the job's [player], else oblique");
  add_trace(mode, options);
  add_video(mode, options);
  add_framing(mode, options);
  add_appearance_options(mode, options.appearance);
  CLI::Option* section =
      add(mode, "--section", "PLANE=MM", options.section_text,
          "Cut by a plane: sagittal, coronal, axial or a normal X,Y,Z (axes of what is fixed on screen), and "
          "its distance from the rotation centre; the camera's side is not drawn");
  CLI::Option* view =
      add(mode, "--view", "STATE", options.view,
          "State of a view (schemas/view-state.md): a file, an address of the page or the JSON");
  for (const char* other : {"--set", "--flexion", "--key", "--varus", "--views", "--hold", "--frame",
                            "--layers", "--hide", "--see-through", "--trace"})
    view->excludes(mode.get_option(other));
  view->excludes(section);
  mode.add_flag("--quiet", options.is_quiet, "Print only paths and warnings");
  mode.footer(view::help_text() +
              "Examples:\n  vrda-player show knee.h5\n"
              "  vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15 --views front,lateral\n"
              "  vrda-player show knee.h5 --video knee.mp4 --views front,lateral --to-and-fro\n"
              "  vrda-player show left.h5 other.h5 --overlay\n"
              "  vrda-player show knee.h5 --without ACLam");
  mode.callback([&mode, &options] { options.has_mode = mode.count("--mode") > 0; });
}

/// `web`, with the bench that it streams.
struct WebMode {
  web::WebOptions web;
  std::vector<std::string> tls;  ///< certificate and key
  bench::BenchOptions bench;
};

void declare_web(CLI::App& mode, WebMode& of)
{
  web::WebOptions& options = of.web;
  mode.add_option("FILE", options.file, "Motion model (.h5)")->required();
  add(mode, "--address", "A", options.address,
      "Listen address (default: 127.0.0.1; any other requires --tls or --self-signed)")
      ->check(empty_value_error);
  add(mode, "--port", "N", options.port, "Port (default: any free port)")->check(CLI::Range(0, 65535));
  add(mode, "--tls", "CERT KEY", of.tls,
      "Certificate and private key (PEM): browsers of other machines require HTTPS")
      ->expected(2)
      ->check(empty_value_error);
  mode.add_flag("--self-signed", options.is_self_signed,
                "Make the certificate; with --tls, write the two files unless they exist");
  mode.add_flag("--qr", options.has_qr_code,
                "Print the address as a QR code (always with --address of the network)");
  add(mode, "--bench", "BENCH.toml", of.bench.bench,
      "Stream flexion and placement of a tracked leg to all browsers (schemas/bench.md, schemas/live.md)")
      ->check(empty_value_error);
  add(mode, "--calibration", "FILE.toml", of.bench.calibration,
      "Calibration of the bench (default: nominal)");
  add(mode, "--set", "SET", of.bench.set, "Set of the streamed motion (default: that of show)");
  mode.add_flag("--open", options.opens_browser, "Open the page in the default browser");
  mode.add_flag("--quiet", options.is_quiet, "Print only the address");
  mode.footer(
      "Prints the page's address and serves until Ctrl-C. The address contains a secret token; requests\n"
      "without it are rejected. WebXR needs https or an address of the device itself. For a headset or a\n"
      "phone on the network:\n"
      "  vrda-player web knee.h5 --address 192.168.1.20 --tls cert.pem key.pem --self-signed\n"
      "For an Android phone by USB, without a certificate:\n"
      "  vrda-player web knee.h5 --port 8443 --qr    and    adb reverse tcp:8443 tcp:8443\n"
      "Examples:\n  vrda-player web knee.h5 --open\n"
      "  vrda-player web knee.h5 --bench bench.toml --calibration anna.toml");
  mode.callback([&of] {
    if (of.tls.empty()) return;
    of.web.certificate = of.tls.front();
    of.web.key = of.tls.back();
  });
}

/// Serves the page; with a bench file the bench, too.
void run_web(WebMode& mode)
{
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

void declare_follow(CLI::App& mode, show::FollowOptions& options)
{
  mode.add_option("START", options.file, "The run's start file (OUTPUT.start.h5)")->required();
  add(mode, "--offscreen", "DIR", options.folder, "Folder for images named step_NUMBER.png and finished.png")
      ->check(empty_value_error);
  add(mode, "--every", "SECONDS", options.every_s, "Write an image at this interval if there are new steps");
  add(mode, "--each", "N", options.every_n_steps, "Write an image every N steps");
  mode.add_flag("--once", options.is_once, "Report the present state and exit");
  mode.add_flag("--text", options.is_text, "Print progress only, without images");
  add(mode, "--steps", "WHICH", options.steps,
      "Steps to show: stable; contact (also search steps in contact); all. Search steps are available "
      "for runs with --trace")
      ->capture_default_str();
  add(mode, "--views", "VIEW,...", options.views,
      "As for show (default: the job's views, else front,lateral)");
  add(mode, "--orient", "X,Y,Z;...", options.orient,
      "One triple per view: rotation of the joint in degrees about the axes of the front view (right, "
      "up, towards the viewer) (ORIENTATION_MODEL)");
  add(mode, "--shift", "X,Y,Z;...", options.shift,
      "One triple per view: shift in mm along these axes (SHIFT_MODEL)");
  add_appearance_options(mode, options.appearance);
  mode.add_flag("--opaque", options.is_opaque,
                "Draw the reference opaque (default: transparent, so that contacts are visible)");
  add(mode, "--size", "WxH", options.size, "Image size in pixels (default: the job's, else 1280x960)");
  mode.add_flag("--quiet", options.is_quiet, "Print no progress");
  mode.footer(
      "Keys: Space pauses, or plays the result; R resets the views; Q quits.\n"
      "Mouse: as for show.\n"
      "Reads the start file and the journals next to it, on this machine or in a shared folder, and never\n"
      "writes there. Ends when the result exists, or with Ctrl-C.\n"
      "Example:\n  vrda-player follow knee.h5.start.h5 --offscreen pictures --every 10 --views front,side");
  mode.callback([&mode, &options] { options.has_mode = mode.count("--mode") > 0; });
}

void add_show_modes(CLI::App& app, Modes& modes)
{
  add_mode<show::ShowOptions>(
      app, modes, "show",
      "Show a motion model in a window, or write images (--offscreen) or a video (--video)", declare_show,
      [](const show::ShowOptions& options) {
        return show::show(options, streams).n_unsolved > 0 ? unsolved_attitudes : done;
      });
  add_mode<WebMode>(
      app, modes, "web",
      "Serve a motion model and its viewer page to browsers, also in augmented and virtual reality",
      declare_web, [](WebMode& mode) { return run_web(mode), done; });
  add_mode<show::FollowOptions>(
      app, modes, "follow", "Show the progress of a running computation", declare_follow,
      [](const show::FollowOptions& options) {
        return show::follow(options, streams) == show::FollowEnd::finished ? done : interrupted;
      });
}

// bench, serve, devices, body, simulate and calibrate.

/// "Keys:" and one line per key; the descriptions start at `column`.
std::string key_help_text(std::span<const view::HelpLine> lines, std::size_t column)
{
  std::string text = "Keys:\n";
  for (const view::HelpLine& line : lines) {
    std::string keys = line.keys;
    keys.resize(std::max(column, keys.size() + 2), ' ');
    text += "  " + keys + line.description + "\n";
  }
  return text;
}

void add_igtl(CLI::App& mode, bench::IgtlOptions& options)
{
  add(mode, "--igtl", "PORT", options.port,
      "Send the joint to OpenIGTLink programs such as 3D Slicer that connect to this port; 0: any free port")
      ->check(CLI::Range(0, 65535));
  add(mode, "--igtl-address", "ADDRESS", options.address,
      "Listen address of --igtl; any but 127.0.0.1 is reachable from other machines")
      ->capture_default_str();
}

void declare_bench(CLI::App& mode, bench::BenchOptions& options)
{
  options.look.mode = view::DrawMode::smooth;
  mode.add_option("FILE", options.file, "Motion model (.h5)")->required();
  add(mode, "--bench", "BENCH.toml", options.bench,
      "Bench file: display, tracker and board (schemas/bench.md)");
  add(mode, "--calibration", "FILE.toml", options.calibration,
      "Calibration file (schemas/calibration.md); the key W writes it (default: nominal values)");
  add(mode, "--set", "SET", options.set, "raw, degree_N, ... (default: the default set of show)");
  mode.add_flag("--headless", options.is_headless, "Render to memory, without a window");
  add(mode, "--seconds", "S", options.seconds, "Duration of the run")->check(CLI::Range(0.1, 1e6));
  add(mode, "--pictures", "DIR", options.pictures, "Folder for the displayed frames, as PNG files");
  add(mode, "--video", "FILE.mp4", options.video, "Video file of the displayed frames");
  add(mode, "--every", "N", options.every, "Keep every N-th frame for --pictures and --video")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  add(mode, "--record", "LOG", options.record, "Record every device sample and key in a new file");
  add(mode, "--replay", "LOG", options.replay, "Replay a recording instead of reading the devices");
  add(mode, "--from", "S", options.from_s, "Start time of the replay in the recording")
      ->check(CLI::Range(0.0, 1e6));
  add(mode, "--speed", "X", options.speed,
      "Replay speed factor (default: 1 in a window, unlimited without a window)");
  add(mode, "--timing", "FILE.json", options.timing, "Write latency, jitter and counts as JSON");
  add_igtl(mode, options.igtl);
  add(mode, "--samples", "1|2|4", options.samples, "Samples per pixel")
      ->check(CLI::IsMember({1, 2, 4}))
      ->option_text("1|2|4=4");
  // A callback, because CLI11 also stores false in a bound flag when the option is absent.
  mode.add_flag_function(
      "--panel,!--no-panel", [&options](std::int64_t given) { options.has_panel = given > 0; },
      "Show the operator's panel at the start (default: in a window with room beside the eyes' views)");
  add_appearance_options(mode, options.look);
  mode.add_flag("--quiet", options.is_quiet, "Print only warnings");
  mode.footer(key_help_text(bench::bench_key_lines(), 16) +
              "During a replay: Space pauses, Left and Right skip 5 s, + and - change the speed.\n"
              "Examples:\n  vrda-player bench knee.h5 --bench bench.toml --calibration anna.toml\n"
              "  vrda-player bench knee.h5 --replay monday.log --headless --video monday.mp4");
}

void declare_serve(CLI::App& mode, bench::ServeOptions& options)
{
  mode.add_option("FILE", options.file, "Motion model (.h5)")->required();
  add_igtl(mode, options.igtl);
  add(mode, "--set", "SET", options.set, "raw, degree_N, ... (default: the default set of show)");
  add(mode, "--rate", "HZ", options.rate_hz, "Frames a second")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  CLI::Option* held = add(mode, "--flexion", "DEG", options.flexion_deg,
                          "Held flexion (default: to and fro over the model's range)");
  add(mode, "--varus", "DEG", options.varus_deg, "Held varus (default: balanced)");
  add(mode, "--period", "S", options.period_s, "Duration of a bend and a stretch")
      ->check(CLI::Range(0.1, 1e6))
      ->excludes(held)
      ->capture_default_str();
  add(mode, "--bench", "BENCH.toml", options.bench,
      "Send the leg tracked by this bench (schemas/bench.md), without a picture");
  add(mode, "--calibration", "FILE.toml", options.calibration,
      "Calibration file of the bench, which must exist (default: nominal values)");
  add(mode, "--seconds", "S", options.seconds, "Duration (default: until Ctrl-C)")
      ->check(CLI::Range(0.1, 1e6));
  mode.add_flag("--quiet", options.is_quiet, "Print only the address");
  mode.footer(
      "Each client receives both meshes once (POLYDATA), then per frame the poses of the bones, of the eyes\n"
      "and of the probe (TRANSFORM, mm) and the angles (STRING). Hidden bodies are left out.\n"
      "Examples:\n  vrda-player serve knee.h5 --igtl 18944\n"
      "  vrda-player serve knee.h5 --igtl 18944 --bench bench.toml --calibration anna.toml");
}

void declare_devices(CLI::App& mode, bench::DevicesOptions& options)
{
  mode.add_option("BENCH", options.bench, "Bench file (schemas/bench.md)")->required();
  add(mode, "--seconds", "S", options.seconds, "Duration of the measurement")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  mode.add_flag("--json", options.has_json, "Print JSON");
  mode.footer("Example:\n  vrda-player devices bench.toml");
}

void declare_body(CLI::App& mode, bench::MeasureBodyOptions& options)
{
  mode.add_option("ROLE", options.role,
                  "Body in the bench file that has marker names: leg, femur, tibia, head")
      ->required();
  add(mode, "--bench", "BENCH.toml", options.bench,
      "Bench file (schemas/bench.md); markers_mm may be missing")
      ->required();
  add(mode, "--seconds", "S", options.seconds, "Duration of the measurement")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  mode.add_flag("--quiet", options.is_quiet, "Print only the lines");
  mode.footer("Example:\n  vrda-player body femur --bench bench.toml");
}

void declare_simulate(CLI::App& mode, bench::SimulateOptions& options)
{
  mode.add_option("BENCH", options.bench, "Bench file with or without [simulation] (schemas/bench.md)")
      ->required();
  add(mode, "--model", "FILE.h5", options.model,
      "Motion model that the simulated tibia follows (default: rotation only)");
  add(mode, "--rehearse", "FILE.toml", options.rehearse,
      "Rehearse a calibration: follow FILE, which calibrate --bench writes, move probe, marker and stage as "
      "its "
      "next task requires, and print where a person would align the lines");
  add(mode, "--address", "ADDRESS", options.address,
      "Listen address; any but 127.0.0.1 is reachable from other machines (default: the bench "
      "file's simulation.address, else 127.0.0.1)");
  add(mode, "--seconds", "S", options.seconds, "Duration (default: until Ctrl-C)")
      ->check(CLI::Range(0.1, 1e6));
  mode.add_flag("--quiet", options.is_quiet, "Print only the addresses");
  mode.footer(
      "Example:\n  vrda-player simulate jobs/bench-desk.toml &\n"
      "  vrda-player bench knee.h5 --bench jobs/bench-desk.toml");
}

void add_virtual(CLI::App& mode, calibration::CalibrateOptions& options)
{
  mode.add_flag("--virtual", options.is_virtual,
                "Use a simulated bench and person: in a window for training; with --headless (or "
                "with neither screen nor --calibration) a simulated operator does every task");
  add(mode, "--seed", "N", options.seed, "Seed of the virtual bench; a calibration belongs to one seed")
      ->check([](const std::string& text) {  // would wrap around
        return text.starts_with('-') ? "found " + text + ", wanted a whole number from 0" : "";
      })
      ->capture_default_str();
  add(mode, "--head", "stage|tracker", options.head, "Mount of the virtual bench's display, without --bench")
      ->capture_default_str();
  add(mode, "--benches", "N", options.n_benches,
      "Calibrate N virtual benches, seeds from --seed on, and report how often the intervals "
      "contain the true values; nothing else is written")
      ->check(CLI::Range(1, 100000));
  add(mode, "--noise", "NAME=X,...", options.noise,
      "Standard deviations of the virtual bench: alignment_px, touch_mm, landmark_mm, tracker_mm, "
      "tracker_deg, model_mm, model_deg, ...");
  add(mode, "--pictures", "DIR", options.pictures,
      "Folder for images of the calibrated virtual bench (--headless) or of each task of a "
      "script");
}

void declare_calibrate(CLI::App& mode, calibration::CalibrateOptions& options)
{
  mode.add_option("STEP", options.step,
                  "viewport, distortion, eyepoints, ipd, tracking, head, subject, or one part of them; all; "
                  "functional: refines femur and tibia by bending the leg (--model); "
                  "bench, person: the steps done once per bench or per person; status: report the current "
                  "results; solve: recompute all results from the marks in the file")
      ->required();
  add(mode, "--bench", "BENCH.toml", options.bench,
      "Bench file: display, tracker and board (schemas/bench.md)");
  add(mode, "--calibration", "FILE.toml", options.calibration,
      "Calibration file, written after every mark (schemas/calibration.md); an existing one is resumed");
  add(mode, "--bench-from", "FILE.toml", options.bench_from,
      "Calibration of another person; its per-bench parts are copied to a new FILE");
  mode.add_flag("--anew", options.is_repeated,
                "Restart the parts of STEP from their first task; omit it to resume them");
  add(mode, "--model", "FILE.h5", options.model,
      "Motion model, for functional, visual adjustment of its placement and images");
  add(mode, "--set", "SET", options.set, "Set of the model: raw, degree_N, ... (default: that of show)");
  mode.add_flag("--headless", options.is_headless, "Run without a window");
  add(mode, "--script", "FILE", options.script,
      "Read keys from a file: lines \"press Right 12\", \"wait 0.5\"");
  add(mode, "--samples", "1|2|4", options.samples, "Samples per pixel")
      ->check(CLI::IsMember({1, 2, 4}))
      ->option_text("1|2|4=1");
  add_virtual(mode, options);
  mode.add_flag("--json", options.has_json, "Print JSON");
  mode.add_flag("--quiet", options.is_quiet, "Print only warnings");
  mode.footer(
      key_help_text(calibration::session_key_lines(), 24) +
      "Exit code 4: stopped before STEP was complete; the same command resumes it.\n"
      "Examples:\n  vrda-player calibrate all --bench bench.toml --calibration anna.toml\n"
      "  vrda-player calibrate person --bench bench.toml --calibration bob.toml --bench-from anna.toml\n"
      "  vrda-player calibrate status --bench bench.toml --calibration anna.toml\n"
      "  vrda-player calibrate all --virtual");
}

void add_bench_modes(CLI::App& app, Modes& modes)
{
  add_mode<bench::BenchOptions>(
      app, modes, "bench",
      "Drive the see-through stereoscopic bench from its tracker, parallax stage and potentiometer",
      declare_bench,
      [](const bench::BenchOptions& options) { return bench::run_bench(options, streams), done; });
  add_mode<bench::ServeOptions>(
      app, modes, "serve",
      "Send a joint to other programs by OpenIGTLink: a motion, or the leg tracked by a bench", declare_serve,
      [](const bench::ServeOptions& options) { return bench::serve(options, streams), done; });
  add_mode<bench::DevicesOptions>(
      app, modes, "devices",
      "List the devices of a bench: whether each answers, its sample rate, its last values", declare_devices,
      [](const bench::DevicesOptions& options) {
        return bench::list_devices(options, streams) > 0 ? unsolved_attitudes : done;
      });
  add_mode<bench::MeasureBodyOptions>(
      app, modes, "body",
      "Measure a marker body with the bench's tracker and print its lines for the bench file", declare_body,
      [](const bench::MeasureBodyOptions& options) { return bench::measure_body(options, streams), done; });
  add_mode<bench::SimulateOptions>(
      app, modes, "simulate",
      "Simulate a bench's tracker and board: a bending leg with noise, occlusions and drop-outs",
      declare_simulate, [](const bench::SimulateOptions& options) {
        options.rehearse.empty() ? bench::simulate(options, streams)
                                 : calibration::rehearse(options, streams);
        return done;
      });
  add_mode<calibration::CalibrateOptions>(
      app, modes, "calibrate", "Calibrate a bench and its user step by step, with confidence intervals",
      declare_calibrate, [](const calibration::CalibrateOptions& options) {
        return calibration::calibrate(options, streams) == calibration::CalibrateEnd::finished ? done
                                                                                               : interrupted;
      });
}

// The program.

/// The arguments, with the mode show before those of "vrda-player FILE.h5".
std::vector<const char*> with_mode(const Modes& modes, int argc, char** argv)
{
  const auto is_model = [](const std::string& word) {
    return word.ends_with(".h5") || word.ends_with(".hdf5") || std::filesystem::is_regular_file(word);
  };
  std::vector<const char*> words(argv, argv + argc);
  const auto first =
      std::find_if(words.begin() + std::min(argc, 1), words.end(),
                   [](const std::string& word) { return word != "--unsealed" && word != "--no-lock"; });
  const auto is_named = [&](const Mode& mode) { return mode.command->get_name() == *first; };
  if (first == words.end() || std::any_of(modes.begin(), modes.end(), is_named)) return words;
  const bool is_shown = **first == '-' ? std::any_of(first, words.end(), is_model) : is_model(*first);
  if (is_shown) words.insert(first, "show");
  return words;
}

/// Reports an unknown option before a missing one; CLI11 reports the missing one first.
void parse(CLI::App& app, const std::vector<const char*>& words)
{
  try {
    app.parse(static_cast<int>(words.size()), words.data());
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
      "--unsealed", [] { store::accept_unsealed_files(); },
      "Accept files without a seal, written or changed by another program");
  app.add_flag_callback(
      "--no-lock", [] { permit_missing_locks([](const std::string& why) { std::cerr << why << "\n"; }); },
      "Go on where the file system has no locks (flock): no other process may write the same output");
  app.fallthrough();  // both options may follow the mode
  store::on_unconfined_read([](const std::string& why) {
    std::cerr << "vrda-player: this system does not sandbox the process that reads HDF5 (" << why
              << "); its resource limits still apply\n";
  });
  app.set_version_flag("--version", "vrda-player " VRDA_VERSION);
  app.require_subcommand(0, 1);
  app.footer(
      "Example:\n  vrda-player knee.h5          (the same as vrda-player show knee.h5)\n\n"
      "Exit codes: 0 success, 2 invalid input, 3 unsolved attitudes (or a device that does not answer), 4 "
      "stopped before the followed run or the calibration was complete (the same command resumes), 5 "
      "internal error");
  Modes modes;
  add_show_modes(app, modes);
  add_bench_modes(app, modes);
  try {
    parse(app, with_mode(modes, argc, argv));
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::cerr << "vrda-player: " << error.what() << " (see vrda-player --help)\n";
    return bad_input;
  }
  for (const Mode& mode : modes) {
    if (mode.command->parsed()) return mode.run();
  }
  std::cerr
      << "vrda-player: found no mode, wanted show, follow, web, bench, serve, calibrate, body, simulate "
         "or devices (see vrda-player --help)\n";
  return bad_input;
}

int refused(const InputError& error)
{
  std::cerr << "vrda-player: " << error.what() << "\n";
  return bad_input;
}

}  // namespace
}  // namespace vrda::app

int main(int argc, char** argv)
{
  try {
    return vrda::app::run(argc, argv);
  } catch (const vrda::InputError& error) {
    return vrda::app::refused(error);
  } catch (const std::filesystem::filesystem_error& error) {
    return vrda::app::refused(vrda::input_error_of(error));
  } catch (const std::exception& error) {
    std::cerr << "vrda-player: internal error: " << error.what()
              << "\nPlease report it with the command line and the file.\n";
    return vrda::app::internal_error;
  }
}
