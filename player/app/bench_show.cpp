#include "app/bench_show.hpp"

#include <cmath>
#include <filesystem>

#include "bench/controls.hpp"
#include "core/error.hpp"
#include "render/png_file.hpp"

namespace vrda {
namespace {

constexpr double message_s = 5.0;

std::string numbered(const std::string& stem, std::uint64_t number)
{
  constexpr std::size_t width = 6;
  std::string digits = std::to_string(number);
  if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
  return stem + digits + ".png";
}

std::unique_ptr<BenchScreen> open_screen(const BenchOptions& options, const BenchSetup& setup)
{
  if (options.is_headless) return open_bench_memory(setup.bench, options.samples);
  return open_bench_window(setup.bench, setup.bench.title + " - vrda-player", options.samples);
}

/// Where keys or the potentiometer left eyes that cannot be drawn for.
void put_back_unusable(BenchState& state, const EyePair& before, PanelContent& panel)
{
  Calibration& calibration = state.values().calibration;
  if (calibration.eyes == before) return;
  try {
    require_usable(calibration.eyes, state.bench().path);
  } catch (const InputError& error) {
    calibration.eyes = before;
    state.select(state.selected());  // keys and potentiometer go on from there
    panel.message = error.facts().found + ": put back";
  }
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
  put_back_unusable(state, before, panel);
  return wishes;
}

BenchShow::BenchShow(const BenchOptions& options, const BenchSetup& setup)
    : options_(options),
      view_(setup.model, setup.bench, setup.calibration, options.look),
      screen_(open_screen(options, setup)),
      watch_(setup.bench)
{
  view_.load_into(screen_->renderer());
  panel_.has_panel = options.has_panel.value_or(!options.is_headless);
  panel_.has_board = setup.bench.board.has_value();
  if (!options.pictures.empty()) std::filesystem::create_directories(options.pictures);
  if (!options.video.empty()) {
    const int frames_per_s = static_cast<int>(std::lround(setup.bench.display.refresh_hz / options.every));
    video_.emplace(VideoOptions{options.video, setup.bench.display.width, setup.bench.display.height,
                                std::max(1, frames_per_s)});
  }
}

bool BenchShow::is_written(std::uint64_t number) const
{
  const bool has_files = !options_.pictures.empty() || video_.has_value();
  return has_files && number % static_cast<std::uint64_t>(options_.every) == 0;
}

void BenchShow::show(BenchState& state, const BenchFrame& frame, std::uint64_t number)
{
  if (view_.take(state.values().calibration.eyes)) screen_->renderer().load(view_.warp());
  view_.place(frame, state.values().calibration);
  panel_.trouble = watch_.trouble(*screen_);
  const Overlay& words = view_.words(state, frame, panel_);
  if (!is_written(number)) {
    screen_->show(view_.scene(), view_.shots(), words);
    return;
  }
  const Image& picture = screen_->picture(view_.scene(), view_.shots(), words);
  if (!options_.pictures.empty()) write_png(picture, options_.pictures + "/" + numbered("picture_", number));
  if (video_) video_->add(picture);
}

void BenchShow::save(BenchState& state, const BenchFrame& frame)
{
  std::uint64_t number = 1;
  while (std::filesystem::exists(numbered("bench_", number))) ++number;
  const std::string name = numbered("bench_", number);
  try {
    write_png(screen_->picture(view_.scene(), view_.shots(), view_.words(state, frame, panel_)), name);
    panel_.message = "picture written: " + name;
  } catch (const InputError& error) {
    panel_.message = error.what();  // a full disk ends no session
  }
}

void BenchShow::finish()
{
  if (video_) video_->finish();
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
