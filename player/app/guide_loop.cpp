#include "app/guide_loop.hpp"

#include <ostream>
#include <utility>

#include "app/pace.hpp"
#include "core/error.hpp"
#include "core/whole_file.hpp"
#include "render/png_file.hpp"
#include "settings/settings_table.hpp"
#include "store/read_apart.hpp"

namespace vrda {
namespace {

std::unique_ptr<BenchScreen> open_screen(const CalibrateOptions& options, const BenchFile& bench)
{
  if (!options.is_headless) return open_bench_window(bench, bench.title + " - calibrate", options.samples);
  return options.pictures.empty() ? nullptr : open_bench_memory(bench, options.samples);
}

KeyScript script_of(const CalibrateOptions& options)
{
  if (options.script.empty()) return KeyScript({});
  return KeyScript(parsed_key_script(settings_file_text(options.script, "a script of keys"), options.script));
}

std::string picture_name(const std::string& folder, int number)
{
  constexpr std::size_t width = 4;
  std::string digits = std::to_string(number);
  digits.insert(0, width - std::min(width, digits.size()), '0');
  return folder + "/task_" + digits + ".png";
}

}  // namespace

void KeptCalibration::write(const GuideSession& session)
{
  if (path_.empty() || session.revision() == revision_) return;
  write_whole(path_, {calibration_text(session.calibration(), bench_)});
  revision_ = session.revision();
}

GuideLoop::GuideLoop(const CalibrateOptions& options, const BenchFile& bench, GuideSession& session,
                     KeptCalibration& kept, const ShowStreams& streams)
    : options_(options),
      bench_(bench),
      session_(session),
      kept_(kept),
      streams_(streams),
      panel_(bench),
      watch_(bench),
      script_(script_of(options))
{
  nothing_.background = background_of(Backdrop::black);
  if (!options.model.empty())
    model_.emplace(bench, read_motion_model_apart(options.model), options.model, options.set);
  screen_ = open_screen(options, bench);
  if (!screen_) return;
  screen_->renderer().load(panel_.font());
  screen_->renderer().load(nothing_);
}

void GuideLoop::run(GuideBench& before, StopSignals& stop)
{
  // What no hand and no device waits for goes as fast as it can.
  const bool is_paced = !(options_.is_virtual && options_.is_headless);
  Pace pace(bench_.display.refresh_hz);
  const auto is_closed = [&] { return screen_ && screen_->should_close(); };
  while (!is_over_ && !is_closed() && !stop.came_within(std::chrono::milliseconds(0))) {
    if (is_paced) pace.wait();
    round(before);
  }
  kept_.write(session_);
}

void GuideLoop::round(GuideBench& before)
{
  take_keys();
  before.send_samples(session_, model_ ? &*model_ : nullptr);
  if (session_.zeroes_stage()) before.zero_stage();
  keep();
  tell_words();
  show(before);
  ++n_rounds_;
  const bool is_done = session_.task() == nullptr;
  const bool is_unattended = options_.is_headless && (is_done || script_.is_over());
  is_over_ = is_over_ || session_.is_left() || is_unattended;
}

void GuideLoop::take_keys()
{
  const auto take = [&](const KeyPress& press) {
    if (press.key == key_of('H')) {
      content_.has_help = !content_.has_help;
    } else if (session_.task() != nullptr) {
      session_.take(press);
    } else {
      is_over_ = is_over_ || press.key == Key::enter || press.key == Key::escape || press.key == key_of('Q');
    }
  };
  if (screen_)
    for (const KeyPress& press : screen_->keys()) take(press);
  const double now_s = static_cast<double>(n_rounds_) / bench_.display.refresh_hz;
  for (const KeyPress& press : script_.keys(now_s)) take(press);
}

/// A disk that is full ends no session; what is not written is tried again.
void GuideLoop::keep()
{
  try {
    kept_.write(session_);
    content_.message.clear();
  } catch (const InputError& error) {
    content_.message = error.what();
  }
}

void GuideLoop::tell_words()
{
  if (session_.revision() == told_revision_) return;
  told_revision_ = session_.revision();
  if (options_.is_quiet) return;
  for (const std::string& line : session_.progress().words) streams_.talk << line << "\n";
}

void GuideLoop::show(GuideBench& before)
{
  if (!screen_) return;
  const Task* task = session_.task();
  const std::string name =
      task == nullptr ? "" : std::string(name_of(session_.progress().part)) + " " + task->name;
  const bool is_written = !options_.pictures.empty() && (n_rounds_ == 0 || name != pictured_);
  if (options_.is_headless && !is_written) return;
  GuideView view = before.view(session_);
  content_.lines = std::move(view.lines);
  content_.boxes = view.boxes;
  content_.notes = std::move(view.notes);
  content_.troubles = task == nullptr ? std::vector<std::string>{} : before.troubles(*task);
  const std::string& trouble = watch_.trouble(*screen_);
  if (!trouble.empty()) content_.troubles.push_back(trouble);
  if (const std::string warning = watch_.take_warning(); !warning.empty())
    streams_.talk << "vrda-player: " << warning << std::endl;
  const bool has_model = task != nullptr && task->kind == TaskKind::place && model_;
  if (has_model) {
    model_->place(session_.calibration(), {session_.progress().part, *task, session_.values()},
                  before.now_ns(), screen_->renderer());
    is_model_loaded_ = true;
  }
  const Scene& scene = is_model_loaded_ ? model_->view().scene() : nothing_;
  const std::span<const Shot> shots = has_model ? model_->view().shots() : std::span<const Shot>();
  const Overlay& words = panel_.drawn(session_, content_);
  if (!is_written) {
    screen_->show(scene, shots, words);
    return;
  }
  pictured_ = name;
  const std::string path = picture_name(options_.pictures, ++n_pictures_);
  write_png(screen_->picture(scene, shots, words), path);
  streams_.data << path << "\n";
}

}  // namespace vrda
