#include "app/show_window.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/arguments.hpp"
#include "app/session.hpp"
#include "app/shown_model.hpp"
#include "app/stopwatch.hpp"
#include "core/error.hpp"
#include "render/png_file.hpp"
#include "render/window.hpp"

namespace vrda {
namespace {

constexpr double paused_wait_s = 0.25;         // a paused picture wants no work
constexpr double least_frame_s = 1.0 / 120.0;  // where the screen sets no pace

void require_window_options(const ShowOptions& options)
{
  if (!options.trace.empty()) {
    throw InputError(
        {"--trace", "", "no --offscreen and no --video", "either of them: a window shows no such series"});
  }
  if (parsed_views(options.views).size() > 1)
    throw InputError({"--views", "", options.views, "one view: a window begins with it"});
}

SessionOptions session_options(const ShowOptions& options, const std::string& set)
{
  const PictureSize size = parsed_size(options.size);
  SessionOptions session;
  session.set = set;
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

WindowOptions window_options(const ShowOptions& options, const SessionOptions& session)
{
  WindowOptions window;
  window.width = session.width;
  window.height = session.height;
  window.samples = options.samples;
  return window;
}

std::string title_of(const ShownModel& shown)
{
  return (shown.title().empty() ? shown.file() : shown.title()) + " - vrda-player";
}

/// Takes what happened; a dropped file is opened behind it. Of several, the first.
void take_events(Window& window, ShownModel& shown, double wait_s)
{
  std::string dropped;
  for (const InputEvent& event : window.events(wait_s)) {
    shown.session().take(event);
    if (event.kind == InputKind::drop && !window.dropped_files().empty())
      dropped = window.dropped_files().front();
  }
  if (!dropped.empty() && shown.open(dropped)) window.set_title(title_of(shown));
}

}  // namespace

void show_in_window(const ShowOptions& options, MotionModel model, const std::string& set)
{
  require_window_options(options);
  SessionOptions chosen = session_options(options, set);
  Window window(window_options(options, chosen));
  chosen.scale = std::clamp(window.content_scale(), 1.0, 4.0);
  ShownModel shown(options.file, std::move(model), chosen, window.renderer());
  window.set_title(title_of(shown));
  Stopwatch stopwatch;
  while (!shown.session().state().is_done && !window.should_close()) {
    const bool is_idle = window.is_iconified() || shown.session().is_idle();
    const double wait_s = is_idle ? paused_wait_s : std::max(0.0, least_frame_s - stopwatch.running_s());
    take_events(window, shown, wait_s);
    Session& session = shown.session();
    session.resize(window.renderer().width(), window.renderer().height());
    session.advance(stopwatch.lap_s());
    if (session.takes_picture()) save_picture(session, window.renderer(), shown.file());
    if (session.toggles_full_screen()) window.toggle_full_screen();
    if (!window.is_iconified()) window.show(session.scene(), session.shots(), &session.overlay());
  }
}

}  // namespace vrda
