/// A picture made of lines and words.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "gui/overlay_text.hpp"
#include "guide/drawing.hpp"
#include "optics/eye.hpp"
#include "render/renderer.hpp"

namespace vrda {

/// A part of a frame buffer, as large as it is shown within the sheet.
struct SheetFrame {
  ShownBox source;
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();  ///< of the sheet: its upper left corner
  double scale = 1.0;                               ///< px of the sheet by px of the frame buffer
};

class Sheet {
 public:
  Sheet(int width, int height);

  /// Lines keep their width; what lies beyond the frame is cut off.
  void add_lines(const SheetFrame& frame, std::span<const GuideLine> lines);
  void add_area(const SheetFrame& frame, const ShownBox& box, const VertexColour& colour);
  /// `at_px`: of the sheet.
  void add_words(const Eigen::Vector2d& at_px, const std::string& words, const VertexColour& colour);
  float width_px(const std::string& words) const { return text_.width_px(words); }

  /// Valid until the next.
  const Image& image();

 private:
  OverlayBox clip_of(const SheetFrame& frame) const;

  std::unique_ptr<Renderer> renderer_;
  OverlayText text_;
  Overlay overlay_;
  Scene nothing_;
};

/// The outline of a box, as a closed line.
GuideLine outline_of(const ShownBox& box, const std::array<float, 3>& colour, double width_px = 1.5);

}  // namespace vrda
