/// The panel beside the views: the grid of attitudes filling in, and words.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/step_status.hpp"
#include "gui/overlay_text.hpp"
#include "store/motion_model.hpp"

namespace vrda {

VertexColour colour_of(StepStatus status);

struct GridCell {
  Eigen::Index flexion = 0, varus = 0;
};

struct RunPanel {
  std::string title;
  std::vector<std::string> lines;  ///< under the title
  std::vector<double> flexion_deg, varus_deg;
  GridB status;
  std::optional<GridCell> current;  ///< framed
};

/// The panel in its part of the picture: flexion downwards, varus to the right, a colour a status with the
/// number of cells that have it.
void add_panel(Overlay& overlay, const OverlayText& text, const Viewport& area, const RunPanel& panel);

/// The name of a view over its tile.
void add_label(Overlay& overlay, const OverlayText& text, const Viewport& tile, const std::string& name);

}  // namespace vrda
