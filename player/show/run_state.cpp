#include "show/run_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ostream>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda::show {
namespace {

using view::faint, view::ink, view::margin_px, view::paper;

constexpr view::VertexColour frame_colour{255, 255, 255, 255};
constexpr float largest_cell_px = 48.0F;
constexpr float ruled_from_px = 5.0F;  // smaller cells are drawn without gaps

std::string label_of(StepStatus status)
{
  std::string words = name_of(status);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

/// Position of the map and size of its cells.
struct MapLayout {
  float left_px = 0.0F, top_px = 0.0F, cell_width_px = 0.0F, cell_height_px = 0.0F;

  view::OverlayBox cell(Eigen::Index i, Eigen::Index j) const
  {
    const float x = left_px + cell_width_px * static_cast<float>(j);
    const float y = top_px + cell_height_px * static_cast<float>(i);
    return {x, y, x + cell_width_px, y + cell_height_px};
  }
};

class PanelDrawing {
 public:
  PanelDrawing(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& area,
               const RunPanel& panel)
      : overlay_(overlay),
        text_(text),
        panel_(panel),
        left_px_(static_cast<float>(area.x) + margin_px),
        right_px_(static_cast<float>(area.x + area.width) - margin_px),
        y_px_(static_cast<float>(area.y) + margin_px),
        bottom_px_(static_cast<float>(area.y + area.height) - margin_px)
  {
    text_.add_area(overlay_, view::overlay_box(area), paper);
  }

  void draw()
  {
    add_line(panel_.title, ink);
    for (const std::string& line : panel_.lines) add_line(line, faint);
    y_px_ += 0.5F * text_.line_px();
    const float legend_px = text_.line_px() * static_cast<float>(std::size(all_step_statuses));
    draw_map(bottom_px_ - legend_px - text_.line_px());
    y_px_ = bottom_px_ - legend_px;
    for (const StepStatus status : all_step_statuses) add_legend(status);
  }

 private:
  void add_line(const std::string& words, const view::VertexColour& colour)
  {
    text_.add_text(overlay_, left_px_, y_px_, text_.fitted(words, right_px_ - left_px_), colour);
    y_px_ += text_.line_px();
  }

  void draw_map(float bottom_px)
  {
    const auto n_flexion = static_cast<float>(panel_.status.rows());
    const auto n_varus = static_cast<float>(panel_.status.cols());
    const float label_px = 1.3F * std::max(text_.width_px("flexion"), text_.width_px("-180"));
    MapLayout place;
    place.left_px = left_px_ + label_px;
    place.top_px = y_px_ + 2.0F * text_.line_px();
    place.cell_width_px = std::min((right_px_ - place.left_px) / n_varus, largest_cell_px);
    place.cell_height_px = std::min((bottom_px - place.top_px) / n_flexion, largest_cell_px);
    if (place.cell_width_px <= 0.0F || place.cell_height_px <= 0.0F) return;  // no room for the map
    draw_cells(place);
    label_flexion(place);
    label_varus(place);
  }

  void draw_cells(const MapLayout& place)
  {
    const float gap_px = std::min(place.cell_width_px, place.cell_height_px) >= ruled_from_px ? 1.0F : 0.0F;
    for (Eigen::Index i = 0; i < panel_.status.rows(); ++i) {
      for (Eigen::Index j = 0; j < panel_.status.cols(); ++j) {
        view::OverlayBox box = place.cell(i, j);
        box.right_px -= gap_px;
        box.bottom_px -= gap_px;
        text_.add_area(overlay_, box, colour_of(static_cast<StepStatus>(panel_.status(i, j))));
      }
    }
    if (panel_.current) frame_cell(place.cell(panel_.current->flexion, panel_.current->varus));
  }

  void frame_cell(const view::OverlayBox& box)
  {
    constexpr float line_px = 2.0F;
    const view::OverlayBox out{box.left_px - line_px, box.top_px - line_px, box.right_px + line_px,
                              box.bottom_px + line_px};
    text_.add_area(overlay_, {out.left_px, out.top_px, out.right_px, box.top_px}, frame_colour);
    text_.add_area(overlay_, {out.left_px, box.bottom_px, out.right_px, out.bottom_px}, frame_colour);
    text_.add_area(overlay_, {out.left_px, box.top_px, box.left_px, box.bottom_px}, frame_colour);
    text_.add_area(overlay_, {box.right_px, box.top_px, out.right_px, box.bottom_px}, frame_colour);
  }

  void label_flexion(const MapLayout& place)
  {
    const auto n = static_cast<Eigen::Index>(panel_.flexion_deg.size());
    const float step_px = std::max(place.cell_height_px, 1.0F);
    const auto every = static_cast<Eigen::Index>(std::ceil(1.6F * text_.line_px() / step_px));
    for (Eigen::Index i = 0; i < n; i += every) {
      const std::string words = shortest_decimal(panel_.flexion_deg[static_cast<std::size_t>(i)]);
      const float y = place.cell(i, 0).top_px + 0.5F * (place.cell_height_px - text_.line_px());
      text_.add_text(overlay_, place.left_px - text_.width_px(words) - 6.0F, y, words, faint);
    }
    text_.add_text(overlay_, left_px_, place.top_px - 2.0F * text_.line_px(), "flexion", faint);
  }

  void label_varus(const MapLayout& place)
  {
    const auto n = static_cast<Eigen::Index>(panel_.varus_deg.size());
    float widest_px = 0.0F;
    for (const double varus_deg : panel_.varus_deg)
      widest_px = std::max(widest_px, text_.width_px(shortest_decimal(varus_deg) + " "));
    auto every = static_cast<Eigen::Index>(std::ceil(1.3F * widest_px / place.cell_width_px));
    // Prefer intervals that label both ends and the middle.
    while (n > 1 && every < n - 1 && (n - 1) % every != 0) ++every;
    for (Eigen::Index j = 0; j < n; j += every) {
      const std::string words = shortest_decimal(panel_.varus_deg[static_cast<std::size_t>(j)]);
      const float x = place.cell(0, j).left_px + 0.5F * (place.cell_width_px - text_.width_px(words));
      text_.add_text(overlay_, x, place.top_px - text_.line_px(), words, faint);
    }
    text_.add_text(overlay_, place.left_px, place.top_px - 2.0F * text_.line_px(), "varus, degrees", faint);
  }

  void add_legend(StepStatus status)
  {
    const auto n = (panel_.status == static_cast<std::int8_t>(status)).count();
    const float side_px = 0.7F * text_.line_px(), top_px = y_px_ + 0.1F * text_.line_px();
    text_.add_area(overlay_, {left_px_, top_px, left_px_ + side_px, top_px + side_px}, colour_of(status));
    text_.add_text(overlay_, left_px_ + 1.2F * text_.line_px(), y_px_,
                   std::to_string(n) + " " + label_of(status), n > 0 ? ink : faint);
    y_px_ += text_.line_px();
  }

  view::Overlay& overlay_;
  const view::OverlayText& text_;
  const RunPanel& panel_;
  float left_px_, right_px_, y_px_, bottom_px_;
};

}  // namespace

// Colour-blind safe palette. Source: Okabe and Ito (2008), Color universal design.
view::VertexColour colour_of(StepStatus status)
{
  // In the order of StepStatus, from pending (-1) on.
  constexpr std::array<view::VertexColour, 7> colours{{{58, 63, 71, 255},
                                                        {0, 158, 115, 255},
                                                        {86, 180, 233, 255},
                                                        {213, 94, 0, 255},
                                                        {240, 228, 66, 255},
                                                        {204, 121, 167, 255},
                                                        {0, 114, 178, 255}}};
  return colours.at(static_cast<std::size_t>(static_cast<int>(status) + 1));
}

void add_panel(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& area,
               const RunPanel& panel)
{
  PanelDrawing(overlay, text, area, panel).draw();
}

void add_label(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& tile,
               const std::string& name)
{
  const float left_px = static_cast<float>(tile.x) + margin_px;
  const float top_px = static_cast<float>(tile.y) + 0.5F * margin_px;
  const view::OverlayBox plate{left_px - 0.5F * margin_px, top_px,
                              left_px + text.width_px(name) + 0.5F * margin_px, top_px + text.line_px()};
  text.add_area(overlay, plate, {paper[0], paper[1], paper[2], 150});
  text.add_text(overlay, left_px, top_px + 0.1F * text.line_px(), name, ink);
}

const std::vector<std::string>& step_choice_names()
{
  static const std::vector<std::string> names{"stable", "contact", "all"};
  return names;
}

RunState::RunState(const store::MotionModel& model, StepChoice choice)
    : choice_(choice),
      title_(model.title),
      flexion_deg_(model.flexion_deg),
      varus_deg_(model.varus_deg),
      status_(store::GridB::Constant(model.status.rows(), model.status.cols(), status_pending))
{
}

bool RunState::is_chosen(const RunStep& step) const
{
  switch (choice_) {
    case StepChoice::stable:
      return step.kind == RunStepKind::cell && step.status == StepStatus::stable;
    case StepChoice::contact:
      return step.kind == RunStepKind::move ? step.in_contact : step.status == StepStatus::stable;
    case StepChoice::all:
      return true;
  }
  throw InternalError("unknown step choice");
}

bool RunState::add_step(const RunStep& step)
{
  // For steps with free varus, key.varus is the index of a start, not of a cell.
  const bool is_at_cell = step.key.kind <= StepKind::row;
  if (is_at_cell) current_ = GridCell{step.key.flexion, step.key.varus};
  if (step.kind == RunStepKind::cell) {
    std::int8_t& status = status_(step.key.flexion, step.key.varus);
    n_done_ += status == status_pending ? 1 : 0;
    status = static_cast<std::int8_t>(step.status);
  }
  if (!is_chosen(step)) return false;
  shown_ = step;
  ++n_shown_;
  return true;
}

void RunState::finish(const store::MotionModel& result)
{
  status_ = result.status;
  n_done_ = static_cast<int>((status_ != status_pending).count());
  current_.reset();
  shown_.reset();
  is_finished_ = true;
}

std::string RunState::progress_text() const
{
  const std::string text = std::to_string(n_done_) + "/" + std::to_string(status_.size()) + " attitudes";
  return is_finished_ ? text + ", finished" : text;
}

std::string RunState::current_attitude() const
{
  if (!current_) return {};
  return "flexion " + shortest_decimal(flexion_deg_[static_cast<std::size_t>(current_->flexion)]) +
         ", varus " + shortest_decimal(varus_deg_[static_cast<std::size_t>(current_->varus)]);
}

RunPanel RunState::panel() const
{
  RunPanel panel{
      title_.empty() ? "untitled" : title_, {progress_text()}, flexion_deg_, varus_deg_, status_, current_};
  if (current_) panel.lines.push_back(current_attitude());
  return panel;
}

namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds between_lines{2};

std::string progress_line(const RunState& state, int n_steps, const std::string& rate)
{
  if (n_steps == 0 && !state.is_finished()) return "waiting for the first step";
  std::string line = state.progress_text();
  if (state.n_done() == 0) line += ", " + std::to_string(n_steps) + " steps of the spine";
  for (const std::string& more : {state.current_attitude(), rate}) line += more.empty() ? "" : ", " + more;
  return line;
}

}  // namespace

void FollowProgress::update_rate(int n_done, int n_cells)
{
  if (n_first_ < 0) {
    n_first_ = n_done;
    first_ = steady_clock::now();
  }
  rate_.clear();
  const double seconds = std::chrono::duration<double>(steady_clock::now() - first_).count();
  const int n_new = n_done - n_first_;
  if (n_new <= 0 || seconds <= 0.0) return;
  const double rate = n_new / seconds;
  const auto left_s = std::lround((n_cells - n_done) / rate);
  char text[80];
  std::snprintf(text, sizeof text, "%.3g/s, %ld:%02ld left", rate, left_s / 60, left_s % 60);
  rate_ = text;
}

void FollowProgress::report_state(const RunState& state, int n_steps, bool is_due)
{
  if (!is_due && steady_clock::now() - said_ < between_lines) return;
  const std::string line = progress_line(state, n_steps, state.is_finished() ? "" : rate_);
  if (line != last_) report_line(line);
}

void FollowProgress::report_line(const std::string& line)
{
  last_ = line;
  said_ = steady_clock::now();
  if (!is_quiet_) stream_ << line << std::endl;
}

}  // namespace vrda::show
