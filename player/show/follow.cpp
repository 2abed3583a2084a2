// The mode `follow`: options, the screen of a run with views and panel, and what happens while it computes.
#include "show/follow.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <deque>
#include <memory>
#include <ostream>

#include "core/text.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"
#include "show/joint_view.hpp"
#include "show/run_panel.hpp"
#include "show/run_watch.hpp"
#include "view/keys.hpp"
#include "view/layers.hpp"

namespace vrda::show {
namespace {

// Options.

/// The appearance of a run: its views and layers; the helical axis is available only for a result.
struct RunScreenOptions {
  ResolvedPictures pictures;
  view::LayerSet layers;
  view::Backdrop backdrop = view::Backdrop::studio;
};

constexpr std::size_t most_views = 16;                        // smaller tiles are unreadable
constexpr double most_turn_deg = 360.0, most_shift_mm = 1e4;  // larger values are typing errors

/// Parses triples of numbers from -most to most.
std::vector<Eigen::Vector3d> triples_of(const std::string& option, const std::string& text, double most)
{
  std::vector<Eigen::Vector3d> triples;
  if (text.empty()) return triples;
  for (const std::string& part : view::split(text, ';')) {
    const std::vector<std::string> numbers = view::split(part, ',');
    Eigen::Vector3d triple = Eigen::Vector3d::Zero();
    bool is_valid = numbers.size() == 3;
    for (std::size_t i = 0; is_valid && i < 3; ++i) {
      double& value = triple[static_cast<Eigen::Index>(i)];
      const char* const end = numbers[i].data() + numbers[i].size();
      const auto read = std::from_chars(numbers[i].data(), end, value);
      is_valid = read.ec == std::errc() && read.ptr == end && std::abs(value) <= most;
    }
    if (!is_valid) {
      throw InputError({option, "", "\"" + part + "\"",
                        "X,Y,Z;X,Y,Z;... one triple per view, numbers from -" + shortest_decimal(most) +
                            " to " + shortest_decimal(most)});
    }
    triples.push_back(triple);
  }
  return triples;
}

/// The views of --orient and --shift; missing triples of the shorter list are zero.
std::vector<view::CameraView> turned_views(const FollowOptions& options, Side side)
{
  std::vector<Eigen::Vector3d> turns_deg = triples_of("--orient", options.orient, most_turn_deg);
  std::vector<Eigen::Vector3d> shifts_mm = triples_of("--shift", options.shift, most_shift_mm);
  const std::size_t n = std::max(turns_deg.size(), shifts_mm.size());
  turns_deg.resize(n, Eigen::Vector3d::Zero());
  shifts_mm.resize(n, Eigen::Vector3d::Zero());
  std::vector<view::CameraView> views;
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d turn_rad = turns_deg[k] * rad_from_deg(1.0);
    const auto degrees = [&](Eigen::Index i) { return shortest_decimal(turns_deg[k][i]); };
    views.push_back(view::turned_view("rotated " + degrees(0) + ", " + degrees(1) + ", " + degrees(2),
                                      turn_rad, shifts_mm[k], side));
  }
  return views;
}

/// True if opaque bodies hide the contact layers; wire frames do not.
bool hides_contacts(const view::AppearanceOptions& look, const view::LayerSet& layers)
{
  return look.mode != view::DrawMode::wire &&
         (layers.has(view::Layer::contacts) || layers.has(view::Layer::normals));
}

/// Converts the options to those of the screen for a run with this model. Throws InputError like follow().
RunScreenOptions screen_options(const FollowOptions& options, const store::MotionModel& model)
{
  const bool is_turned = !options.orient.empty() || !options.shift.empty();
  if (is_turned && !options.views.empty()) {
    throw InputError(
        {"--views", "", options.views + " with --orient or --shift", "either --views or --orient/--shift"});
  }
  RunScreenOptions screen{resolved_pictures(options, model, "front,lateral"), {}, options.backdrop};
  ResolvedPictures& pictures = screen.pictures;
  pictures.zoom = view::job_views(model.job.resolved).zoom;
  if (is_turned) pictures.views = turned_views(options, side_named(model.side));
  if (pictures.views.size() > most_views) {
    throw InputError(
        {"views", "", std::to_string(pictures.views.size()), "at most " + std::to_string(most_views)});
  }
  view::AppearanceOptions& look = pictures.appearance;
  screen.layers = view::parsed_layers(look.layers);
  if (look.see_through.empty() && !options.is_opaque && hides_contacts(look, screen.layers))
    look.see_through = "reference";
  return screen;
}

// The displayed state of a run.

/// Which steps of a run are shown; the grid is updated by all steps.
enum class StepChoice {
  stable,   ///< stable cells
  contact,  ///< also search moves in contact, which give a smooth motion (thesis 3.8)
  all       ///< every search move and probe
};

StepChoice choice_of(const FollowOptions& options)
{
  constexpr std::array names{"stable", "contact", "all"};
  const auto found = std::ranges::find(names, options.steps);
  if (found == names.end())
    throw InputError({"--steps", "", "\"" + options.steps + "\"", "stable, contact or all"});
  return static_cast<StepChoice>(found - names.begin());
}

class RunState {
 public:
  RunState(const store::MotionModel& model, StepChoice choice)
      : choice_(choice),
        grid_{model.title.empty() ? "untitled" : model.title,
              model.flexion_deg,
              model.varus_deg,
              store::GridB::Constant(model.status.rows(), model.status.cols(), status_pending),
              {}}
  {
  }

  /// Updates the grid. Returns true if the step is to be shown.
  bool add_step(const RunStep& step)
  {
    // For steps with free varus, key.varus is the index of a start, not of a cell.
    const bool is_at_cell = step.key.kind <= StepKind::row;
    if (is_at_cell) grid_.current = GridCell{step.key.flexion, step.key.varus};
    if (step.kind == RunStepKind::cell) {
      std::int8_t& status = grid_.status(step.key.flexion, step.key.varus);
      n_done_ += status == status_pending ? 1 : 0;
      status = static_cast<std::int8_t>(step.status);
    }
    if (!is_chosen(step)) return false;
    shown_ = step;
    ++n_shown_;
    return true;
  }

  /// Takes the grid of the result and clears the shown step.
  void finish(const store::MotionModel& result)
  {
    grid_.status = result.status;
    n_done_ = static_cast<int>((grid_.status != status_pending).count());
    grid_.current.reset();
    shown_.reset();
    is_finished_ = true;
  }

  const std::optional<RunStep>& shown() const { return shown_; }
  int n_shown() const { return n_shown_; }
  bool is_finished() const { return is_finished_; }
  int n_done() const { return n_done_; }
  int n_cells() const { return static_cast<int>(grid_.status.size()); }
  const RunGrid& grid() const { return grid_; }

  /// "640/1911 attitudes"
  std::string progress_text() const
  {
    const std::string text = std::to_string(n_done_) + "/" + std::to_string(n_cells()) + " attitudes";
    return is_finished_ ? text + ", finished" : text;
  }
  /// "flexion 30, varus -4"; empty without a current cell.
  std::string current_attitude() const
  {
    if (!grid_.current) return {};
    return "flexion " +
           shortest_decimal(grid_.flexion_deg[static_cast<std::size_t>(grid_.current->flexion)]) +
           ", varus " + shortest_decimal(grid_.varus_deg[static_cast<std::size_t>(grid_.current->varus)]);
  }

 private:
  bool is_chosen(const RunStep& step) const
  {
    switch (choice_) {
      case StepChoice::stable:
        return step.kind == RunStepKind::cell && step.status == StepStatus::stable;
      case StepChoice::contact:
        return step.kind == RunStepKind::move ? step.in_contact : step.status == StepStatus::stable;
      case StepChoice::all:
        return true;
    }
    throw InternalError("unknown step choice");
  }

  StepChoice choice_;
  RunGrid grid_;
  std::optional<RunStep> shown_;
  int n_shown_ = 0, n_done_ = 0;
  bool is_finished_ = false;
};

// The screen of a run.

constexpr int border_px = 2;  // between tiles
constexpr double usual_aspect = 4.0 / 3.0;

/// Divides `area` into `n` tiles, row by row, as large as possible at an aspect near 4:3.
std::vector<view::Viewport> tiles(std::size_t n, const view::Viewport& area)
{
  check(n > 0, "there is at least one view");
  const auto count = static_cast<int>(n);
  int n_columns = 1;
  double best = 0.0;
  for (int columns = 1; columns <= count; ++columns) {
    const int rows = (count + columns - 1) / columns;
    const double size = std::min(1.0 * area.width / columns, usual_aspect * area.height / rows);
    if (size <= best) continue;
    best = size;
    n_columns = columns;
  }
  const int n_rows = (count + n_columns - 1) / n_columns;
  std::vector<view::Viewport> all;
  for (int k = 0; k < count; ++k) {
    const int row = k / n_columns, column = k % n_columns;
    // The last row's tiles share its width.
    const int columns = row + 1 < n_rows ? n_columns : count - row * n_columns;
    const int left = area.width * column / columns, right = area.width * (column + 1) / columns;
    const int top = area.height * row / n_rows, bottom = area.height * (row + 1) / n_rows;
    all.push_back({area.x + left, area.y + top, std::max(1, right - left - border_px),
                   std::max(1, bottom - top - border_px)});
  }
  return all;
}

/// Draws the name of a view on its tile.
void add_label(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& tile,
               const std::string& name)
{
  using view::ink, view::margin_px, view::paper;
  const float left_px = static_cast<float>(tile.x) + margin_px;
  const float top_px = static_cast<float>(tile.y) + 0.5F * margin_px;
  const view::OverlayBox plate{left_px - 0.5F * margin_px, top_px,
                               left_px + text.width_px(name) + 0.5F * margin_px, top_px + text.line_px()};
  text.add_area(overlay, plate, {paper[0], paper[1], paper[2], 150});
  text.add_text(overlay, left_px, top_px + 0.1F * text.line_px(), name, ink);
}

constexpr std::size_t usual_contacts = 32;  // initial capacity; most steps have fewer than ten

/// The joint of a run, from a start file or a result. Its steps have contacts and normals as markers.
class RunScene {
 public:
  /// Shows both objects at the first flexion with zero translation and rotation.
  RunScene(const store::MotionModel& model, const RunScreenOptions& options)
      : wanted_(options.layers),
        of_steps_(options.layers),
        joint_(model, options.pictures.appearance, options.backdrop),
        raw_(model, "raw"),
        frame_{side_named(model.side), model.rotation_centre_mm, model.delta},
        scale_(view::marker_scale(model)),
        points_(joint_.scene(), view::Layer::contacts, BodyIndex::world, "contacts"),
        arrows_(joint_.scene(), view::Layer::normals, BodyIndex::world, "contact normals")
  {
    joint_.fixed_object = BodyIndex::world;
    for (const view::Layer layer : {view::Layer::contacts, view::Layer::normals, view::Layer::helical_axis})
      of_steps_.set(layer, false);
    for (Eigen::Index i = 0; i < model.push.delta.rows(); ++i)
      deltas_.emplace_back(model.push.delta.row(i).transpose());
    reserve_markers(usual_contacts);
    place(raw_.joint_pose({rad_from_deg(model.flexion_deg.front()), 0.0}, {}), raw_, of_steps_);
  }

  /// Shows the pose of a step; the attitude rotates the reference, as in the search.
  void show(const RunStep& step)
  {
    SolverFrame frame = frame_;
    frame.delta = deltas_[static_cast<std::size_t>(step.key.flexion)];
    const Eigen::Vector3d t_mm = world_translation_mm(frame, step.pose);
    place(raw_.joint_pose(step.attitude, {t_mm.x(), t_mm.y(), t_mm.z(), step.pose.theta_rad}), raw_,
          of_steps_);
    place_markers(step, frame);
  }
  /// Shows a pose of `motion`, a set of the result that the scene was made from; of one that is not solved
  /// only the reference.
  void show(const store::JointPose& pose, const store::Motion& motion) { place(pose, motion, wanted_); }

  const view::Scene& scene() const { return joint_.scene(); }
  /// Increases when a renderer must reload the scene.
  std::uint64_t n_layouts() const { return n_layouts_; }

  /// The points to be framed, world: near the joint at first, middle and last flexion, at the present
  /// translation.
  std::vector<Eigen::Vector3d> framed_points() const
  {
    view::Scene scene = joint_.scene();
    std::vector<Eigen::Vector3d> all;
    const Eigen::Vector3d t_mm = pose_.X_world_moving * frame_.rotation_centre_mm;
    const double first_rad = raw_.first_flexion_rad(), last_rad = raw_.last_flexion_rad();
    for (const double flexion_rad : {first_rad, 0.5 * (first_rad + last_rad), last_rad}) {
      view::place(scene,
                  view::frames_of(raw_.joint_pose({flexion_rad, 0.0}, {t_mm.x(), t_mm.y(), t_mm.z(), 0.0})));
      const std::vector<Eigen::Vector3d> near = view::points_within(scene, view::joint_sphere(scene));
      all.insert(all.end(), near.begin(), near.end());
    }
    return all;
  }

 private:
  void place(const store::JointPose& pose, const store::Motion& motion, const view::LayerSet& layers)
  {
    pose_ = pose;
    joint_.show(motion, pose, layers);
  }

  void reserve_markers(std::size_t n_contacts)
  {
    points_.reserve(joint_.scene(), n_contacts);
    arrows_.reserve(joint_.scene(), n_contacts);
    ++n_layouts_;
  }

  void place_markers(const RunStep& step, const SolverFrame& frame)
  {
    const std::size_t n = step.contacts.size();
    if (n == 0) return;
    if (n > points_.capacity()) reserve_markers(2 * n);
    std::vector<Eigen::Vector3d> tips_mm, arrows_mm;
    for (const ContactRecord& contact : step.contacts) {
      tips_mm.push_back(world_from_solver(frame, contact.point_solver_mm));
      arrows_mm.emplace_back(scale_ * view::plain_arrow_mm * world_from_solver(frame, contact.normal_solver));
    }
    view::Scene& scene = joint_.scene();
    points_.show(scene, wanted_.has(view::Layer::contacts));
    arrows_.show(scene, wanted_.has(view::Layer::normals));
    points_.place(scene, tips_mm, arrows_mm, scale_);
    arrows_.place(scene, tips_mm, arrows_mm, scale_);
  }

  view::LayerSet wanted_, of_steps_;  // those of steps lack contacts and normals, which are markers
  JointView joint_;
  store::Motion raw_;
  SolverFrame frame_;                    // at the first flexion
  std::vector<Eigen::Vector3d> deltas_;  // [n_flexion]
  double scale_ = 1.0;
  view::ContactMarkers points_, arrows_;  // of steps
  store::JointPose pose_;
  std::uint64_t n_layouts_ = 0;
};

// Fraction of the image width, limited to what text and map need at least and can use at most.
constexpr double panel_part = 0.25;
constexpr int narrowest_panel_px = 150, widest_panel_px = 420;
// Text size relative to the image height.
constexpr double text_part = 1.0 / 60.0, smallest_text_px = 10.0, largest_text_px = 22.0;

/// Views, each with its own camera, and the panel of a run, as scene, shots and overlay for a renderer.
class RunScreen {
 public:
  RunScreen(const store::MotionModel& model, const RunScreenOptions& options) : options_(options)
  {
    check(!options.pictures.views.empty(), "there is at least one view");
    finish(model);
    resize(options.pictures.size.width, options.pictures.size.height);
  }

  /// Resets for a restarted run, possibly of another joint.
  void restart(const store::MotionModel& model)
  {
    finish(model);
    has_step_ = false;
    fit_cameras();
  }
  /// Switches to the result of the finished run; keeps the cameras.
  void finish(const store::MotionModel& result)
  {
    scene_.emplace(result, options_);
    n_loaded_layouts_ = 0;
  }

  /// Shows the step of the state, and its panel with additional lines. The first step sets the cameras.
  void show(const RunState& state, const std::vector<std::string>& lines)
  {
    if (state.shown()) scene_->show(*state.shown());
    draw(state, lines, state.shown().has_value());
  }
  /// Shows a pose of `motion`, a set of the result.
  void show(const RunState& state, const std::vector<std::string>& lines, const store::JointPose& pose,
            const store::Motion& motion)
  {
    scene_->show(pose, motion);
    draw(state, lines, true);
  }

  /// Sets the size in pixels. Returns true if it changed; show() must follow.
  bool resize(int width, int height)
  {
    if (width == width_ && height == height_) return false;
    if (height != height_) {
      text_.emplace(std::clamp(text_part * height, smallest_text_px, largest_text_px));
      is_font_loaded_ = false;
    }
    width_ = width;
    height_ = height;
    const int panel_px = std::clamp(static_cast<int>(panel_part * width),
                                    std::min(narrowest_panel_px, width / 2), widest_panel_px);
    panel_area_ = {width - panel_px, 0, panel_px, height};
    fit_cameras();
    return true;
  }

  /// Fits the cameras of all views to the joint.
  void fit_cameras()
  {
    const std::vector<Eigen::Vector3d> points_mm = scene_->framed_points();
    const std::vector<view::CameraView>& views = options_.pictures.views;
    const std::vector<view::Viewport> areas =
        tiles(views.size(), {0, 0, width_ - panel_area_.width, height_});
    shots_.clear();
    for (std::size_t k = 0; k < views.size(); ++k) {
      view::FrameOptions frame;
      frame.aspect = 1.0 * areas[k].width / areas[k].height;
      view::CameraFit fit(views[k].R_world_camera, frame);
      fit.include(points_mm);
      shots_.push_back({view::placed_camera(fit, views[k], options_.pictures.zoom), areas[k]});
    }
    pivots_world_mm_.assign(views.size(), view::joint_sphere(scene_->scene()).centre_world_mm);
    set_depths();
  }

  /// The view under the pointer.
  std::optional<std::size_t> view_at(const Eigen::Vector2d& pointer_px) const
  {
    for (std::size_t k = 0; k < shots_.size(); ++k) {
      const view::Viewport& at = shots_[k].viewport;
      const double x = pointer_px.x() - at.x, y = pointer_px.y() - at.y;
      if (x >= 0.0 && x < at.width && y >= 0.0 && y < at.height) return k;
    }
    return std::nullopt;
  }
  view::OrbitCamera orbit_camera(std::size_t view) const
  {
    return {shots_[view].camera, pivots_world_mm_[view]};
  }
  void set_orbit_camera(std::size_t view, const view::OrbitCamera& gaze)
  {
    pivots_world_mm_[view] = gaze.pivot_world_mm;
    shots_[view].camera = view::with_depth_range(gaze.camera, scene_->scene());
  }

  /// Loads new meshes and fonts into the renderer; must precede its draw() or present().
  void load(view::Renderer& renderer)
  {
    if (n_loaded_layouts_ != scene_->n_layouts()) renderer.load(scene_->scene());
    n_loaded_layouts_ = scene_->n_layouts();
    if (!is_font_loaded_) renderer.load(text_->font());
    is_font_loaded_ = true;
  }
  const view::Scene& scene() const { return scene_->scene(); }
  const std::vector<view::Shot>& shots() const { return shots_; }
  const view::Overlay& overlay() const { return overlay_; }

 private:
  void set_depths()
  {
    for (view::Shot& shot : shots_) shot.camera = view::with_depth_range(shot.camera, scene_->scene());
  }

  void draw(const RunState& state, const std::vector<std::string>& lines, bool has_pose)
  {
    if (has_pose && !has_step_) fit_cameras();
    has_step_ = has_step_ || has_pose;
    set_depths();
    view::clear_overlay(overlay_, width_, height_);
    std::vector<std::string> all{state.progress_text()};
    if (state.grid().current) all.push_back(state.current_attitude());
    all.insert(all.end(), lines.begin(), lines.end());
    for (std::size_t k = 0; k < shots_.size(); ++k)
      add_label(overlay_, *text_, shots_[k].viewport, options_.pictures.views[k].name);
    add_panel(overlay_, *text_, panel_area_, state.grid(), all);
    view::finish_overlay(overlay_);
  }

  RunScreenOptions options_;
  int width_ = 0, height_ = 0;
  std::optional<RunScene> scene_;
  std::optional<view::OverlayText> text_;
  view::Viewport panel_area_;
  std::vector<view::Shot> shots_;
  view::Overlay overlay_;
  std::vector<Eigen::Vector3d> pivots_world_mm_;  // one per view
  bool has_step_ = false;                         // the cameras were fitted to a step
  std::uint64_t n_loaded_layouts_ = 0;
  bool is_font_loaded_ = false;
};

// The mode.

using std::chrono::steady_clock;

constexpr std::chrono::seconds between_lines{2};  // of progress
// A compromise between latency and the load on a network disk.
constexpr std::chrono::milliseconds poll_interval{200};
constexpr double frame_s = 1.0 / 60.0;
constexpr double idle_s = 0.1;       // nothing moves: latency for new steps
constexpr double reading_s = 0.005;  // while existing records are being read
// Steps arrive in bursts; a burst is played within this time.
constexpr double play_s = 1.0;

/// Playback of the finished motion, forwards and backwards; without a window its middle pose.
struct Playback {
  Playback(const store::MotionModel& result, bool is_played)
      : set(store::default_motion(result).set),
        motion(result, set),
        doubts(result),
        reference_name(store::displayed_name(result, BodyIndex::reference))
  {
    timeline.first = motion.first_flexion_rad();
    timeline.last = motion.last_flexion_rad();
    timeline.position = is_played ? timeline.first : 0.5 * (timeline.first + timeline.last);
    timeline.is_playing = is_played && timeline.last > timeline.first;
  }
  store::JointPose pose() const
  {
    return motion.at({timeline.position, motion.balanced_varus_rad(timeline.position)});
  }

  /// Of the panel, whose lines are short: the set, and what is wrong with the pose without its explanation.
  std::vector<std::string> lines(const store::JointPose& pose) const
  {
    const std::string doubt = view::doubt_text(pose, doubts.at(pose), reference_name.c_str()).data();
    std::vector<std::string> lines{"set " + set};
    if (!doubt.empty()) lines.push_back(doubt.substr(0, doubt.find(':')));
    return lines;
  }

  std::string set;
  store::Motion motion;
  view::DoubtReader doubts;
  std::string reference_name;
  view::Timeline timeline;
};

/// Prints the progress of a followed run as lines of text.
class FollowProgress {
 public:
  FollowProgress(std::ostream& stream, bool is_quiet) : stream_(stream), is_quiet_(is_quiet) {}

  /// Restarts the rate measurement.
  void restart() { n_first_ = -1; }
  /// Updates the rate. Attitudes done before the first call are not counted.
  void update_rate(int n_done, int n_cells)
  {
    if (n_first_ < 0) {
      n_first_ = n_done;
      first_ = steady_clock::now();
    }
    rate_.clear();
    const double seconds = std::chrono::duration<double>(steady_clock::now() - first_).count();
    const int n_new = n_done - n_first_;
    if (n_new <= 0 || seconds <= 0.0) return;
    const double rate = n_new / seconds;
    const auto left_s = std::lround((n_cells - n_done) / rate);
    char text[80];
    std::snprintf(text, sizeof text, "%.3g/s, %ld:%02ld left", rate, left_s / 60, left_s % 60);
    rate_ = text;
  }
  /// "512/s, 0:02 left"; empty while unknown.
  const std::string& rate() const { return rate_; }

  /// Prints the state with the rate, at most every few seconds and only if it changed; `is_due` ignores the
  /// interval.
  void report_state(const RunState& state, int n_steps, bool is_due = false)
  {
    if (!is_due && steady_clock::now() - said_ < between_lines) return;
    const std::string line = line_of(state, n_steps);
    if (line != last_) report_line(line);
  }
  void report_line(const std::string& line)
  {
    last_ = line;
    said_ = steady_clock::now();
    if (!is_quiet_) stream_ << line << std::endl;
  }

 private:
  std::string line_of(const RunState& state, int n_steps) const
  {
    if (n_steps == 0 && !state.is_finished()) return "waiting for the first step";
    std::string line = state.progress_text();
    if (state.n_done() == 0) line += ", " + std::to_string(n_steps) + " steps of the spine";
    for (const std::string& more : {state.current_attitude(), state.is_finished() ? "" : rate_})
      line += more.empty() ? "" : ", " + more;
    return line;
  }

  std::ostream& stream_;
  bool is_quiet_;
  std::string rate_, last_;
  steady_clock::time_point said_, first_;
  int n_first_ = -1;
};

/// Shows a run in an interactive window, as image files or as text only.
class FollowedRun final : public Mode {
 public:
  FollowedRun(const FollowOptions& options, StepChoice choice, const Streams& streams, RunWatch watch,
              Sink& sink)
      : options_(options),
        choice_(choice),
        streams_(streams),
        output_(watch.output()),
        sink_(sink),
        state_(watch.model(), choice),
        progress_(options.folder.empty() ? streams.data : streams.messages, options.is_quiet)
  {
    if (sink.has_output()) {
      screen_.emplace(watch.model(), screen_options(options, watch.model()));
      screen_->show(state_, {});
    }
    thread_.emplace(std::move(watch), poll_interval);
  }

  FollowEnd end()
  {
    if (playback_ || is_over_) return FollowEnd::finished;
    if (!is_in_window()) progress_.report_line("stopped: the run has not ended");
    return FollowEnd::stopped;
  }

  bool is_over() const override { return is_over_ || is_left_; }

  RoundTime round_time() const override
  {
    if (is_in_window()) return {sink_.is_hidden() || is_still() ? idle_s : frame_s};
    if (!queue_.empty() || is_due_) return {0.0};
    const std::chrono::duration<double> interval = poll_interval;
    return {is_caught_up_ ? interval.count() : reading_s};
  }

  void take(const view::InputEvent& event) override
  {
    if (event.kind == view::InputKind::key_press) return press_key(event.key);
    const std::optional<std::size_t> over = screen_->view_at({event.x_px, event.y_px});
    if (!navigation_.is_dragging() && over) view_ = *over;
    if (!navigation_.is_dragging() && !over) return;
    screen_->set_orbit_camera(view_, navigation_.after(event, screen_->orbit_camera(view_), screen_->scene(),
                                                       screen_->shots()[view_].viewport));
  }

  void advance(double elapsed_s) override
  {
    take(thread_->take());
    if (is_in_window() && screen_->resize(sink_.renderer().width(), sink_.renderer().height())) show_state();
    if (!is_paused_) play_steps(elapsed_s);
    const bool has_all = !is_paused_ && queue_.empty();
    if (has_all && result_ && !playback_) return finish();
    if (playback_) return play_result(elapsed_s);
    if (has_all && options_.is_once && is_caught_up_) return end_now();
    if (options_.every_s > 0.0 && seconds_since(drawn_) >= options_.every_s && state_.n_shown() != n_drawn_)
      is_due_ = true;
    if (is_caught_up_ || n_steps_ > 0) progress_.report_state(state_, n_steps_);
  }

  void draw() override
  {
    if (!screen_ || (!is_in_window() && !is_due_)) return;
    screen_->load(sink_.renderer());
    const Frame frame{screen_->scene(), screen_->shots(), &screen_->overlay()};
    if (is_in_window()) {
      sink_.window()->set_title(state_.progress_text() + " - vrda-player");
      return sink_.show(frame);
    }
    is_due_ = false;
    drawn_ = steady_clock::now();
    n_drawn_ = state_.n_shown();
    const std::string name =
        playback_ ? "finished" : padded_name("step_", static_cast<std::size_t>(state_.n_shown()), 6);
    streams_.data << sink_.record(frame, name + ".png") << std::endl;
  }

 private:
  bool is_in_window() const { return sink_.window() != nullptr; }
  bool is_still() const
  {
    return queue_.empty() && (!playback_ || !playback_->timeline.is_playing) && !navigation_.is_dragging();
  }

  static double seconds_since(steady_clock::time_point then)
  {
    return std::chrono::duration<double>(steady_clock::now() - then).count();
  }

  void take(RunUpdate arrivals)
  {
    for (const std::string& remark : arrivals.remarks) streams_.messages << "vrda-player: " << remark << "\n";
    if (arrivals.is_restarted && arrivals.model) begin_again(*arrivals.model);
    for (RunStep& step : arrivals.steps) queue_.push_back(std::move(step));
    n_steps_ = arrivals.n_steps;
    is_caught_up_ = !arrivals.has_more;
    if (arrivals.phase == RunPhase::finished && arrivals.model) result_ = arrivals.model;
  }

  void begin_again(const store::MotionModel& model)
  {
    if (n_steps_ > 0 || state_.n_done() > 0) progress_.report_line("the run was restarted");
    progress_.restart();
    queue_.clear();
    navigation_.stop();
    state_ = RunState(model, choice_);
    n_drawn_ = 0;
    if (!screen_) return;
    screen_->restart(model);
    screen_->show(state_, {});
  }

  /// In a window plays the steps due by now; otherwise all up to the next image.
  void play_steps(double elapsed_s)
  {
    if (queue_.empty()) return;
    std::size_t n_due = queue_.size();
    if (is_in_window()) {
      const double part = std::min(1.0, elapsed_s / play_s);
      n_due =
          std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(part * static_cast<double>(n_due))));
    }
    for (; n_due > 0 && !is_due_; --n_due) {
      const bool is_shown = state_.add_step(queue_.front());
      queue_.pop_front();
      is_due_ = is_shown && options_.every_n_steps > 0 && state_.n_shown() % options_.every_n_steps == 0;
    }
    if (is_in_window() || queue_.empty()) progress_.update_rate(state_.n_done(), state_.n_cells());
    show_state();
  }

  void show_state()
  {
    const std::string& rate = progress_.rate();
    if (screen_) screen_->show(state_, rate.empty() ? std::vector<std::string>{} : std::vector{rate});
  }

  void finish()
  {
    state_.finish(*result_);
    playback_.emplace(*result_, is_in_window());
    if (screen_) screen_->finish(*result_);
    progress_.report_line(output_ + ": " + state_.progress_text());
    for (const std::string& warning : view::model_warnings(*result_))
      streams_.messages << "warning: " << output_ << ": " << warning << "\n";
    if (const std::string reason = store::default_motion(*result_).reason; !reason.empty())
      progress_.report_line(output_ + ": " + playback_->set + " is shown; " + reason);
    play_result(0.0);
    is_due_ = true;
    is_over_ = !is_in_window();
  }

  void play_result(double elapsed_s)
  {
    playback_->timeline = view::advanced(playback_->timeline, elapsed_s);
    const store::JointPose pose = playback_->pose();
    if (screen_) screen_->show(state_, playback_->lines(pose), pose, playback_->motion);
  }

  void end_now()
  {
    is_due_ = is_due_ || state_.n_shown() != n_drawn_ || n_drawn_ == 0;
    is_over_ = true;
    progress_.report_state(state_, n_steps_, true);
  }

  void press_key(view::Key key)
  {
    if (key == view::key_of('Q')) is_left_ = true;
    if (key == view::key_of('R')) screen_->fit_cameras();
    if (key != view::Key::space) return;
    if (playback_) {
      playback_->timeline = view::toggled(playback_->timeline);
    } else {
      is_paused_ = !is_paused_;
    }
  }

  const FollowOptions& options_;
  StepChoice choice_;
  Streams streams_;
  std::string output_;
  Sink& sink_;
  RunState state_;
  FollowProgress progress_;
  std::optional<RunScreen> screen_;  // empty for text output
  std::optional<WatchThread> thread_;
  std::deque<RunStep> queue_;  // read, not yet shown
  std::shared_ptr<const store::MotionModel> result_;
  std::optional<Playback> playback_;
  int n_steps_ = 0;
  bool is_caught_up_ = false;
  view::Navigation navigation_;
  std::size_t view_ = 0;  // under the pointer
  bool is_paused_ = false, is_left_ = false;
  // For image files: whether one is due, when the last was written, and its number of steps.
  bool is_due_ = false, is_over_ = false;
  steady_clock::time_point drawn_;
  int n_drawn_ = 0;
};

void require_valid(const FollowOptions& options)
{
  choice_of(options);
  if (!(options.every_s >= 0.0))
    throw InputError({"--every", "", std::to_string(options.every_s), "seconds"});
  if (options.every_n_steps < 0)
    throw InputError({"--each", "", std::to_string(options.every_n_steps), "1 or more steps"});
  const bool has_interval = options.every_s > 0.0 || options.every_n_steps > 0;
  if (has_interval && options.folder.empty())
    throw InputError({"--offscreen", "", "nothing", "a folder for the images of --every and --each"});
  if (options.is_once && options.folder.empty() && !options.is_text)
    throw InputError({"--once", "", "a window", "--offscreen or --text with it"});
  if (options.is_text && !options.folder.empty())
    throw InputError({"--text", "", "--offscreen " + options.folder, "only one of them"});
}

Sink sink_of(const FollowOptions& options, const store::MotionModel& model)
{
  if (options.is_text) return {};
  const view::PictureSize size = screen_options(options, model).pictures.size;
  if (!options.folder.empty()) {
    Sink files(view::RenderOptions{size.width, size.height});
    files.record_images(options.folder, "--offscreen");
    return files;
  }
  view::WindowOptions window;
  window.width = size.width;
  window.height = size.height;
  window.title = "vrda-player";
  return Sink(window);
}

}  // namespace

FollowEnd follow(const FollowOptions& options, const Streams& streams)
{
  require_valid(options);
  StopSignals stop;  // before the thread, which inherits the signal mask
  const StepChoice choice = choice_of(options);
  RunWatch watch(options.file, choice != StepChoice::stable);
  Sink sink = sink_of(options, watch.model());
  FollowedRun run(options, choice, streams, std::move(watch), sink);
  run_loop(run, sink, stop);
  return run.end();
}

}  // namespace vrda::show
