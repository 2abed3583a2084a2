// Frame rates of the player. usage: vrda_player_bench PLAYER NAME=MODEL.h5... [--benchmark_...]
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>

#include "processor_time.hpp"
#include "show/session.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "support/process.hpp"
#include "support/scratch.hpp"
#include "view/camera.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"
#include "view/window.hpp"

namespace vrda::benchmarks {
namespace {

constexpr int width = 640, height = 480;

/// A joint moved by a degree per frame, with the camera of `vrda-player show`.
class Film {
 public:
  explicit Film(const std::string& file)
      : model_(store::read_motion_model(file)),
        motion_(model_, store::set_names(model_).front()),
        scene_(view::scene_of(model_.reference, model_.moving, model_.rotation_centre_mm))
  {
    scene_.mode = view::DrawMode::smooth;
    place_at(motion_.first_flexion_rad());
    view::CameraFit fit(
        view::view_rotation(view::View::oblique, model_.side == "left" ? Side::left : Side::right));
    fit.include(view::points_within(scene_, view::joint_sphere(scene_)));
    camera_ = fit.camera();
  }

  /// The next frame; flexion restarts after the last.
  view::Shot next()
  {
    const double range_rad = motion_.last_flexion_rad() - motion_.first_flexion_rad();
    const int n_frames = std::max(1, static_cast<int>(deg_from_rad(range_rad)));
    place_at(motion_.first_flexion_rad() + range_rad * (n_shown_++ % n_frames) / n_frames);
    return {view::with_depth_range(camera_, scene_), {0, 0, width, height}};
  }

  const view::Scene& scene() const { return scene_; }
  double n_triangles() const
  {
    std::size_t n = 0;
    for (const view::Drawable& drawable : scene_.drawables) n += drawable.mesh.triangles.size() / 3;
    return static_cast<double>(n);
  }

 private:
  void place_at(double flexion_rad)
  {
    view::place(scene_, view::frames_of(motion_.at({flexion_rad, motion_.balanced_varus_rad(flexion_rad)})));
  }

  store::MotionModel model_;
  store::Motion motion_;
  view::Scene scene_;
  view::Camera camera_;
  int n_shown_ = 0;
};

/// Times `draw` per frame; the first, which compiles shaders, is excluded.
void count_frames(benchmark::State& state, Film& film, const std::function<void(const view::Shot&)>& draw)
{
  draw(film.next());
  const double before_s = process_s();
  for (auto _ : state) draw(film.next());
  const auto n_frames = static_cast<double>(state.iterations());
  state.counters["frames/s"] = benchmark::Counter(n_frames, benchmark::Counter::kIsRate);
  state.counters["processor ms"] = 1e3 * (process_s() - before_s) / n_frames;
  state.counters["triangles"] = film.n_triangles();
}

void off_screen(benchmark::State& state, const std::string& file, const view::RenderOptions& options,
                view::Backend backend)
{
  Film film(file);
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer(options, backend);
  renderer->load(film.scene());
  count_frames(state, film, [&](const view::Shot& shot) {
    benchmark::DoNotOptimize(renderer->draw(film.scene(), {&shot, 1}, nullptr).rgba.data());
  });
}

/// The window of `show` at its default size: turned by the mouse, or at rest after it was turned.
void in_a_window(benchmark::State& state, const std::string& file, bool is_turned)
{
  store::MotionModel model = store::read_motion_model(file);
  show::SessionOptions chosen;
  chosen.set = store::set_names(model).front();
  chosen.is_plain_while_moving = true;
  view::WindowOptions options;
  options.width = chosen.width;
  options.height = chosen.height;
  options.is_vsynced = false;
  const std::unique_ptr<view::Window> window = view::open_window(options);
  show::ShownModel shown(file, std::move(model), chosen, window->renderer());
  show::Session& session = shown.session();
  const auto draw = [&](double elapsed_s) {
    window->events();
    session.advance(elapsed_s);
    window->renderer().set_samples(session.is_plain() ? 1 : show::samples_at_rest);
    window->show(session.scene(), session.shots(), &session.overlay());
  };
  const auto drag = [&](int k) {
    session.take({view::InputKind::motion, 400.0 + k % 200, 400.0});
    draw(0.03);
  };
  // The time from the release of the button to the first picture in full quality.
  const auto rest = [&] {
    session.take({view::InputKind::release, 400.0, 400.0});
    const auto start = std::chrono::steady_clock::now();
    draw(0.0);
    draw(show::settle_s);
    return show::settle_s + seconds_since(start);
  };
  const auto press = [&] { session.take({view::InputKind::press, 400.0, 400.0}); };
  press();
  for (int k = 0; k < 30; ++k) drag(k);  // until the levels of detail are there
  rest();
  press();
  int k = 0;
  for (auto _ : state) {
    drag(++k);
    if (is_turned) continue;
    state.SetIterationTime(rest());
    press();
  }
  if (is_turned)
    state.counters["frames/s"] =
        benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

/// A process from its start to an image on disk; `is_cold`: with an empty shader cache.
void first_picture(benchmark::State& state, const std::string& player, const std::string& file, bool is_cold)
{
  const test::Scratch scratch;
  int n = 0;
  for (auto _ : state) {
    const std::string cache = (scratch.path() / ("shaders" + std::to_string(is_cold ? n++ : 0))).string();
    std::filesystem::create_directories(cache);
    const auto start = std::chrono::steady_clock::now();
    const test::Ended ended = test::run({player,
                                         {"show", file, "--offscreen", scratch.path().string(), "--flexion",
                                          "30", "--views", "oblique", "--size", "640x480"},
                                         {{"MESA_SHADER_CACHE_DIR", cache}},
                                         {}});
    state.SetIterationTime(seconds_since(start));
    if (ended.exit_code != 0) throw std::runtime_error(ended.err);
  }
}

void register_knee(const std::string& player, const std::string& knee, const std::string& file)
{
  const auto add = [&](const std::string& what, const std::function<void(benchmark::State&)>& run) {
    return benchmark::RegisterBenchmark(("player/" + what + "/" + knee).c_str(), run);
  };
  const view::RenderOptions moving{width, height, 1, view::moving_coarseness_px},
      whole{width, height, 1, 0.0}, fine{width, height, 4, view::moving_coarseness_px};
  const auto frames = [&](const std::string& what, const view::RenderOptions& options,
                          view::Backend backend) {
    add(what, [=](benchmark::State& state) { off_screen(state, file, options, backend); })->UseRealTime();
  };
  frames("frame", moving, view::Backend::osmesa);
  frames("frame, every triangle", whole, view::Backend::osmesa);
  frames("frame, 4 samples", fine, view::Backend::osmesa);
  frames("frame by EGL", moving, view::Backend::egl);
  if (std::getenv("DISPLAY") != nullptr) {
    add("show, turned", [=](benchmark::State& state) { in_a_window(state, file, true); })->UseRealTime();
    add("show, at rest", [=](benchmark::State& state) { in_a_window(state, file, false); })->UseManualTime();
  }
  for (const bool is_cold : {false, true}) {
    add(is_cold ? "first picture, no shaders kept" : "first picture",
        [=](benchmark::State& state) { first_picture(state, player, file, is_cold); })
        ->UseManualTime()
        ->Iterations(5);
  }
}

}  // namespace
}  // namespace vrda::benchmarks

int main(int argc, char** argv)
{
  benchmark::Initialize(&argc, argv);
  if (argc < 3) {
    std::cerr << "usage: vrda_player_bench PLAYER NAME=MODEL.h5... [--benchmark_...]\n";
    return 2;
  }
  for (int i = 2; i < argc; ++i) {
    const std::string model = argv[i];
    const std::size_t equals = model.find('=');
    if (equals == std::string::npos) {
      std::cerr << model << ": found no =, wanted NAME=MODEL.h5\n";
      return 2;
    }
    vrda::benchmarks::register_knee(argv[1], model.substr(0, equals), model.substr(equals + 1));
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
