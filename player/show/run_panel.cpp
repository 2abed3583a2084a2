#include "show/run_panel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

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
               const RunGrid& grid)
      : overlay_(overlay),
        text_(text),
        grid_(grid),
        left_px_(static_cast<float>(area.x) + margin_px),
        right_px_(static_cast<float>(area.x + area.width) - margin_px),
        y_px_(static_cast<float>(area.y) + margin_px),
        bottom_px_(static_cast<float>(area.y + area.height) - margin_px)
  {
    text_.add_area(overlay_, view::overlay_box(area), paper);
  }

  void draw(const std::vector<std::string>& lines)
  {
    add_line(grid_.title, ink);
    for (const std::string& line : lines) add_line(line, faint);
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
    const auto n_flexion = static_cast<float>(grid_.status.rows());
    const auto n_varus = static_cast<float>(grid_.status.cols());
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
    for (Eigen::Index i = 0; i < grid_.status.rows(); ++i) {
      for (Eigen::Index j = 0; j < grid_.status.cols(); ++j) {
        view::OverlayBox box = place.cell(i, j);
        box.right_px -= gap_px;
        box.bottom_px -= gap_px;
        text_.add_area(overlay_, box, colour_of(static_cast<StepStatus>(grid_.status(i, j))));
      }
    }
    if (grid_.current) frame_cell(place.cell(grid_.current->flexion, grid_.current->varus));
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
    const auto n = static_cast<Eigen::Index>(grid_.flexion_deg.size());
    const float step_px = std::max(place.cell_height_px, 1.0F);
    const auto every = static_cast<Eigen::Index>(std::ceil(1.6F * text_.line_px() / step_px));
    for (Eigen::Index i = 0; i < n; i += every) {
      const std::string words = shortest_decimal(grid_.flexion_deg[static_cast<std::size_t>(i)]);
      const float y = place.cell(i, 0).top_px + 0.5F * (place.cell_height_px - text_.line_px());
      text_.add_text(overlay_, place.left_px - text_.width_px(words) - 6.0F, y, words, faint);
    }
    text_.add_text(overlay_, left_px_, place.top_px - 2.0F * text_.line_px(), "flexion", faint);
  }

  void label_varus(const MapLayout& place)
  {
    const auto n = static_cast<Eigen::Index>(grid_.varus_deg.size());
    float widest_px = 0.0F;
    for (const double varus_deg : grid_.varus_deg)
      widest_px = std::max(widest_px, text_.width_px(shortest_decimal(varus_deg) + " "));
    auto every = static_cast<Eigen::Index>(std::ceil(1.3F * widest_px / place.cell_width_px));
    // Prefer intervals that label both ends and the middle.
    while (n > 1 && every < n - 1 && (n - 1) % every != 0) ++every;
    for (Eigen::Index j = 0; j < n; j += every) {
      const std::string words = shortest_decimal(grid_.varus_deg[static_cast<std::size_t>(j)]);
      const float x = place.cell(0, j).left_px + 0.5F * (place.cell_width_px - text_.width_px(words));
      text_.add_text(overlay_, x, place.top_px - text_.line_px(), words, faint);
    }
    text_.add_text(overlay_, place.left_px, place.top_px - 2.0F * text_.line_px(), "varus, degrees", faint);
  }

  void add_legend(StepStatus status)
  {
    const auto n = (grid_.status == static_cast<std::int8_t>(status)).count();
    const float side_px = 0.7F * text_.line_px(), top_px = y_px_ + 0.1F * text_.line_px();
    text_.add_area(overlay_, {left_px_, top_px, left_px_ + side_px, top_px + side_px}, colour_of(status));
    text_.add_text(overlay_, left_px_ + 1.2F * text_.line_px(), y_px_,
                   std::to_string(n) + " " + label_of(status), n > 0 ? ink : faint);
    y_px_ += text_.line_px();
  }

  view::Overlay& overlay_;
  const view::OverlayText& text_;
  const RunGrid& grid_;
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
               const RunGrid& grid, const std::vector<std::string>& lines)
{
  PanelDrawing(overlay, text, area, grid).draw(lines);
}

}  // namespace vrda::show
