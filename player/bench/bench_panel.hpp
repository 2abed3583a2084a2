/// Text over the bench's frame: inputs that are not live in both eyes' views, and a panel for the operator
/// with devices, parameter and timing.
#pragma once

#include <optional>
#include <string>

#include "bench/bench_state.hpp"
#include "bench/timing.hpp"
#include "view/overlay_text.hpp"
#include "view/doubts.hpp"

namespace vrda::bench {

struct PanelContent {
  bool has_panel = true, has_help = false;
  bench::DeviceReport tracker, board;
  bool has_board = false;
  const BenchTiming* timing = nullptr;
  std::string error_message;      ///< problem of the display; may be empty
  std::string message;            ///< newest message, shown for some seconds
  view::DoubtText doubt{};  ///< what is wrong with the model's pose; may be empty
};

class BenchPanel {
 public:
  explicit BenchPanel(const bench::BenchFile& bench);

  const view::OverlayFont& font() const { return text_.font(); }
  /// Valid until the next call. The panel is beside the eyes' windows or over the left one.
  const view::Overlay& drawn(const BenchState& state, const BenchFrame& frame, const PanelContent& content);

 private:
  void add_marks(const view::Viewport& visible, const BenchFrame& frame, const PanelContent& content);
  void add_panel(const view::Viewport& area, const BenchState& state, const BenchFrame& frame,
                 const PanelContent& content);
  void add_histogram(const view::Viewport& area, float top_px, const TimeHistogram& times);
  void add_line(const view::Viewport& area, float& top_px, const std::string& words,
                const view::VertexColour& colour);

  view::OverlayText text_;
  view::Overlay overlay_;
  bench::DisplaySettings display_;
  view::OverlayReflector reflector_;
};

/// Largest area beside the eyes' windows that is large enough for a panel.
std::optional<view::Viewport> operator_area(const bench::DisplaySettings& display);

/// "internal rotation 9.2 deg, anterior 3.1 mm", or external and posterior.
std::string joint_text(const ClinicalCoordinates& joint);

/// "tracker 127.0.0.1:18944: up, 100 a second".
std::string device_text(const std::string& name, const bench::DeviceReport& report);

/// "tibia hidden for 1.2 s"; empty if the input is live or not used.
std::string input_status_text(const std::string& name, const InputStatus& mark);

/// The same for the stage, also if it has no zero or has lost counts.
std::string stage_status_text(const BenchFrame& frame);

}  // namespace vrda::bench
