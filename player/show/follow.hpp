/// The mode `follow`: shows a run while it computes. It is `show` with another source: the options, scene,
/// sink and loop of `show`, the steps of run_watch.
#pragma once

#include <string>

#include "show/show.hpp"

namespace vrda::show {

/// The options of `follow`.
struct FollowOptions : PictureOptions {
  FollowOptions() { appearance.layers = "contacts,normals"; }

  double every_s = 0.0;          ///< write an image at this interval if there are new steps; 0: off
  int every_n_steps = 0;         ///< write an image every N steps; 0: off
  bool is_once = false;          ///< report the present state and exit
  bool is_text = false;          ///< print progress only, without images
  std::string steps = "stable";  ///< stable, contact or all
  std::string orient, shift;     ///< X,Y,Z;X,Y,Z;... one triple per view, degrees and mm
  bool is_opaque = false;        ///< false: the reference is transparent if contacts are shown
};

/// Why following ended.
enum class FollowEnd {
  finished,  ///< the run finished, or `is_once` was set
  stopped    ///< Ctrl-C or the window was closed before the run finished
};

/// Runs the mode. `streams.data` gets one path per image, or the progress if no images are written. Throws
/// InputError for invalid input.
FollowEnd follow(const FollowOptions& options, const Streams& streams);

}  // namespace vrda::show
