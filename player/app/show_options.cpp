// The options of `show`.
#include "app/options.hpp"

#include <CLI/CLI.hpp>
#include <map>

#include "app/named_choice.hpp"
#include "view/arguments.hpp"
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

}  // namespace vrda
