/// Words and areas over the picture, without controls, and their font.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "render/renderer.hpp"

namespace vrda {

/// As the program carries it: gzip, half as large.
std::string_view compressed_font_file();

/// The bytes of a TrueType file.
std::string font_file();

/// A place in the picture, in pixels from its top left corner.
struct OverlayBox {
  float left_px = 0.0F, top_px = 0.0F, right_px = 0.0F, bottom_px = 0.0F;
};

/// One size of the program's font.
class OverlayText {
 public:
  explicit OverlayText(double size_px);
  ~OverlayText();
  OverlayText(const OverlayText&) = delete;
  OverlayText& operator=(const OverlayText&) = delete;

  /// For Renderer::load, once.
  const OverlayFont& font() const;
  float line_px() const;  ///< from one line to the next
  float width_px(std::string_view words) const;

  /// One line, its upper left corner at a place rounded to whole pixels. UTF-8 is not known: other than
  /// printable ASCII is a question mark.
  void add_words(Overlay& overlay, float left_px, float top_px, std::string_view words,
                 const VertexColour& colour) const;
  void add_area(Overlay& overlay, const OverlayBox& box, const VertexColour& colour) const;
  /// Through two or more points, in pixels; its edges fade over a pixel, so that it stands where it is meant
  /// to parts of a pixel. A turn of more than 120 degrees is cut short.
  void add_line(Overlay& overlay, std::span<const Eigen::Vector2d> points_px, double width_px,
                const VertexColour& colour) const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Makes it as large as the picture, with nothing in it yet; keeps its memory.
void empty_overlay(Overlay& overlay, int width, int height);

/// What is added from now on is cut off at the box.
void clip_overlay(Overlay& overlay, const OverlayBox& box);

/// What was added after empty_overlay() is drawn. Wanted once, before the overlay is.
void close_overlay(Overlay& overlay);

}  // namespace vrda
