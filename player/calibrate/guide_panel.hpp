/// The guided procedure on screen: what a task shows, and words for the operator.
#pragma once

#include <optional>
#include <string>

#include "gui/overlay_text.hpp"
#include "guide/drawing.hpp"
#include "guide/session.hpp"
#include "optics/eye.hpp"

namespace vrda {

/// Letters and colours of what stands beside the eyes' views, and of sheets.
inline constexpr double text_px = 15.0;
inline constexpr VertexColour ink{226, 230, 235, 255}, faint{150, 157, 166, 255};

struct GuideContent {
  /// In pixels of the picture; those under the others first.
  std::vector<GuideLine> lines;
  /// Where lines of the left and right eye are cut off; nothing: nowhere.
  std::optional<std::array<ShownBox, 2>> boxes;
  std::vector<std::string> notes;     ///< of what stands there
  std::vector<std::string> troubles;  ///< of devices that the task at hand wants
  std::string message;                ///< what went wrong outside the procedure
  bool has_help = false;
};

class GuidePanel {
 public:
  explicit GuidePanel(const BenchFile& bench);

  const OverlayFont& font() const { return text_.font(); }
  /// Valid until the next. Words stand in the operator's area; where a layout leaves none, at the bottom of
  /// what the left eye sees.
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

/// Draws lines into an overlay: smooth ones anti-aliased, others as whole pixels.
void add_guide_line(Overlay& overlay, const OverlayText& text, const GuideLine& line);

/// "left edge 132 px".
std::string dial_text(const Dial& dial, double value);

}  // namespace vrda
