/// The state of a window that the user can change (angles in rad), and the effect of each action on it.
/// Values are clamped to the range of the motion model.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/units.hpp"
#include "model/frames.hpp"
#include "model/step_record.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "view/camera.hpp"
#include "view/keys.hpp"
#include "view/scene.hpp"
#include "view/section.hpp"

namespace vrda::view {

enum class LoopMode {
  once,   ///< stops at the end
  wrap,   ///< continues from the first end
  bounce  ///< reverses at the ends
};

const char* name_of(LoopMode mode);

/// What the positions of a timeline are.
enum class TimelineAxis {
  flexion,  ///< rad
  frames    ///< of a sequence, counted from 0
};

/// The user's steps are degrees, or frames; speeds are shown in them.
constexpr double position_of_steps(TimelineAxis axis, double n_steps)
{
  return axis == TimelineAxis::flexion ? rad_from_deg(n_steps) : n_steps;
}
constexpr double steps_of_position(TimelineAxis axis, double position)
{
  return axis == TimelineAxis::flexion ? deg_from_rad(position) : position;
}

inline constexpr double slowest_steps_s = 1.0, fastest_steps_s = 360.0;

struct Timeline {
  TimelineAxis axis = TimelineAxis::flexion;
  double first = 0.0, last = 0.0;  ///< first <= last
  double position = 0.0;           ///< within first and last
  double speed_steps_s = 30.0;     ///< within slowest and fastest
  int direction = 1;               ///< 1, or -1 on the return of a bounce
  bool is_playing = false;
  LoopMode loop = LoopMode::bounce;
};

/// Advances by `elapsed_s` (not negative, arbitrarily large) in closed form: splitting the time gives the
/// same result up to rounding.
Timeline advanced(Timeline timeline, double elapsed_s);

/// Toggles play and pause; at the end of `once`, play restarts.
Timeline toggled(Timeline timeline);

/// Pauses and moves by degrees or frames, clamped to the range.
Timeline stepped(Timeline timeline, double n_steps);

/// Moves to `position`, clamped to the range; keeps playing.
Timeline moved_to(Timeline timeline, double position);

/// Sets another range and clamps the position to it.
Timeline with_range(Timeline timeline, double first, double last);

/// The next higher or lower of 1, 2, 5, 10, 20, 30, 45, 60, 90, 180, 360 steps per second.
Timeline faster(Timeline timeline);
Timeline slower(Timeline timeline);

struct PlayerState {
  Timeline timeline;
  std::optional<double> varus_rad;  ///< empty: the balanced varus
  std::size_t set = 0;              ///< index of the set
  DrawMode mode = DrawMode::textured;
  LayerSet layers;
  Backdrop backdrop = Backdrop::studio;
  BodyIndex fixed_object = BodyIndex::moving;
  bool shows_numbers = true;
  bool shows_panel = true;
  bool shows_structures = false;  ///< in the panel, in place of the controls
  Section section;
  bool shows_help = false;
  bool is_done = false;  ///< the window should close
};

/// Limits given by the motion model and the current set.
struct PlayerRange {
  std::size_t n_sets = 1;
  double first_varus_rad = 0.0, last_varus_rad = 0.0;  ///< of the set
  bool is_varus_free = false;                          ///< the set determines the varus
  double balanced_varus_rad = 0.0;                     ///< at the current flexion
  const char* key_name = nullptr;                      ///< of a sequence of frames; else null
  LayerSet available;
};

/// Applies `action` to `state`. View, screenshot and full-screen actions have no effect here. Allocates
/// nothing.
PlayerState apply_action(PlayerState state, Action action, const PlayerRange& range);

/// The varus to show, clamped to the range.
double wanted_varus_rad(const PlayerState& state, const PlayerRange& range);

/// The timeline's range for a motion.
Timeline timeline_over(const store::Motion& motion);

/// The pose at a position of the motion's timeline: at this flexion and the varus, or at this frame.
store::JointPose pose_at(const store::Motion& motion, double position, double varus_rad);

/// The view selected by an action; empty for other actions.
std::optional<View> view_of(Action action);

const char* name_of(DrawMode mode);
const char* name_of(Backdrop backdrop);

// The appearance of a scene: options shared by the modes that draw.

/// The options of the command line.
struct AppearanceOptions {
  /// Names separated by commas; "none" or empty for none; "default": ligaments, if the model has them.
  std::string layers = "default";
  DrawMode mode = DrawMode::textured;
  std::string texture;             ///< PNG file for bone; empty: mottled
  double texture_scale_mm = 40.0;  ///< width of one tile
  std::string lights;              ///< TOML file (schemas/lights.md); empty: studio_lighting()
  /// Structures, separated by commas: ids, names in the model, or the parts of "reference", "moving" (or that
  /// body's name) or "both"; empty for none.
  std::string see_through, hidden;
};

/// What the cameras are fitted to.
enum class Framing {
  joint,  ///< the region of contact; long shafts are cropped
  all     ///< both objects completely
};
/// The points to be framed at the present placement, world.
std::vector<Eigen::Vector3d> framed_points(const Scene& scene, Framing framed);

/// Parses AppearanceOptions::layers. Throws InputError for an unknown or repeated one.
LayerSet parsed_layers(const std::string& text);

/// Applies draw mode, texture, lights, transparency and visibility to `scene`; must precede Renderer::load.
/// Throws InputError for an invalid option or file.
void apply_appearance(Scene& scene, const AppearanceOptions& look);

// What a motion model says against its poses: the plausibility of the cells around a pose, cells without a
// pose, and the warnings about its job.

struct PoseDoubt {
  Plausibility plausibility = Plausibility::nothing_found;  ///< the first of doubtful_plausibilities around
  bool is_beside_hole = false;  ///< a cell around has no pose, or the pose itself is missing
  /// Whose pose that is; null: the joint's. A follower has a doubt only if the joint has none.
  const store::FollowerRows* follower = nullptr;

  bool is_any() const { return is_beside_hole || is_doubtful(plausibility); }
};

/// A part of the timeline whose poses are doubtful or missing, in positions of the timeline.
struct MarkedSpan {
  double first = 0.0, last = 0.0;
  bool has_pose = true;
};

class DoubtReader {
 public:
  /// `model` must outlive it.
  explicit DoubtReader(const store::MotionModel& model) : model_(model) {}
  /// Of the cells around the pose, of any set of the model. Allocates nothing.
  PoseDoubt at(const store::JointPose& pose) const;
  /// The spans between neighbouring flexions, or frames, of the model, at `varus_rad` or the balanced varus.
  std::vector<MarkedSpan> marks(const store::Motion& motion, std::optional<double> varus_rad) const;

 private:
  const store::MotionModel& model_;
};

/// Zero-terminated; empty: nothing to say.
using DoubtText = std::array<char, 320>;
/// What is wrong with a pose, as one line; `drawn` is the name of the body that is drawn without a pose.
/// Allocates nothing.
DoubtText doubt_text(const store::JointPose& pose, const PoseDoubt& doubt, const char* drawn);

/// The counts of doubtful and missing poses with their reasons, then the warnings about the job.
std::vector<std::string> model_warnings(const store::MotionModel& model);
/// Why the solved poses of `set` are shown; empty unless it is the default motion in place of the smoothed
/// one.
std::string default_motion_remark(const store::MotionModel& model, const std::string& set);
/// The verdict on each set (store/verdict.hpp), one sentence; empty texts for joints other than knees.
std::vector<std::string> verdict_sentences(const store::MotionModel& model,
                                           const std::vector<std::string>& sets);
/// Whether a cell is doubtful or has no pose.
bool has_doubtful_poses(const store::MotionModel& model);

// Views, size and zoom of a job's table [player] (schemas/job.schema.json), which `show` and `follow` use
// where the command line has none.

struct CameraView {
  std::string name;
  Eigen::Matrix3d R_world_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_camera_mm = Eigen::Vector3d::Zero();  ///< shift of the joint, camera axes
};

CameraView named_view(const std::string& name, View view, Side side);

/// The front view with the joint rotated about X, then Y, then Z and shifted, all in the axes of that view:
/// X right on screen (the subject's left), Y up, Z towards the viewer.
/// Source: ORIENTATION_MODEL and SHIFT_MODEL, thesis appendix B, which does not state the order of rotations.
CameraView turned_view(const std::string& name, const Eigen::Vector3d& turn_rad,
                       const Eigen::Vector3d& shift_mm, Side side);

/// The camera fitted to the joint, shifted as the view, with the field of view divided by `zoom`.
Camera placed_camera(const CameraFit& fit, const CameraView& view, double zoom);

/// A view of the job's table [player] (schemas/job.schema.json).
struct JobView {
  int number = 0;
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d orientation_deg = Eigen::Vector3d::Zero();
};

struct JobViews {
  std::vector<JobView> views;  ///< in the job's order
  double zoom = 1.0;
  int width_px = 0, height_px = 0;  ///< display size; 0 if not given
  std::string render;               ///< "fill", "wire" or empty
};

/// Reads the resolved job of a motion model. Missing entries and those of another type keep their defaults,
/// as does all of a text that is not TOML.
JobViews job_views(std::string_view resolved_job);

/// The job's views as cameras; "view 2".
std::vector<CameraView> camera_views(const JobViews& job, Side side);

/// Whether the display size is within the limits of images; a historic one may exceed them.
bool has_usable_size(const JobViews& job);

}  // namespace vrda::view
