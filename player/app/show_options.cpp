// Options of the modes `show`, `follow` and `web`.
#include <CLI/CLI.hpp>
#include <map>
#include <vector>

#include "app/options.hpp"
#include "core/text.hpp"
#include "view/keys.hpp"

namespace vrda::app {
namespace {

/// Adds an option that is one of the names of `choices`; reports any other as "found X, wanted A, B or C".
template <typename Value>
void add_choice(CLI::App* mode, const char* name, const char* type, Value& value,
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
  mode->add_option(name, value, text)
      ->transform(CLI::Validator(to_number, "NAME"))
      ->type_name(type)
      ->option_text(type);
}

void add_trace(CLI::App* show, show::ShowOptions& options)
{
  add(show, "--trace", "FILE", options.trace,
      "Trace (.trace.h5) of the motion model: show one search from its seed to its end, one frame per "
      "step, named VIEW_frame_NUMBER.png; --flexion and --varus choose the grid cell (default: the "
      "spine cell of the first flexion)");
  show->add_flag("--contact-only", options.contact_only,
                 "With --trace: only steps in contact, which give a smooth motion");
  add(show, "--every", "N", options.every, "With --trace: only every N-th frame, and the last")
      ->capture_default_str();
}

void add_video(CLI::App* show, show::ShowOptions& options)
{
  add(show, "--video", "FILE", options.video,
      "Video of all views side by side, written by ffmpeg: .mp4, .webm or .gif")
      ->check(empty_value_error);
  add(show, "--fps", "N", options.frames_per_s, "Frames per second of the video (default 25)");
  add(show, "--speed", "N", options.speed_deg_s,
      "Degrees per second of the video (default 30; with --flexion one frame per angle)");
  show->add_flag("--to-and-fro", options.is_to_and_fro, "Play the video forwards, then backwards");
  show->add_flag("--numbers", options.has_numbers, "Show angles and gaps on images and video");
}

void add_framing(CLI::App* show, show::ShowOptions& options)
{
  add(show, "--size", "WxH", options.size,
      "Size of an image or of the window, in pixels (default: the job's [player], else 1280x960)");
  add(show, "--samples", "1|2|4", options.samples,
      "Samples per pixel: 1 has jagged edges and is several times faster without a graphics card; default: "
      "4, in a window without a graphics card 1")
      ->check(CLI::IsMember({1, 2, 4}))
      ->option_text("1|2|4");
  add_choice<view::Backdrop>(show, "--background", "NAME", options.backdrop,
                             {{"studio", view::Backdrop::studio},
                              {"night", view::Backdrop::night},
                              {"black", view::Backdrop::black}},
                             "studio, night or black (default studio)");
  add_choice<BodyIndex>(
      show, "--hold", "NAME", options.fixed_object,
      {{"tibia", BodyIndex::moving},
       {"femur", BodyIndex::reference},
       {"moving", BodyIndex::moving},
       {"reference", BodyIndex::reference},
       {"push", BodyIndex::world}},
      "Fixed on screen: tibia or femur (of other joints moving, reference), which then does not move at all; "
      "or push, the direction of push (default tibia)");
  add_choice<view::Framing>(show, "--frame", "NAME", options.framing,
                            {{"joint", view::Framing::joint}, {"all", view::Framing::all}},
                            "What the image contains: joint, or all of both objects (default joint)");
}

}  // namespace

CLI::App* add_show(CLI::App& app, show::ShowOptions& options)
{
  CLI::App* show = app.add_subcommand(
      "show", "Show a motion model in a window, or write images (--offscreen) or a video (--video)");
  show->add_option("FILE", options.file, "Motion model (.h5)")->required();
  add(show, "--offscreen", "DIR", options.folder,
      "Folder for images named VIEW_flexion_ANGLE.png, instead of a window")
      ->check(empty_value_error);
  add(show, "--flexion", "A:B:STEP", options.flexion,
      "Angles in degrees (default: the grid's range in six steps); a window starts at A");
  add(show, "--key", "A:B:STEP", options.frame,
      "Of a sequence of frames: keys instead of angles (default: seven frames, a video: all); a window "
      "starts at A");
  add(show, "--varus", "ANGLE", options.varus_deg,
      "Angle in degrees, adduction positive (default: the varus that balances both compartments "
      "at each flexion, interpolated linearly between solved flexions)");
  add(show, "--set", "SET", options.set,
      "two_sided, raw, degree_N, degree_N_recontacted, zero_varus, or quantile_0, 5, 50, 95 or 100 of an "
      "uncertain job (default: the model's default motion, which vrda info names)");
  add(show, "--views", "VIEW,...", options.views,
      "front, back, left, right, medial, lateral (or side), top, oblique, inverted (oblique and "
      "upside down); default: the views of the job's [player], else oblique");
  add_trace(show, options);
  add_video(show, options);
  add_framing(show, options);
  add_appearance_options(*show, options.appearance);
  show->add_flag("--quiet", options.is_quiet, "Print only paths and warnings");
  show->footer(view::help_text() +
               "Examples:\n  vrda-player show knee.h5\n"
               "  vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15 --views front,lateral\n"
               "  vrda-player show knee.h5 --video knee.mp4 --views front,lateral --to-and-fro");
  show->callback([show, &options] { options.has_mode = show->count("--mode") > 0; });
  return show;
}

void add_appearance_options(CLI::App& mode, view::AppearanceOptions& look)
{
  add(&mode, "--layers", "LAYER,...", look.layers,
      "Layers to show with the bodies: contacts, normals (forces where known), axes, helical-axis, gaps, "
      "ligaments, contact-paths, labels, band; or none (default: ligaments, if the model has them)");
  add_choice<view::DrawMode>(&mode, "--mode", "MODE", look.mode,
                             {{"wire", view::DrawMode::wire},
                              {"hidden-line", view::DrawMode::hidden_line},
                              {"flat", view::DrawMode::flat},
                              {"smooth", view::DrawMode::smooth},
                              {"textured", view::DrawMode::textured}},
                             "wire, hidden-line, flat, smooth or textured (default textured)");
  CLI::Option* texture = add(&mode, "--texture", "FILE.png", look.texture,
                             "Tiled texture image for bone, with matching edges (default: mottled)");
  add(&mode, "--texture-scale", "MM", look.texture_scale_mm, "Width of one tile")
      ->needs(texture)
      ->capture_default_str();
  add(&mode, "--lights", "FILE.toml", look.lights, "Lights and background (default: studio)");
  add(&mode, "--see-through", "NAME", look.see_through,
      "Transparent objects: one by its name (femur, talus, ... or reference, moving), or both");
  add(&mode, "--hide", "NAME", look.hidden,
      "Object to hide, except its layers: by its name (femur, talus, ... or reference, moving)");
}

CLI::App* add_follow(CLI::App& app, show::FollowOptions& options)
{
  CLI::App* follow = app.add_subcommand("follow", "Show the progress of a running computation");
  follow->add_option("START", options.file, "The run's start file (OUTPUT.start.h5)")->required();
  add(follow, "--offscreen", "DIR", options.folder,
      "Folder for images named step_NUMBER.png and finished.png")
      ->check(empty_value_error);
  add(follow, "--every", "SECONDS", options.every_s,
      "Write an image at this interval if there are new steps");
  add(follow, "--each", "N", options.every_n_steps, "Write an image every N steps");
  follow->add_flag("--once", options.is_once, "Report the present state and exit");
  follow->add_flag("--text", options.is_text, "Print progress only, without images");
  add(follow, "--steps", "WHICH", options.steps,
      "Steps to show: stable; contact (also search steps in contact); all. Search steps are available "
      "for runs with --trace")
      ->capture_default_str();
  add(follow, "--views", "VIEW,...", options.views,
      "As for show (default: the job's views, else front,lateral)");
  add(follow, "--orient", "X,Y,Z;...", options.orient,
      "One triple per view: rotation of the joint in degrees about the axes of the front view (right, "
      "up, towards the viewer) (ORIENTATION_MODEL)");
  add(follow, "--shift", "X,Y,Z;...", options.shift,
      "One triple per view: shift in mm along these axes (SHIFT_MODEL)");
  add_appearance_options(*follow, options.appearance);
  follow->add_flag("--opaque", options.is_opaque,
                   "Draw the reference opaque (default: transparent, so that contacts are visible)");
  add(follow, "--size", "WxH", options.size, "Image size in pixels (default: the job's, else 1280x960)");
  follow->add_flag("--quiet", options.is_quiet, "Print no progress");
  follow->footer(
      "Keys: Space pauses, or plays the result; R resets the views; Q or Esc quits.\n"
      "Mouse: as for show.\n"
      "Reads the start file and the journals next to it, on this machine or in a shared folder, and never\n"
      "writes there. Ends when the result exists, or with Ctrl-C.\n"
      "Example:\n  vrda-player follow knee.h5.start.h5 --offscreen pictures --every 10 --views front,side");
  follow->callback([follow, &options] { options.has_mode = follow->count("--mode") > 0; });
  return follow;
}

CLI::App* add_web(CLI::App& app, WebMode& mode)
{
  web::WebOptions& options = mode.web;
  CLI::App* web = app.add_subcommand(
      "web", "Serve a motion model and its viewer page to browsers, also in augmented and virtual reality");
  web->add_option("FILE", options.file, "Motion model (.h5)")->required();
  add(web, "--address", "A", options.address,
      "Listen address (default: 127.0.0.1; any other requires --tls or --self-signed)")
      ->check(empty_value_error);
  add(web, "--port", "N", options.port, "Port (default: any free port)")->check(CLI::Range(0, 65535));
  add(web, "--tls", "CERT KEY", mode.tls,
      "Certificate and private key (PEM): browsers of other machines require HTTPS")
      ->expected(2)
      ->check(empty_value_error);
  web->add_flag("--self-signed", options.is_self_signed,
                "Make the certificate; with --tls, write the two files unless they exist");
  web->add_flag("--qr", options.has_qr_code,
                "Print the address as a QR code (always with --address of the network)");
  add(web, "--bench", "BENCH.toml", mode.bench.bench,
      "Stream flexion and placement of a tracked leg to all browsers (schemas/bench.md, schemas/live.md)")
      ->check(empty_value_error);
  add(web, "--calibration", "FILE.toml", mode.bench.calibration,
      "Calibration of the bench (default: nominal)");
  add(web, "--set", "SET", mode.bench.set, "Set of the streamed motion (default: that of show)");
  web->add_flag("--open", options.opens_browser, "Open the page in the default browser");
  web->add_flag("--quiet", options.is_quiet, "Print only the address");
  web->footer(
      "Prints the page's address and serves until Ctrl-C. The address contains a secret token; requests\n"
      "without it are rejected. WebXR needs https or an address of the device itself. For a headset or a\n"
      "phone on the network:\n"
      "  vrda-player web knee.h5 --address 192.168.1.20 --tls cert.pem key.pem --self-signed\n"
      "For an Android phone by USB, without a certificate:\n"
      "  vrda-player web knee.h5 --port 8443 --qr    and    adb reverse tcp:8443 tcp:8443\n"
      "Examples:\n  vrda-player web knee.h5 --open\n"
      "  vrda-player web knee.h5 --bench bench.toml --calibration anna.toml");
  web->callback([&mode] {
    if (mode.tls.empty()) return;
    mode.web.certificate = mode.tls.front();
    mode.web.key = mode.tls.back();
  });
  return web;
}

}  // namespace vrda::app
