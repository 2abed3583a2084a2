/// The mode `show`: a motion model in a window, as pictures, as a film.
#pragma once

#include <optional>
#include <string>

#include "loop/loop.hpp"
#include "scene/lighting.hpp"
#include "scene/scene.hpp"
#include "store/motion_model.hpp"
#include "view/look.hpp"

namespace vrda {

/// As on the command line; angles in degrees.
struct ShowOptions {
  std::string file;
  std::string folder;                  ///< of the stills; without it and a video a window is opened
  std::optional<std::string> flexion;  ///< A:B:STEP; default the measured range in six steps
  std::optional<double> varus_deg;     ///< default the balanced varus of each flexion
  std::string set;                     ///< default the first of set_names()
  std::string views = "oblique";
  std::string size = "1280x960";
  int samples = 4;            ///< a pixel; 1 is fastest and has jagged edges
  std::string trace;          ///< a trace of the model: one of its searches instead of attitudes
  bool contact_only = false;  ///< only moves in contact
  int every = 1;              ///< only every so many frames, and the last
  Backdrop backdrop = Backdrop::studio;
  Held held = Held::moving;
  Framed framed = Framed::joint;
  LookOptions look;
  bool has_numbers = false;           ///< angles and gaps over the pictures
  std::string video;                  ///< a film of all views side by side
  std::optional<int> frames_per_s;    ///< of the film; default 25
  std::optional<double> speed_deg_s;  ///< of the film; default 30, but a frame an angle with `flexion`
  bool is_to_and_fro = false;         ///< the film comes back to where it began
  bool is_quiet = false;
};

struct ShowSummary {
  int n_stills = 0;    ///< written
  int n_unsolved = 0;  ///< attitudes without an answer and so without pictures; stretches of a film
};

/// Throws InputError for everything a user can put right.
ShowSummary show(const ShowOptions& options, const Streams& streams);

/// Until the user closes it. `set` is one of set_names(model). Throws InputError when there is no display, or
/// for options that want pictures.
void show_in_window(const ShowOptions& options, MotionModel model, const std::string& set);

}  // namespace vrda
