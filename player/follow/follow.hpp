/// The mode `follow`: a run while it computes.
#pragma once

#include <string>

#include "follow/run_screen.hpp"
#include "loop/loop.hpp"
#include "view/look.hpp"

namespace vrda {

/// With contacts and normals.
LookOptions follow_look();

/// As on the command line.
struct FollowOptions {
  std::string file;              ///< OUTPUT.start.h5
  std::string folder;            ///< of pictures; empty wants a window
  double every_s = 0.0;          ///< a picture every so many seconds in which something came; 0: none
  int each = 0;                  ///< a picture each so many steps; 0: none
  bool is_once = false;          ///< what there is now, and the end
  bool is_text = false;          ///< only progress, no picture
  std::string steps = "stable";  ///< step_choice_names()
  std::string views;             ///< names; empty: those of the job, else front and lateral
  std::string orient, shift;     ///< X,Y,Z;X,Y,Z;... one a view, degrees and mm
  LookOptions look = follow_look();
  bool has_mode = false;   ///< look.mode was asked for; else it is that of the job, if that has one
  bool is_opaque = false;  ///< the reference too, where contacts are to be seen
  std::string size;        ///< empty: that of the job, else 1280x960
  Backdrop backdrop = Backdrop::studio;
  bool is_quiet = false;
};

/// How following ended.
enum class FollowEnd {
  finished,  ///< so has the run, or it was asked for what there is now
  stopped    ///< by Ctrl-C or the closing of the window, before the run ended
};

/// Data: a path a line, without pictures the progress. Throws InputError for everything a user can put right.
FollowEnd follow(const FollowOptions& options, const Streams& streams);

/// What the options say of the pictures of a run with this model. Throws InputError like follow().
RunScreenOptions screen_options(const FollowOptions& options, const MotionModel& model);

}  // namespace vrda
