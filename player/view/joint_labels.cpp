// Names of bones and ligaments over the picture.
#include <imgui.h>

#include <array>
#include <cmath>
#include <span>

#include "view/panels.hpp"

namespace vrda::view {
namespace {

constexpr std::size_t most_labels = 64;  // over all views

}  // namespace

void draw_labels(const PanelView& view)
{
  const ImU32 plate = IM_COL32(24, 27, 32, 190), text_colour = IM_COL32(240, 243, 246, 255);
  const float margin = 0.3F * view.layout.em_px;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  std::array<ImVec4, most_labels> taken{};
  std::size_t n_taken = 0;
  for (const view::ScreenLabel& own : view.frame.labels) {
    if (!own.is_shown || n_taken == taken.size()) continue;
    const ImVec2 size = ImGui::CalcTextSize(own.text.c_str());
    ImVec2 corner(std::round(static_cast<float>(own.centre_px.x()) - 0.5F * size.x),
                  std::round(static_cast<float>(own.centre_px.y()) - 0.5F * size.y));
    // Moved down below the labels that it would overlap.
    for (std::size_t tries = 0; tries < n_taken; ++tries) {
      for (const ImVec4& other : std::span(taken).first(n_taken)) {
        const bool is_beside = corner.x + size.x + 2.0F * margin < other.x || corner.x > other.z + 2.0F * margin;
        if (!is_beside && corner.y < other.w && corner.y + size.y > other.y) corner.y = other.w + 1.0F;
      }
    }
    taken[n_taken++] = {corner.x, corner.y, corner.x + size.x, corner.y + size.y};
    list.AddRectFilled(ImVec2(corner.x - margin, corner.y),
                       ImVec2(corner.x + size.x + margin, corner.y + size.y), plate, margin);
    list.AddText(corner, text_colour, own.text.c_str());
  }
}

}  // namespace vrda::view
