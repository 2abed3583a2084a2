/// The mode `show`: displays a motion model in a window, as images or as a video.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "show/comparison.hpp"
#include "show/loop.hpp"
#include "show/view_state.hpp"
#include "store/motion_model.hpp"
#include "view/keys.hpp"
#include "view/player_state.hpp"
#include "view/scene.hpp"

namespace vrda::show {

/// Options of the command line that all pictures of a motion model have.
struct PictureOptions {
  std::string file;
  std::string views;  ///< names; default: those of the job's [player], else the mode's own
  std::string size;   ///< default: that of the job's [player], else 1280x960
  view::AppearanceOptions appearance;
  bool has_mode = false;  ///< `appearance.mode` was given; else the job's
  view::Backdrop backdrop = view::Backdrop::studio;
  std::string folder;  ///< output folder of images; without it and a video: a window
  bool is_quiet = false;
};

/// The options completed by the job's [player].
struct ResolvedPictures {
  std::vector<view::CameraView> views;  ///< at least one
  double zoom = 1.0;                    ///< of the job's views
  view::PictureSize size;
  view::AppearanceOptions appearance;
};
/// `own_views`: where neither the options nor the job have views. Throws InputError for invalid options.
ResolvedPictures resolved_pictures(const PictureOptions& options, const store::MotionModel& model,
                                   const char* own_views = "oblique");

/// The options of `show`; angles in degrees.
struct ShowOptions : PictureOptions {
  std::optional<std::string> flexion;  ///< A:B:STEP; default: the grid's range in six steps
  std::optional<std::string> frame;    ///< A:B:STEP of keys, of a sequence of frames; default: all of them
  std::optional<double> varus_deg;     ///< default: the balanced varus of each flexion
  std::string set;                     ///< default: store::default_motion
  /// Per pixel; 1 is fastest and has jagged edges. 0: four for images; in a window as in view/window.hpp.
  int samples = 0;
  std::string trace;          ///< trace file of the model; shows one search instead of attitudes
  bool contact_only = false;  ///< with `trace`: only steps in contact
  int every = 1;              ///< with `trace`: only every N-th frame, and the last
  BodyIndex fixed_object = BodyIndex::moving;
  view::Framing framing = view::Framing::joint;
  std::string view;                ///< `--view`: see read_view_state
  std::string section_text;        ///< `--section`: see parsed_section
  view::Section section;           ///< of either
  std::optional<ViewState> state;  ///< of `view`
  ComparisonOptions other;
  bool has_numbers = false;           ///< draw angles and gaps on the images
  std::string video;                  ///< video file, all views side by side
  std::optional<int> frames_per_s;    ///< of the video; default 25
  std::optional<double> speed_deg_s;  ///< of the video; default 30; with `flexion` one frame per angle
  bool is_to_and_fro = false;         ///< the video plays forwards, then backwards
};

struct ShowSummary {
  int n_images = 0;    ///< images written
  int n_unsolved = 0;  ///< unsolved attitudes without image, plus unsolved intervals of a video
};

/// Runs the mode; results go to `streams.data`, messages to standard error. Throws InputError for invalid
/// input.
ShowSummary show(const ShowOptions& options, const Streams& streams);

/// Runs until the user closes the window. `set` is one of set_names(model). Throws InputError if there is no
/// display, or for options that require images.
void show_in_window(const ShowOptions& options, store::MotionModel model, const std::string& set);

}  // namespace vrda::show
