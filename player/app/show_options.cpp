// Options of the modes `show`, `follow` and `web`.
#include <CLI/CLI.hpp>
#include <map>

#include "app/options.hpp"
#include "navigation/keys.hpp"

namespace vrda::app {
namespace {

void add_trace(CLI::App* show, show::ShowOptions& options)
{
  show->add_option(
          "--trace", options.trace,
          "Trace (.trace.h5) of the motion model: show one search from its seed to its end, one frame per "
          "step, named VIEW_frame_NUMBER.png; --flexion and --varus choose the grid cell (default: the "
          "spine cell of the first flexion)")
      ->type_name("FILE");
  show->add_flag("--contact-only", options.contact_only,
                 "With --trace: only steps in contact, which give a smooth motion");
  show->add_option("--every", options.every, "With --trace: only every N-th frame, and the last")
      ->type_name("N")
      ->capture_default_str();
}

void add_video(CLI::App* show, show::ShowOptions& options)
{
  show->add_option("--video", options.video,
                   "Video of all views side by side, written by ffmpeg: .mp4, .webm or .gif")
      ->type_name("FILE")
      ->check(empty_value_error);
  show->add_option("--fps", options.frames_per_s, "Frames per second of the video (default 25)")
      ->type_name("N");
  show->add_option("--speed", options.speed_deg_s,
                   "Degrees per second of the video (default 30; with --flexion one frame per angle)")
      ->type_name("N");
  show->add_flag("--to-and-fro", options.is_to_and_fro, "Play the video forwards, then backwards");
  show->add_flag("--numbers", options.has_numbers, "Show angles and gaps on images and video");
}

void add_framing(CLI::App* show, show::ShowOptions& options)
{
  show->add_option("--size", options.size, "Size of an image or of the window, in pixels")
      ->type_name("WxH")
      ->capture_default_str();
  show->add_option(
          "--samples", options.samples,
          "Samples per pixel: 1 has jagged edges and is several times faster without a graphics card")
      ->type_name("1|2|4")
      ->check(CLI::IsMember({1, 2, 4}))
      ->capture_default_str()
      ->option_text("1|2|4=4");
  const std::map<std::string, scene::Backdrop> backdrops{{"studio", scene::Backdrop::studio},
                                                         {"night", scene::Backdrop::night},
                                                         {"black", scene::Backdrop::black}};
  show->add_option("--background", options.backdrop, "studio, night or black (default studio)")
      ->transform(named_choice(enum_numbers(backdrops)))
      ->type_name("NAME")
      ->option_text("NAME");
  const std::map<std::string, scene::FixedObject> held{{"moving", scene::FixedObject::moving},
                                                       {"reference", scene::FixedObject::reference}};
  show->add_option("--hold", options.fixed_object,
                   "Object fixed on screen: moving or reference (default moving)")
      ->transform(named_choice(enum_numbers(held)))
      ->type_name("NAME")
      ->option_text("NAME");
  const std::map<std::string, navigation::Framing> framed{{"joint", navigation::Framing::joint},
                                                          {"all", navigation::Framing::all}};
  show->add_option("--frame", options.framing,
                   "What the image contains: joint, or all of both objects (default joint)")
      ->transform(named_choice(enum_numbers(framed)))
      ->type_name("NAME")
      ->option_text("NAME");
}

}  // namespace

CLI::App* add_show(CLI::App& app, show::ShowOptions& options)
{
  CLI::App* show = app.add_subcommand(
      "show", "Show a motion model in a window, or write images (--offscreen) or a video (--video)");
  show->add_option("FILE", options.file, "Motion model (.h5)")->required();
  show->add_option("--offscreen", options.folder,
                   "Folder for images named VIEW_flexion_ANGLE.png, instead of a window")
      ->type_name("DIR")
      ->check(empty_value_error);
  show->add_option("--flexion", options.flexion,
                   "Angles in degrees (default: the grid's range in six steps); a window starts at A")
      ->type_name("A:B:STEP");
  show->add_option("--varus", options.varus_deg,
                   "Angle in degrees, adduction positive (default: the varus that balances both compartments "
                   "at each flexion, interpolated linearly between solved flexions)")
      ->type_name("ANGLE");
  show->add_option("--set", options.set,
                   "two_sided, raw, degree_N, degree_N_recontacted or zero_varus (default: two_sided if "
                   "available, then "
                   "the highest degree, recontacted if available; otherwise raw)")
      ->type_name("SET");
  show->add_option("--views", options.views,
                   "front, back, left, right, medial, lateral (or side), top, oblique, inverted (oblique and "
                   "upside down)")
      ->type_name("VIEW,...")
      ->capture_default_str();
  add_trace(show, options);
  add_video(show, options);
  add_framing(show, options);
  add_appearance_options(*show, options.appearance);
  show->add_flag("--quiet", options.is_quiet, "Print only paths and warnings");
  show->footer(navigation::help_text() +
               "Examples:\n  vrda-player show knee.h5\n"
               "  vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15 --views front,lateral\n"
               "  vrda-player show knee.h5 --video knee.mp4 --views front,lateral --to-and-fro");
  return show;
}

void add_appearance_options(CLI::App& mode, navigation::AppearanceOptions& look)
{
  mode.add_option("--layers", look.layers,
                  "Layers to show with the bodies: contacts, normals (forces where known), axes, "
                  "helical-axis, gaps, ligaments")
      ->type_name("LAYER,...");
  const std::map<std::string, scene::DrawMode> modes{{"wire", scene::DrawMode::wire},
                                                     {"hidden-line", scene::DrawMode::hidden_line},
                                                     {"flat", scene::DrawMode::flat},
                                                     {"smooth", scene::DrawMode::smooth},
                                                     {"textured", scene::DrawMode::textured}};
  mode.add_option("--mode", look.mode, "wire, hidden-line, flat, smooth or textured (default textured)")
      ->transform(named_choice(enum_numbers(modes)))
      ->type_name("MODE")
      ->option_text("MODE");
  mode.add_option("--texture", look.texture,
                  "Tiled texture image for bone, with matching edges (default: mottled)")
      ->type_name("FILE.png");
  mode.add_option("--texture-scale", look.texture_scale_mm, "Width of one tile")
      ->type_name("MM")
      ->capture_default_str();
  mode.add_option("--lights", look.lights, "Lights and background (default: studio)")->type_name("FILE.toml");
  mode.add_option("--see-through", look.see_through, "Transparent objects: reference, moving or both")
      ->type_name("NAME");
  mode.add_option("--hide", look.hidden, "Object to hide, except its layers: reference or moving")
      ->type_name("NAME");
}

CLI::App* add_follow(CLI::App& app, follow::FollowOptions& options)
{
  CLI::App* follow = app.add_subcommand("follow", "Show the progress of a running computation");
  follow->add_option("START", options.file, "The run's start file (OUTPUT.start.h5)")->required();
  follow
      ->add_option("--offscreen", options.folder, "Folder for images named step_NUMBER.png and finished.png")
      ->type_name("DIR")
      ->check(empty_value_error);
  follow->add_option("--every", options.every_s, "Write an image at this interval if there are new steps")
      ->type_name("SECONDS");
  follow->add_option("--each", options.every_n_steps, "Write an image every N steps")->type_name("N");
  follow->add_flag("--once", options.is_once, "Report the present state and exit");
  follow->add_flag("--text", options.is_text, "Print progress only, without images");
  follow
      ->add_option(
          "--steps", options.steps,
          "Steps to show: stable; contact (also search steps in contact); all. Search steps are available "
          "for runs with --trace")
      ->type_name("WHICH")
      ->capture_default_str();
  follow->add_option("--views", options.views, "As for show (default: the job's views, else front,lateral)")
      ->type_name("VIEW,...");
  follow
      ->add_option(
          "--orient", options.orient,
          "One triple per view: rotation of the joint in degrees about the axes of the front view (right, "
          "up, towards the viewer) (ORIENTATION_MODEL)")
      ->type_name("X,Y,Z;...");
  follow
      ->add_option("--shift", options.shift,
                   "One triple per view: shift in mm along these axes (SHIFT_MODEL)")
      ->type_name("X,Y,Z;...");
  add_appearance_options(*follow, options.appearance);
  follow->add_flag("--opaque", options.is_opaque,
                   "Draw the reference opaque (default: transparent, so that contacts are visible)");
  follow->add_option("--size", options.size, "Image size in pixels (default: the job's, else 1280x960)")
      ->type_name("WxH");
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

CLI::App* add_web(CLI::App& app, web::WebOptions& options)
{
  CLI::App* web =
      app.add_subcommand("web", "Serve a motion model and its viewer page to a browser on this machine");
  web->add_option("FILE", options.file, "Motion model (.h5)")->required();
  web->add_option("--port", options.port, "Port on 127.0.0.1 (default: any free port)")
      ->type_name("N")
      ->check(CLI::Range(0, 65535));
  web->add_flag("--open", options.opens_browser, "Open the page in the default browser");
  web->add_flag("--quiet", options.is_quiet, "Print only the address");
  web->footer(
      "Prints the page's address and serves until Ctrl-C. The address contains a secret token.\n"
      "Requests from other machines or without the token are rejected.\n"
      "Example:\n  vrda-player web knee.h5 --open");
  return web;
}

}  // namespace vrda::app
