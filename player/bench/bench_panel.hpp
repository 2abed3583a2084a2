/// Text over the bench's frame: inputs that are not live in both eyes' views, and a panel for the operator
/// with devices, parameter and timing.
#pragma once

#include <optional>
#include <string>

#include "bench/bench_state.hpp"
#include "bench/timing.hpp"
#include "gui/overlay_text.hpp"

namespace vrda {

struct PanelContent {
  bool has_panel = true, has_help = false;
  DeviceReport tracker, board;
  bool has_board = false;
  const BenchTiming* timing = nullptr;
  std::string trouble;  ///< problem of the display; may be empty
  std::string message;  ///< newest message, shown for some seconds
};

class BenchPanel {
 public:
  explicit BenchPanel(const BenchFile& bench);

  const OverlayFont& font() const { return text_.font(); }
  /// Valid until the next call. The panel is beside the eyes' windows or over the left one.
  const Overlay& drawn(const BenchState& state, const BenchFrame& frame, const PanelContent& content);

 private:
  void add_marks(const Viewport& visible, const BenchFrame& frame);
  void add_panel(const Viewport& area, const BenchState& state, const BenchFrame& frame,
                 const PanelContent& content);
  void add_histogram(const Viewport& area, float top_px, const TimeHistogram& times);
  void add_line(const Viewport& area, float& top_px, const std::string& words, const VertexColour& colour);

  OverlayText text_;
  Overlay overlay_;
  DisplaySettings display_;
};

OverlayBox overlay_box(const Viewport& v);

/// Largest area beside the eyes' windows that is large enough for a panel.
std::optional<Viewport> operators_area(const DisplaySettings& display);

/// "tracker 127.0.0.1:18944: up, 100 a second".
std::string device_text(const std::string& name, const DeviceReport& report);

/// "tibia hidden for 1.2 s"; empty if the input is live or not used.
std::string mark_text(const std::string& name, const InputMark& mark);

/// The same for the stage, also if it has no zero or has lost counts.
std::string stage_mark_text(const BenchFrame& frame);

}  // namespace vrda
