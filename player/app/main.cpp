// vrda-player: reads the command line, runs a mode, turns what went wrong into one message and a code.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <map>

#include "app/show.hpp"
#include "core/error.hpp"
#include "web/server.hpp"

namespace {

/// DESIGN.md 7.
enum ExitCode { done = 0, bad_input = 2, unsolved_attitudes = 3, our_mistake = 5 };

void add_look(CLI::App& mode, vrda::LookOptions& look)
{
  mode.add_option("--layers", look.layers,
                  "What to show beside the bodies: contacts, normals (forces where they are known), axes, "
                  "helical-axis, gaps, ligaments")
      ->type_name("LAYER,...");
  const std::map<std::string, vrda::DrawMode> modes{{"wire", vrda::DrawMode::wire},
                                                    {"hidden-line", vrda::DrawMode::hidden_line},
                                                    {"flat", vrda::DrawMode::flat},
                                                    {"smooth", vrda::DrawMode::smooth},
                                                    {"textured", vrda::DrawMode::textured}};
  mode.add_option("--mode", look.mode, "wire, hidden-line, flat, smooth or textured (default textured)")
      ->transform(CLI::CheckedTransformer(modes))
      ->type_name("MODE")
      ->option_text("MODE");
  mode.add_option("--texture", look.texture, "Picture for bone, repeated (default: mottled)")
      ->type_name("FILE.png");
  mode.add_option("--texture-scale", look.texture_scale_mm, "Width of one repeat")
      ->type_name("MM")
      ->capture_default_str();
  mode.add_option("--lights", look.lights, "Lights and background (default: those of the studio)")
      ->type_name("FILE.toml");
  mode.add_option("--see-through", look.see_through, "Objects to look through: reference, moving or both")
      ->type_name("NAME");
}

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
  add_look(*show, options.look);
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

int run(int argc, char** argv)
{
  CLI::App app("Shows the motion of a joint from a motion model", "vrda-player");
  app.set_version_flag("--version", "vrda-player " VRDA_VERSION);
  app.require_subcommand(0, 1);
  app.footer(
      "Example:\n  vrda-player show knee.h5 --offscreen pictures --flexion 0:90:15\n\n"
      "Exit codes: 0 done, 2 bad input, 3 some attitudes have no answer, 5 a mistake of the program");
  vrda::ShowOptions options;
  add_show(app, options);
  vrda::WebOptions web_options;
  const CLI::App* web = add_web(app, web_options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    std::cerr << "vrda-player: " << error.what() << " (see vrda-player --help)\n";
    return bad_input;
  }
  if (app.get_subcommands().empty()) {
    std::cerr << "vrda-player: found no mode, wanted show or web (see vrda-player --help)\n";
    return bad_input;
  }
  if (web->parsed()) {
    vrda::serve_web(web_options, std::cout, std::cerr);
    return done;
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
