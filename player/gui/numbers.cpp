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
constexpr float backing = 0.85F;  // blended in linear light: less would leave white text on grey
constexpr float column_em = 5.0F, legend_width_em = 10.0F, message_width_em = 22.0F;
constexpr int labels_a_row = 3;
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
  ImGui::Text("%.1f°", shown_deg(angle_rad));
  if (remark == nullptr) return;
  ImGui::SameLine(2.0F * column_em * view.layout.em_px);
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

ImU32 packed(const VertexColour& colour)
{
  return IM_COL32(colour[0], colour[1], colour[2], 255);
}

void draw_swatch(const PanelView& view, const VertexColour& colour, const std::string& text)
{
  if (text.empty()) {
    ImGui::NewLine();
    return;
  }
  const float side = 0.8F * view.layout.em_px;
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  ImGui::GetWindowDrawList()->AddRectFilled(corner, ImVec2(corner.x + side, corner.y + side), packed(colour));
  ImGui::Dummy(ImVec2(side, side));
  ImGui::SameLine();
  ImGui::TextUnformatted(text.c_str());
}

/// Colours run on between those of the palette, as colour_of() mixes them.
void draw_bar(const Legend& legend, float width, float height)
{
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float step = width / static_cast<float>(legend.palette.size() - 1);
  for (std::size_t i = 0; i + 1 < legend.palette.size(); ++i) {
    const float x = corner.x + step * static_cast<float>(i);
    const ImU32 from = packed(legend.palette[i]), to = packed(legend.palette[i + 1]);
    ImGui::GetWindowDrawList()->AddRectFilledMultiColor(
        ImVec2(x, corner.y), ImVec2(x + step, corner.y + height), from, to, to, from);
  }
  ImGui::Dummy(ImVec2(width, height));
}

void draw_legend(const PanelView& view, const Legend& legend)
{
  const float em = view.layout.em_px;
  ImGui::BeginGroup();
  ImGui::TextUnformatted(legend.title.c_str());
  ImGui::SameLine();
  draw_swatch(view, legend.below, legend.below_label);
  draw_bar(legend, legend_width_em * em, 0.8F * em);
  ImGui::Text("%g to %g", legend.lowest, legend.highest);
  if (!legend.beyond_label.empty()) {
    ImGui::SameLine();
    ImGui::TextColored(quiet_colour, "then %s", legend.beyond_label.c_str());
  }
  ImGui::EndGroup();
}

void draw_axis_labels(const PanelView& view, std::span<const Label> labels)
{
  int n = 0;
  for (const Label& axis : labels) {
    if (n++ % labels_a_row != 0)
      ImGui::SameLine(static_cast<float>((n - 1) % labels_a_row) * 7.4F * view.layout.em_px);
    draw_swatch(view, axis.colour, axis.name);
  }
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
  if (view.readout.message != nullptr) {
    ImGui::PushTextWrapPos(message_width_em * view.layout.em_px);
    ImGui::TextColored(warning_colour, "%s", view.readout.message);
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

void draw_legends(const PanelView& view, const PlayerState& state)
{
  const ColourKey& key = view.frame.key;
  if (key.gaps == nullptr && key.strain == nullptr && key.axes.empty()) return;
  const bool is_bar_there = view.frame.has_controls && state.shows_panel;
  const float bottom =
      static_cast<float>(view.frame.height) - (is_bar_there ? view.layout.bar_height_px : 0.0F);
  ImGui::SetNextWindowPos(ImVec2(0.0F, bottom), ImGuiCond_Always, ImVec2(0.0F, 1.0F));
  ImGui::SetNextWindowBgAlpha(backing);
  ImGui::Begin("legends", nullptr, text_only | ImGuiWindowFlags_AlwaysAutoResize);
  draw_axis_labels(view, key.axes);
  if (key.gaps != nullptr) draw_legend(view, *key.gaps);
  if (key.gaps != nullptr && key.strain != nullptr) ImGui::SameLine(0.0F, view.layout.em_px);
  if (key.strain != nullptr) draw_legend(view, *key.strain);
  ImGui::End();
}

}  // namespace vrda
