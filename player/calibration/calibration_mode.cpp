#include "calibration/calibration_mode.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ostream>
#include <sstream>
#include <utility>

#include "core/document.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "show/session.hpp"
#include "store/motion_model.hpp"

namespace vrda::calibration {
namespace {

using view::margin_px;

view::OverlayBox overlay_box(const view::ShownBox& box)
{
  const Eigen::Vector2f low = box.low_px.cast<float>(), high = box.high_px.cast<float>();
  return {low.x(), low.y(), high.x(), high.y()};
}

/// Inset area that is probably visible while the edges are unknown.
view::Viewport inner(const view::Viewport& visible)
{
  constexpr int share = 12;
  const int x = visible.width / share, y = visible.height / share;
  return {visible.x + x, visible.y + y, visible.width - 2 * x, visible.height - 2 * y};
}

view::VertexColour bytes_of(const std::array<float, 3>& colour)
{
  view::VertexColour bytes{0, 0, 0, 255};
  for (std::size_t k = 0; k < colour.size(); ++k)
    bytes[k] = static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(colour[k], 0.0F, 1.0F)));
  return bytes;
}

/// Whole pixels of a horizontal or vertical line.
view::OverlayBox pixels_of(const DrawnLine& line)
{
  Eigen::Vector2d low = line.points_px.front(), high = line.points_px.front();
  for (const Eigen::Vector2d& p : line.points_px) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Index thin = high.x() - low.x() < high.y() - low.y() ? 0 : 1;
  low[thin] -= 0.5 * line.width_px;
  high[thin] = low[thin] + line.width_px;
  return {static_cast<float>(std::round(low.x())), static_cast<float>(std::round(low.y())),
          static_cast<float>(std::round(high.x())), static_cast<float>(std::round(high.y()))};
}

/// "12 minutes", at least one.
std::string minutes_text(double s)
{
  constexpr double s_per_minute = 60.0;
  const long n = std::max(1L, std::lround(s / s_per_minute));
  return std::to_string(n) + (n == 1 ? " minute" : " minutes");
}

view::VertexColour colour_of(DiagramInk drawn_with)
{
  constexpr std::array colours{faint, view::amber, view::green};
  return colours.at(static_cast<std::size_t>(drawn_with));
}

int decimals_of_step(double step)
{
  constexpr int most = 6;
  int n = 0;
  for (double rest = step; n < most && std::abs(rest - std::round(rest)) > 1e-9; rest *= 10.0) ++n;
  return n;
}

}  // namespace

std::string dial_text(const Dial& dial, double value)
{
  return dial.name + " " + bench::text(value, decimals_of_step(dial.step), dial.unit);
}

void add_drawn_line(view::Overlay& overlay, const view::OverlayText& text, const DrawnLine& line)
{
  if (line.is_smooth) {
    text.add_line(overlay, line.points_px, line.width_px, bytes_of(line.colour));
  } else {
    text.add_area(overlay, pixels_of(line), bytes_of(line.colour));
  }
}

CalibrationPanel::CalibrationPanel(const BenchFile& bench)
    : text_(view::panel_text_px),
      display_(bench.display),
      reflector_(bench.display.windows, bench.display.reflection)
{
}

void CalibrationPanel::add_lines(const CalibrationPanelContent& content)
{
  for (const bool is_right : {false, true}) {
    if (content.view.boxes)
      view::clip_overlay(overlay_, overlay_box((*content.view.boxes)[is_right ? 1 : 0]));
    for (const DrawnLine& line : content.view.lines)
      if (line.is_right == is_right) add_drawn_line(overlay_, text_, line);
  }
  view::clip_overlay(overlay_,
                     {0.0F, 0.0F, static_cast<float>(display_.width), static_cast<float>(display_.height)});
}

namespace {

/// Lines of text, wrapped at a width.
struct TextBlock {
  const view::OverlayText& text;
  float width_px;
  struct Line {
    std::string text;
    view::VertexColour colour;
  };
  std::vector<Line> lines = {};

  void add(const std::string& words, const view::VertexColour& colour)
  {
    for (const std::string& line : bench::wrapped(text, words, width_px)) lines.push_back({line, colour});
  }
};

void add_task(TextBlock& block, const CalibrationSession& session, double time_left_s)
{
  const Task& task = *session.task();
  const CalibrationProgress& progress = session.progress();
  block.add("Part " + std::to_string(progress.number) + " of " + std::to_string(progress.n_parts) + ": " +
                bench::name_of(progress.part) + ", " + std::to_string(progress.n_done + 1) + " of " +
                std::to_string(progress.n_tasks) + ", " + task.name,
            faint);
  block.add(std::to_string(std::lround(100.0 * overall_progress(progress))) + " % of all parts done, about " +
                minutes_text(time_left_s) + " left",
            faint);
  block.add(task.instruction, ink);
  // One or two dials have their own keys; of more dials one is selected.
  const bool is_selecting = task.dials.size() > 2;
  for (std::size_t k = 0; k < task.dials.size(); ++k) {
    const bool is_live = !is_selecting || k == session.selected_dial();
    const std::string mark = !is_selecting ? (k == 0 ? "Left, Right: " : "Up, Down: ")
                             : is_live     ? "> "
                                           : "- ";
    block.add(mark + dial_text(task.dials[k], session.values()[k]), is_live ? view::green : ink);
  }
  if (progress.is_sampling) {
    block.add(std::to_string(progress.n_samples) + " of " + std::to_string(task.n_samples) + " samples of " +
                  task.tool,
              view::green);
  }
}

void add_help(TextBlock& block)
{
  for (const view::HelpLine& help : session_key_lines())
    block.add(std::string(help.keys) + ": " + help.description, ink);
  block.add("H: back to the task", ink);
}

void add_state(TextBlock& block, const CalibrationSession& session, const CalibrationPanelContent& content)
{
  const CalibrationProgress& progress = session.progress();
  const bool is_over = session.task() == nullptr;
  if (is_over) {
    block.add("All requested parts are done. Enter: quit", view::green);
  } else {
    add_task(block, session, content.time_left_s);
  }
  // Twice what a careful hand is off, and ten: repeat it.
  const double off = content.deviation_value;
  if (!content.deviation.empty())
    block.add(content.deviation, off > large_deviation  ? view::red
                                 : off > fair_deviation ? view::amber
                                                        : view::green);
  for (const std::string& line : progress.messages)
    block.add(line, progress.has_error ? view::amber : view::green);
  for (const std::string& note : content.view.notes) block.add(note, ink);
  for (const std::string& message : content.error_messages) block.add(message, view::amber);
  if (!content.message.empty()) block.add(content.message, view::amber);
  block.add(is_over                ? "To repeat a part: vrda-player calibrate PART --anew"
            : progress.is_sampling ? "Backspace: stop sampling. R: take back this part"
                                   : "Backspace: take back the previous task. R: take back this part",
            faint);
  block.add("H: keys", faint);
}

}  // namespace

/// Below the text, as wide as the area and its remaining height allow.
void CalibrationPanel::add_diagram(const Diagram& diagram, const view::Viewport& area, float top_px)
{
  constexpr float least_px = 160.0F;
  const float bottom_px = static_cast<float>(area.y + area.height) - margin_px;
  const float size_px = std::min(static_cast<float>(area.width) - 2.0F * margin_px,
                                 (bottom_px - top_px) / static_cast<float>(diagram.height));
  if (size_px < least_px) return;
  const Eigen::Vector2d corner_px(static_cast<double>(area.x) + static_cast<double>(margin_px),
                                  static_cast<double>(top_px));
  constexpr double plain_px = 1.0, marked_px = 2.0;
  std::vector<Eigen::Vector2d> points_px;
  for (const DiagramLine& line : diagram.lines) {
    points_px.clear();
    for (const Eigen::Vector2d& p : line.points)
      points_px.emplace_back(corner_px + static_cast<double>(size_px) * p);
    text_.add_line(overlay_, points_px, line.ink == DiagramInk::plain ? plain_px : marked_px,
                   colour_of(line.ink));
  }
  for (const DiagramLabel& label : diagram.labels) {
    const Eigen::Vector2f at_px = (corner_px + static_cast<double>(size_px) * label.at).cast<float>();
    text_.add_text(overlay_, at_px.x(), at_px.y(),
                   text_.fitted(label.text, static_cast<float>(area.x + area.width) - margin_px - at_px.x()),
                   ink);
  }
}

const view::Overlay& CalibrationPanel::drawn(const CalibrationSession& session,
                                             const CalibrationPanelContent& content)
{
  view::clear_overlay(overlay_, display_.width, display_.height);
  add_lines(content);
  const std::optional<view::Viewport> area = bench::operator_area(display_);
  const view::Viewport home = area ? *area : inner(session.calibration().eyes.left.visible);
  if (area) text_.add_area(overlay_, view::overlay_box(home), view::paper);
  TextBlock block{text_, static_cast<float>(home.width) - 2.0F * margin_px};
  if (content.has_help) {
    add_help(block);
  } else {
    add_state(block, session, content);
  }
  const float height_px = text_.line_px() * static_cast<float>(block.lines.size());
  float top_px = area ? static_cast<float>(home.y) + margin_px
                      : static_cast<float>(home.y + home.height) - margin_px - height_px;
  for (const TextBlock::Line& line : block.lines) {
    text_.add_text(overlay_, static_cast<float>(home.x) + margin_px, top_px, line.text, line.colour);
    top_px += text_.line_px();
  }
  if (area && content.diagram && !content.has_help) add_diagram(*content.diagram, *area, top_px + margin_px);
  view::finish_overlay(overlay_);
  reflector_.reflect(overlay_);
  return overlay_;
}

namespace {

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
  constexpr std::array<std::pair<const char*, view::Key>, 8> named{{{"Enter", view::Key::enter},
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
    refuse(where, joined(words, " "), "\"press KEY\", \"press KEY TIMES\" or \"wait SECONDS\"");
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

std::string text_of(const Deviation& off)
{
  return "You were " + bench::text(off.value, off.unit.empty() ? 3 : 1, off.unit) + " from the truth" +
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
    store::MotionModel model = store::read_motion_model(options.model);
    store::require_grid(model, options.model, "a calibration");
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
    press(press_of_wheel(wheel_ > 0.0, event.has_shift, event.has_control));
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
    session_.take(DialDrag{{event.x_px - drag_->x_px, event.y_px - drag_->y_px},
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
    awaited_ = {task_name(session_), session_.task()->kind->traits().typical_s,
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
  } else if (press.key == view::Key::escape) {
    content_.has_help = false;
  } else if (session_.task() != nullptr) {
    press_in_task(press);
  } else {
    is_over_ = is_over_ || press.key == view::Key::enter || press.key == view::key_of('Q');
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
  const Task* task = session_.task();
  return &outlines_[task != nullptr && task->body == BodyRole::tibia ? 1 : 0];
}

void CalibrationMode::make_content()
{
  const Task* task = session_.task();
  content_.view = calibration_bench_->view(session_);
  content_.time_left_s = time_left_s(pace_, session_.progress().typical_left_s);
  if (const std::string name = task_name(session_); name != drawn_task_) {
    drawn_task_ = name;
    content_.diagram.reset();
    if (task != nullptr) content_.diagram = diagram_of(*task, bench_, outline());
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
  if (task == nullptr || !task->kind->traits().places_model || !model_) return false;
  model_->place(session_, calibration_bench_->now_ns(), sink_.renderer());
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
