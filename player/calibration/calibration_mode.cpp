#include "calibration/calibration_mode.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <ostream>
#include <sstream>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/document.hpp"
#include "show/loop.hpp"
#include "view/arguments.hpp"
#include "show/settings_text.hpp"
#include "store/motion_model_file.hpp"

namespace vrda::calibration {
namespace {

store::MotionModel grid_model(const std::string& file)
{
  store::MotionModel model = store::read_motion_model(file);
  store::require_grid(model, file, "a calibration");
  return model;
}

constexpr int most_presses = 10000;
constexpr double longest_s = 3600.0;

struct Where {
  const std::string& path;
  std::size_t line;
};

[[noreturn]] void refuse(const Where& where, const std::string& found, const std::string& wanted)
{
  throw InputError({where.path, "line " + std::to_string(where.line), "\"" + found + "\"", wanted});
}

std::optional<view::Key> key_named(const std::string& name)
{
  constexpr std::array<std::pair<const char*, view::Key>, 8> named{
      {{"Enter", view::Key::enter},
       {"Backspace", view::Key::backspace},
       {"Escape", view::Key::escape},
       {"Space", view::Key::space},
       {"Left", view::Key::left},
       {"Right", view::Key::right},
       {"Up", view::Key::up},
       {"Down", view::Key::down}}};
  for (const auto& [known, key] : named)
    if (name == known) return key;
  const bool is_one = name.size() == 1;
  if (is_one && ((name[0] >= 'A' && name[0] <= 'Z') || (name[0] >= '0' && name[0] <= '9')))
    return view::key_of(name[0]);
  return std::nullopt;
}

view::KeyPress parsed_press(const std::string& text, const Where& where)
{
  view::KeyPress press;
  std::vector<std::string> parts = view::split(text, '+');
  const std::optional<view::Key> key = key_named(parts.back());
  if (!key)
    refuse(where, text, "a key: a capital letter, a digit, Enter, Backspace, Escape, Space, Left, ...");
  press.key = *key;
  parts.pop_back();
  for (const std::string& part : parts) {
    bool& has = part == "Shift" ? press.has_shift : press.has_control;
    if ((part != "Shift" && part != "Control") || has)
      refuse(where, text, "each of Shift+ and Control+ at most once before the key");
    has = true;
  }
  return press;
}

template <typename Number>
Number parsed_number(const std::string& text, const Where& where, Number most, const char* wanted)
{
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = error == std::errc() && end == text.data() + text.size();
  if (!is_whole || !(value > Number{0} && value <= most)) refuse(where, text, wanted);
  return value;
}

ScriptLine parsed_line(const std::vector<std::string>& words, const Where& where)
{
  ScriptLine line;
  if (words[0] == "press" && (words.size() == 2 || words.size() == 3)) {
    line.press = parsed_press(words[1], where);
    line.n_presses = words.size() == 2 ? 1 : parsed_number(words[2], where, most_presses, "1 to 10000 times");
  } else if (words[0] == "wait" && words.size() == 2) {
    line.wait_s = parsed_number(words[1], where, longest_s, "seconds above 0, up to 3600");
  } else {
    std::string whole;
    for (const std::string& word : words) whole += (whole.empty() ? "" : " ") + word;
    refuse(where, whole, "\"press KEY\", \"press KEY TIMES\" or \"wait SECONDS\"");
  }
  return line;
}

}  // namespace

std::vector<ScriptLine> parse_key_script(const std::string& text, const std::string& path)
{
  std::vector<ScriptLine> lines;
  std::istringstream all(text);
  std::size_t number = 0;
  for (std::string row; std::getline(all, row);) {
    ++number;
    std::istringstream rest(row.substr(0, row.find('#')));
    std::vector<std::string> words;
    for (std::string word; rest >> word;) words.push_back(word);
    if (!words.empty()) lines.push_back(parsed_line(words, {path, number}));
  }
  return lines;
}

const std::vector<view::KeyPress>& KeyScript::keys(double now_s)
{
  keys_.clear();
  if (is_over()) return keys_;
  const ScriptLine& line = lines_[next_];
  if (line.n_presses > 0) {
    keys_.assign(static_cast<std::size_t>(line.n_presses), line.press);
    ++next_;
  } else if (begun_s_ < 0.0) {
    begun_s_ = now_s;
  } else if (now_s - begun_s_ >= line.wait_s) {
    begun_s_ = -1.0;
    ++next_;
  }
  return keys_;
}

namespace {

/// Part and task; empty at the end.
std::string task_name(const CalibrationSession& session)
{
  if (session.task() == nullptr) return {};
  return std::string(bench::name_of(session.progress().part)) + " " + session.task()->name;
}

std::string text_of(const calibration::VirtualOperator::Deviation& off)
{
  return "You were " + show::rounded_text(off.value, off.unit.empty() ? 3 : 1) +
         (off.unit.empty() ? "" : " " + off.unit) + " from the truth" +
         (off.value > large_deviation ? ": again. Backspace takes it back." : ".");
}

show::Sink sink_of(const CalibrateOptions& options, const BenchFile& bench)
{
  if (!options.is_headless) return bench::bench_window(bench, bench.title + " - calibrate", options.samples);
  return options.pictures.empty() ? show::Sink() : bench::bench_memory(bench, options.samples);
}

KeyScript script_of(const CalibrateOptions& options)
{
  if (options.script.empty()) return KeyScript({});
  return KeyScript(
      parse_key_script(core::read_document_text(options.script, "a key script"), options.script));
}

}  // namespace

CalibrationWriter::CalibrationWriter(const BenchFile& bench, const std::string& path)
{
  if (!path.empty()) file_.emplace(bench, path, read_text_file(path).value_or(""));
}

void CalibrationWriter::write(const CalibrationSession& session)
{
  if (!file_ || session.revision() == revision_) return;
  file_->write(session.calibration());
  revision_ = session.revision();
}

CalibrationMode::CalibrationMode(const CalibrateOptions& options, const BenchFile& bench,
                                 CalibrationSession& session, CalibrationWriter& kept,
                                 const show::Streams& streams)
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
  nothing_.background = view::background_of(view::Backdrop::black);
  if (!options.model.empty()) {
    store::MotionModel model = grid_model(options.model);
    outlines_ = {outline_of(model.reference), outline_of(model.moving)};
    model_.emplace(bench, std::move(model), options.model, options.set);
  }
  if (!sink_.has_output()) return;
  if (!options.pictures.empty()) sink_.record_images(options.pictures, "--pictures");
  sink_.renderer().load(panel_.font());
  sink_.renderer().load(nothing_);
}

show::RoundTime CalibrationMode::round_time() const
{
  // A headless virtual bench has no operator or device and runs without pacing.
  const bool is_paced = !(options_.is_virtual && options_.is_headless);
  return {is_paced ? 1.0 / bench_.display.refresh_hz : 0.0, false};
}

void CalibrationMode::take(const view::InputEvent& event)
{
  if (const std::optional<view::KeyPress> pressed = show::key_press_of(event)) press(*pressed);
  take_pointer(event);
  if (event.kind != view::InputKind::wheel) return;
  // Touchpads send parts of a notch.
  for (wheel_ += event.wheel; std::abs(wheel_) >= 1.0; wheel_ -= std::copysign(1.0, wheel_))
    press(calibration::press_of_wheel(wheel_ > 0.0, event.has_shift, event.has_control));
}

/// A drag is computed from its press: returning there restores the dials.
void CalibrationMode::take_pointer(const view::InputEvent& event)
{
  if (event.kind == view::InputKind::press && event.button == view::MouseButton::middle)
    return press({view::Key::enter});
  if (event.kind == view::InputKind::press) {
    drag_ = event;
    session_.begin_drag();
  } else if (event.kind == view::InputKind::motion && drag_) {
    session_.take(calibration::DialDrag{{event.x_px - drag_->x_px, event.y_px - drag_->y_px},
                                              drag_->button == view::MouseButton::right,
                                              drag_->has_shift});
  } else if (event.kind == view::InputKind::release || event.kind == view::InputKind::focus_lost) {
    drag_.reset();
  }
}

void CalibrationMode::take_gamepad(double elapsed_s)
{
  const std::optional<view::Gamepad> pad =
      sink_.window() == nullptr ? std::nullopt : sink_.window()->gamepad();
  if (!pad) return;
  const bool is_plane = session_.task() != nullptr && session_.task()->dials.size() <= 2;
  for (const view::KeyPress& pressed : gamepad_.keys(*pad, elapsed_s, is_plane)) press(pressed);
}

void CalibrationMode::press_in_task(const view::KeyPress& press)
{
  const bool is_confirmed = press.key == view::Key::enter && !session_.progress().is_sampling;
  if (is_confirmed) {
    content_.deviation.clear();
    awaited_ = {task_name(session_), calibration::typical_s(*session_.task()),
                calibration_bench_->deviation(session_)};
  }
  session_.take(press);
}

/// A task ends with its confirmation or its last sample.
void CalibrationMode::note_task_end()
{
  if (awaited_.name.empty() || session_.progress().is_sampling) return;
  if (task_name(session_) != awaited_.name) {
    pace_.typical_s += awaited_.typical_s;
    if (awaited_.deviation) {
      content_.deviation = text_of(*awaited_.deviation);
      content_.deviation_value = awaited_.deviation->value;
      if (!options_.is_quiet) streams_.messages << awaited_.name << ": " << content_.deviation << "\n";
    }
  }
  awaited_ = {};
}

void CalibrationMode::press(const view::KeyPress& press)
{
  if (press.key == view::key_of('H')) {
    content_.has_help = !content_.has_help;
  } else if (session_.task() != nullptr) {
    press_in_task(press);
  } else {
    is_over_ = is_over_ || press.key == view::Key::enter || press.key == view::Key::escape ||
               press.key == view::key_of('Q');
  }
}

void CalibrationMode::advance(double elapsed_s)
{
  pace_.used_s += elapsed_s;
  take_gamepad(elapsed_s);
  const double now_s = static_cast<double>(n_rounds_) / bench_.display.refresh_hz;
  for (const view::KeyPress& pressed : script_.keys(now_s)) press(pressed);
  calibration_bench_->send_samples(session_, model_ ? &*model_ : nullptr);
  note_task_end();
  if (session_.take_zero_request()) calibration_bench_->zero_stage();
  // A full disk does not end the session; the write is repeated.
  const auto refused = show::catch_input_error([&] { kept_.write(session_); });
  content_.message = refused ? refused->what() : "";
  print_words();
}

void CalibrationMode::print_words()
{
  if (session_.revision() == printed_revision_) return;
  printed_revision_ = session_.revision();
  if (options_.is_quiet) return;
  for (const std::string& line : session_.progress().messages) streams_.messages << line << "\n";
}

/// Of the body whose points the current task touches; null without a model.
const BodyOutline* CalibrationMode::outline() const
{
  if (outlines_.empty()) return nullptr;
  return &outlines_[session_.progress().part == CalibrationPart::tibia ? 1 : 0];
}

void CalibrationMode::make_content()
{
  const Task* task = session_.task();
  CalibrationView view = calibration_bench_->view(session_);
  content_.time_left_s = calibration::time_left_s(pace_, session_.progress().typical_left_s);
  content_.lines = std::move(view.lines);
  content_.boxes = view.boxes;
  content_.notes = std::move(view.notes);
  if (const std::string name = task_name(session_); name != drawn_task_) {
    drawn_task_ = name;
    content_.diagram.reset();
    if (task != nullptr) content_.diagram = diagram_of(session_.progress().part, *task, bench_, outline());
  }
  content_.error_messages =
      task == nullptr ? std::vector<std::string>{} : calibration_bench_->device_problems(*task);
  const std::string& error_message = watch_.error_message(sink_);
  if (!error_message.empty()) content_.error_messages.push_back(error_message);
  if (const std::string warning = watch_.take_warning(); !warning.empty())
    streams_.messages << "vrda-player: " << warning << std::endl;
}

/// Places the model if the task adjusts it.
bool CalibrationMode::place_model()
{
  const Task* task = session_.task();
  if (task == nullptr || task->kind != TaskKind::model_pose || !model_) return false;
  model_->place(session_.calibration(), {session_.progress().part, *task, session_.values()},
                calibration_bench_->now_ns(), sink_.renderer());
  return is_model_loaded_ = true;
}

void CalibrationMode::draw()
{
  const Task* task = session_.task();
  const std::string name = task_name(session_);
  const bool is_kept = sink_.is_recording() && (n_rounds_ == 0 || name != pictured_);
  ++n_rounds_;
  const bool is_unattended = options_.is_headless && (task == nullptr || script_.is_over());
  is_over_ = is_over_ || session_.has_quit() || is_unattended;
  if (!sink_.has_output() || (options_.is_headless && !is_kept)) return;
  make_content();
  const bool has_model = place_model();
  const show::Frame frame{is_model_loaded_ ? model_->view().scene() : nothing_,
                          has_model ? model_->view().shots() : std::span<const view::Shot>(),
                          &panel_.drawn(session_, content_)};
  if (!is_kept) return sink_.show(frame);
  pictured_ = name;
  streams_.data << sink_.record(frame, show::padded_name("task_", ++n_pictures_, 4) + ".png") << "\n";
}

}  // namespace vrda::calibration
