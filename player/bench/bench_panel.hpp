/// Words over the bench's picture: what is not live for whoever looks through the display, and for the
/// operator the devices, the parameter and the timing.
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
  std::string trouble;  ///< of the display; empty: none
  std::string message;  ///< the newest, for some seconds
};

class BenchPanel {
 public:
  explicit BenchPanel(const BenchFile& bench);

  const OverlayFont& font() const { return text_.font(); }
  /// Valid until the next. What is beyond the eyes' windows is the operator's; where nothing is, the panel
  /// lies over the left eye's.
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

/// The largest part beside all eyes' windows that a panel fits into.
std::optional<Viewport> operators_area(const DisplaySettings& display);

/// "tracker 127.0.0.1:18944: up, 100 a second".
std::string device_text(const std::string& name, const DeviceReport& report);

/// "tibia hidden for 1.2 s"; empty for an input that is live or not used.
std::string mark_text(const std::string& name, const InputMark& mark);

/// The same of the stage, which may also have no zero, or not have counted all of its way.
std::string stage_mark_text(const BenchFrame& frame);

}  // namespace vrda
