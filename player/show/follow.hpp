/// The mode `follow`: shows a run while it computes.
#pragma once

#include <string>

#include "show/run_screen.hpp"
#include "show/loop.hpp"
#include "view/appearance.hpp"

namespace vrda::show {

/// The default appearance: with contacts and normals.
view::AppearanceOptions follow_appearance();

/// The options of the command line.
struct FollowOptions {
  std::string file;              ///< OUTPUT.start.h5
  std::string folder;            ///< output folder of images; empty: a window
  double every_s = 0.0;          ///< write an image at this interval if there are new steps; 0: off
  int every_n_steps = 0;         ///< write an image every N steps; 0: off
  bool is_once = false;          ///< report the present state and exit
  bool is_text = false;          ///< print progress only, without images
  std::string steps = "stable";  ///< one of step_choice_names()
  std::string views;             ///< names; empty: the job's, else front and lateral
  std::string orient, shift;     ///< X,Y,Z;X,Y,Z;... one triple per view, degrees and mm
  view::AppearanceOptions appearance = follow_appearance();
  bool has_mode = false;   ///< the draw mode was given by option; otherwise the job's applies, if any
  bool is_opaque = false;  ///< false: the reference is transparent if contacts are shown
  std::string size;        ///< empty: the job's, else 1280x960
  view::Backdrop backdrop = view::Backdrop::studio;
  bool is_quiet = false;
};

/// Why following ended.
enum class FollowEnd {
  finished,  ///< the run finished, or `is_once` was set
  stopped    ///< Ctrl-C or the window was closed before the run finished
};

/// Runs the mode. `streams.data` gets one path per image, or the progress if no images are written. Throws
/// InputError for invalid input.
FollowEnd follow(const FollowOptions& options, const show::Streams& streams);

/// Converts the options to those of the screen for a run with this model. Throws InputError like follow().
RunScreenOptions screen_options(const FollowOptions& options, const store::MotionModel& model);

}  // namespace vrda::show
