// The options of `show`.
#include <CLI/CLI.hpp>
#include <map>

#include "app/options.hpp"
#include "view/keys.hpp"

namespace vrda {
namespace {

void add_trace(CLI::App* show, ShowOptions& options)
{
  show->add_option(
          "--trace", options.trace,
          "Trace (.trace.h5) of the motion model: shows one search, a still a move named "
          "VIEW_frame_NUMBER.png, from its seed to its end; --flexion and --varus choose the cell of the "
          "grid (default: the spine's cell of the first flexion)")
      ->type_name("FILE");
  show->add_flag("--contact-only", options.contact_only,
                 "Of a trace only the moves in contact, which play as a smooth motion");
  show->add_option("--every", options.every, "Of a trace only every N-th still, and the last")
      ->type_name("N")
      ->capture_default_str();
}

void add_video(CLI::App* show, ShowOptions& options)
{
  show->add_option("--video", options.video,
                   "Film of all views side by side, written by ffmpeg: .mp4, .webm or .gif")
      ->type_name("FILE")
      ->check(refusal_of_nothing);
  show->add_option("--fps", options.frames_per_s, "Frames of the film a second (default 25)")->type_name("N");
  show->add_option("--speed", options.speed_deg_s,
                   "Of the film, degrees a second (default 30; with --flexion a frame an angle)")
      ->type_name("N");
  show->add_flag("--to-and-fro", options.is_to_and_fro, "The film comes back to where it began");
  show->add_flag("--numbers", options.has_numbers, "Angles and gaps over pictures and film");
}

void add_framing(CLI::App* show, ShowOptions& options)
{
  show->add_option("--size", options.size, "Of a picture or of the window, in pixels")
      ->type_name("WxH")
      ->capture_default_str();
  show->add_option(
          "--samples", options.samples,
          "Samples a pixel: 1 has jagged edges, and is several times as fast without a graphics card")
      ->type_name("1|2|4")
      ->check(CLI::IsMember({1, 2, 4}))
      ->capture_default_str()
      ->option_text("1|2|4=4");
  const std::map<std::string, Backdrop> backdrops{
      {"studio", Backdrop::studio}, {"night", Backdrop::night}, {"black", Backdrop::black}};
  show->add_option("--background", options.backdrop, "studio, night or black (default studio)")
      ->transform(named_choice(numbers_of(backdrops)))
      ->type_name("NAME")
      ->option_text("NAME");
  const std::map<std::string, Held> held{{"moving", Held::moving}, {"reference", Held::reference}};
  show->add_option("--hold", options.held, "Object that stands still: moving or reference (default moving)")
      ->transform(named_choice(numbers_of(held)))
      ->type_name("NAME")
      ->option_text("NAME");
  const std::map<std::string, Framed> framed{{"joint", Framed::joint}, {"all", Framed::all}};
  show->add_option("--frame", options.framed,
                   "What the picture has room for: joint, or all of both objects (default joint)")
      ->transform(named_choice(numbers_of(framed)))
      ->type_name("NAME")
      ->option_text("NAME");
}

}  // namespace

CLI::App* add_show(CLI::App& app, ShowOptions& options)
{
  CLI::App* show = app.add_subcommand(
      "show", "Show a motion model: in a window, with --offscreen as pictures, with --video as a film");
  show->add_option("FILE", options.file, "Motion model (.h5)")->required();
  show->add_option("--offscreen", options.folder,
                   "Folder for stills named VIEW_flexion_ANGLE.png, instead of a window")
      ->type_name("DIR")
      ->check(refusal_of_nothing);
  show->add_option("--flexion", options.flexion,
                   "Angles in degrees (default: the measured range in six steps); a window begins at A")
      ->type_name("A:B:STEP");
  show->add_option("--varus", options.varus_deg,
                   "Angle in degrees, adduction positive (default: for each flexion the varus at which both "
                   "compartments balance, linear between the flexions solved)")
      ->type_name("ANGLE");
  show->add_option("--set", options.set,
                   "raw, degree_N, degree_N_recontacted or zero_varus (default: the highest degree, "
                   "recontacted where there is that; else raw)")
      ->type_name("SET");
  show->add_option("--views", options.views,
                   "front, back, left, right, medial, lateral (or side), top, oblique, inverted (oblique, "
                   "upside down)")
      ->type_name("VIEW,...")
      ->capture_default_str();
  add_trace(show, options);
  add_video(show, options);
  add_framing(show, options);
  add_look(*show, options.look);
  show->add_flag("--quiet", options.is_quiet, "Only paths and warnings");
  show->footer(help_text() +
               "Examples:\n  vrda-player show knee.h5\n"
               "  vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15 --views front,lateral\n"
               "  vrda-player show knee.h5 --video knee.mp4 --views front,lateral --to-and-fro");
  return show;
}

// The options that say how things look.

void add_look(CLI::App& mode, LookOptions& look)
{
  mode.add_option("--layers", look.layers,
                  "What to show beside the bodies: contacts, normals (forces where they are known), axes, "
                  "helical-axis, gaps, ligaments")
      ->type_name("LAYER,...");
  const std::map<std::string, DrawMode> modes{{"wire", DrawMode::wire},
                                              {"hidden-line", DrawMode::hidden_line},
                                              {"flat", DrawMode::flat},
                                              {"smooth", DrawMode::smooth},
                                              {"textured", DrawMode::textured}};
  mode.add_option("--mode", look.mode, "wire, hidden-line, flat, smooth or textured (default textured)")
      ->transform(named_choice(numbers_of(modes)))
      ->type_name("MODE")
      ->option_text("MODE");
  mode.add_option("--texture", look.texture,
                  "Picture for bone, repeated: its edges should meet (default: mottled)")
      ->type_name("FILE.png");
  mode.add_option("--texture-scale", look.texture_scale_mm, "Width of one repeat")
      ->type_name("MM")
      ->capture_default_str();
  mode.add_option("--lights", look.lights, "Lights and background (default: those of the studio)")
      ->type_name("FILE.toml");
  mode.add_option("--see-through", look.see_through, "Objects to look through: reference, moving or both")
      ->type_name("NAME");
  mode.add_option("--hide", look.hidden, "Object to leave out, but for its layers: reference or moving")
      ->type_name("NAME");
}

CLI::App* add_follow(CLI::App& app, FollowOptions& options)
{
  CLI::App* follow = app.add_subcommand("follow", "Follow a run while it computes");
  follow->add_option("START", options.file, "The run's start file (OUTPUT.start.h5)")->required();
  follow
      ->add_option("--offscreen", options.folder,
                   "Folder for pictures named step_NUMBER.png and finished.png")
      ->type_name("DIR")
      ->check(refusal_of_nothing);
  follow->add_option("--every", options.every_s, "A picture every so many seconds in which something came")
      ->type_name("SECONDS");
  follow->add_option("--each", options.each, "A picture each so many steps")->type_name("N");
  follow->add_flag("--once", options.is_once, "What there is now, and end");
  follow->add_flag("--text", options.is_text, "Only the progress, no picture");
  follow
      ->add_option(
          "--steps", options.steps,
          "Those shown: stable; contact (the moves in contact too); all. Moves are known of runs with "
          "--trace")
      ->type_name("WHICH")
      ->capture_default_str();
  follow->add_option("--views", options.views, "As of show (default: those of the job, else front,lateral)")
      ->type_name("VIEW,...");
  follow
      ->add_option(
          "--orient", options.orient,
          "A view a triple: degrees to turn the joint, as seen from the front, about the axes to the "
          "right, up and towards the viewer (ORIENTATION_MODEL)")
      ->type_name("X,Y,Z;...");
  follow->add_option("--shift", options.shift, "A view a triple: mm along these axes (SHIFT_MODEL)")
      ->type_name("X,Y,Z;...");
  add_look(*follow, options.look);
  follow->add_flag("--opaque", options.is_opaque,
                   "The reference too: without it contacts and normals are seen through it");
  follow
      ->add_option("--size", options.size,
                   "Of the picture, in pixels (default: that of the job, else 1280x960)")
      ->type_name("WxH");
  follow->add_flag("--quiet", options.is_quiet, "No progress");
  follow->footer(
      "Keys of the window: Space pauses, or plays the result; R resets the views; Q or Esc ends it.\n"
      "Mouse: as of show.\n"
      "Reads the start file and the journals beside it and never writes there: on this machine or over a\n"
      "shared folder. Ends when the result is there, or with Ctrl-C.\n"
      "Example:\n  vrda-player follow knee.h5.start.h5 --offscreen pictures --every 10 --views front,side");
  follow->callback([follow, &options] { options.has_mode = follow->count("--mode") > 0; });
  return follow;
}

// The options of `web`.

CLI::App* add_web(CLI::App& app, WebOptions& options)
{
  CLI::App* web =
      app.add_subcommand("web", "Serve a motion model and a page that shows it to a browser on this machine");
  web->add_option("FILE", options.file, "Motion model (.h5)")->required();
  web->add_option("--port", options.port, "Of 127.0.0.1 (default: a free one)")
      ->type_name("N")
      ->check(CLI::Range(0, 65535));
  web->add_flag("--open", options.is_open, "Open the page in the desktop's browser");
  web->add_flag("--quiet", options.is_quiet, "Only the address");
  web->footer(
      "Prints the page's address and serves until Ctrl-C. The address holds a token: keep it to yourself.\n"
      "Neither other machines are answered nor requests without the token.\n"
      "Example:\n  vrda-player web knee.h5 --open");
  return web;
}

}  // namespace vrda
