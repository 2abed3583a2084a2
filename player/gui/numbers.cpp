// What is only read: the numbers of the attitude, the colours' meaning.
#include <imgui.h>

#include <cmath>

#include "core/units.hpp"
#include "gui/panels.hpp"

namespace vrda {
namespace {

constexpr ImGuiWindowFlags text_only = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                       ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                                       ImGuiWindowFlags_NoBringToFrontOnFocus;
constexpr float backing = 0.62F;  // dark enough for white text on the light backdrop
constexpr float column_em = 5.0F;
const ImVec4 warning_colour(1.0F, 0.72F, 0.30F, 1.0F), quiet_colour(0.72F, 0.76F, 0.80F, 1.0F);

void label(const PanelView& view, const char* text)
{
  ImGui::TextColored(quiet_colour, "%s", text);
  ImGui::SameLine(column_em * view.layout.em_px);
}

/// Degrees with the sign of zero taken away: "-0.0" looks like a fault.
double shown_deg(double angle_rad)
{
  return std::round(deg_from_rad(angle_rad) * 10.0) / 10.0 + 0.0;
}

void draw_angle(const PanelView& view, const char* name, double angle_rad, const char* remark)
{
  label(view, name);
  ImGui::Text("%6.1f°", shown_deg(angle_rad));
  if (remark == nullptr) return;
  ImGui::SameLine();
  ImGui::TextColored(quiet_colour, "%s", remark);
}

const char* varus_remark(const PanelView& view)
{
  if (view.range.is_varus_free) return "as found";
  if (view.readout.pose.is_varus_clamped) return "end of the range";
  return view.readout.is_varus_balanced ? "balanced" : nullptr;
}

const char* name_of(GapSource source)
{
  switch (source) {
    case GapSource::cells:
      return "the solver's cells";
    case GapSource::audit:
      return "nearest audited attitude";
    case GapSource::travel:
      return "way into contact at the cells";
    case GapSource::recontacted:
      return "recontacted at the cells";
    case GapSource::none:
      break;
  }
  return "no audit of this set";
}

void draw_mm(const char* name, double length_mm)
{
  if (std::isnan(length_mm)) {
    ImGui::Text("%s: nothing faces", name);
  } else {
    ImGui::Text("%s %.3f mm", name, length_mm);
  }
}

void draw_gap(const PanelView& view)
{
  const GapReading& gap = view.readout.gap;
  if (gap.source == GapSource::cells) {
    label(view, "gap");
    draw_mm("medial", gap.medial_mm);
    label(view, "");
    draw_mm("lateral", gap.lateral_mm);
  } else if (gap.source != GapSource::none) {
    const bool is_overlapping = gap.penetration_mm > 0.0;
    label(view, is_overlapping ? "overlap" : "gap");
    draw_mm("whole joint", is_overlapping ? gap.penetration_mm : gap.gap_mm);
  } else {
    label(view, "gap");
    ImGui::Text("not measured");
  }
  label(view, "");
  ImGui::TextColored(quiet_colour, "%s", name_of(gap.source));
}

void draw_legend(const PanelView& view, const Legend& legend)
{
  const float em = view.layout.em_px, width = 11.0F * em, height = 0.8F * em;
  ImGui::Text("%s", legend.title);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float step = width / static_cast<float>(legend.colours.size());
  for (std::size_t i = 0; i < legend.colours.size(); ++i) {
    const VertexColour& colour = legend.colours[i];
    const float x = corner.x + step * static_cast<float>(i);
    ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(x, corner.y), ImVec2(x + step, corner.y + height),
                                              IM_COL32(colour[0], colour[1], colour[2], 255));
  }
  ImGui::Dummy(ImVec2(width, height));
  ImGui::Text("%g", legend.low);
  ImGui::SameLine(width - 3.0F * em);
  ImGui::Text("%g %s", legend.high, legend.unit);
}

}  // namespace

void draw_numbers(const PanelView& view, const PlayerState& state)
{
  const JointPose& pose = view.readout.pose;
  ImGui::SetNextWindowPos(ImVec2(0.0F, 0.0F));
  ImGui::SetNextWindowBgAlpha(backing);
  ImGui::Begin("numbers", nullptr, text_only | ImGuiWindowFlags_AlwaysAutoResize);
  if (!view.title.empty()) ImGui::Text("%s", view.title.c_str());
  draw_angle(view, "flexion", pose.attitude.flexion_rad,
             pose.is_flexion_clamped ? "end of the range" : nullptr);
  draw_angle(view, "varus", pose.attitude.varus_rad, varus_remark(view));
  if (pose.status == PoseStatus::solved) {
    draw_angle(view, "theta", pose.theta_rad, nullptr);
    draw_gap(view);
  } else {
    ImGui::TextColored(warning_colour, "no answer here: a cell around it is unsolved");
  }
  label(view, "set");
  ImGui::Text("%s", view.set_labels[state.set].c_str());
  if (view.readout.message != nullptr) ImGui::TextColored(warning_colour, "%s", view.readout.message);
  ImGui::End();
}

void draw_legends(const PanelView& view, const PlayerState& state)
{
  if (view.frame.legends.empty()) return;
  const bool is_bar_there = view.frame.has_controls && state.shows_panel;
  const float bottom =
      static_cast<float>(view.frame.height) - (is_bar_there ? view.layout.bar_height_px : 0.0F);
  ImGui::SetNextWindowPos(ImVec2(0.0F, bottom), ImGuiCond_Always, ImVec2(0.0F, 1.0F));
  ImGui::SetNextWindowBgAlpha(backing);
  ImGui::Begin("legends", nullptr, text_only | ImGuiWindowFlags_AlwaysAutoResize);
  for (const Legend& legend : view.frame.legends) draw_legend(view, legend);
  ImGui::End();
}

}  // namespace vrda
