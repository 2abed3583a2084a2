#include "follow/run_panel.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/number_text.hpp"

namespace vrda {
namespace {

constexpr VertexColour paper{24, 27, 32, 255}, ink{226, 230, 235, 255}, faint{150, 157, 166, 255},
    frame_colour{255, 255, 255, 255};
constexpr float margin_px = 12.0F;
constexpr float largest_cell_px = 48.0F;
constexpr float ruled_from_px = 5.0F;  // smaller cells have no gaps between them

std::string words_of(StepStatus status)
{
  std::string words = name_of(status);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

/// Where the map lies and how large its cells are.
struct MapPlace {
  float left_px = 0.0F, top_px = 0.0F, cell_width_px = 0.0F, cell_height_px = 0.0F;

  OverlayBox cell(Eigen::Index i, Eigen::Index j) const
  {
    const float x = left_px + cell_width_px * static_cast<float>(j);
    const float y = top_px + cell_height_px * static_cast<float>(i);
    return {x, y, x + cell_width_px, y + cell_height_px};
  }
};

std::string fitting(const OverlayText& text, std::string words, float width_px)
{
  while (words.size() > 1 && text.width_px(words) > width_px) {
    words.resize(words.size() - 1);
    words.back() = '.';
  }
  return words;
}

class PanelDrawing {
 public:
  PanelDrawing(Overlay& overlay, const OverlayText& text, const Viewport& area, const RunPanel& panel)
      : overlay_(overlay),
        text_(text),
        panel_(panel),
        left_px_(static_cast<float>(area.x) + margin_px),
        right_px_(static_cast<float>(area.x + area.width) - margin_px),
        y_px_(static_cast<float>(area.y) + margin_px),
        bottom_px_(static_cast<float>(area.y + area.height) - margin_px)
  {
    text_.add_area(overlay_,
                   {static_cast<float>(area.x), static_cast<float>(area.y),
                    static_cast<float>(area.x + area.width), static_cast<float>(area.y + area.height)},
                   paper);
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
  void add_line(const std::string& words, const VertexColour& colour)
  {
    text_.add_words(overlay_, left_px_, y_px_, fitting(text_, words, right_px_ - left_px_), colour);
    y_px_ += text_.line_px();
  }

  void draw_map(float bottom_px)
  {
    const auto n_flexion = static_cast<float>(panel_.status.rows());
    const auto n_varus = static_cast<float>(panel_.status.cols());
    const float label_px = 1.3F * std::max(text_.width_px("flexion"), text_.width_px("-180"));
    MapPlace place;
    place.left_px = left_px_ + label_px;
    place.top_px = y_px_ + 2.0F * text_.line_px();
    place.cell_width_px = std::min((right_px_ - place.left_px) / n_varus, largest_cell_px);
    place.cell_height_px = std::min((bottom_px - place.top_px) / n_flexion, largest_cell_px);
    if (place.cell_width_px <= 0.0F || place.cell_height_px <= 0.0F) return;  // a tiny picture
    draw_cells(place);
    label_flexion(place);
    label_varus(place);
  }

  void draw_cells(const MapPlace& place)
  {
    const float gap_px = std::min(place.cell_width_px, place.cell_height_px) >= ruled_from_px ? 1.0F : 0.0F;
    for (Eigen::Index i = 0; i < panel_.status.rows(); ++i) {
      for (Eigen::Index j = 0; j < panel_.status.cols(); ++j) {
        OverlayBox box = place.cell(i, j);
        box.right_px -= gap_px;
        box.bottom_px -= gap_px;
        text_.add_area(overlay_, box, colour_of(static_cast<StepStatus>(panel_.status(i, j))));
      }
    }
    if (panel_.current) frame_cell(place.cell(panel_.current->flexion, panel_.current->varus));
  }

  void frame_cell(const OverlayBox& box)
  {
    constexpr float line_px = 2.0F;
    const OverlayBox out{box.left_px - line_px, box.top_px - line_px, box.right_px + line_px,
                         box.bottom_px + line_px};
    text_.add_area(overlay_, {out.left_px, out.top_px, out.right_px, box.top_px}, frame_colour);
    text_.add_area(overlay_, {out.left_px, box.bottom_px, out.right_px, out.bottom_px}, frame_colour);
    text_.add_area(overlay_, {out.left_px, box.top_px, box.left_px, box.bottom_px}, frame_colour);
    text_.add_area(overlay_, {box.right_px, box.top_px, out.right_px, box.bottom_px}, frame_colour);
  }

  void label_flexion(const MapPlace& place)
  {
    const auto n = static_cast<Eigen::Index>(panel_.flexion_deg.size());
    const float step_px = std::max(place.cell_height_px, 1.0F);
    const auto every = static_cast<Eigen::Index>(std::ceil(1.6F * text_.line_px() / step_px));
    for (Eigen::Index i = 0; i < n; i += every) {
      const std::string words = shortest(panel_.flexion_deg[static_cast<std::size_t>(i)]);
      const float y = place.cell(i, 0).top_px + 0.5F * (place.cell_height_px - text_.line_px());
      text_.add_words(overlay_, place.left_px - text_.width_px(words) - 6.0F, y, words, faint);
    }
    text_.add_words(overlay_, left_px_, place.top_px - 2.0F * text_.line_px(), "flexion", faint);
  }

  void label_varus(const MapPlace& place)
  {
    const auto n = static_cast<Eigen::Index>(panel_.varus_deg.size());
    float widest_px = 0.0F;
    for (const double varus_deg : panel_.varus_deg)
      widest_px = std::max(widest_px, text_.width_px(shortest(varus_deg) + " "));
    auto every = static_cast<Eigen::Index>(std::ceil(1.3F * widest_px / place.cell_width_px));
    // Both ends and the middle carry numbers where they can.
    while (n > 1 && every < n - 1 && (n - 1) % every != 0) ++every;
    for (Eigen::Index j = 0; j < n; j += every) {
      const std::string words = shortest(panel_.varus_deg[static_cast<std::size_t>(j)]);
      const float x = place.cell(0, j).left_px + 0.5F * (place.cell_width_px - text_.width_px(words));
      text_.add_words(overlay_, x, place.top_px - text_.line_px(), words, faint);
    }
    text_.add_words(overlay_, place.left_px, place.top_px - 2.0F * text_.line_px(), "varus, degrees", faint);
  }

  void add_legend(StepStatus status)
  {
    const auto n = (panel_.status == static_cast<std::int8_t>(status)).count();
    const float side_px = 0.7F * text_.line_px(), top_px = y_px_ + 0.1F * text_.line_px();
    text_.add_area(overlay_, {left_px_, top_px, left_px_ + side_px, top_px + side_px}, colour_of(status));
    text_.add_words(overlay_, left_px_ + 1.2F * text_.line_px(), y_px_,
                    std::to_string(n) + " " + words_of(status), n > 0 ? ink : faint);
    y_px_ += text_.line_px();
  }

  Overlay& overlay_;
  const OverlayText& text_;
  const RunPanel& panel_;
  float left_px_, right_px_, y_px_, bottom_px_;
};

}  // namespace

// Colours that colour-blind eyes tell apart. Source: Okabe and Ito (2008), Color universal design.
VertexColour colour_of(StepStatus status)
{
  switch (status) {
    case StepStatus::pending:
      return {58, 63, 71, 255};
    case StepStatus::stable:
      return {0, 158, 115, 255};
    case StepStatus::no_contact:
      return {86, 180, 233, 255};
    case StepStatus::no_clearance:
      return {213, 94, 0, 255};
    case StepStatus::iteration_limit:
      return {240, 228, 66, 255};
    case StepStatus::unbounded:
      return {204, 121, 167, 255};
    case StepStatus::overlapping:
      return {0, 114, 178, 255};
  }
  throw InternalError("a status without a colour");
}

void add_panel(Overlay& overlay, const OverlayText& text, const Viewport& area, const RunPanel& panel)
{
  PanelDrawing(overlay, text, area, panel).draw();
}

void add_label(Overlay& overlay, const OverlayText& text, const Viewport& tile, const std::string& name)
{
  const float left_px = static_cast<float>(tile.x) + margin_px;
  const float top_px = static_cast<float>(tile.y) + 0.5F * margin_px;
  const OverlayBox plate{left_px - 0.5F * margin_px, top_px, left_px + text.width_px(name) + 0.5F * margin_px,
                         top_px + text.line_px()};
  text.add_area(overlay, plate, {paper[0], paper[1], paper[2], 150});
  text.add_words(overlay, left_px, top_px + 0.1F * text.line_px(), name, ink);
}

}  // namespace vrda
