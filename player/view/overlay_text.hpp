/// Text, areas and lines in an overlay, without controls, and their font.
#pragma once

#include <Eigen/Core>

#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "view/layers.hpp"
#include "view/renderer.hpp"

struct ImFontAtlas;

namespace vrda::view {

/// The embedded font, gzip-compressed.
std::string_view compressed_font_file();

/// Rasterises the font into the atlas of the interface library.
OverlayFont built_font(ImFontAtlas& atlas, double size_px);

/// A rectangle in pixels from the top left corner of the window.
struct OverlayBox {
  float left_px = 0.0F, top_px = 0.0F, right_px = 0.0F, bottom_px = 0.0F;
};
OverlayBox overlay_box(const Viewport& v);

/// Height and margin of the text of panels, and their colours.
inline constexpr double panel_text_px = 15.0;
inline constexpr float margin_px = 12.0F;
inline constexpr VertexColour paper{24, 27, 32, 255}, ink{226, 230, 235, 255}, faint{150, 157, 166, 255},
    amber{255, 176, 46, 255}, green{96, 200, 120, 255}, red{240, 92, 84, 255};

/// One size of the program's font.
class OverlayText {
 public:
  explicit OverlayText(double size_px);
  ~OverlayText();

  /// For Renderer::load, once.
  const OverlayFont& font() const;
  float line_px() const;  ///< line spacing
  float width_px(std::string_view words) const;
  /// The words, cut with a dot where they are wider.
  std::string fitted(std::string words, float width_px) const;

  /// Adds one line of text, its upper left corner rounded to whole pixels. Bytes other than printable ASCII
  /// are drawn as question marks.
  void add_text(Overlay& overlay, float left_px, float top_px, std::string_view words,
                const VertexColour& colour) const;
  void add_area(Overlay& overlay, const OverlayBox& box, const VertexColour& colour) const;
  /// Adds an anti-aliased line through two or more points, in pixels, with sub-pixel accuracy. Mitres are
  /// limited at turns of more than 120 degrees.
  void add_line(Overlay& overlay, std::span<const Eigen::Vector2d> points_px, double width_px,
                const VertexColour& colour) const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Reflects what an overlay draws within the windows of the eyes, as their frames are.
class OverlayReflector {
 public:
  OverlayReflector(const EyeWindows& windows, const Reflection& reflection)
      : windows_{windows.left, windows.right}, reflection_(reflection)
  {
  }
  /// Moves triangles whose centre is in a window, and boxes that clip to a part of one. Does not allocate
  /// once an overlay of this size was reflected.
  void reflect(Overlay& overlay);

 private:
  std::array<Viewport, 2> windows_;
  Reflection reflection_;
  std::vector<bool> is_done_;  ///< by vertex
};

/// Clears the overlay and sets its size in pixels; keeps its memory.
void clear_overlay(Overlay& overlay, int width, int height);

/// Clips everything added afterwards to the box.
void clip_overlay(Overlay& overlay, const OverlayBox& box);

/// Completes the overlay; must be called once before it is drawn.
void finish_overlay(Overlay& overlay);

}  // namespace vrda::view
