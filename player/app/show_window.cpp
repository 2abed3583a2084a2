#include "app/show_window.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "app/arguments.hpp"
#include "app/session.hpp"
#include "core/error.hpp"
#include "render/png_file.hpp"
#include "render/window.hpp"

namespace vrda {
namespace {

constexpr double idle_wait_s = 0.25;           // a paused picture wants no work
constexpr double least_frame_s = 1.0 / 120.0;  // where the screen sets no pace
constexpr double longest_frame_s = 10.0;       // a clock that jumps is not time that was seen

void require_window_options(const ShowOptions& options)
{
  const auto refuse = [](const char* option) {
    throw InputError(
        {option, "", "no --offscreen and no --video", "either of them: a window shows no such series"});
  };
  if (!options.trace.empty()) refuse("--trace");
  if (options.speed_deg_s) refuse("--speed");
  if (options.is_to_and_fro) refuse("--to-and-fro");
}

SessionOptions session_options(const ShowOptions& options, const MotionModel& model, const std::string& set)
{
  const PictureSize size = parsed_size(options.size);
  SessionOptions session;
  session.set = set;
  session.title = model.title;
  session.view = *view_named(parsed_views(options.views).front());
  if (options.flexion)
    session.flexion_rad = rad_from_deg(parsed_angles("--flexion", *options.flexion).first_deg);
  if (options.varus_deg) session.varus_rad = rad_from_deg(*options.varus_deg);
  session.backdrop = options.backdrop;
  session.held = options.held;
  session.look = options.look;
  session.frames_all = options.framed == Framed::all;
  session.width = size.width;
  session.height = size.height;
  return session;
}

/// A name in the current folder that nothing has yet: knee_flexion_040.png, then knee_flexion_040_2.png.
std::string free_name(const std::string& file, double flexion_rad)
{
  const std::string stem = std::filesystem::path(file).stem().string() + "_flexion_" +
                           angle_label(std::round(deg_from_rad(flexion_rad)), {});
  std::string name = stem + ".png";
  for (int n = 2; std::filesystem::exists(name); ++n) name = stem + "_" + std::to_string(n) + ".png";
  return name;
}

void save_picture(Session& session, Renderer& renderer, const std::string& file)
{
  const std::string name = free_name(file, session.pose().attitude.flexion_rad);
  try {
    write_png(session.picture(renderer), name);
    session.tell("picture written: " + name);
  } catch (const InputError& error) {
    // A full disk ends no session.
    session.tell(error.what());
  }
}

bool is_reached(const Session& session, double flexion_rad)
{
  constexpr double rounding_rad = 1e-9;
  return std::abs(session.state().timeline.flexion_rad - flexion_rad) < rounding_rad;
}

class Stopwatch {
 public:
  double running_s() const
  {
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - start_;
    return std::min(since.count(), longest_frame_s);
  }
  /// Begins anew; how long it ran.
  double lap_s()
  {
    const double s = running_s();
    start_ = std::chrono::steady_clock::now();
    return s;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

void show_in_window(const ShowOptions& options, MotionModel model, const std::string& set)
{
  require_window_options(options);
  SessionOptions chosen = session_options(options, model, set);
  WindowOptions window_options;
  window_options.width = chosen.width;
  window_options.height = chosen.height;
  window_options.samples = options.samples;
  window_options.title = (model.title.empty() ? options.file : model.title) + " - vrda-player";
  Window window(window_options);
  chosen.width = window.renderer().width();
  chosen.height = window.renderer().height();
  chosen.scale = std::clamp(window.content_scale(), 1.0, 4.0);
  Session session(std::move(model), chosen);
  session.load_into(window.renderer());
  if (chosen.flexion_rad && !is_reached(session, *chosen.flexion_rad))
    session.tell("the flexion asked for lies outside the measured range");
  Stopwatch stopwatch;
  while (!session.state().is_done && !window.should_close()) {
    const bool is_idle = window.is_iconified() || session.is_idle();
    const double wait_s = is_idle ? idle_wait_s : std::max(0.0, least_frame_s - stopwatch.running_s());
    for (const InputEvent& event : window.events(wait_s)) session.take(event);
    session.resize(window.renderer().width(), window.renderer().height());
    session.advance(stopwatch.lap_s());
    if (session.takes_picture()) save_picture(session, window.renderer(), options.file);
    if (session.toggles_full_screen()) window.toggle_full_screen();
    if (!window.is_iconified()) window.show(session.scene(), session.shots(), &session.overlay());
  }
}

}  // namespace vrda
