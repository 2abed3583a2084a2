/// The panel of a run on screen: title, lines, the map of its attitudes by status, a legend.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/step_record.hpp"
#include "store/motion_model.hpp"
#include "view/overlay_text.hpp"
#include "view/renderer.hpp"

namespace vrda::show {

struct GridCell {
  Eigen::Index flexion = 0, varus = 0;
};

/// The attitudes of a run.
struct RunGrid {
  std::string title;
  std::vector<double> flexion_deg, varus_deg;
  store::GridB status;
  std::optional<GridCell> current;  ///< outlined in the map
};

view::VertexColour colour_of(StepStatus status);

/// Draws the panel in `area`: the title, `lines`, the map of statuses (flexion downwards, varus to the right)
/// and a legend with the number of cells per status.
void add_panel(view::Overlay& overlay, const view::OverlayText& text, const view::Viewport& area,
               const RunGrid& grid, const std::vector<std::string>& lines);

}  // namespace vrda::show
