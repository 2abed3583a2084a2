#include "app/follow_window.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <ostream>

#include "app/follow_progress.hpp"
#include "app/mouse_button.hpp"
#include "app/stop_signals.hpp"
#include "app/stopwatch.hpp"
#include "follow/watch_thread.hpp"
#include "render/window.hpp"
#include "view/pointer.hpp"
#include "view/timeline.hpp"

namespace vrda {
namespace {

constexpr double frame_s = 1.0 / 60.0;
constexpr double idle_wait_s = 0.1;  // nothing moves: steps that come are seen soon enough
// Steps come in bursts; each is played within this time, so that moves are seen without falling behind.
constexpr double play_s = 1.0;

/// The finished motion, to and fro.
struct Playback {
  explicit Playback(const MotionModel& result) : set(set_names(result).front()), motion(result, set)
  {
    timeline.first_rad = motion.first_flexion_rad();
    timeline.last_rad = motion.last_flexion_rad();
    timeline.flexion_rad = timeline.first_rad;
    timeline.is_playing = timeline.last_rad > timeline.first_rad;
  }
  JointPose pose() const
  {
    return motion.at({timeline.flexion_rad, motion.balanced_varus_rad(timeline.flexion_rad)});
  }

  std::string set;
  Motion motion;
  Timeline timeline;
};

/// What the window shows and its user does.
class FollowSession {
 public:
  FollowSession(const FollowOptions& options, StepChoice choice, const MotionModel& model,
                const FollowStreams& streams)
      : choice_(choice),
        talk_(streams.talk),
        state_(model, choice),
        screen_(model, screen_options(options, model)),
        progress_(streams.data, options.is_quiet)
  {
    screen_.show(state_, {});
  }

  RunScreen& screen() { return screen_; }
  bool is_done() const { return is_done_; }
  bool is_finished() const { return playback_.has_value(); }
  bool is_idle() const { return queue_.empty() && (!playback_ || !playback_->timeline.is_playing) && !drag_; }
  /// Of the window.
  std::string title() const { return state_.counts() + " - vrda-player"; }

  void take(WatchArrivals arrivals)
  {
    for (const std::string& remark : arrivals.remarks) talk_ << "vrda-player: " << remark << "\n";
    if (arrivals.is_anew && arrivals.model) begin_again(*arrivals.model);
    for (SeenStep& step : arrivals.steps) queue_.push_back(std::move(step));
    n_steps_ = arrivals.n_steps;
    if (arrivals.phase == RunPhase::finished && arrivals.model) result_ = arrivals.model;
  }

  void resize(int width, int height)
  {
    if (screen_.resize(width, height)) show_state();
  }

  void advance(double elapsed_s)
  {
    if (!is_paused_) play_steps(elapsed_s);
    if (!is_paused_ && queue_.empty() && result_ && !playback_) finish();
    if (playback_) play_result(elapsed_s);
    progress_.say_state(state_, n_steps_);
  }

  void take(const InputEvent& event)
  {
    const Eigen::Vector2d pointer_px(event.x_px, event.y_px);
    switch (event.kind) {
      case InputKind::press:
        return press(event, pointer_px);
      case InputKind::motion:
        if (drag_) screen_.look(view_, dragged(*drag_, pointer_px, screen_.shots()[view_].viewport));
        return;
      case InputKind::release:
      case InputKind::focus_lost:
        return drag_.reset();
      case InputKind::wheel:
        if (const auto view = screen_.view_at(pointer_px))
          screen_.look(*view, nearer(screen_.gaze(*view), event.wheel_y));
        return;
      case InputKind::key_press:
        return press_key(event.key);
      default:
        return;
    }
  }

 private:
  void begin_again(const MotionModel& model)
  {
    if (state_.n_done() > 0) progress_.say("the run began anew");
    progress_.begin_again();
    queue_.clear();
    drag_.reset();
    state_ = RunState(model, choice_);
    screen_.begin(model);
    screen_.show(state_, {});
  }

  void play_steps(double elapsed_s)
  {
    if (queue_.empty()) return;
    const double part = std::min(1.0, elapsed_s / play_s);
    auto n_due = static_cast<std::size_t>(std::ceil(part * static_cast<double>(queue_.size())));
    for (n_due = std::max<std::size_t>(n_due, 1); n_due > 0; --n_due) {
      state_.take(queue_.front());
      queue_.pop_front();
    }
    progress_.note(state_.n_done(), state_.n_cells());
    show_state();
  }

  void show_state()
  {
    const std::string& rate = progress_.rate();
    screen_.show(state_, rate.empty() ? std::vector<std::string>{} : std::vector{rate});
  }

  void finish()
  {
    state_.finish(*result_);
    playback_.emplace(*result_);
    screen_.finish(*result_);
    progress_.say_state(state_, n_steps_, true);
  }

  void play_result(double elapsed_s)
  {
    playback_->timeline = advanced(playback_->timeline, elapsed_s);
    const JointPose pose = playback_->pose();
    if (pose.status == PoseStatus::solved)
      screen_.show(state_, {"set " + playback_->set}, pose, playback_->motion);
  }

  void press(const InputEvent& event, const Eigen::Vector2d& pointer_px)
  {
    const std::optional<std::size_t> view = screen_.view_at(pointer_px);
    if (!view) return;
    view_ = *view;
    const Button button = button_of(event.button);
    if (event.n_clicks == 2 && button == Button::left) return centre(pointer_px);
    drag_ = Drag{drag_of(button, event.has_shift, event.has_control), screen_.gaze(view_), pointer_px};
  }

  void centre(const Eigen::Vector2d& pointer_px)
  {
    const Shot& shot = screen_.shots()[view_];
    if (const auto point = point_under(screen_.scene(), shot.camera, shot.viewport, pointer_px))
      screen_.look(view_, centred_on(screen_.gaze(view_), *point));
  }

  void press_key(int key)
  {
    if (key == key_escape || key == 'Q') is_done_ = true;
    if (key == 'R') screen_.reset_views();
    if (key != ' ') return;
    if (playback_) {
      playback_->timeline = toggled(playback_->timeline);
    } else {
      is_paused_ = !is_paused_;
    }
  }

  StepChoice choice_;
  std::ostream& talk_;
  RunState state_;
  RunScreen screen_;
  FollowProgress progress_;
  std::deque<SeenStep> queue_;  // seen, not yet shown
  std::shared_ptr<const MotionModel> result_;
  std::optional<Playback> playback_;
  int n_steps_ = 0;
  std::optional<Drag> drag_;
  std::size_t view_ = 0;  // that the pointer is at
  bool is_paused_ = false, is_done_ = false;
};

WindowOptions window_options(const FollowOptions& options, const MotionModel& model)
{
  const RunScreenOptions screen = screen_options(options, model);
  WindowOptions window;
  window.width = screen.width;
  window.height = screen.height;
  window.title = "vrda-player";
  return window;
}

}  // namespace

FollowEnd follow_in_window(const FollowOptions& options, StepChoice choice, const FollowStreams& streams)
{
  StopSignals signals;  // before the thread, which keeps them too
  RunWatch watch(options.file, choice != StepChoice::stable);
  const MotionModel model = watch.model();
  Window window(window_options(options, model));
  FollowSession session(options, choice, model, streams);
  WatchThread thread(std::move(watch), between_looks);
  Stopwatch stopwatch;
  while (!session.is_done() && !window.should_close()) {
    if (signals.came_within(std::chrono::milliseconds(0))) break;
    const bool is_idle = window.is_iconified() || session.is_idle();
    for (const InputEvent& event : window.events(is_idle ? idle_wait_s : frame_s)) session.take(event);
    session.take(thread.take());
    session.resize(window.renderer().width(), window.renderer().height());
    session.advance(stopwatch.lap_s());
    window.set_title(session.title());
    if (window.is_iconified()) continue;
    session.screen().load(window.renderer());
    window.show(session.screen().scene(), session.screen().shots(), &session.screen().overlay());
  }
  return session.is_finished() ? FollowEnd::finished : FollowEnd::stopped;
}

}  // namespace vrda
