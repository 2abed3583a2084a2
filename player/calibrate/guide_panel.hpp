/// Screen of the calibration session: lines of the task and text for the operator.
#pragma once

#include <optional>
#include <string>

#include "gui/overlay_text.hpp"
#include "guide/drawing.hpp"
#include "guide/session.hpp"
#include "optics/eye.hpp"

namespace vrda {

/// Text height and colours of the panel and of sheets.
inline constexpr double text_px = 15.0;
inline constexpr VertexColour ink{226, 230, 235, 255}, faint{150, 157, 166, 255};

struct GuideContent {
  /// In picture pixels, in drawing order.
  std::vector<GuideLine> lines;
  /// Clip boxes of the left and the right eye; empty: no clipping.
  std::optional<std::array<ShownBox, 2>> boxes;
  std::vector<std::string> notes;     ///< simulated readings
  std::vector<std::string> troubles;  ///< problems of required devices
  std::string message;                ///< error outside the procedure
  bool has_help = false;
};

class GuidePanel {
 public:
  explicit GuidePanel(const BenchFile& bench);

  const OverlayFont& font() const { return text_.font(); }
  /// Valid until the next call. Text is in the operator's area or, if the layout has none, at the bottom of
  /// the left eye's visible part.
  const Overlay& drawn(const GuideSession& session, const GuideContent& content);

 private:
  struct Words {
    std::string text;
    VertexColour colour;
  };
  void add_lines(const GuideContent& content);
  std::vector<Words> words_of(const GuideSession& session, const GuideContent& content, float width_px) const;
  void add_wrapped(std::vector<Words>& words, const std::string& text, const VertexColour& colour,
                   float width_px) const;
  void add_task(std::vector<Words>& words, const GuideSession& session, float width_px) const;

  OverlayText text_;
  Overlay overlay_;
  DisplaySettings display_;
};

/// Draws a line into an overlay, anti-aliased if smooth, else in whole pixels.
void add_guide_line(Overlay& overlay, const OverlayText& text, const GuideLine& line);

/// "left edge 132 px".
std::string dial_text(const Dial& dial, double value);

}  // namespace vrda
