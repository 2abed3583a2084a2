/// The parts of the interface; each adds to the current frame of the interface library.
#pragma once

#include <array>

#include "model/coordinates.hpp"
#include "view/gui.hpp"

namespace vrda::view {

/// Sizes on screen, pixels.
struct GuiLayout {
  float em_px = 15.0F;  ///< size of the text
  float panel_width_px = 0.0F, bar_height_px = 0.0F;
};

struct PanelView {
  const GuiFrame& frame;
  const GuiLayout& layout;
  const view::PlayerRange& range;
  const Readout& readout;
  const std::string& title;
  const std::vector<std::string>& set_labels;
  const std::array<std::string, 3>& held_labels;  ///< in the order of view::FixedObject
  const JointKind& kind;
  const std::vector<std::string>& warnings;
  view::Viewport picture;  ///< below the warnings
};

/// Height of the strip of warnings above a picture of this width; 0 without warnings.
float warnings_height_px(const GuiLayout& layout, const std::vector<std::string>& warnings,
                         bool has_doubtful_poses, const view::Viewport& area);
void draw_warnings(const PanelView& view);
/// Doubtful and missing poses along the lower edge of the slider that was drawn last.
void draw_marks(const PanelView& view, const view::Timeline& timeline);

void draw_numbers(const PanelView& view, const view::PlayerState& state);
void draw_labels(const PanelView& view);
void draw_legends(const PanelView& view, const view::PlayerState& state);
GuiResult with_bar(const PanelView& view, GuiResult answer);
GuiResult with_panel(const PanelView& view, GuiResult answer);
GuiResult with_help(const PanelView& view, GuiResult answer);

}  // namespace vrda::view
