#include "app/follow.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>

#include "app/follow_progress.hpp"
#include "app/follow_window.hpp"
#include "app/stop_signals.hpp"
#include "core/error.hpp"
#include "render/png_file.hpp"

namespace vrda {
namespace {

using std::chrono::steady_clock;

// Often enough that a step is seen as it comes, rare enough for a network disk.

double seconds_since(steady_clock::time_point then)
{
  return std::chrono::duration<double>(steady_clock::now() - then).count();
}

/// Pictures of a run, written to a folder.
class Pictures {
 public:
  Pictures(const FollowOptions& options, const MotionModel& model, std::ostream& data)
      : folder_(options.folder), data_(data), screen_(model, screen_options(options, model))
  {
    const RunScreenOptions asked = screen_options(options, model);
    renderer_ = make_offscreen_renderer({asked.width, asked.height});
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) throw InputError({folder_, "--offscreen", error.message(), "a folder that can be written"});
  }

  void begin(const MotionModel& model) { screen_.begin(model); }
  void write(const RunState& state, const std::vector<std::string>& lines)
  {
    screen_.show(state, lines);
    char name[32];
    std::snprintf(name, sizeof name, "step_%06d.png", state.n_shown());
    write_as(name);
  }
  void write_result(const RunState& state, const MotionModel& result)
  {
    screen_.finish(result);
    const std::string set = set_names(result).front();
    const Motion motion(result, set);
    const double flexion_rad = 0.5 * (motion.first_flexion_rad() + motion.last_flexion_rad());
    const JointPose pose = motion.at({flexion_rad, motion.balanced_varus_rad(flexion_rad)});
    if (pose.status == PoseStatus::solved) {
      screen_.show(state, {"set " + set}, pose, motion);
    } else {
      screen_.show(state, {});
    }
    write_as("finished.png");
  }

 private:
  void write_as(const std::string& name)
  {
    screen_.load(*renderer_);
    const std::string path = (std::filesystem::path(folder_) / name).string();
    write_png(renderer_->draw(screen_.scene(), screen_.shots(), &screen_.overlay()), path);
    data_ << path << std::endl;
  }

  std::string folder_;
  std::ostream& data_;
  RunScreen screen_;
  std::unique_ptr<Renderer> renderer_;
};

StepChoice choice_of(const FollowOptions& options)
{
  const std::vector<std::string>& names = step_choice_names();
  const auto found = std::find(names.begin(), names.end(), options.steps);
  if (found == names.end())
    throw InputError({"--steps", "", "\"" + options.steps + "\"", "stable, contact or all"});
  return static_cast<StepChoice>(found - names.begin());
}

void require_sound(const FollowOptions& options)
{
  choice_of(options);
  if (!(options.every_s >= 0.0))
    throw InputError({"--every", "", std::to_string(options.every_s), "seconds"});
  if (options.each < 0) throw InputError({"--each", "", std::to_string(options.each), "1 or more steps"});
  const bool has_rhythm = options.every_s > 0.0 || options.each > 0;
  if (has_rhythm && options.folder.empty())
    throw InputError(
        {"--offscreen", "", "nothing", "the folder of the pictures that --every and --each ask for"});
  if (options.is_once && options.folder.empty() && !options.is_text)
    throw InputError({"--once", "", "a window", "--offscreen or --text with it"});
  if (options.is_text && !options.folder.empty())
    throw InputError({"--text", "", "--offscreen " + options.folder, "pictures or none"});
}

/// A run followed without a window.
class Followed {
 public:
  Followed(const FollowOptions& options, const FollowStreams& streams)
      : options_(options),
        streams_(streams),
        watch_(options.file, choice_of(options) != StepChoice::stable),
        state_(watch_.model(), choice_of(options)),
        progress_(options.folder.empty() ? streams.data : streams.talk, options.is_quiet)
  {
    if (!options.folder.empty()) pictures_.emplace(options, watch_.model(), streams.data);
  }

  FollowEnd run()
  {
    while (watch_.phase() != RunPhase::finished) {
      const bool has_more = look();
      if (watch_.phase() == RunPhase::finished) break;
      if (!has_more && options_.is_once) return end_now();
      if (signals_.came_within(has_more ? std::chrono::milliseconds(0) : between_looks)) {
        progress_.say("stopped: the run has not ended");
        return FollowEnd::stopped;
      }
    }
    state_.finish(watch_.model());
    if (pictures_) pictures_->write_result(state_, watch_.model());
    progress_.say(watch_.output() + ": " + state_.counts());
    return FollowEnd::finished;
  }

 private:
  /// Whether to look again at once.
  bool look()
  {
    const WatchNews news = watch_.look();
    for (const std::string& remark : news.remarks) streams_.talk << "vrda-player: " << remark << "\n";
    if (news.is_anew) begin_again();
    for (const SeenStep& step : news.steps) {
      if (!state_.take(step) || options_.each == 0 || state_.n_shown() % options_.each != 0) continue;
      write_picture();
      if (signals_.came_within(std::chrono::milliseconds(0))) return false;
    }
    progress_.note(watch_.n_done(), watch_.n_cells());
    if (options_.every_s > 0.0 && seconds_since(written_) >= options_.every_s &&
        state_.n_shown() != n_written_) {
      write_picture();
    }
    progress_.say_state(state_, watch_.n_steps());
    return news.has_more;
  }

  void begin_again()
  {
    if (watch_.n_steps() > 0 || state_.n_done() > 0) progress_.say("the run began anew");
    progress_.begin_again();
    state_ = RunState(watch_.model(), choice_of(options_));
    if (pictures_) pictures_->begin(watch_.model());
    n_written_ = 0;
  }

  void write_picture()
  {
    written_ = steady_clock::now();
    n_written_ = state_.n_shown();
    const std::string& rate = progress_.rate();
    pictures_->write(state_, rate.empty() ? std::vector<std::string>{} : std::vector{rate});
  }

  FollowEnd end_now()
  {
    if (pictures_ && (state_.n_shown() != n_written_ || n_written_ == 0)) write_picture();
    progress_.say_state(state_, watch_.n_steps(), true);
    return FollowEnd::finished;
  }

  const FollowOptions& options_;
  const FollowStreams& streams_;
  StopSignals signals_;
  RunWatch watch_;
  RunState state_;
  FollowProgress progress_;
  std::optional<Pictures> pictures_;
  steady_clock::time_point written_;
  int n_written_ = 0;
};

}  // namespace

FollowEnd follow(const FollowOptions& options, const FollowStreams& streams)
{
  require_sound(options);
  if (options.folder.empty() && !options.is_text)
    return follow_in_window(options, choice_of(options), streams);
  return Followed(options, streams).run();
}

}  // namespace vrda
