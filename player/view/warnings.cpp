// The warnings of a model above the picture, and the marks on the timeline.
#include <imgui.h>

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "view/panels.hpp"

namespace vrda::view {
namespace {

constexpr float strip_margin_em = 0.5F, highest_strip_part = 0.35F;
constexpr float pose_lines = 2.0F;  // of the longest reason at 800 pixels

constexpr ImGuiWindowFlags strip_flags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                         ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                                         ImGuiWindowFlags_NoBringToFrontOnFocus;
const ImVec4 amber_text(1.0F, 0.72F, 0.30F, 1.0F);
constexpr ImU32 doubtful_mark = IM_COL32(255, 176, 46, 255), missing_mark = IM_COL32(235, 90, 60, 255);

}  // namespace

float warnings_height_px(const GuiLayout& layout, const std::vector<std::string>& warnings,
                         bool has_doubtful_poses, const view::Viewport& area)
{
  if (warnings.empty() && !has_doubtful_poses) return 0.0F;
  const float em = layout.em_px, margin = strip_margin_em * em;
  const float spacing = ImGui::GetStyle().ItemSpacing.y,
              wrap = static_cast<float>(area.width) - 2.0F * margin;
  const ImFont& font = *ImGui::GetIO().Fonts->Fonts[0];
  float height = 2.0F * margin + (has_doubtful_poses ? pose_lines * em + spacing : 0.0F);
  for (const std::string& warning : warnings)
    height += font.CalcTextSizeA(em, FLT_MAX, wrap, warning.c_str()).y + spacing;
  return std::min(height, highest_strip_part * static_cast<float>(area.height));
}

void draw_warnings(const PanelView& view)
{
  if (view.picture.y == 0) return;
  const float margin = strip_margin_em * view.layout.em_px;
  ImGui::SetNextWindowPos(ImVec2(0.0F, 0.0F));
  ImGui::SetNextWindowSize(
      ImVec2(static_cast<float>(view.picture.width), static_cast<float>(view.picture.y)));
  ImGui::SetNextWindowBgAlpha(1.0F);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(margin, margin));
  ImGui::Begin("warnings", nullptr, strip_flags);
  ImGui::PushStyleColor(ImGuiCol_Text, amber_text);
  if (view.readout.doubt != nullptr) ImGui::TextWrapped("%s", view.readout.doubt);
  ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(), margin));
  for (const std::string& warning : view.warnings) ImGui::TextWrapped("%s", warning.c_str());
  ImGui::PopStyleColor();
  ImGui::End();
  ImGui::PopStyleVar();
}

void draw_marks(const PanelView& view, const view::Timeline& timeline)
{
  if (timeline.last <= timeline.first) return;
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  const float inset = 2.0F + 0.5F * ImGui::GetStyle().GrabMinSize, left = low.x + inset;
  const float width = high.x - inset - left, thick = 0.27F * view.layout.em_px;
  const auto x_of = [&](double position) {
    return left + width * static_cast<float>((position - timeline.first) / (timeline.last - timeline.first));
  };
  for (const view::MarkedSpan& span : view.frame.marks)
    ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(x_of(span.first), high.y - thick),
                                              ImVec2(x_of(span.last), high.y),
                                              span.has_pose ? doubtful_mark : missing_mark);
}

}  // namespace vrda::view
