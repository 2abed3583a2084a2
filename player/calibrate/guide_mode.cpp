#include "calibrate/guide_mode.hpp"

#include <ostream>
#include <utility>

#include "core/error.hpp"
#include "core/whole_file.hpp"
#include "documents/document.hpp"
#include "loop/window_input.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

Sink sink_of(const CalibrateOptions& options, const BenchFile& bench)
{
  if (!options.is_headless) return bench_window(bench, bench.title + " - calibrate", options.samples);
  return options.pictures.empty() ? Sink() : bench_memory(bench, options.samples);
}

KeyScript script_of(const CalibrateOptions& options)
{
  if (options.script.empty()) return KeyScript({});
  return KeyScript(parsed_key_script(document_text(options.script, "a script of keys"), options.script));
}

}  // namespace

void KeptCalibration::write(const GuideSession& session)
{
  if (path_.empty() || session.revision() == revision_) return;
  write_whole(path_, {calibration_text(session.calibration(), bench_)});
  revision_ = session.revision();
}

GuideMode::GuideMode(const CalibrateOptions& options, const BenchFile& bench, GuideSession& session,
                     KeptCalibration& kept, const Streams& streams)
    : options_(options),
      bench_(bench),
      session_(session),
      kept_(kept),
      streams_(streams),
      panel_(bench),
      sink_(sink_of(options, bench)),
      watch_(bench),
      script_(script_of(options))
{
  nothing_.background = background_of(Backdrop::black);
  if (!options.model.empty())
    model_.emplace(bench, read_motion_model(options.model), options.model, options.set);
  if (!sink_.is_anywhere()) return;
  if (!options.pictures.empty()) sink_.keep_pictures(options.pictures, "--pictures");
  sink_.renderer().load(panel_.font());
  sink_.renderer().load(nothing_);
}

RoundTime GuideMode::round_time() const
{
  // What no hand and no device waits for goes as fast as it can.
  const bool is_paced = !(options_.is_virtual && options_.is_headless);
  return {is_paced ? 1.0 / bench_.display.refresh_hz : 0.0, false};
}

void GuideMode::take(const InputEvent& event)
{
  if (const std::optional<KeyPress> pressed = key_press_of(event)) press(*pressed);
}

void GuideMode::press(const KeyPress& press)
{
  if (press.key == key_of('H')) {
    content_.has_help = !content_.has_help;
  } else if (session_.task() != nullptr) {
    session_.take(press);
  } else {
    is_over_ = is_over_ || press.key == Key::enter || press.key == Key::escape || press.key == key_of('Q');
  }
}

void GuideMode::advance(double)
{
  const double now_s = static_cast<double>(n_rounds_) / bench_.display.refresh_hz;
  for (const KeyPress& pressed : script_.keys(now_s)) press(pressed);
  before_->send_samples(session_, model_ ? &*model_ : nullptr);
  if (session_.zeroes_stage()) before_->zero_stage();
  // A disk that is full ends no session; what is not written is tried again.
  const auto refused = attempt([&] { kept_.write(session_); });
  content_.message = refused ? refused->what() : "";
  tell_words();
}

void GuideMode::tell_words()
{
  if (session_.revision() == told_revision_) return;
  told_revision_ = session_.revision();
  if (options_.is_quiet) return;
  for (const std::string& line : session_.progress().words) streams_.talk << line << "\n";
}

void GuideMode::make_content()
{
  const Task* task = session_.task();
  GuideView view = before_->view(session_);
  content_.lines = std::move(view.lines);
  content_.boxes = view.boxes;
  content_.notes = std::move(view.notes);
  content_.troubles = task == nullptr ? std::vector<std::string>{} : before_->troubles(*task);
  const std::string& trouble = watch_.trouble(sink_);
  if (!trouble.empty()) content_.troubles.push_back(trouble);
  if (const std::string warning = watch_.take_warning(); !warning.empty())
    streams_.talk << "vrda-player: " << warning << std::endl;
}

/// Where the task is one that places it.
bool GuideMode::place_model()
{
  const Task* task = session_.task();
  if (task == nullptr || task->kind != TaskKind::place || !model_) return false;
  model_->place(session_.calibration(), {session_.progress().part, *task, session_.values()},
                before_->now_ns(), sink_.renderer());
  return is_model_loaded_ = true;
}

void GuideMode::draw()
{
  const Task* task = session_.task();
  const std::string name =
      task == nullptr ? "" : std::string(name_of(session_.progress().part)) + " " + task->name;
  const bool is_kept = sink_.keeps() && (n_rounds_ == 0 || name != pictured_);
  ++n_rounds_;
  const bool is_unattended = options_.is_headless && (task == nullptr || script_.is_over());
  is_over_ = is_over_ || session_.is_left() || is_unattended;
  if (!sink_.is_anywhere() || (options_.is_headless && !is_kept)) return;
  make_content();
  const bool has_model = place_model();
  const Frame frame{is_model_loaded_ ? model_->view().scene() : nothing_,
                    has_model ? model_->view().shots() : std::span<const Shot>(),
                    &panel_.drawn(session_, content_)};
  if (!is_kept) return sink_.show(frame);
  pictured_ = name;
  streams_.data << sink_.keep(frame, numbered("task_", ++n_pictures_, 4) + ".png") << "\n";
}

}  // namespace vrda
