#include "bench/bench_show.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "bench/controls.hpp"
#include "core/error.hpp"
#include "render/image.hpp"

namespace vrda {
namespace {

/// The warp does not depend on the eye's position.
bool has_same_warp(const Eye& a, const Eye& b)
{
  return a.visible == b.visible && a.distortion == b.distortion;
}

}  // namespace

BenchView::BenchView(const MotionModel& model, const BenchFile& bench, const Calibration& calibration,
                     const LookOptions& look)
    : file_(bench.path),
      display_(bench.display),
      scene_(scene_of(model.reference, model.moving, Eigen::Vector3d::Zero())),
      eyes_(calibration.eyes),
      plan_(stereo_plan(calibration.eyes, bench.display.width, bench.display.height, bench.path)),
      panel_(bench)
{
  scene_.background = background_of(Backdrop::black);  // black is transparent on the display
  dress(scene_, look);
}

void BenchView::load_into(Renderer& renderer) const
{
  renderer.load(scene_);
  renderer.load(panel_.font());
  renderer.load(plan_.warp);
}

void BenchView::place(const BenchFrame& frame, const Calibration& calibration)
{
  JointFrames frames;
  frames.X_world_reference = frame.X_tracker_reference;
  frames.X_world_delta = frame.X_tracker_moving;
  vrda::place(scene_, frames);
  shots_ = shots_of(plan_, calibration.eyes, frame.X_tracker_eyes, scene_);
}

bool BenchView::take(const EyePair& eyes)
{
  if (eyes_ == eyes) return false;
  const bool has_new_warp = !has_same_warp(eyes_.left, eyes.left) || !has_same_warp(eyes_.right, eyes.right);
  plan_ = stereo_plan(eyes, display_.width, display_.height, file_);
  eyes_ = eyes;
  return has_new_warp;
}

namespace {

constexpr double message_s = 5.0;
constexpr std::size_t digits_of_pictures = 6;

Sink sink_of(const BenchOptions& options, const BenchSetup& setup)
{
  Sink sink = options.is_headless
                  ? bench_memory(setup.bench, options.samples)
                  : bench_window(setup.bench, setup.bench.title + " - vrda-player", options.samples);
  if (!options.pictures.empty()) sink.keep_pictures(options.pictures, "--pictures");
  if (!options.video.empty()) {
    const DisplaySettings& display = setup.bench.display;
    const int frames_per_s = std::max(1, static_cast<int>(std::lround(display.refresh_hz / options.every)));
    sink.keep_film({options.video, display.width, display.height, frames_per_s});
  }
  return sink;
}

/// Restores the eyes if keys or the potentiometer made them unusable.
void restore_unusable(BenchState& state, const EyePair& before, PanelContent& panel)
{
  Calibration& calibration = state.values().calibration;
  if (calibration.eyes == before) return;
  const std::optional<InputError::Facts> facts = unusable(calibration.eyes, state.bench().path);
  if (!facts) return;
  calibration.eyes = before;
  state.select(state.selected());  // keys and potentiometer continue from the restored value
  panel.message = facts->found + ": restored";
}

}  // namespace

BenchWishes take(BenchState& state, PanelContent& panel, std::span<const KeyPress> keys,
                 std::span<const Sample> samples)
{
  BenchWishes wishes;
  const EyePair before = state.values().calibration.eyes;
  for (const KeyPress& press : keys) {
    const BenchRequest request = press_key(state, press);
    wishes.quits = wishes.quits || request == BenchRequest::quit;
    wishes.zeroes_stage = wishes.zeroes_stage || request == BenchRequest::zero_stage;
    wishes.writes_calibration = wishes.writes_calibration || request == BenchRequest::write_calibration;
    wishes.takes_picture = wishes.takes_picture || request == BenchRequest::screenshot;
    if (request == BenchRequest::show_panel) panel.has_panel = !panel.has_panel;
    if (request == BenchRequest::show_help) panel.has_help = !panel.has_help;
  }
  for (const Sample& sample : samples) state.take(sample);
  restore_unusable(state, before, panel);
  return wishes;
}

BenchShow::BenchShow(const BenchOptions& options, const BenchSetup& setup)
    : options_(options),
      view_(setup.model, setup.bench, setup.calibration, options.look),
      sink_(sink_of(options, setup)),
      watch_(setup.bench)
{
  view_.load_into(sink_.renderer());
  panel_.has_panel = options.has_panel.value_or(!options.is_headless);
  panel_.has_board = setup.bench.board.has_value();
}

Frame BenchShow::drawn(BenchState& state, const BenchFrame& frame)
{
  return {view_.scene(), view_.shots(), &view_.words(state, frame, panel_)};
}

void BenchShow::show(BenchState& state, const BenchFrame& frame, std::uint64_t number)
{
  if (view_.take(state.values().calibration.eyes)) sink_.renderer().load(view_.warp());
  view_.place(frame, state.values().calibration);
  panel_.trouble = watch_.trouble(sink_);
  if (sink_.keeps() && number % static_cast<std::uint64_t>(options_.every) == 0) {
    sink_.keep(drawn(state, frame), numbered("picture_", number, digits_of_pictures) + ".png");
  } else {
    sink_.show(drawn(state, frame));
  }
}

void BenchShow::save(BenchState& state, const BenchFrame& frame)
{
  std::string name;
  for (std::size_t number = 1; name.empty() || std::filesystem::exists(name); ++number)
    name = numbered("bench_", number, digits_of_pictures) + ".png";
  const Frame last = drawn(state, frame);
  const auto refused =
      attempt([&] { write_png(sink_.renderer().draw(last.scene, last.shots, last.overlay), name); });
  panel_.message = refused ? refused->what() : "screenshot written: " + name;
}

void BenchShow::finish()
{
  sink_.finish();
}

void BenchShow::tell(const std::string& message, double now_s)
{
  panel_.message = message;
  message_until_s_ = now_s + message_s;
}

void BenchShow::forget_message(double now_s)
{
  if (message_until_s_ == 0.0 && !panel_.message.empty()) message_until_s_ = now_s + message_s;
  if (message_until_s_ > 0.0 && now_s > message_until_s_) {
    panel_.message.clear();
    message_until_s_ = 0.0;
  }
}

}  // namespace vrda
