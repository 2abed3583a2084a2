/// Text over the bench's frame: inputs that are not live in both eyes' views, and a panel for the operator
/// with devices, parameter and timing.
#pragma once

#include <optional>
#include <string>

#include "bench/bench_state.hpp"
#include "bench/timing.hpp"
#include "gui/overlay_text.hpp"
#include "navigation/doubts.hpp"

namespace vrda::bench {

struct PanelContent {
  bool has_panel = true, has_help = false;
  devices::DeviceReport tracker, board;
  bool has_board = false;
  const BenchTiming* timing = nullptr;
  std::string error_message;      ///< problem of the display; may be empty
  std::string message;            ///< newest message, shown for some seconds
  navigation::DoubtText doubt{};  ///< what is wrong with the model's pose; may be empty
};

class BenchPanel {
 public:
  explicit BenchPanel(const bench_files::BenchFile& bench);

  const render::OverlayFont& font() const { return text_.font(); }
  /// Valid until the next call. The panel is beside the eyes' windows or over the left one.
  const render::Overlay& drawn(const BenchState& state, const BenchFrame& frame, const PanelContent& content);

 private:
  void add_marks(const optics::Viewport& visible, const BenchFrame& frame, const PanelContent& content);
  void add_panel(const optics::Viewport& area, const BenchState& state, const BenchFrame& frame,
                 const PanelContent& content);
  void add_histogram(const optics::Viewport& area, float top_px, const TimeHistogram& times);
  void add_line(const optics::Viewport& area, float& top_px, const std::string& words,
                const scene::VertexColour& colour);

  gui::OverlayText text_;
  render::Overlay overlay_;
  bench_files::DisplaySettings display_;
  gui::OverlayReflector reflector_;
};

/// Largest area beside the eyes' windows that is large enough for a panel.
std::optional<optics::Viewport> operator_area(const bench_files::DisplaySettings& display);

/// "internal rotation 9.2 deg, anterior 3.1 mm", or external and posterior.
std::string joint_text(const ClinicalCoordinates& joint);

/// "tracker 127.0.0.1:18944: up, 100 a second".
std::string device_text(const std::string& name, const devices::DeviceReport& report);

/// "tibia hidden for 1.2 s"; empty if the input is live or not used.
std::string input_status_text(const std::string& name, const InputStatus& mark);

/// The same for the stage, also if it has no zero or has lost counts.
std::string stage_status_text(const BenchFrame& frame);

}  // namespace vrda::bench
