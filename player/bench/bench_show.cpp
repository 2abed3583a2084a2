#include "bench/bench_show.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/body_tracker.hpp"
#include "core/text.hpp"
#include "show/session.hpp"
#include "view/image.hpp"
#include "view/window.hpp"

namespace vrda::bench {
namespace {

constexpr int least_width_px = 320, least_height_px = 400;
using view::amber, view::faint, view::green, view::ink, view::margin_px;

std::string tenths(double value)
{
  return short_decimal(value, 1);
}

const char* why(ToolVisibility state)
{
  return std::array{"seen", "hidden", "silent", "invalid pose"}.at(static_cast<std::size_t>(state));
}

const char* name_of(LinkState state)
{
  return std::array{"closed", "opening", "up"}.at(static_cast<std::size_t>(state));
}

/// "internal rotation 9.2 deg, anterior 3.1 mm", or external and posterior.
std::string joint_text(const ClinicalCoordinates& joint)
{
  const auto& words = joint_kind("knee").words;
  return words[2].of(joint.internal_rotation_rad) + std::string(" ") +
         tenths(std::abs(deg_from_rad(joint.internal_rotation_rad))) + " deg, " +
         words[3].of(joint.anterior_mm) + " " + tenths(std::abs(joint.anterior_mm)) + " mm";
}

}  // namespace

std::string next_step_text(const BenchFrame& frame, const PanelContent& content)
{
  if (content.tracker.link != LinkState::up) return "next: 1 start the tracker";
  if (frame.stage.is_used && !stage_status_text(frame).empty())
    return "next: 2 zero the stage: move it to its stop, press Z";
  return content.is_calibrated ? "" : "next: 3 calibrate: vrda-player calibrate all";
}

std::optional<view::Viewport> operator_area(const DisplaySettings& display)
{
  const view::Viewport &l = display.windows.left, &r = display.windows.right;
  const int left = std::min(l.x, r.x), right = std::max(l.x + l.width, r.x + r.width);
  const int top = std::min(l.y, r.y), bottom = std::max(l.y + l.height, r.y + r.height);
  const std::array<view::Viewport, 4> strips{{{0, 0, left, display.height},
                                              {right, 0, display.width - right, display.height},
                                              {0, 0, display.width, top},
                                              {0, bottom, display.width, display.height - bottom}}};
  const view::Viewport* best = nullptr;
  for (const view::Viewport& strip : strips) {
    if (strip.width < least_width_px || strip.height < least_height_px) continue;
    if (best == nullptr || strip.width * strip.height > best->width * best->height) best = &strip;
  }
  return best == nullptr ? std::nullopt : std::optional(*best);
}

std::string device_text(const std::string& name, const DeviceReport& report)
{
  std::string text = name + " " + report.peer + ": " + name_of(report.link);
  if (report.link == LinkState::up) text += ", " + tenths(report.rate_hz) + " a second";
  if (!report.error_message.empty()) text += ", " + report.error_message;
  return text;
}

std::string input_status_text(const std::string& name, const InputStatus& mark)
{
  if (!mark.is_used || mark.is_live) return {};
  if (!mark.was_seen) return name + " not seen yet";
  return name + " " + why(mark.state) + " for " + tenths(mark.age_s) + " s";
}

std::string stage_status_text(const BenchFrame& frame)
{
  const InputStatus& mark = frame.stage;
  if (!mark.is_used) return {};
  if (mark.state != ToolVisibility::seen) return input_status_text("stage", mark);
  if (!frame.is_stage_zeroed) return "stage not zeroed: press Z at its stop";
  return frame.stage_has_lost_counts ? "stage has lost counts: press Z at its stop" : "";
}

std::vector<std::string> wrapped(const view::OverlayText& text, const std::string& words, float width_px)
{
  std::vector<std::string> lines;
  for (const std::string& paragraph : view::split(words, '\n')) {
    lines.emplace_back();
    for (const std::string& word : view::split(paragraph, ' ')) {
      const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
      if (!lines.back().empty() && text.width_px(longer) > width_px)
        lines.push_back(word);
      else
        lines.back() = longer;
    }
  }
  return lines;
}

BenchPanel::BenchPanel(const BenchFile& bench)
    : text_(view::panel_text_px),
      display_(bench.display),
      reflector_(bench.display.windows, bench.display.reflection)
{
}

const view::Overlay& BenchPanel::drawn(const BenchState& state, const BenchFrame& frame,
                                       const PanelContent& content)
{
  view::clear_overlay(overlay_, display_.width, display_.height);
  const view::EyePair& eyes = state.values().calibration.eyes;
  const std::optional<view::Viewport> area = operator_area(display_);
  if (content.has_panel || content.has_help) {
    if (area) {
      text_.add_area(overlay_, view::overlay_box(*area), view::paper);
      add_panel(*area, state, frame, content);
    } else {
      add_panel(eyes.left.visible, state, frame, content);
    }
  }
  add_marks(eyes.left.visible, frame, content);
  add_marks(eyes.right.visible, frame, content);
  view::finish_overlay(overlay_);
  reflector_.reflect(overlay_);
  return overlay_;
}

void BenchPanel::add_marks(const view::Viewport& visible, const BenchFrame& frame,
                           const PanelContent& content)
{
  float bottom_px = static_cast<float>(visible.y + visible.height) - margin_px - text_.line_px();
  const auto add = [&](const std::string& words) {
    if (words.empty()) return;
    const std::string fitted = text_.fitted(words, static_cast<float>(visible.width) - 2.0F * margin_px);
    const float left_px =
        static_cast<float>(visible.x) + 0.5F * (static_cast<float>(visible.width) - text_.width_px(fitted));
    text_.add_text(overlay_, left_px, bottom_px, fitted, amber);
    bottom_px -= text_.line_px();
  };
  for (const BodyRole role : body_roles) add(input_status_text(name_of(role), frame.bodies[role]));
  add(leg_check_text(frame.leg));
  if (frame.is_pose_held) add("the model has no pose here: the last one is drawn");
  if (frame.is_moved_aside) add("moved off the leg by the pointer: R puts it back");
  add(stage_status_text(frame));
  add(input_status_text("potentiometer", frame.potentiometer));
  add(content.doubt.data());
  add(content.error_message);
}

void BenchPanel::add_panel(const view::Viewport& area, const BenchState& state, const BenchFrame& frame,
                           const PanelContent& content)
{
  float top_px = static_cast<float>(area.y) + margin_px;
  const float room_px = static_cast<float>(area.width) - 2.0F * margin_px;
  // In as many rows as its words need.
  const auto line = [&](const std::string& words, const view::VertexColour& colour = ink) {
    for (const std::string& row : wrapped(text_, words, room_px)) {
      text_.add_text(overlay_, static_cast<float>(area.x) + margin_px, top_px, text_.fitted(row, room_px),
                     colour);
      top_px += text_.line_px();
    }
  };
  if (content.has_help) {
    for (const view::HelpLine& help : bench_key_lines())
      line(std::string(help.keys) + ": " + std::string(help.description));
    return;
  }
  line(state.bench().title, faint);
  if (const std::string next = next_step_text(frame, content); !next.empty()) line(next, green);
  if (!content.error_message.empty()) line(content.error_message, amber);
  line("> " + parameter_text(state, state.selected()), green);
  const Attitude& at = frame.pose.attitude;
  line("flexion " + tenths(deg_from_rad(at.flexion_rad)) + ", varus " + tenths(deg_from_rad(at.varus_rad)) +
           " deg" + (frame.leg.is_wrong() ? " (nearest of the model)" : ""),
       frame.leg.is_wrong() ? amber : ink);
  if (frame.leg.is_wrong()) line(leg_check_text(frame.leg), amber);
  if (frame.pose.status == store::PoseStatus::solved) line(joint_text(state.clinical(frame.pose)));
  if (frame.stage.is_used)
    line("stage " + tenths(frame.stage_mm) + " mm", stage_status_text(frame).empty() ? ink : amber);
  line(std::string("filter ") + (state.is_filtered() ? "on" : "off") + ", prediction " +
       tenths(state.values().prediction_ms) + " ms");
  line(device_text("tracker", content.tracker), content.tracker.link == LinkState::up ? ink : amber);
  for (const std::string& note : content.tracker.notes) line(note, amber);
  for (const BodyRole role : body_roles) {
    const PoseFit* const fit = state.fit(role);
    if (fit != nullptr)
      line(std::string(name_of(role)) + ": " + fit_text(*fit),
           fit->status == FitStatus::fitted ? ink : amber);
  }
  if (content.has_board)
    line(device_text("board", content.board), content.board.link == LinkState::up ? ink : amber);
  if (!content.message.empty()) line(content.message, green);
  if (content.timing == nullptr) return;
  const BenchTiming& t = *content.timing;
  const double interval_ms = t.interval.mean_ms();
  line(tenths(interval_ms > 0.0 ? 1000.0 / interval_ms : 0.0) + " frames a second", faint);
  line("latency: " + tenths(t.latency.percentile_ms(0.5)) + " ms median, " +
           tenths(t.latency.percentile_ms(0.99)) + " ms 99th percentile",
       faint);
  line(std::to_string(t.n_missed) + " samples missed, " + std::to_string(t.n_late) + " late, " +
           std::to_string(t.n_lost) + " lost",
       faint);
  add_histogram(area, top_px + margin_px, t.latency);
}

void BenchPanel::add_histogram(const view::Viewport& area, float top_px, const TimeHistogram& times)
{
  constexpr std::size_t n_bars = 50, bins_a_bar = 4;  // 1 ms each
  constexpr float height_px = 90.0F;
  std::array<std::uint64_t, n_bars> bars{};
  for (std::size_t k = 0; k < TimeHistogram::n_bins; ++k)
    bars[std::min(k / bins_a_bar, n_bars - 1)] += times.bins()[k];
  const std::uint64_t most = std::max<std::uint64_t>(1, *std::ranges::max_element(bars));
  const float left_px = static_cast<float>(area.x) + margin_px;
  const float bar_px = (static_cast<float>(area.width) - 2.0F * margin_px) / static_cast<float>(n_bars);
  const float base_px = top_px + height_px;
  for (std::size_t k = 0; k < n_bars; ++k) {
    const float share = static_cast<float>(bars[k]) / static_cast<float>(most);
    const float x = left_px + bar_px * static_cast<float>(k);
    // A non-empty bin is at least 1 px high.
    const float tall_px = bars[k] == 0 ? 0.0F : std::max(1.0F, height_px * share);
    text_.add_area(overlay_, {x, base_px - tall_px, x + bar_px - 1.0F, base_px}, k < 33 ? green : amber);
  }
  text_.add_area(overlay_, {left_px, base_px, left_px + bar_px * static_cast<float>(n_bars), base_px + 1.0F},
                 faint);
  for (const int ms : {0, 10, 20, 30, 40, 50}) {
    const std::string words = std::to_string(ms);
    const float x = left_px + bar_px * static_cast<float>(ms);
    text_.add_text(overlay_,
                   std::min(x, left_px + bar_px * static_cast<float>(n_bars) - text_.width_px(words)),
                   base_px + 2.0F, words, faint);
  }
  text_.add_text(overlay_, left_px, base_px + 2.0F + text_.line_px(), "latency, ms", faint);
}

namespace {

/// The warp does not depend on the eye's position.
bool has_same_warp(const view::Eye& a, const view::Eye& b)
{
  return a.visible == b.visible && a.distortion == b.distortion;
}

/// The layers that a bench draws; throws InputError for labels, whose text would differ in depth from the
/// joint.
view::LayerSet bench_layers(const std::string& text)
{
  const view::LayerSet layers = view::parsed_layers(text);
  if (layers.has(view::Layer::labels))
    throw InputError({"--layers", "", "labels", "layers of the bench, which draws no labels"});
  return layers;
}

view::JointFrames joint_frames(const BenchFrame& frame)
{
  return view::with_followers({frame.X_tracker_reference, frame.X_tracker_moving,
                               frame.X_tracker_reference * frame.pose.X_world_reference.inverse()},
                              frame.pose);
}

}  // namespace

BenchView::BenchView(const store::MotionModel& model, const store::Motion& motion, const BenchFile& bench,
                     const Calibration& calibration, const view::AppearanceOptions& look)
    : motion_(motion),
      file_(bench.path),
      display_(bench.display),
      scene_(view::scene_of(model, Eigen::Vector3d::Zero())),
      eyes_(calibration.eyes),
      plan_(view::stereo_plan(calibration.eyes, bench.display.width, bench.display.height, bench.path,
                              bench.display.reflection)),
      panel_(bench)
{
  // Leaves the time of a frame to both eyes.
  scene_.occlusion_radius_mm = 0.0;
  scene_.has_vertex_lighting = true;
  scene_.background = view::background_of(view::Backdrop::black);  // black is transparent on the display
  view::apply_appearance(scene_, look);
  for (const view::Drawable& drawable : scene_.drawables) materials_.push_back(drawable.material);
  shown_bodies_ = view::shown_drawables(scene_);
  shown_layers_ = bench_layers(look.layers);
  if (shown_layers_ != view::LayerSet()) layers_.emplace(model, scene_);
}

void BenchView::load_into(view::Renderer& renderer) const
{
  renderer.load(scene_);
  renderer.load(panel_.font());
  renderer.load(plan_.warp);
}

void BenchView::place(const BenchFrame& frame, const Calibration& calibration)
{
  const view::JointFrames frames = joint_frames(frame);
  vrda::view::place(scene_, frames);
  view::show_bodies(scene_, shown_bodies_, BodyIndex::reference, true, frames);
  for (std::size_t k = 0; k < materials_.size(); ++k) {
    Material& material = scene_.drawables[k].material;
    material = materials_[k];
    if (frame.leg.is_wrong()) material.colour = view::linear_from_srgb(view::amber);
  }
  if (layers_) layers_->update(scene_, motion_, {frame.pose, frames, shown_layers_});
  shots_ = view::shots_of(plan_, calibration.eyes, frame.X_tracker_eyes, scene_);
}

bool BenchView::take(const view::EyePair& eyes)
{
  if (eyes_ == eyes) return false;
  const bool has_new_warp = !has_same_warp(eyes_.left, eyes.left) || !has_same_warp(eyes_.right, eyes.right);
  plan_ = view::stereo_plan(eyes, display_.width, display_.height, file_, display_.reflection);
  eyes_ = eyes;
  return has_new_warp;
}

namespace {

constexpr double message_s = 5.0;
constexpr std::size_t digits_of_pictures = 6;

int video_rate(const DisplaySettings& display, int every)
{
  return std::max(1, static_cast<int>(std::lround(display.refresh_hz / every)));
}

show::Sink sink_of(const BenchOptions& options, const BenchSetup& setup)
{
  show::Sink sink = options.is_headless
                        ? bench_memory(setup.bench, options.samples)
                        : bench_window(setup.bench, setup.bench.title + " - vrda-player", options.samples);
  if (!options.pictures.empty()) sink.record_images(options.pictures, "--pictures");
  if (!options.video.empty()) {
    const DisplaySettings& display = setup.bench.display;
    sink.record_video({options.video, display.width, display.height, video_rate(display, options.every)});
  }
  return sink;
}

/// Restores the eyes if keys or the potentiometer made them unusable.
void restore_unusable(BenchState& state, const view::EyePair& before, PanelContent& panel)
{
  Calibration& calibration = state.values().calibration;
  if (calibration.eyes == before) return;
  const std::optional<InputError::Facts> facts = view::usability_error(calibration.eyes, state.bench().path);
  if (!facts) return;
  calibration.eyes = before;
  state.select(state.selected());  // keys and potentiometer continue from the restored value
  panel.message = facts->found + ": restored";
}

}  // namespace

BenchRequests apply_input(BenchState& state, PanelContent& panel, std::span<const view::KeyPress> keys,
                          std::span<const Sample> samples)
{
  BenchRequests requests;
  const view::EyePair before = state.values().calibration.eyes;
  for (const view::KeyPress& press : keys) {
    const BenchRequest request = apply_key(state, press);
    requests.quit = requests.quit || request == BenchRequest::quit;
    requests.zero_stage = requests.zero_stage || request == BenchRequest::zero_stage;
    requests.write_calibration = requests.write_calibration || request == BenchRequest::write_calibration;
    requests.take_screenshot = requests.take_screenshot || request == BenchRequest::screenshot;
    if (request == BenchRequest::show_panel) panel.has_panel = !panel.has_panel;
    if (request == BenchRequest::show_help) panel.has_help = !panel.has_help;
    if (request == BenchRequest::close_help) panel.has_help = false;
  }
  for (const Sample& sample : samples) state.take(sample);
  restore_unusable(state, before, panel);
  return requests;
}

BenchOutput::BenchOutput(const BenchOptions& options, const BenchSetup& setup)
    : options_(options),
      view_(setup.model, setup.motion, setup.bench, setup.calibration, options.look),
      sink_(sink_of(options, setup)),
      video_per_s_(video_rate(setup.bench.display, options.every)),
      watch_(setup.bench),
      doubts_(setup.model)
{
  view_.load_into(sink_.renderer());
  // Unasked, it does not cover what the eyes see.
  panel_.has_panel =
      options.has_panel.value_or(!options.is_headless && operator_area(setup.bench.display).has_value());
  panel_.is_calibrated = !setup.facts.calibration_text.empty();
  panel_.has_board = setup.bench.board.has_value();
}

show::Frame BenchOutput::drawn(BenchState& state, const BenchFrame& frame)
{
  return {view_.scene(), view_.shots(), &view_.overlay(state, frame, panel_)};
}

std::int64_t BenchOutput::due_video_frames(double at_s)
{
  if (options_.video.empty()) return 0;
  if (!video_start_s_) video_start_s_ = at_s;
  constexpr double rounding = 1e-6;  // of a frame
  const double frames = (at_s - *video_start_s_) * video_per_s_;
  const std::int64_t n_due = static_cast<std::int64_t>(std::floor(frames + rounding)) + 1 - n_video_;
  n_video_ += std::max<std::int64_t>(0, n_due);
  return std::max<std::int64_t>(0, n_due);
}

void BenchOutput::show(BenchState& state, const BenchFrame& frame, std::uint64_t number, double at_s)
{
  if (view_.take(state.values().calibration.eyes)) sink_.renderer().load(view_.warp());
  view_.place(frame, state.values().calibration);
  panel_.error_message = watch_.error_message(sink_);
  panel_.doubt =
      frame.is_pose_held ? view::DoubtText{} : view::doubt_text(frame.pose, doubts_.at(frame.pose), "");
  const bool is_picture =
      !options_.pictures.empty() && number % static_cast<std::uint64_t>(options_.every) == 0;
  const std::int64_t n_video = due_video_frames(at_s);
  if (is_picture || n_video > 0) {
    sink_.record(drawn(state, frame),
                 is_picture ? show::padded_name("picture_", number, digits_of_pictures) + ".png" : "",
                 n_video);
  } else {
    sink_.show(drawn(state, frame));
  }
}

void BenchOutput::save_screenshot(BenchState& state, const BenchFrame& frame)
{
  std::string name;
  const show::Frame last = drawn(state, frame);
  const auto refused = show::catch_input_error([&] {
    const view::Image& image = sink_.renderer().draw(last.scene, last.shots, last.overlay);
    name = show::write_with_free_name(
        [](std::size_t number) { return show::padded_name("bench_", number, digits_of_pictures) + ".png"; },
        [&](const std::string& free) { view::write_png(image, free); });
  });
  panel_.message = refused ? refused->what() : "screenshot written: " + name;
}

void BenchOutput::show_message(const std::string& message, double now_s)
{
  panel_.message = message;
  message_until_s_ = now_s + message_s;
}

void BenchOutput::expire_message(double now_s)
{
  if (message_until_s_ == 0.0 && !panel_.message.empty()) message_until_s_ = now_s + message_s;
  if (message_until_s_ > 0.0 && now_s > message_until_s_) {
    panel_.message.clear();
    message_until_s_ = 0.0;
  }
}

// The window.

namespace {

/// Error of surfaces by levels of detail (view::RenderOptions), below the resolution of the eye.
constexpr double coarseness_px = 0.5;

std::string pair_text(int a, const char* between, int b)
{
  return std::to_string(a) + between + std::to_string(b);
}

const view::Monitor& monitor_named(const BenchFile& bench, const std::string& name,
                                   std::span<const view::Monitor> monitors)
{
  const auto found = std::ranges::find(monitors, name, &view::Monitor::name);
  if (found != monitors.end()) return *found;
  std::string names;
  for (const view::Monitor& monitor : monitors) names += (names.empty() ? "" : ", ") + monitor.name;
  throw InputError({bench.path, "display.outputs", "\"" + name + "\"",
                    names.empty() ? "a connected monitor; no monitor is connected" : "one of " + names});
}

/// The part of the area that monitors display, at most 1; of monitors that show the same the first counts.
double displayed_share(const view::WindowGeometry& area, std::span<const view::Monitor> monitors)
{
  double shown = 0.0;
  for (std::size_t k = 0; k < monitors.size(); ++k) {
    const view::WindowGeometry& m = monitors[k].geometry;
    const bool is_copy = std::ranges::any_of(monitors.first(k), [&](const view::Monitor& other) {
      return other.geometry.x == m.x && other.geometry.y == m.y;
    });
    const int width = std::min(area.x + area.width, m.x + m.width) - std::max(area.x, m.x);
    const int height = std::min(area.y + area.height, m.y + m.height) - std::max(area.y, m.y);
    if (!is_copy && width > 0 && height > 0) shown += static_cast<double>(width) * height;
  }
  return std::min(1.0, shown / (static_cast<double>(area.width) * area.height));
}

std::optional<InputError::Facts> hidden_part(const BenchFile& bench, const view::WindowGeometry& place,
                                             std::span<const view::Monitor> monitors)
{
  if (monitors.empty() || place.width <= 0 || place.height <= 0) return std::nullopt;
  const double shown = displayed_share(place, monitors);
  if (shown >= 1.0) return std::nullopt;
  const std::string where =
      " (" + pair_text(place.width, " x ", place.height) + " at " + pair_text(place.x, ", ", place.y) + ")";
  return InputError::Facts{
      bench.path, "display.at",
      (shown == 0.0 ? "a window off every screen" : "a window partly off the screens") + where,
      "a window within the screens"};
}

}  // namespace

std::optional<std::array<int, 2>> window_position(const BenchFile& bench,
                                                  std::span<const view::Monitor> monitors)
{
  const DisplaySettings& display = bench.display;
  if (display.outputs.empty()) return display.at;
  const view::WindowGeometry& left = monitor_named(bench, display.outputs.front(), monitors).geometry;
  if (display.outputs.size() == 2) {
    const view::WindowGeometry& right = monitor_named(bench, display.outputs.back(), monitors).geometry;
    const int wanted_x = left.x + display.windows.right.x;
    if (right.x != wanted_x || right.y != left.y) {
      throw InputError({bench.path, "display.outputs",
                        "\"" + display.outputs.back() + "\" at " + pair_text(right.x, ", ", right.y),
                        "the right eye's monitor at " + pair_text(wanted_x, ", ", left.y) +
                            ": arrange the desktop so, or exchange the names"});
    }
  }
  return std::array{left.x, left.y};
}

std::optional<InputError::Facts> window_mismatch(const BenchFile& bench,
                                                 const std::optional<view::WindowGeometry>& place,
                                                 std::span<const view::Monitor> monitors)
{
  if (!place) return std::nullopt;
  const DisplaySettings& display = bench.display;
  if (place->width != display.width || place->height != display.height) {
    return InputError::Facts{bench.path, "display.width, display.height",
                             "a frame buffer of " + pair_text(place->width, " x ", place->height),
                             pair_text(display.width, " x ", display.height)};
  }
  std::optional<std::array<int, 2>> wanted;
  // A monitor may be unplugged meanwhile.
  if (const auto refused = show::catch_input_error([&] { wanted = window_position(bench, monitors); }))
    return refused->facts();
  if (wanted && (place->x != (*wanted)[0] || place->y != (*wanted)[1])) {
    return InputError::Facts{bench.path, display.outputs.empty() ? "display.at" : "display.outputs",
                             "a window at " + pair_text(place->x, ", ", place->y),
                             pair_text((*wanted)[0], ", ", (*wanted)[1])};
  }
  return hidden_part(bench, *place, monitors);
}

const std::string& WindowCheck::error_message(const show::Sink& sink)
{
  constexpr int every = 30;  // frames: placing and querying a window takes time
  if (++n_calls_ % every != 0) return error_message_;
  const view::Window* const window = sink.window();
  if (window == nullptr) return error_message_;
  // Monitors are queried again when the window moved, and every 10 s at 60 frames a second.
  constexpr int every_check = 20;
  const view::WindowGeometry place = window->geometry();
  if (place != place_ || n_calls_ / every % every_check == 1) monitors_ = window->monitors();
  place_ = place;
  const std::optional<InputError::Facts> facts = window_mismatch(bench_, place, monitors_);
  if (!facts) {
    error_message_.clear();
    return error_message_;
  }
  error_message_ = "found " + facts->found + ", wanted " + facts->wanted;
  if (!std::exchange(was_warned_, true)) warning_ = InputError(*facts).what();
  return error_message_;
}

show::Sink bench_window(const BenchFile& bench, const std::string& title, int samples)
{
  view::WindowOptions options;
  options.width = bench.display.width;
  options.height = bench.display.height;
  options.title = title;
  options.samples = samples;
  options.is_vsynced = false;
  options.is_resizable = false;
  options.at = window_position(
      bench, bench.display.outputs.empty() ? std::vector<view::Monitor>{} : view::connected_monitors());
  options.alternative = "--headless";
  return show::Sink(options);
}

show::Sink bench_memory(const BenchFile& bench, int samples)
{
  return show::Sink(view::RenderOptions{bench.display.width, bench.display.height, samples, coarseness_px});
}

}  // namespace vrda::bench
