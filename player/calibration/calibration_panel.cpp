#include "calibration/calibration_panel.hpp"

#include <algorithm>
#include <cmath>

#include "bench/bench_panel.hpp"
#include "show/settings_text.hpp"

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

/// Twice what a careful hand is off, and ten: repeat it.
view::VertexColour colour_of_deviation(double value)
{
  return value > large_deviation ? view::red : value > fair_deviation ? view::amber : view::green;
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
  return dial.name + " " + show::rounded_text(value, decimals_of_step(dial.step)) +
         (dial.unit.empty() ? "" : " " + dial.unit);
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
    if (content.boxes) view::clip_overlay(overlay_, overlay_box((*content.boxes)[is_right ? 1 : 0]));
    for (const DrawnLine& line : content.lines)
      if (line.is_right == is_right) add_drawn_line(overlay_, text_, line);
  }
  view::clip_overlay(overlay_,
                    {0.0F, 0.0F, static_cast<float>(display_.width), static_cast<float>(display_.height)});
}

void CalibrationPanel::add_wrapped(std::vector<TextLine>& lines, const std::string& text,
                                   const view::VertexColour& colour, float width_px) const
{
  std::string line, word;
  const auto end_word = [&] {
    const std::string longer = line.empty() ? word : line + " " + word;
    if (!line.empty() && text_.width_px(longer) > width_px) {
      lines.push_back({line, colour});
      line = word;
    } else {
      line = longer;
    }
    word.clear();
  };
  for (const char c : text + "\n") {
    if (c != ' ' && c != '\n') {
      word += c;
      continue;
    }
    end_word();
    if (c == '\n') {
      lines.push_back({line, colour});
      line.clear();
    }
  }
}

void CalibrationPanel::add_task(std::vector<TextLine>& lines, const CalibrationSession& session,
                                const CalibrationPanelContent& content, float width_px) const
{
  const Task& task = *session.task();
  const CalibrationProgress& progress = session.progress();
  add_wrapped(lines,
              "Part " + std::to_string(progress.number) + " of " + std::to_string(progress.n_parts) + ": " +
                  bench::name_of(progress.part) + ", " + std::to_string(progress.n_done + 1) + " of " +
                  std::to_string(progress.n_tasks) + ", " + task.name,
              faint, width_px);
  add_wrapped(lines,
              std::to_string(std::lround(100.0 * calibration::overall_progress(progress))) +
                  " % of all parts done, about " + minutes_text(content.time_left_s) + " left",
              faint, width_px);
  add_wrapped(lines, task.instruction, ink, width_px);
  // One or two dials have their own keys; of more dials one is selected.
  const bool is_selecting = task.dials.size() > 2;
  for (std::size_t k = 0; k < task.dials.size(); ++k) {
    const bool is_live = !is_selecting || k == session.selected_dial();
    const std::string mark = !is_selecting ? (k == 0 ? "Left, Right: " : "Up, Down: ")
                             : is_live     ? "> "
                                           : "- ";
    add_wrapped(lines, mark + dial_text(task.dials[k], session.values()[k]), is_live ? view::green : ink,
                width_px);
  }
  if (progress.is_sampling) {
    add_wrapped(lines,
                std::to_string(progress.n_samples) + " of " + std::to_string(task.n_samples) +
                    " samples of " + task.tool,
                view::green, width_px);
  }
}

std::vector<CalibrationPanel::TextLine> CalibrationPanel::lines_of(const CalibrationSession& session,
                                                                   const CalibrationPanelContent& content,
                                                                   float width_px) const
{
  std::vector<TextLine> lines;
  if (content.has_help) {
    for (const view::HelpLine& help : calibration::session_key_lines())
      add_wrapped(lines, std::string(help.keys) + ": " + help.description, ink, width_px);
    add_wrapped(lines, "H: back to the task", ink, width_px);
    return lines;
  }
  if (session.task() != nullptr) {
    add_task(lines, session, content, width_px);
  } else {
    add_wrapped(lines, "All requested parts are done. Enter: quit", view::green, width_px);
  }
  const CalibrationProgress& progress = session.progress();
  if (!content.deviation.empty())
    add_wrapped(lines, content.deviation, colour_of_deviation(content.deviation_value), width_px);
  for (const std::string& line : progress.messages)
    add_wrapped(lines, line, progress.has_error ? view::amber : view::green, width_px);
  for (const std::string& note : content.notes) add_wrapped(lines, note, ink, width_px);
  for (const std::string& error_message : content.error_messages)
    add_wrapped(lines, error_message, view::amber, width_px);
  if (!content.message.empty()) add_wrapped(lines, content.message, view::amber, width_px);
  if (session.task() == nullptr) {
    add_wrapped(lines, "To repeat a part: vrda-player calibrate PART --anew", faint, width_px);
  } else {
    add_wrapped(lines,
                progress.is_sampling ? "Backspace: stop sampling. R: take back this part"
                                     : "Backspace: take back the previous task. R: take back this part",
                faint, width_px);
  }
  add_wrapped(lines, "H: keys", faint, width_px);
  return lines;
}

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
  const std::vector<TextLine> lines =
      lines_of(session, content, static_cast<float>(home.width) - 2.0F * margin_px);
  const float height_px = text_.line_px() * static_cast<float>(lines.size());
  float top_px = area ? static_cast<float>(home.y) + margin_px
                      : static_cast<float>(home.y + home.height) - margin_px - height_px;
  for (const TextLine& line : lines) {
    text_.add_text(overlay_, static_cast<float>(home.x) + margin_px, top_px, line.text, line.colour);
    top_px += text_.line_px();
  }
  if (area && content.diagram && !content.has_help) add_diagram(*content.diagram, *area, top_px + margin_px);
  view::finish_overlay(overlay_);
  reflector_.reflect(overlay_);
  return overlay_;
}

}  // namespace vrda::calibration
