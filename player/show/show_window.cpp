// The mode `show` in a window.

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/error.hpp"
#include "show/loop.hpp"
#include "view/arguments.hpp"
#include "view/image.hpp"
#include "view/window.hpp"
#include "show/session.hpp"
#include "show/show.hpp"

namespace vrda::show {
namespace {

constexpr double paused_wait_s = 0.25;         // saves work while nothing changes
constexpr double least_frame_s = 1.0 / 120.0;  // limit without vertical synchronisation

void require_window_options(const ShowOptions& options)
{
  if (!options.trace.empty()) {
    throw InputError(
        {"--trace", "", "no --offscreen and no --video", "either of them: a window cannot show a trace"});
  }
  if (!options.views.empty() && view::parsed_views(options.views).size() > 1)
    throw InputError({"--views", "", options.views, "one view: the window starts with it"});
}

SessionOptions session_options(const ShowOptions& options, const store::MotionModel& model,
                               const std::string& set)
{
  const ResolvedShowOptions look = resolved_options(options, model);
  SessionOptions session;
  session.set = set;
  if (const std::optional<view::View> view = view::view_named(look.views.front().name)) {
    session.view = *view;
  } else {
    session.job_view = look.views.front();
  }
  session.zoom = look.zoom;
  if (options.flexion)
    session.flexion_rad = rad_from_deg(view::parsed_angles("--flexion", *options.flexion).first_deg);
  if (options.frame) session.key = view::parsed_angles("--key", *options.frame).first_deg;
  if (options.varus_deg) session.varus_rad = rad_from_deg(*options.varus_deg);
  session.backdrop = options.backdrop;
  session.fixed_object = options.fixed_object;
  session.appearance = look.appearance;
  session.framing = options.framing;
  session.width = look.size.width;
  session.height = look.size.height;
  return session;
}

/// In the current folder: knee_flexion_040.png, then knee_flexion_040_2.png.
std::string picture_name(const std::string& file, double flexion_rad, std::size_t number)
{
  const std::string stem = std::filesystem::path(file).stem().string() + "_flexion_" +
                           view::angle_label(std::round(deg_from_rad(flexion_rad)), {});
  return stem + (number == 1 ? "" : "_" + std::to_string(number)) + ".png";
}

view::WindowOptions window_options(const ShowOptions& options, const SessionOptions& session)
{
  view::WindowOptions window;
  window.width = session.width;
  window.height = session.height;
  window.samples = options.samples;
  return window;
}

/// Runs a session in a window and opens dropped files.
class ShowMode final : public show::Mode {
 public:
  ShowMode(const ShowOptions& options, store::MotionModel model, const SessionOptions& session,
           show::Sink& sink)
      : sink_(sink),
        shown_(options.file, std::move(model), session, sink.renderer()),
        has_moving_quality_(options.samples == 0 && session.is_plain_while_moving)
  {
    set_title();
  }

  bool is_over() const override { return shown_.session().state().is_done; }

  show::RoundTime round_time() const override
  {
    return {sink_.is_hidden() || shown_.session().is_idle() ? paused_wait_s : least_frame_s};
  }

  void take(const view::InputEvent& event) override
  {
    shown_.session().take(event);
    const std::vector<std::string>& dropped = sink_.window()->dropped_files();
    // Only the first of several dropped files is opened.
    if (event.kind == view::InputKind::drop && !dropped.empty() && shown_.open(dropped.front()))
      set_title();
  }

  void advance(double elapsed_s) override
  {
    Session& session = shown_.session();
    session.resize(sink_.renderer().width(), sink_.renderer().height());
    session.advance(elapsed_s);
    if (session.consume_screenshot_request()) save_picture();
    if (session.consume_full_screen_request()) sink_.window()->toggle_full_screen();
  }

  void draw() override
  {
    const Session& session = shown_.session();
    if (has_moving_quality_) sink_.renderer().set_samples(session.is_plain() ? 1 : samples_at_rest);
    if (session.has_same_picture() && sink_.show_again(&session.overlay())) return;
    sink_.show({session.scene(), session.shots(), &session.overlay()});
  }

 private:
  void set_title()
  {
    sink_.window()->set_title((shown_.title().empty() ? shown_.file() : shown_.title()) + " - vrda-player");
  }

  void save_picture()
  {
    Session& session = shown_.session();
    if (has_moving_quality_) sink_.renderer().set_samples(samples_at_rest);
    std::string name;
    const auto refused = show::catch_input_error([&] {
      const view::Image& image = session.draw_screenshot(sink_.renderer());
      const double flexion_rad = session.pose().attitude.flexion_rad;
      name = show::write_with_free_name(
          [&](std::size_t number) { return picture_name(shown_.file(), flexion_rad, number); },
          [&](const std::string& free) { view::write_png(image, free); });
    });
    session.show_message(refused ? refused->what() : "image written: " + name);
  }

  show::Sink& sink_;
  ShownModel shown_;
  bool has_moving_quality_;  ///< one sample per pixel while something moves, else samples_at_rest
};

}  // namespace

void show_in_window(const ShowOptions& options, store::MotionModel model, const std::string& set)
{
  require_window_options(options);
  SessionOptions chosen = session_options(options, model, set);
  show::Sink sink(window_options(options, chosen));
  chosen.is_plain_while_moving = sink.window()->is_software_rendered();
  chosen.scale = std::clamp(sink.window()->content_scale(), 1.0, 4.0);
  ShowMode mode(options, std::move(model), chosen, sink);
  show::StopSignals stop;
  show::run_loop(mode, sink, stop);
}

}  // namespace vrda::show
