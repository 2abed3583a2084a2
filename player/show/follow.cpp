#include "show/follow.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <ostream>

#include "core/error.hpp"
#include "show/run_state.hpp"
#include "show/run_watch.hpp"
#include "show/loop.hpp"
#include "store/joint_parts.hpp"
#include "view/doubts.hpp"
#include "view/orbit_camera.hpp"
#include "view/player_state.hpp"

namespace vrda::show {
namespace {

using std::chrono::steady_clock;

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
        reference_name(store::displayed_name(result, store::JointBody::reference))
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

/// Shows a run in an interactive window, as image files or as text only.
class FollowedRun final : public show::Mode {
 public:
  FollowedRun(const FollowOptions& options, StepChoice choice, const show::Streams& streams, RunWatch watch,
              show::Sink& sink)
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

  show::RoundTime round_time() const override
  {
    if (is_in_window()) return {sink_.is_hidden() || is_still() ? idle_s : frame_s};
    if (!queue_.empty() || is_due_) return {0.0};
    const std::chrono::duration<double> interval = poll_interval;
    return {is_caught_up_ ? interval.count() : reading_s};
  }

  void take(const view::InputEvent& event) override
  {
    const Eigen::Vector2d pointer_px(event.x_px, event.y_px);
    switch (event.kind) {
      case view::InputKind::press:
        return press(event, pointer_px);
      case view::InputKind::motion:
        if (drag_)
          screen_->set_orbit_camera(
              view_, view::dragged(*drag_, pointer_px, screen_->shots()[view_].viewport));
        return;
      case view::InputKind::release:
      case view::InputKind::focus_lost:
        return drag_.reset();
      case view::InputKind::wheel:
        if (const auto view = screen_->view_at(pointer_px))
          screen_->set_orbit_camera(*view,
                                    view::moved_closer(screen_->orbit_camera(*view), event.wheel));
        return;
      case view::InputKind::key_press:
        return press_key(event.key);
      default:
        return;
    }
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
    const show::Frame frame{screen_->scene(), screen_->shots(), &screen_->overlay()};
    if (is_in_window()) {
      sink_.window()->set_title(state_.progress_text() + " - vrda-player");
      return sink_.show(frame);
    }
    is_due_ = false;
    drawn_ = steady_clock::now();
    n_drawn_ = state_.n_shown();
    const std::string name =
        playback_ ? "finished" : show::padded_name("step_", static_cast<std::size_t>(state_.n_shown()), 6);
    streams_.data << sink_.record(frame, name + ".png") << std::endl;
  }

 private:
  bool is_in_window() const { return sink_.window() != nullptr; }
  bool is_still() const
  {
    return queue_.empty() && (!playback_ || !playback_->timeline.is_playing) && !drag_;
  }

  static double seconds_since(steady_clock::time_point then)
  {
    return std::chrono::duration<double>(steady_clock::now() - then).count();
  }

  void take(AccumulatedUpdate arrivals)
  {
    for (const std::string& remark : arrivals.remarks) streams_.messages << "vrda-player: " << remark << "\n";
    if (arrivals.is_restarted && arrivals.model) begin_again(*arrivals.model);
    for (RunStep& step : arrivals.steps) queue_.push_back(std::move(step));
    n_steps_ = arrivals.n_steps;
    is_caught_up_ = arrivals.is_caught_up;
    if (arrivals.phase == RunPhase::finished && arrivals.model) result_ = arrivals.model;
  }

  void begin_again(const store::MotionModel& model)
  {
    if (n_steps_ > 0 || state_.n_done() > 0) progress_.report_line("the run was restarted");
    progress_.restart();
    queue_.clear();
    drag_.reset();
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

  void press(const view::InputEvent& event, const Eigen::Vector2d& pointer_px)
  {
    const std::optional<std::size_t> view = screen_->view_at(pointer_px);
    if (!view) return;
    view_ = *view;
    if (event.n_clicks == 2 && event.button == view::MouseButton::left) return centre(pointer_px);
    drag_ = view::Drag{view::drag_of(event.button, event.has_shift, event.has_control),
                             screen_->orbit_camera(view_), pointer_px};
  }

  void centre(const Eigen::Vector2d& pointer_px)
  {
    const view::Shot& shot = screen_->shots()[view_];
    if (const auto point = view::point_under(screen_->scene(), shot.camera, shot.viewport, pointer_px))
      screen_->set_orbit_camera(view_, view::centred_on(screen_->orbit_camera(view_), *point));
  }

  void press_key(view::Key key)
  {
    if (key == view::Key::escape || key == view::key_of('Q')) is_left_ = true;
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
  show::Streams streams_;
  std::string output_;
  show::Sink& sink_;
  RunState state_;
  FollowProgress progress_;
  std::optional<RunScreen> screen_;  // empty for text output
  std::optional<WatchThread> thread_;
  std::deque<RunStep> queue_;  // read, not yet shown
  std::shared_ptr<const store::MotionModel> result_;
  std::optional<Playback> playback_;
  int n_steps_ = 0;
  bool is_caught_up_ = false;
  std::optional<view::Drag> drag_;
  std::size_t view_ = 0;  // under the pointer
  bool is_paused_ = false, is_left_ = false;
  // For image files: whether one is due, when the last was written, and its number of steps.
  bool is_due_ = false, is_over_ = false;
  steady_clock::time_point drawn_;
  int n_drawn_ = 0;
};

StepChoice choice_of(const FollowOptions& options)
{
  const std::vector<std::string>& names = step_choice_names();
  const auto found = std::ranges::find(names, options.steps);
  if (found == names.end())
    throw InputError({"--steps", "", "\"" + options.steps + "\"", "stable, contact or all"});
  return static_cast<StepChoice>(found - names.begin());
}

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

show::Sink sink_of(const FollowOptions& options, const store::MotionModel& model)
{
  if (options.is_text) return {};
  const RunScreenOptions screen = screen_options(options, model);
  if (!options.folder.empty()) {
    show::Sink files(view::RenderOptions{screen.width, screen.height});
    files.record_images(options.folder, "--offscreen");
    return files;
  }
  view::WindowOptions window;
  window.width = screen.width;
  window.height = screen.height;
  window.title = "vrda-player";
  return show::Sink(window);
}

}  // namespace

FollowEnd follow(const FollowOptions& options, const show::Streams& streams)
{
  require_valid(options);
  show::StopSignals stop;  // before the thread, which inherits the signal mask
  const StepChoice choice = choice_of(options);
  RunWatch watch(options.file, choice != StepChoice::stable);
  show::Sink sink = sink_of(options, watch.model());
  FollowedRun run(options, choice, streams, std::move(watch), sink);
  show::run_loop(run, sink, stop);
  return run.end();
}

}  // namespace vrda::show
