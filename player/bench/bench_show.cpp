#include "bench/bench_show.hpp"

#include <algorithm>
#include <cmath>

#include "bench/controls.hpp"
#include "core/error.hpp"
#include "view/image.hpp"

namespace vrda::bench {
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
  return {frame.X_tracker_reference, frame.X_tracker_moving,
          frame.X_tracker_reference * frame.pose.X_world_reference.inverse()};
}

}  // namespace

BenchView::BenchView(const store::MotionModel& model, const store::Motion& motion,
                     const bench::BenchFile& bench, const bench::Calibration& calibration,
                     const view::AppearanceOptions& look)
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
  shown_layers_ = bench_layers(look.layers);
  if (shown_layers_ != view::LayerSet()) layers_.emplace(model, scene_);
}

void BenchView::load_into(view::Renderer& renderer) const
{
  renderer.load(scene_);
  renderer.load(panel_.font());
  renderer.load(plan_.warp);
}

void BenchView::place(const BenchFrame& frame, const bench::Calibration& calibration)
{
  const view::JointFrames frames = joint_frames(frame);
  vrda::view::place(scene_, frames);
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

int video_rate(const bench::DisplaySettings& display, int every)
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
    const bench::DisplaySettings& display = setup.bench.display;
    sink.record_video({options.video, display.width, display.height, video_rate(display, options.every)});
  }
  return sink;
}

/// Restores the eyes if keys or the potentiometer made them unusable.
void restore_unusable(BenchState& state, const view::EyePair& before, PanelContent& panel)
{
  bench::Calibration& calibration = state.values().calibration;
  if (calibration.eyes == before) return;
  const std::optional<InputError::Facts> facts =
      view::usability_error(calibration.eyes, state.bench().path);
  if (!facts) return;
  calibration.eyes = before;
  state.select(state.selected());  // keys and potentiometer continue from the restored value
  panel.message = facts->found + ": restored";
}

}  // namespace

BenchRequests apply_input(BenchState& state, PanelContent& panel, std::span<const view::KeyPress> keys,
                          std::span<const bench::Sample> samples)
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
  }
  for (const bench::Sample& sample : samples) state.take(sample);
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
  panel_.has_panel = options.has_panel.value_or(!options.is_headless);
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
  panel_.doubt = frame.is_pose_held ? view::DoubtText{}
                                    : view::doubt_text(frame.pose, doubts_.at(frame.pose), "");
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

void BenchOutput::finish()
{
  sink_.finish();
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

}  // namespace vrda::bench
