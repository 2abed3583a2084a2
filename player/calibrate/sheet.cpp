#include "calibrate/sheet.hpp"

#include "calibrate/guide_panel.hpp"

namespace vrda {
namespace {

constexpr int samples_of_sheet = 1;  // lines are smooth by themselves

Eigen::Vector2d placed(const SheetFrame& frame, const Eigen::Vector2d& p_px)
{
  return frame.at_px + frame.scale * (p_px - frame.source.low_px);
}

}  // namespace

Sheet::Sheet(int width, int height)
    : renderer_(make_offscreen_renderer({width, height, samples_of_sheet, 0.0})), text_(text_px)
{
  nothing_.background = background_of(Backdrop::black);
  renderer_->load(nothing_);
  renderer_->load(text_.font());
  empty_overlay(overlay_, width, height);
}

OverlayBox Sheet::clip_of(const SheetFrame& frame) const
{
  // An outline about the whole is not cut in halves.
  constexpr float rim_px = 2.0F;
  const Eigen::Vector2f low = placed(frame, frame.source.low_px).cast<float>();
  const Eigen::Vector2f high = placed(frame, frame.source.high_px).cast<float>();
  return {low.x() - rim_px, low.y() - rim_px, high.x() + rim_px, high.y() + rim_px};
}

void Sheet::add_lines(const SheetFrame& frame, std::span<const GuideLine> lines)
{
  clip_overlay(overlay_, clip_of(frame));
  for (GuideLine line : lines) {
    for (Eigen::Vector2d& p : line.points_px) p = placed(frame, p);
    line.is_smooth = true;
    add_guide_line(overlay_, text_, line);
  }
}

void Sheet::add_area(const SheetFrame& frame, const ShownBox& box, const VertexColour& colour)
{
  clip_overlay(overlay_, clip_of(frame));
  const Eigen::Vector2f low = placed(frame, box.low_px).cast<float>();
  const Eigen::Vector2f high = placed(frame, box.high_px).cast<float>();
  text_.add_area(overlay_, {low.x(), low.y(), high.x(), high.y()}, colour);
}

void Sheet::add_words(const Eigen::Vector2d& at_px, const std::string& words, const VertexColour& colour)
{
  clip_overlay(overlay_,
               {0.0F, 0.0F, static_cast<float>(renderer_->width()), static_cast<float>(renderer_->height())});
  const Eigen::Vector2f at = at_px.cast<float>();
  text_.add_words(overlay_, at.x(), at.y(), words, colour);
}

const Image& Sheet::image()
{
  close_overlay(overlay_);
  return renderer_->draw(nothing_, {}, &overlay_);
}

GuideLine outline_of(const ShownBox& box, const std::array<float, 3>& colour, double width_px)
{
  const Eigen::Vector2d &low = box.low_px, &high = box.high_px;
  GuideLine line;
  line.points_px = {low, {high.x(), low.y()}, high, {low.x(), high.y()}, low};
  line.width_px = width_px;
  line.colour = colour;
  return line;
}

}  // namespace vrda
