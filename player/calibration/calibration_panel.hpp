/// Screen of the calibration session: lines of the task and text for the operator.
#pragma once

#include <optional>
#include <string>

#include "calibration/calibrate.hpp"
#include "calibration/diagram.hpp"
#include "view/overlay_text.hpp"
#include "view/eye.hpp"

namespace vrda::calibration {

using view::faint, view::ink;

struct CalibrationPanelContent {
  /// In picture pixels, in drawing order.
  std::vector<DrawnLine> lines;
  /// Clip boxes of the left and the right eye; empty: no clipping.
  std::optional<std::array<view::ShownBox, 2>> boxes;
  std::vector<std::string> notes;           ///< simulated readings
  std::vector<std::string> error_messages;  ///< problems of required devices
  std::string message;                      ///< error outside the procedure
  /// Of the last task from the truth, and how far it is: in px, mm or another unit of the task.
  std::string deviation;
  double deviation_value = 0.0;
  double time_left_s = 0.0;
  std::optional<Diagram> diagram;  ///< of the task; drawn if the layout has an operator's area
  bool has_help = false;
};

/// Deviations from the truth, px or mm: above the first amber, above the second red, and to be done again.
inline constexpr double fair_deviation = 2.0, large_deviation = 10.0;

class CalibrationPanel {
 public:
  explicit CalibrationPanel(const BenchFile& bench);

  const view::OverlayFont& font() const { return text_.font(); }
  /// Valid until the next call. Text is in the operator's area or, if the layout has none, at the bottom of
  /// the left eye's visible part.
  const view::Overlay& drawn(const CalibrationSession& session, const CalibrationPanelContent& content);

 private:
  struct TextLine {
    std::string text;
    view::VertexColour colour;
  };
  void add_lines(const CalibrationPanelContent& content);
  std::vector<TextLine> lines_of(const CalibrationSession& session, const CalibrationPanelContent& content,
                                 float width_px) const;
  void add_wrapped(std::vector<TextLine>& lines, const std::string& text, const view::VertexColour& colour,
                   float width_px) const;
  void add_diagram(const Diagram& diagram, const view::Viewport& area, float top_px);
  void add_task(std::vector<TextLine>& lines, const CalibrationSession& session,
                const CalibrationPanelContent& content, float width_px) const;

  view::OverlayText text_;
  view::Overlay overlay_;
  bench::DisplaySettings display_;
  view::OverlayReflector reflector_;
};

/// Draws a line into an overlay, anti-aliased if smooth, else in whole pixels.
void add_drawn_line(view::Overlay& overlay, const view::OverlayText& text, const DrawnLine& line);

/// "left edge 132 px".
std::string dial_text(const Dial& dial, double value);

}  // namespace vrda::calibration
