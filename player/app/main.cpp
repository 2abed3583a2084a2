// vrda-player: reads the command line, runs a mode, turns what went wrong into one message and a code.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <map>

#include "app/follow.hpp"
#include "app/show.hpp"
#include "core/error.hpp"
#include "web/server.hpp"

namespace {

/// DESIGN.md 7.
enum ExitCode { done = 0, bad_input = 2, unsolved_attitudes = 3, interrupted = 4, our_mistake = 5 };

void add_show(CLI::App& app, vrda::ShowOptions& options)
{
  CLI::App* show = app.add_subcommand("show", "Show a motion model; with --offscreen as pictures");
  show->add_option("FILE", options.file, "Motion model (.h5)")->required();
  show->add_option("--offscreen", options.folder, "Folder for stills named VIEW_flexion_ANGLE.png")
      ->type_name("DIR");
  show->add_option("--flexion", options.flexion,
                   "Angles in degrees (default: the measured range in six steps)")
      ->type_name("A:B:STEP");
  show->add_option("--varus", options.varus_deg,
                   "Angle in degrees, adduction positive (default: for each flexion the varus at which both "
                   "compartments balance, linear between the flexions solved)")
      ->type_name("ANGLE");
  show->add_option("--set", options.set, "raw or degree_N (default: the highest degree there is, else raw)")
      ->type_name("SET");
  show->add_option("--views", options.views,
                   "front, back, left, right, medial, lateral (or side), top, oblique, inverted (oblique, "
                   "upside down)")
      ->type_name("VIEW,...")
      ->capture_default_str();
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
  show->add_option("--size", options.size, "Of a picture, in pixels")
      ->type_name("WxH")
      ->capture_default_str();
  const std::map<std::string, vrda::Backdrop> backdrops{
      {"studio", vrda::Backdrop::studio}, {"night", vrda::Backdrop::night}, {"black", vrda::Backdrop::black}};
  show->add_option("--background", options.backdrop, "studio, night or black (default studio)")
      ->transform(CLI::CheckedTransformer(backdrops))
      ->type_name("NAME")
      ->option_text("NAME");
  const std::map<std::string, vrda::Held> held{{"moving", vrda::Held::moving},
                                               {"reference", vrda::Held::reference}};
  show->add_option("--hold", options.held, "Object that stands still: moving or reference (default moving)")
      ->transform(CLI::CheckedTransformer(held))
      ->type_name("NAME")
      ->option_text("NAME");
  const std::map<std::string, vrda::Framed> framed{{"joint", vrda::Framed::joint},
                                                   {"all", vrda::Framed::all}};
  show->add_option("--frame", options.framed,
                   "What the picture has room for: joint, or all of both objects (default joint)")
      ->transform(CLI::CheckedTransformer(framed))
      ->type_name("NAME")
      ->option_text("NAME");
  show->add_flag("--quiet", options.is_quiet, "Only paths and warnings");
  show->footer(
      "Example:\n  vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15 --views front,lateral");
}

CLI::App* add_web(CLI::App& app, vrda::WebOptions& options)
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
      "Prints the page's address and serves until Ctrl-C. Other machines are not answered.\n"
      "Example:\n  vrda-player web knee.h5 --open");
  return web;
}

CLI::App* add_follow(CLI::App& app, vrda::FollowOptions& options)
{
  CLI::App* follow = app.add_subcommand("follow", "Follow a run while it computes");
  follow->add_option("START", options.file, "The run's start file (OUTPUT.start.h5)")->required();
  follow
      ->add_option("--offscreen", options.folder,
                   "Folder for pictures named step_NUMBER.png and finished.png")
      ->type_name("DIR");
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
  follow->add_option("--mode", options.mode, "wire, hidden-line, flat, fill or smooth, textured")
      ->type_name("MODE");
  follow->add_option("--layers", options.layers, "contacts, normals, axes; or none")
      ->type_name("LAYER,...")
      ->capture_default_str();
  follow->add_option("--size", options.size, "Of the picture, in pixels")
      ->type_name("WxH")
      ->capture_default_str();
  follow->add_flag("--quiet", options.is_quiet, "No progress");
  follow->footer(
      "Reads the start file and the journals beside it and never writes there: on this machine or over a\n"
      "shared folder. Ends when the result is there, or with Ctrl-C.\n"
      "Example:\n  vrda-player follow knee.h5.start.h5 --offscreen pictures --every 10 --views front,side");
  return follow;
}

int run(int argc, char** argv)
{
  CLI::App app("Shows the motion of a joint from a motion model", "vrda-player");
  app.set_version_flag("--version", "vrda-player " VRDA_VERSION);
  app.require_subcommand(0, 1);
  app.footer(
      "Example:\n  vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15\n\n"
      "Exit codes: 0 done, 2 bad input, 3 some attitudes have no answer, 4 stopped before the run it follows "
      "ended, "
      "5 a mistake of the program");
  vrda::ShowOptions options;
  add_show(app, options);
  vrda::WebOptions web_options;
  const CLI::App* web = add_web(app, web_options);
  vrda::FollowOptions follow_options;
  const CLI::App* follow = add_follow(app, follow_options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    std::cerr << "vrda-player: " << error.what() << " (see vrda-player --help)\n";
    return bad_input;
  }
  if (app.get_subcommands().empty()) {
    std::cerr << "vrda-player: found no mode, wanted show, follow or web (see vrda-player --help)\n";
    return bad_input;
  }
  if (web->parsed()) {
    vrda::serve_web(web_options, std::cout, std::cerr);
    return done;
  }
  if (follow->parsed()) {
    const vrda::FollowEnd end = vrda::follow(follow_options, {std::cout, std::cerr});
    return end == vrda::FollowEnd::finished ? done : interrupted;
  }
  const vrda::ShowSummary summary = vrda::show(options, {std::cout, std::cerr});
  return summary.n_unsolved > 0 ? unsolved_attitudes : done;
}

}  // namespace

int main(int argc, char** argv)
{
  try {
    return run(argc, argv);
  } catch (const vrda::InputError& error) {
    std::cerr << "vrda-player: " << error.what() << "\n";
    return bad_input;
  } catch (const std::exception& error) {
    std::cerr << "vrda-player: a mistake of the program: " << error.what()
              << "\nPlease report it with the command line and the file.\n";
    return our_mistake;
  }
}
