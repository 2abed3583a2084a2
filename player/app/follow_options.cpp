#include "app/named_choice.hpp"
#include "app/options.hpp"

#include <CLI/CLI.hpp>

#include "view/arguments.hpp"

namespace vrda {

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

}  // namespace vrda
