/// The interactive state of mode `show`, independent of the window: a motion model's sets, the displayed
/// attitude and appearance. In: elapsed seconds, input events (pixels from the upper left). Out: a scene in
/// mm, the state of the user interface. Angles are in rad.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "show/comparison.hpp"
#include "show/joint_view.hpp"
#include "show/view_state.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "view/camera.hpp"
#include "view/gui.hpp"
#include "view/player_state.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"
#include "view/window.hpp"

namespace vrda::show {

struct SessionOptions {
  std::string set;  ///< one of set_names(model)
  std::string title;
  view::View view = view::View::oblique;
  std::optional<view::CameraView> job_view;  ///< at the start and at a reset, until a view is chosen
  double zoom = 1.0;                         ///< of the view at the start
  std::optional<double> flexion_rad;         ///< default: the first of the set
  std::optional<double> varus_rad;           ///< default: the balanced varus
  std::optional<double> key;                 ///< of a sequence of frames; default: the first
  view::Backdrop backdrop = view::Backdrop::studio;
  BodyIndex fixed_object = BodyIndex::moving;
  view::AppearanceOptions appearance;
  view::Section section;
  std::optional<ViewState> state;  ///< whose structures and camera are used
  ComparisonOptions other;
  view::Framing framing = view::Framing::joint;
  int width = 1280, height = 960;
  double scale = 1.0;  ///< factor for text and controls
  /// Without ambient occlusion and lit at vertices while the joint or the camera moves and for settle_s
  /// after: software rendering is then several times faster.
  bool is_plain_while_moving = false;
};

/// Time without a change after which a picture is at rest.
inline constexpr double settle_s = 0.06;
/// Samples per pixel of a picture at rest if `is_plain_while_moving`; one while moving.
inline constexpr int samples_at_rest = 4;

class Session {
 public:
  Session(store::MotionModel model, const SessionOptions& options);

  /// Loads the meshes and the font into a renderer.
  void load_into(view::Renderer& renderer) const;

  /// Input events in order of occurrence.
  void take(const view::InputEvent& event);
  void press_key(const view::KeyPress& press) { do_action(view::action_of(press)); }
  void resize(int width, int height);
  /// Of text and controls, of the monitor that the window is on; loads its font.
  void set_scale(double scale, view::Renderer& renderer);

  /// Advances by `elapsed_s` (not negative) and updates scene, shots and overlay. Allocates nothing once
  /// warm.
  void advance(double elapsed_s);

  /// Drawn in reduced quality because something moves.
  bool is_plain() const { return is_plain_while_moving_ && still_s_ < settle_s; }
  /// True if scene and shots are those of the previous frame.
  bool has_same_picture() const { return has_same_picture_; }
  /// True if the frame does not change before the next event.
  bool is_idle() const;

  const view::Scene& scene() const { return joint_.scene(); }
  std::span<const view::Shot> shots() const { return shots_; }
  const view::Overlay& overlay() const { return gui_.overlay(); }
  const view::PlayerState& state() const { return state_; }
  const store::JointPose& pose() const { return readout_.pose; }
  /// What is wrong with the pose; empty if nothing is.
  const char* doubt() const { return readout_.doubt == nullptr ? "" : readout_.doubt; }
  bool is_varus_free() const { return range_.is_varus_free; }
  /// The latest message, also after its display time.
  const std::string& last_message() const { return message_; }
  const view::OrbitCamera& orbit_camera() const { return gaze_; }

  /// Return a pending request of the user and clear it.
  bool consume_screenshot_request();
  bool consume_save_request() { return std::exchange(saves_view_, false); }
  /// Whether full screen is wanted of a window that `is_full` screen now or not.
  bool consume_full_screen_request(bool is_full);

  /// Renders a screenshot without controls at the renderer's size.
  const view::Image& draw_screenshot(view::Renderer& renderer);
  /// What is shown; without the roll of the camera.
  ViewState view_state() const;
  /// Displays a message for some seconds.
  void show_message(const std::string& message);

 private:
  const store::Motion& motion() const { return sets_[state_.set].motion; }
  void do_action(view::Action action);
  void do_structure_action(view::Action action);
  void touch(const Eigen::Vector2d& pointer_px);
  void update_card();
  void update_section(view::SectionKind before);
  void take_key(const view::InputEvent& event);
  void set_view(view::View view);
  void frame_joint();
  bool is_over_picture(const Eigen::Vector2d& pointer_px) const;
  view::Viewport area() const { return gui_.free_area(width_, height_, state_); }
  /// The part of the area that has one picture: that at the pointer, or the first.
  view::Viewport pane(const std::optional<Eigen::Vector2d>& pointer_px = {}) const;
  view::PlayerRange range_now() const;
  void place_joint();
  void frame_fixed_object();
  void update_marks();
  view::GuiFrame frame_of(int width, int height);
  void draw_interface(double elapsed_s);
  void aim(const view::Viewport& viewport);

  store::MotionModel model_;
  std::vector<PlayedSet> sets_;
  JointView joint_;
  std::optional<Comparison> other_;
  std::vector<Eigen::Vector3d> framed_points_;  ///< over the whole motion, world
  Side side_ = Side::right;
  view::DoubtReader doubts_{model_};
  std::vector<view::MarkedSpan> marks_;     ///< on the timeline
  std::optional<double> marked_varus_rad_;  ///< that of the marks
  std::optional<std::size_t> marked_set_;
  view::Framing framing_ = view::Framing::joint;
  view::Gui gui_;
  view::PlayerState state_;
  view::PlayerRange range_;
  view::Readout readout_;
  view::OrbitCamera gaze_;
  view::View view_ = view::View::oblique;
  std::optional<view::CameraView> job_view_;  ///< until a view is chosen
  double zoom_ = 1.0;                         ///< of the view at the start
  view::Backdrop backdrop_ =
      view::Backdrop::studio;  ///< last applied to the scene; a lights file may replace it
  std::vector<view::Shot> shots_;
  view::Navigation navigation_;
  view::StructureList list_{joint_.structures(), joint_.looks(), {}, 60.0};
  /// Of the highlighted bundle over the timeline, percent, and what it belongs to.
  view::CurveLine strain_;
  std::optional<std::size_t> card_row_, card_set_;
  std::optional<double> card_varus_rad_;
  double tightest_ = 0.0;                    ///< position on the timeline
  std::optional<Eigen::Vector2d> press_px_;  ///< of a click, until the pointer moves
  Pose X_world_framed_ = Pose::Identity();   ///< the camera as the named view placed it
  view::GuiPointer pointer_;
  view::Key held_key_ = view::Key::none;
  int n_frames_due_ = 0;           ///< frames to draw until the interface settles
  bool was_left_pressed_ = false;  ///< since the last frame, so that a click shorter than a frame counts
  int width_ = 0, height_ = 0;
  double occlusion_radius_mm_ = 0.0;  ///< at rest
  bool is_plain_while_moving_ = false, was_moving_ = false;
  bool is_disturbed_ = true;  ///< by an event since the last frame
  double still_s_ = 0.0;      ///< since the last change of the picture
  bool has_same_picture_ = false;
  bool takes_picture_ = false, saves_view_ = false, toggles_full_screen_ = false, leaves_full_screen_ = false;
  std::string message_;
  double message_left_s_ = 0.0;
};

/// The motion model shown in the window; dropped files replace it.
class ShownModel {
 public:
  /// Shows `model`, read from `file`. The renderer must outlive this. Throws InputError if the model lacks
  /// what the options request.
  ShownModel(const std::string& file, store::MotionModel model, const SessionOptions& options,
             view::Renderer& renderer);

  Session& session() const { return *session_; }
  const std::string& file() const { return file_; }
  const std::string& title() const { return title_; }

  /// Opens the motion model in `file` with the same options, or its default set if it lacks theirs. On
  /// failure shows the error message, keeps the present model and returns false.
  bool open(const std::string& file);

 private:
  void show(store::MotionModel model, const SessionOptions& options);

  SessionOptions options_;
  view::Renderer& renderer_;
  std::string file_, title_;
  std::unique_ptr<Session> session_;
};

// Formatting of TOML values for files that the player writes: the text reads back as the same value.

/// Numbers always have a decimal point or an exponent, so that TOML reads them as floats; a list is
/// "[1.5, 2.0]".
std::string number_text(double value);
std::string list_text(std::span<const double> values);

}  // namespace vrda::show
