#include "view/gui.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "core/units.hpp"

namespace vrda::view {
namespace {

constexpr double text_px = 15.0;  // at scale 1: readable at arm's length at 96 dots per inch
constexpr float panel_width_em = 16.0F, bar_height_em = 4.6F;
constexpr float least_elapsed_s = 1e-4F;  // the library requires a positive time step
constexpr float strip_margin_em = 0.5F, highest_strip_part = 0.35F;
constexpr float pose_lines = 2.0F;  // of the longest reason at 800 pixels
constexpr float column_em = 5.0F, legend_width_em = 10.0F, message_width_em = 22.0F;
constexpr int labels_a_row = 3;
constexpr std::size_t most_labels = 64;  // over all views
// Text over a picture is smaller in a picture smaller than this, and its boxes leave out what is not a
// number.
constexpr float full_size_px = 900.0F, least_scale = 0.7F, folded_below = 0.85F;
constexpr float differences_height_em = 13.3F, legend_rows = 2.0F;
constexpr float least_plot_margin = 0.05F;  // of values: a line without differences is flat
constexpr ImU32 plot_backing = IM_COL32(41, 44, 50, 255);
constexpr ImU32 band_alpha = 70;
constexpr float label_aside_part = 0.06F;  // between what is named and the names
constexpr double varus_for_s = 0.25;
constexpr float opacity_width_em = 4.0F, card_height_em = 17.0F, curve_height_em = 4.5F;
// Opacity of numbers and legends; less leaves too little contrast, since blending is in linear light.
constexpr float backing = 0.85F;
const ImVec4 warning_colour(1.0F, 0.72F, 0.30F, 1.0F), quiet_colour(0.72F, 0.76F, 0.80F, 1.0F);
constexpr ImU32 doubtful_mark = IM_COL32(255, 176, 46, 255), missing_mark = IM_COL32(235, 90, 60, 255);

constexpr ImGuiWindowFlags fixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav;
constexpr ImGuiWindowFlags text_only = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                       ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                                       ImGuiWindowFlags_NoBringToFrontOnFocus;
// Keys are handled by the player, so sliders accept no typed numbers.
constexpr ImGuiSliderFlags sliding = ImGuiSliderFlags_NoInput | ImGuiSliderFlags_AlwaysClamp;

std::atomic<std::uint64_t> n_allocations{0};

void* counted_allocation(std::size_t size, void* /*user*/)
{
  ++n_allocations;
  return std::malloc(size);
}

void counted_release(void* memory, void* /*user*/)
{
  std::free(memory);
}

void set_style(float scale)
{
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 0.0F;
  style.FrameRounding = 3.0F;
  style.GrabRounding = 3.0F;
  style.WindowBorderSize = 0.0F;
  style.ItemSpacing = ImVec2(6.0F, 5.0F);
  // Texture-based lines require bilinear filtering of the font image, which this renderer does not do.
  style.AntiAliasedLinesUseTex = false;
  style.Colors[ImGuiCol_PopupBg] = ImVec4(0.14F, 0.15F, 0.18F, 1.0F);
  style.Colors[ImGuiCol_WindowBg] = ImVec4(0.10F, 0.11F, 0.13F, 1.0F);
  style.ScaleAllSizes(scale);
}

OverlayVertex vertex_of(const ImDrawVert& vertex)
{
  const auto byte = [&](int shift) { return static_cast<std::uint8_t>((vertex.col >> shift) & 0xFFU); };
  return {vertex.pos.x,
          vertex.pos.y,
          vertex.uv.x,
          vertex.uv.y,
          {byte(IM_COL32_R_SHIFT), byte(IM_COL32_G_SHIFT), byte(IM_COL32_B_SHIFT), byte(IM_COL32_A_SHIFT)}};
}

/// Windows without anything behind them.
constexpr std::array<std::string_view, 4> panel_names{"panel", "timeline", "warnings", "differences"};

void append(Overlay& overlay, const ImDrawList& list)
{
  const auto first_vertex = static_cast<std::uint32_t>(overlay.vertices.size());
  const auto first_index = static_cast<std::uint32_t>(overlay.indices.size());
  for (const ImDrawVert& vertex : list.VtxBuffer) overlay.vertices.push_back(vertex_of(vertex));
  for (const ImDrawIdx index : list.IdxBuffer) overlay.indices.push_back(index);
  const std::size_t first_command = overlay.commands.size();
  for (const ImDrawCmd& command : list.CmdBuffer) {
    if (command.ElemCount == 0) continue;
    const ImVec4& clip = command.ClipRect;
    overlay.commands.push_back({{clip.x, clip.y, clip.z, clip.w},
                                first_index + command.IdxOffset,
                                command.ElemCount,
                                first_vertex + command.VtxOffset});
  }
  const auto* panel = std::ranges::find(panel_names, std::string_view(list._OwnerName));
  if (panel == panel_names.end() || list.VtxBuffer.Size < 4) return;
  const ImVec2 low = list.VtxBuffer[0].pos, high = list.VtxBuffer[2].pos;  // the background is drawn first
  overlay.panels.push_back({{low.x, low.y, high.x, high.y},
                            first_command,
                            overlay.commands.size() - first_command,
                            first_vertex,
                            static_cast<std::size_t>(list.VtxBuffer.Size)});
}

/// Colour-blind safe (Okabe and Ito 2008), the lighter ones first.
constexpr std::array line_colours{IM_COL32(86, 180, 233, 255), IM_COL32(230, 159, 0, 255),
                                  IM_COL32(0, 178, 130, 255),  IM_COL32(224, 140, 187, 255),
                                  IM_COL32(240, 228, 66, 255), IM_COL32(233, 110, 40, 255),
                                  IM_COL32(190, 190, 190, 255)};

ImU32 line_colour(std::size_t k)
{
  return line_colours[k % line_colours.size()];
}

/// A colour that is used again is that of a dashed line.
bool is_dashed(std::size_t k)
{
  return k >= line_colours.size();
}

ImU32 with_alpha(ImU32 colour, ImU32 alpha)
{
  return (colour & ~IM_COL32_A_MASK) | (alpha << IM_COL32_A_SHIFT);
}

struct Press {
  const char* label;
  Action action;
};

bool is_pressed(const char* label, float width)
{
  return ImGui::Button(label, ImVec2(width, 0.0F));
}

/// Buttons side by side over the available width; returns the action of the pressed one.
Action row_of(std::span<const Press> presses)
{
  const float spacing = ImGui::GetStyle().ItemSpacing.x;
  const auto n = static_cast<float>(presses.size());
  const float width = (ImGui::GetContentRegionAvail().x - spacing * (n - 1.0F)) / n;
  Action action = Action::none;
  for (std::size_t i = 0; i < presses.size(); ++i) {
    if (i > 0) ImGui::SameLine();
    if (is_pressed(presses[i].label, width)) action = presses[i].action;
  }
  return action;
}

float as_deg(double angle_rad)
{
  return static_cast<float>(deg_from_rad(angle_rad));
}

void heading(const char* text)
{
  ImGui::Spacing();
  ImGui::TextDisabled("%s", text);
}

bool has_open_menu = false, closes_menu = false;  // of the frame that is built

/// Combo box of `n` choices, whose names are `label_of(i)`; returns the chosen one.
template <typename Labels>
std::size_t chosen(const char* id, std::size_t n, std::size_t choice, const Labels& label_of,
                   float width = -1.0F)
{
  ImGui::SetNextItemWidth(width);
  if (!ImGui::BeginCombo(id, label_of(choice))) return choice;
  has_open_menu = true;
  if (closes_menu) ImGui::CloseCurrentPopup();
  for (std::size_t i = 0; i < n; ++i) {
    if (ImGui::Selectable(label_of(i), i == choice)) choice = i;
  }
  ImGui::EndCombo();
  return choice;
}

/// The same over the enum values 0 ... last.
template <typename Enum>
Enum chosen(const char* id, Enum value, Enum last, float width = -1.0F)
{
  const auto label_of = [](std::size_t i) { return name_of(static_cast<Enum>(i)); };
  return static_cast<Enum>(
      chosen(id, static_cast<std::size_t>(last) + 1, static_cast<std::size_t>(value), label_of, width));
}

/// Two rows of buttons.
Action rows_of(std::span<const Press> first, std::span<const Press> second)
{
  const Action upper = row_of(first), lower = row_of(second);
  return upper != Action::none ? upper : lower;
}

Action pressed_view()
{
  heading("view (1 ... 6, R)");
  return rows_of(std::array{Press{"front", Action::view_front}, Press{"back", Action::view_back},
                            Press{"medial", Action::view_medial}},
                 std::array{Press{"lateral", Action::view_lateral}, Press{"top", Action::view_top},
                            Press{"oblique", Action::view_oblique}});
}

Action pressed_tool()
{
  ImGui::Spacing();
  return rows_of(std::array{Press{"reset (R)", Action::reset_view}, Press{"picture (P)", Action::screenshot}},
                 std::array{Press{"full (F)", Action::full_screen}, Press{"help (H)", Action::show_help}});
}

/// Degrees rounded to 0.1, without negative zero.
double shown_deg(double angle_rad)
{
  return std::round(deg_from_rad(angle_rad) * 10.0) / 10.0 + 0.0;
}

/// Rotation and translation that the attitude does not contain, with the names of their directions.
void draw_joint(const ClinicalCoordinates& joint, const JointKind& kind)
{
  ImGui::Text("%s %.1f°", kind.words[2].of(joint.internal_rotation_rad),
              std::abs(shown_deg(joint.internal_rotation_rad)));
  ImGui::Text("%s %.1f mm", kind.words[3].of(joint.anterior_mm), std::abs(joint.anterior_mm));
}

const char* name_of(GapSource source)
{
  return std::array{"no audit of this set",     "measured with the motion",    "solver, at the cells",
                    "nearest audited attitude", "contact travel at the cells", "recontacted at the cells"}
      .at(static_cast<std::size_t>(source));
}

void draw_mm(const char* name, double length_mm)
{
  if (std::isnan(length_mm)) {
    ImGui::Text("%s: none facing", name);
  } else {
    ImGui::Text("%s %.3f mm", name, length_mm);
  }
}

ImU32 packed(const VertexColour& colour)
{
  return IM_COL32(colour[0], colour[1], colour[2], 255);
}

/// Interpolates the palette linearly, like colour_of().
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

/// The parts of the interface; each adds to the current frame of the interface library.
struct Panels {
  explicit Panels(const GuiOptions& shown)
      : options(shown),
        held_labels{shown.moving + " fixed", shown.reference + " fixed", "direction of push fixed"},
        em_px(static_cast<float>(std::round(text_px * shown.scale))),
        panel_width_px(panel_width_em * em_px),
        bar_height_px(bar_height_em * em_px)
  {
    for (const std::string& set : shown.sets) set_labels.push_back(set_label(set));
  }

  static int covered_px(float px) { return static_cast<int>(std::ceil(px)); }

  /// Of a window without its controls.
  Viewport area_of(int width, int height, const PlayerState& state, bool has_controls) const
  {
    if (!state.shows_panel || !has_controls) return {0, 0, width, height};
    return {0, 0, std::max(1, width - covered_px(panel_width_px)),
            std::max(1, height - covered_px(bar_height_px))};
  }

  /// In a small window, and above two joints, the remark is in the strip above the picture, beside the joint.
  bool is_folded(const Viewport& area) const { return options.has_differences || is_small(area); }
  bool has_remark(const PlayerState& state) const
  {
    return !options.remark.empty() && state.set == options.remarked_set;
  }
  static float strip_scale(const Viewport& area) { return is_small(area) ? picture_scale(area) : 1.0F; }

  /// Height of the strip of warnings in this area; 0 without warnings.
  float warnings_height_px(const Viewport& area) const
  {
    const bool is_remarked = is_folded(area) && !options.remark.empty();
    if (options.warnings.empty() && !options.has_doubtful_poses && !is_remarked) return 0.0F;
    const float letter_px = strip_scale(area) * em_px;
    const float margin = strip_margin_em * em_px;
    const float spacing = ImGui::GetStyle().ItemSpacing.y,
                wrap = static_cast<float>(area.width) - 2.0F * margin;
    const ImFont& font = *ImGui::GetIO().Fonts->Fonts[0];
    const auto height_px = [&](const std::string& text) {
      return font.CalcTextSizeA(letter_px, FLT_MAX, wrap, text.c_str()).y + spacing;
    };
    float height = 2.0F * margin + (options.has_doubtful_poses ? pose_lines * letter_px + spacing : 0.0F);
    for (const std::string& warning : options.warnings) height += height_px(warning);
    if (is_remarked) height += height_px(options.remark);
    return std::min(height, highest_strip_part * static_cast<float>(area.height));
  }

  void draw_warnings(const PlayerState& state)
  {
    if (picture.y == 0) return;
    const float margin = strip_margin_em * em_px;
    ImGui::SetNextWindowPos(ImVec2(0.0F, 0.0F));
    ImGui::SetNextWindowSize(ImVec2(static_cast<float>(picture.width), static_cast<float>(picture.y)));
    ImGui::SetNextWindowBgAlpha(1.0F);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(margin, margin));
    ImGui::Begin("warnings", nullptr, text_only);
    ImGui::SetWindowFontScale(strip_scale(uncovered));
    ImGui::PushStyleColor(ImGuiCol_Text, warning_colour);
    if (readout->doubt != nullptr) ImGui::TextWrapped("%s", readout->doubt);
    ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(), margin));
    for (const std::string& warning : options.warnings) ImGui::TextWrapped("%s", warning.c_str());
    if (has_remark(state) && is_folded(uncovered)) ImGui::TextWrapped("%s", options.remark.c_str());
    ImGui::PopStyleColor();
    ImGui::End();
    ImGui::PopStyleVar();
  }

  /// On both sides of what is named, from top to bottom, with a line to each anchor.
  void draw_labels()
  {
    for (std::size_t first = 0; first < frame->labels.size();) {
      std::size_t last = first;
      while (last < frame->labels.size() && frame->labels[last].picture == frame->labels[first].picture)
        ++last;
      draw_labels_of(frame->labels.subspan(first, last - first));
      first = last;
    }
  }

  void draw_labels_of(std::span<const ScreenLabel> labels)
  {
    std::array<const ScreenLabel*, most_labels> shown{};
    std::size_t n_shown = 0;
    float left = FLT_MAX, right = -FLT_MAX;
    double sum = 0.0;
    for (const ScreenLabel& label : labels) {
      if (!label.is_shown || n_shown == shown.size()) continue;
      shown[n_shown++] = &label;
      left = std::min(left, static_cast<float>(label.anchor_px.x()));
      right = std::max(right, static_cast<float>(label.anchor_px.x()));
      sum += label.anchor_px.x();
    }
    const std::span<const ScreenLabel*> all(shown.data(), n_shown);
    std::ranges::sort(all, {}, [](const ScreenLabel* label) { return label->anchor_px.y(); });
    const double middle = sum / static_cast<double>(std::max<std::size_t>(n_shown, 1));
    const Viewport& area = labels[0].picture;
    const float aside = label_aside_part * static_cast<float>(std::min(area.width, area.height));
    for (const bool is_left : {true, false})
      draw_label_column(all, area, middle, is_left, is_left ? left - aside : right + aside);
  }

  /// The labels left or right of the middle; `edge`: where their texts end or begin.
  void draw_label_column(std::span<const ScreenLabel*> all, const Viewport& area, double middle, bool is_left,
                         float edge)
  {
    constexpr ImU32 plate = IM_COL32(24, 27, 32, 210), text_colour = IM_COL32(240, 243, 246, 255);
    const float size = em_px * picture_scale(area), margin = 0.3F * size;
    const auto width_of = [&](const ScreenLabel& label) {
      return ImGui::GetFont()->CalcTextSizeA(size, FLT_MAX, 0.0F, label.text.c_str()).x;
    };
    const auto is_own = [&](const ScreenLabel* label) { return (label->anchor_px.x() < middle) == is_left; };
    float height = 0.0F;
    for (const ScreenLabel* label : all) height += is_own(label) ? size + margin : 0.0F;
    const float top = static_cast<float>(area.y) + margin, bottom = top + static_cast<float>(area.height);
    float next = top;
    for (const ScreenLabel* label : all) {
      if (!is_own(label)) continue;
      const ImVec2 anchor(static_cast<float>(label->anchor_px.x()), static_cast<float>(label->anchor_px.y()));
      const float width = width_of(*label), most = static_cast<float>(area.x + area.width) - width - margin;
      const float x = std::round(std::clamp(is_left ? edge - width : edge,
                                            static_cast<float>(area.x) + margin, std::max(most, 0.0F)));
      // Below the text above it, and so that those below it still fit.
      float y = std::clamp(anchor.y - 0.5F * size, next, std::max(next, bottom - height - margin));
      y = below_boxes(std::round(y), x, width, size);
      next = y + size + margin;
      height -= size + margin;
      ImDrawList& list = *ImGui::GetBackgroundDrawList();
      const float from = is_left ? x + width + margin : x - margin;
      list.AddLine(ImVec2(from, y + 0.5F * size), anchor, plate, 3.0F);
      list.AddLine(ImVec2(from, y + 0.5F * size), anchor, text_colour, 1.0F);
      list.AddCircleFilled(anchor, 0.16F * size, text_colour, 12);
      list.AddRectFilled(ImVec2(x - margin, y), ImVec2(x + width + margin, y + size), plate, margin);
      list.AddText(ImGui::GetFont(), size, ImVec2(x, y), text_colour, label->text.c_str());
    }
  }

  /// `y`, or below the boxes of numbers and legends of the last frame.
  float below_boxes(float y, float x, float width, float height) const
  {
    for (const ImVec4& box : {numbers_px, legends_px})
      if (x < box.z && x + width > box.x && y < box.w && y + height > box.y) y = box.w + 0.3F * height;
    return y;
  }

  /// Of text over a picture of this size.
  static float picture_scale(const Viewport& area)
  {
    return std::clamp(static_cast<float>(std::min(area.width, area.height * 4 / 3)) / full_size_px,
                      least_scale, 1.0F);
  }
  static bool is_small(const Viewport& area) { return picture_scale(area) < folded_below; }

  /// The rectangle of the window that is being drawn.
  static ImVec4 window_px()
  {
    const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    return {at.x, at.y, at.x + size.x, at.y + size.y};
  }

  /// Two joints have theirs below the picture.
  void draw_numbers(const PlayerState& state)
  {
    const store::JointPose& pose = readout->pose;
    numbers_px = {};
    if (options.has_differences && readout->message == nullptr) return;
    ImGui::SetNextWindowPos(ImVec2(0.0F, static_cast<float>(picture.y)));
    ImGui::SetNextWindowBgAlpha(backing);
    ImGui::Begin("numbers", nullptr, text_only | ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::SetWindowFontScale(picture_scale(picture));
    if (!options.has_differences) draw_pose_numbers(state, pose);
    if (readout->message != nullptr) {
      ImGui::PushTextWrapPos(message_width_em * em_px);
      ImGui::TextColored(warning_colour, "%s", readout->message);
      ImGui::PopTextWrapPos();
    }
    if (!is_motion_in_panel(state)) draw_motion(state, message_width_em * ImGui::GetFontSize());
    numbers_px = window_px();
    ImGui::End();
  }

  void draw_pose_numbers(const PlayerState& state, const store::JointPose& pose)
  {
    if (!options.title.empty() && !is_small(picture)) ImGui::Text("%s", options.title.c_str());
    if (readout->clinical) draw_own_angles(*readout->clinical);
    draw_rotation(0, pose.attitude.flexion_rad, pose.is_flexion_clamped ? "end of the range" : nullptr);
    draw_rotation(1, pose.attitude.varus_rad, varus_remark());
    if (pose.status == store::PoseStatus::solved) {
      if (readout->joint) draw_joint(*readout->joint, kind());
      draw_gap();
    } else {
      ImGui::TextColored(warning_colour, "no pose");
    }
    label("set");
    ImGui::Text("%s", set_labels[state.set].c_str());
  }

  /// Verdict and remark on the shown set. A small picture has the numbers alone.
  std::array<std::string_view, 2> motion_texts(const PlayerState& state) const
  {
    std::array<std::string_view, 2> texts;
    if (!is_folded(picture) && state.set < options.verdicts.size()) texts[0] = options.verdicts[state.set];
    if (!is_folded(uncovered) && has_remark(state)) texts[1] = options.remark;
    return texts;
  }
  bool has_rotations(const PlayerState& state) const
  {
    return !is_folded(picture) && state.set < options.rotations.of_sets.size();
  }

  /// What is said of the whole motion is at the end of the panel where that has room, rather than over the
  /// joint.
  bool is_motion_in_panel(const PlayerState& state) const
  {
    if (!frame->has_controls || !state.shows_panel || state.shows_structures) return false;
    const ImFont& font = *ImGui::GetFont();
    float height = has_rotations(state) ? (curve_height_em + 4.0F) * em_px : 0.0F;
    for (const std::string_view text : motion_texts(state)) {
      if (text.empty()) continue;
      const char* const end = text.data() + text.size();
      height += ImGui::GetStyle().ItemSpacing.y +
                font.CalcTextSizeA(em_px, FLT_MAX, panel_text_width_px, text.data(), end).y;
    }
    return height <= panel_room_px;
  }

  void draw_motion(const PlayerState& state, float width_px)
  {
    const auto [verdict, remark] = motion_texts(state);
    ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + width_px);
    if (!verdict.empty()) ImGui::TextUnformatted(verdict.data(), verdict.data() + verdict.size());
    ImGui::PushStyleColor(ImGuiCol_Text, warning_colour);
    if (!remark.empty()) ImGui::TextUnformatted(remark.data(), remark.data() + remark.size());
    ImGui::PopStyleColor();
    ImGui::PopTextWrapPos();
    if (has_rotations(state)) draw_rotations(state.set, width_px);
  }

  /// Of the shown pose in a plot over these flexions, from 0 to 1.
  double position_between(double first_rad, double last_rad) const
  {
    return (readout->pose.attitude.flexion_rad - first_rad) / std::max(last_rad - first_rad, 1e-9);
  }

  void draw_rotations(std::size_t set, float wide)
  {
    const RotationPlots& all = options.rotations;
    ImGui::TextColored(quiet_colour, "internal rotation over flexion, °");
    const double now = position_between(all.first_flexion_rad, all.last_flexion_rad);
    draw_plot(all.of_sets[set], now, ImVec2(wide, curve_height_em * ImGui::GetFontSize()));
    draw_names(all.of_sets[set], ImGui::GetCursorPosX(), wide);
  }

  void draw_legends()
  {
    const ColourKey& key = frame->key;
    if (key.gaps == nullptr && key.strain == nullptr && key.axes.empty()) return;
    const float bottom = static_cast<float>(picture.y + picture.height);
    ImGui::SetNextWindowPos(ImVec2(0.0F, bottom), ImGuiCond_Always, ImVec2(0.0F, 1.0F));
    ImGui::SetNextWindowBgAlpha(backing);
    ImGui::Begin("legends", nullptr, text_only | ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::SetWindowFontScale(picture_scale(picture));
    draw_axis_labels(key.axes);
    if (key.gaps != nullptr) draw_legend(*key.gaps);
    if (key.gaps != nullptr && key.strain != nullptr) ImGui::SameLine(0.0F, em_px);
    if (key.strain != nullptr) draw_legend(*key.strain);
    legends_px = window_px();
    ImGui::End();
  }

  GuiResult with_bar(GuiResult answer)
  {
    const float em = em_px, width = static_cast<float>(frame->width) - panel_width_px;
    ImGui::SetNextWindowPos(ImVec2(0.0F, static_cast<float>(frame->height) - bar_height_px));
    ImGui::SetNextWindowSize(ImVec2(width, bar_height_px));
    ImGui::Begin("timeline", nullptr, fixed | ImGuiWindowFlags_NoScrollbar);
    Timeline& timeline = answer.state.timeline;
    timeline = with_timeline_slider(timeline);
    constexpr std::array before{Press{"|<", Action::go_to_first}, Press{"<", Action::step_back}};
    constexpr std::array behind{Press{">", Action::step_forward}, Press{">|", Action::go_to_last}};
    for (const Press& press : before) {
      if (is_pressed(press.label, 2.4F * em)) answer.action = press.action;
      ImGui::SameLine();
    }
    if (is_pressed(timeline.is_playing ? "pause###play" : "play###play", 5.0F * em))
      answer.action = Action::play_pause;
    for (const Press& press : behind) {
      ImGui::SameLine();
      if (is_pressed(press.label, 2.4F * em)) answer.action = press.action;
    }
    ImGui::SameLine(0.0F, em);
    ImGui::PushID("loop");
    if (is_pressed(name_of(timeline.loop), 5.5F * em)) answer.action = Action::next_loop;
    ImGui::PopID();
    ImGui::SameLine(0.0F, em);
    if (is_pressed("-", 2.0F * em)) answer.action = Action::slower;
    ImGui::SameLine();
    if (is_pressed("+", 2.0F * em)) answer.action = Action::faster;
    ImGui::SameLine();
    ImGui::Text(timeline.axis == TimelineAxis::flexion ? "%.0f°/s" : "%.0f frames/s", timeline.speed_steps_s);
    ImGui::End();
    return answer;
  }

  GuiResult with_panel(GuiResult answer)
  {
    const float left = static_cast<float>(frame->width) - panel_width_px;
    ImGui::SetNextWindowPos(ImVec2(left, 0.0F));
    ImGui::SetNextWindowSize(ImVec2(panel_width_px, static_cast<float>(frame->height)));
    ImGui::Begin("panel", nullptr, fixed);
    PlayerState& state = answer.state;
    if (state.shows_structures && frame->list != nullptr) {
      answer = with_structures(answer);
      ImGui::End();
      return answer;
    }
    ImGui::TextDisabled("set (S)");
    if (frame->list != nullptr) {
      ImGui::SameLine(0.0F, em_px);
      if (ImGui::SmallButton("structures (Y)")) answer.action = Action::show_structures;
    }
    state.set =
        chosen("##set", set_labels.size(), state.set, [&](std::size_t i) { return set_labels[i].c_str(); });
    state = with_varus(state);
    heading("draw mode (M), background (K)");
    state.mode = chosen("##mode", state.mode, DrawMode::textured, 8.4F * em_px);
    ImGui::SameLine();
    state.backdrop = chosen("##backdrop", state.backdrop, Backdrop::black);
    state = with_layers(state);
    heading("fixed on screen (O)");
    state.fixed_object = holdable[chosen("##held", held_labels.size(), held_row(state.fixed_object),
                                         [&](std::size_t i) { return held_labels[i].c_str(); })];
    for (const Action action : {pressed_view(), pressed_tool()}) {
      if (action != Action::none) answer.action = action;
    }
    panel_room_px = ImGui::GetContentRegionAvail().y;
    panel_text_width_px = ImGui::GetContentRegionAvail().x;
    if (state.shows_numbers && is_motion_in_panel(state)) draw_motion(state, panel_text_width_px);
    ImGui::End();
    return answer;
  }

  GuiResult with_structures(GuiResult answer)
  {
    StructureList& list = *frame->list;
    if (ImGui::SmallButton("controls (Y)")) answer.action = Action::show_structures;
    ImGui::SameLine(0.0F, em_px);
    if (ImGui::SmallButton("show all (Shift Z)")) answer.action = Action::show_all_structures;
    answer.state.section = with_section(answer.state.section, static_cast<float>(list.section_range_mm));
    const bool has_card = list.looks.highlighted.has_value();
    const float room = ImGui::GetContentRegionAvail().y - (has_card ? card_height_em * em_px : 0.0F);
    ImGui::BeginChild("list", ImVec2(0.0F, std::max(room, 6.0F * em_px)));
    for (std::size_t k = 0; k < list.structures.size(); ++k) {
      const StructureGroup group = list.structures[k].group;
      if (k == 0 || group != list.structures[k - 1].group) heading(heading_of(group));
      answer.state.layers = with_structure(k, answer.state.layers);
    }
    ImGui::EndChild();
    if (!has_card) return answer;
    const Action pressed = draw_card(list.structures[*list.looks.highlighted]);
    if (pressed != Action::none) answer.action = pressed;
    return answer;
  }

  /// A row of the list: visibility, name, opacity.
  LayerSet with_structure(std::size_t k, LayerSet layers)
  {
    const Structure& structure = frame->list->structures[k];
    Looks& looks = frame->list->looks;
    StructureLook& look = looks.of[k];
    const Layer layer = layer_of(structure);
    bool is_visible = look.is_visible && (layer == Layer::bodies || layers.has(layer));
    ImGui::PushID(static_cast<int>(k));
    if (ImGui::Checkbox("##visible", &is_visible)) {
      look.is_visible = is_visible;
      if (is_visible || structure.group == StructureGroup::contact) layers.set(layer, is_visible);
    }
    ImGui::SameLine();
    const bool is_own = looks.highlighted == k;
    const float left = ImGui::GetCursorPosX();
    const float width = ImGui::GetContentRegionAvail().x - (opacity_width_em + 0.4F) * em_px;
    // A long name has more than one line.
    const float height = ImGui::CalcTextSize(structure.name.c_str(), nullptr, false, width).y;
    if (ImGui::Selectable("##name", is_own, 0, ImVec2(width, height)))
      looks.highlighted = is_own ? std::nullopt : std::optional(k);
    ImGui::SameLine(left);
    ImGui::PushTextWrapPos(left + width);
    ImGui::TextUnformatted(structure.name.c_str());
    ImGui::PopTextWrapPos();
    ImGui::SameLine(left + width + 0.4F * em_px);
    ImGui::SetNextItemWidth(-1.0F);
    ImGui::SliderFloat("##opacity", &look.opacity, least_opacity, 1.0F, "%.1f", sliding);
    ImGui::PopID();
    return layers;
  }

  Section with_section(Section section, float range_mm)
  {
    heading("section (W, 8, 9)");
    section.kind = chosen("##section", section.kind, SectionKind::free, 6.0F * em_px);
    if (section.kind == SectionKind::none) return section;
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1.0F);
    auto at_mm = static_cast<float>(section.at_mm);
    if (ImGui::SliderFloat("##at", &at_mm, -range_mm, range_mm, "%.1f mm", sliding))
      section.at_mm = static_cast<double>(at_mm);
    return section;
  }

  Action draw_card(const Structure& structure)
  {
    const StructureCard& card = frame->list->card;
    ImGui::Separator();
    ImGui::PushTextWrapPos(0.0F);
    ImGui::TextUnformatted(structure.name.c_str());
    ImGui::TextColored(quiet_colour, "%s", structure.does.c_str());
    if (card.reading[0] != 0) ImGui::TextUnformatted(card.reading.data());
    ImGui::PopTextWrapPos();
    if (!card.strain.empty()) draw_curve(card);
    return rows_of(std::array{Press{"isolate (J)", Action::isolate_structure},
                              Press{"hide (Z)", Action::switch_structure}},
                   std::array{Press{"fade others (Shift J)", Action::fade_other_structures}});
  }

  /// Strain over flexion; where it is taut is above the line of zero.
  void draw_curve(const StructureCard& card)
  {
    const float left = ImGui::GetCursorPosX();
    draw_plot(card.strain, card.now, ImVec2(ImGui::GetContentRegionAvail().x, curve_height_em * em_px));
    ImGui::SetCursorPosX(left);
    ImGui::TextColored(quiet_colour, "strain over flexion, %%");
  }

  /// Lines with their bands, the lowest and highest value, zero and the present position, from 0 to 1.
  void draw_plot(std::span<const CurveLine> lines, double now, const ImVec2& size)
  {
    float lowest = 0.0F, highest = 0.0F;
    for (const CurveLine& line : lines) {
      for (const std::vector<float>* values : {&line.values, &line.low, &line.high}) {
        for (const float value : *values) {
          lowest = std::fmin(lowest, value);
          highest = std::fmax(highest, value);
        }
      }
    }
    const float margin = std::max(0.08F * (highest - lowest), least_plot_margin);
    const float size_px = ImGui::GetFontSize();
    const ImVec2 corner = ImGui::GetCursorScreenPos(), end(corner.x + size.x, corner.y + size.y);
    const auto y_of = [&](float value) {
      return corner.y + size.y * (highest + margin - value) / (highest - lowest + 2.0F * margin);
    };
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, end, plot_backing);
    const ImU32 quiet = ImGui::GetColorU32(quiet_colour);
    list.AddLine(ImVec2(corner.x, y_of(0.0F)), ImVec2(end.x, y_of(0.0F)), quiet);
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const CurveLine& line = lines[k];
      const auto n = static_cast<float>(std::max<std::size_t>(line.values.size(), 2) - 1);
      const auto point = [&](std::size_t i, float value) {
        return ImVec2(corner.x + size.x * static_cast<float>(i) / n, y_of(value));
      };
      list.Flags &= ~ImDrawListFlags_AntiAliasedFill;  // the parts of a band meet without seams
      for (std::size_t i = 1; i < line.low.size(); ++i)
        list.AddQuadFilled(point(i - 1, line.low[i - 1]), point(i, line.low[i]), point(i, line.high[i]),
                           point(i - 1, line.high[i - 1]), with_alpha(line_colour(k), band_alpha));
      list.Flags |= ImDrawListFlags_AntiAliasedFill;
      for (std::size_t i = 0; i < line.values.size(); ++i) {
        const bool is_between = is_dashed(k) && i % 4 == 3;
        const bool has_value = !std::isnan(line.values[i]) && !is_between;
        if (has_value) list.PathLineTo(point(i, line.values[i]));
        if (!has_value || i + 1 == line.values.size()) list.PathStroke(line_colour(k), 0, line.width_px);
      }
    }
    if (now >= 0.0 && now <= 1.0) {
      const float x = corner.x + size.x * static_cast<float>(now);
      list.AddLine(ImVec2(x, corner.y), ImVec2(x, end.y), ImGui::GetColorU32(warning_colour));
    }
    std::array<char, 16> text{};
    for (const float value : {highest, lowest}) {
      std::snprintf(text.data(), text.size(), "%.1f", static_cast<double>(value));
      const float y = std::clamp(y_of(value) - 0.5F * size_px, corner.y, end.y - size_px);
      list.AddText(ImVec2(corner.x + 2.0F, y), quiet, text.data());
    }
    ImGui::Dummy(size);
  }

  /// The names of lines in their colours, in rows of a width from `left`.
  void draw_names(std::span<const CurveLine> lines, float left, float wide)
  {
    float x = left, y = ImGui::GetCursorPosY();
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const char* const mark = is_dashed(k) ? "- - " : "";
      const char* const name = lines[k].name.c_str();
      const float needed = ImGui::CalcTextSize(mark).x + ImGui::CalcTextSize(name).x;
      if (x > left && x + needed > left + wide) x = left, y += ImGui::GetTextLineHeightWithSpacing();
      ImGui::SetCursorPos(ImVec2(x, y));
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(line_colour(k)), "%s%s", mark, name);
      x += needed + 0.8F * ImGui::GetFontSize();
    }
  }

  /// Height of the strip of differences below a picture of this size; 0 without.
  float differences_height_px(const Viewport& area) const
  {
    return options.has_differences ? differences_height_em * em_px * picture_scale(area) : 0.0F;
  }

  /// The plots below the picture, side by side.
  void draw_differences(const PlayerState& state)
  {
    const Differences& all = *frame->differences;
    const auto width = static_cast<float>(picture.width), n = static_cast<float>(all.plots.size());
    ImGui::SetNextWindowPos(ImVec2(0.0F, static_cast<float>(picture.y + picture.height)));
    const float bar_px = frame->has_controls && state.shows_panel ? bar_height_px : 0.0F;
    const auto bottom = static_cast<float>(frame->height - picture.y - picture.height);
    ImGui::SetNextWindowSize(ImVec2(width, bottom - bar_px));
    ImGui::Begin("differences", nullptr, fixed | ImGuiWindowFlags_NoScrollbar);
    ImGui::SetWindowFontScale(picture_scale(picture));
    for (const char* caption : all.captions) ImGui::TextUnformatted(caption);
    const double now = position_between(all.first_flexion_rad, all.last_flexion_rad);
    const float gap = ImGui::GetStyle().WindowPadding.x, wide = (width - gap) / n - gap;
    const float line_px = ImGui::GetTextLineHeightWithSpacing();
    const float top = ImGui::GetCursorPosY();
    const float high = ImGui::GetContentRegionAvail().y - (1.0F + legend_rows) * line_px;
    for (std::size_t k = 0; k < all.plots.size(); ++k) {
      const float left = gap + static_cast<float>(k) * (wide + gap);
      ImGui::SetCursorPos(ImVec2(left, top));
      ImGui::TextColored(quiet_colour, "%s, second minus first", all.plots[k].title.c_str());
      ImGui::SetCursorPosX(left);
      draw_plot(all.plots[k].lines, now, ImVec2(wide, std::max(high, line_px)));
      draw_names(all.plots[k].lines, left, wide);
    }
    ImGui::End();
  }

  GuiResult with_help(GuiResult answer)
  {
    const ImVec2 middle(0.5F * static_cast<float>(frame->width), 0.5F * static_cast<float>(frame->height));
    ImGui::SetNextWindowPos(middle, ImGuiCond_Always, ImVec2(0.5F, 0.5F));
    ImGui::SetNextWindowFocus();
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1.0F);
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(0.4F * em_px, 0.13F * em_px));  // for small screens
    ImGui::Begin("help", nullptr, fixed | ImGuiWindowFlags_AlwaysAutoResize);
    draw_help_lines("Keys", key_help());
    ImGui::Spacing();
    draw_help_lines("Mouse", mouse_help());
    ImGui::Spacing();
    if (is_pressed("close (Esc)", 8.0F * em_px)) answer.state.shows_help = false;
    ImGui::End();
    ImGui::PopStyleVar(2);
    return answer;
  }

  // Parts of the above.

  /// Doubtful and missing poses along the lower edge of the slider that was drawn last.
  void draw_marks(const Timeline& timeline)
  {
    if (timeline.last <= timeline.first) return;
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    const float inset = 2.0F + 0.5F * ImGui::GetStyle().GrabMinSize, left = low.x + inset;
    const float width = high.x - inset - left, thick = 0.27F * em_px;
    const auto x_of = [&](double position) {
      return left +
             width * static_cast<float>((position - timeline.first) / (timeline.last - timeline.first));
    };
    for (const MarkedSpan& span : frame->marks)
      ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(x_of(span.first), high.y - thick),
                                                ImVec2(x_of(span.last), high.y),
                                                span.has_pose ? doubtful_mark : missing_mark);
  }

  Timeline with_timeline_slider(Timeline timeline)
  {
    const auto steps = [&timeline](double position) {
      return static_cast<float>(steps_of_position(timeline.axis, position));
    };
    float at = steps(timeline.position);
    ImGui::AlignTextToFramePadding();
    if (range->key_name != nullptr) {
      ImGui::Text("%s %.4g", range->key_name, readout->pose.key);
    } else {
      ImGui::Text("%s %.1f°", kind().words[0].positive, static_cast<double>(at));
    }
    ImGui::SameLine(8.0F * em_px);
    ImGui::SetNextItemWidth(-1.0F);
    const bool is_moved =
        ImGui::SliderFloat("##flexion", &at, steps(timeline.first), steps(timeline.last), "", sliding);
    draw_marks(timeline);
    if (!is_moved) return timeline;
    return moved_to(timeline, position_of_steps(timeline.axis, static_cast<double>(at)));
  }

  PlayerState with_varus(PlayerState state)
  {
    float varus_deg = as_deg(wanted_varus_rad(state, *range));
    // A number that changes with every frame could not be read, and the panel would be drawn each time.
    if (state.timeline.is_playing && ImGui::GetTime() < varus_until_s) {
      varus_deg = shown_varus_deg;
    } else {
      shown_varus_deg = varus_deg;
      varus_until_s = ImGui::GetTime() + varus_for_s;
    }
    ImGui::Spacing();
    ImGui::TextDisabled("%s (Up, Down)", kind().words[1].positive);
    ImGui::SameLine(10.0F * em_px);
    ImGui::Text("%.1f°", shown_deg(rad_from_deg(static_cast<double>(varus_deg))));
    if (range->is_varus_free || range->first_varus_rad >= range->last_varus_rad) {
      ImGui::TextDisabled(range->is_varus_free ? "fixed by this set" : "one angle only");
      return state;
    }
    ImGui::SetNextItemWidth(-1.0F);
    if (ImGui::SliderFloat("##varus", &varus_deg, as_deg(range->first_varus_rad),
                           as_deg(range->last_varus_rad), "", sliding))
      state.varus_rad = rad_from_deg(static_cast<double>(varus_deg));
    bool is_balanced = !state.varus_rad.has_value();
    if (ImGui::Checkbox("balanced (B)", &is_balanced))
      state.varus_rad = is_balanced ? std::nullopt : std::optional(range->balanced_varus_rad);
    return state;
  }

  PlayerState with_layers(PlayerState state)
  {
    using Row = std::pair<const char*, Layer>;
    heading("layers");
    for (const auto& [name, layer] :
         {Row{"contacts (F1)", Layer::contacts}, Row{"normals (F2)", Layer::normals},
          Row{"axes (F3)", Layer::axes}, Row{"band (U)", Layer::band},
          Row{"helical axis (F4)", Layer::helical_axis}, Row{"gap map (F5)", Layer::gap_map},
          Row{"ligaments (F6)", Layer::ligaments}, Row{"paths (F7)", Layer::contact_paths},
          Row{"labels (F8)", Layer::labels}}) {
      // The panel's height is that of a small screen.
      if (layer == Layer::labels || layer == Layer::band) ImGui::SameLine(8.0F * em_px);
      bool is_shown = state.layers.has(layer);
      ImGui::BeginDisabled(!range->available.has(layer));
      if (ImGui::Checkbox(name, &is_shown)) state.layers.set(layer, is_shown);
      ImGui::EndDisabled();
    }
    return state;
  }

  void draw_help_lines(const char* title, std::span<const HelpLine> lines)
  {
    ImGui::TextDisabled("%s", title);
    for (const HelpLine& line : lines) {
      ImGui::Text("%s", line.keys);
      ImGui::SameLine(8.0F * em_px);
      ImGui::Text("%s", line.description);
    }
  }

  // "plantarflexion" is twice as long as "flexion".
  float column_px() const { return (has_own_words(kind()) ? 1.7F * column_em : column_em) * em_px; }

  void label(const char* text)
  {
    ImGui::TextColored(quiet_colour, "%s", text);
    ImGui::SameLine(column_px());
  }

  void draw_angle(const char* name, double angle_rad, const char* remark)
  {
    label(name);
    ImGui::Text("%.1f°", shown_deg(angle_rad));
    if (remark == nullptr) return;
    ImGui::SameLine(2.0F * column_px());
    ImGui::TextColored(quiet_colour, "%s", remark);
  }

  /// Flexion (0) or varus (1) with the names of the joint's kind; if both directions have names: "abduction
  /// 5".
  void draw_rotation(std::size_t k, double angle_rad, const char* remark)
  {
    const bool is_other_way = has_own_words(kind()) && shown_deg(angle_rad) < 0.0;
    const CoordinateWords& words = kind().words[k];
    draw_angle(is_other_way ? words.negative : words.positive, is_other_way ? -angle_rad : angle_rad, remark);
  }

  const char* varus_remark()
  {
    if (range->is_varus_free) return "solved";
    if (readout->pose.is_varus_clamped) return "end of the range";
    return readout->is_varus_balanced ? "balanced" : nullptr;
  }

  /// Above those of the attitude, with a heading for both.
  void draw_own_angles(const ClinicalCoordinates& clinical)
  {
    ImGui::TextColored(quiet_colour, "joint (Grood-Suntay)");
    draw_rotation(0, clinical.flexion_rad, nullptr);
    draw_rotation(1, clinical.varus_rad, nullptr);
    ImGui::TextColored(quiet_colour, "attitude, about axes turned with Delta");
  }

  void draw_gap()
  {
    const GapReading& gap = readout->gap;
    if (gap.source == GapSource::cells || gap.source == GapSource::two_sided) {
      label("gap");
      draw_mm("medial", gap.compartment_mm[0]);
      label("");
      draw_mm("lateral", gap.compartment_mm[1]);
    } else if (gap.source != GapSource::none) {
      const bool is_overlapping = gap.penetration_mm > 0.0;
      label(is_overlapping ? "overlap" : "gap");
      draw_mm("whole joint", is_overlapping ? gap.penetration_mm : gap.gap_mm);
    } else {
      label("gap");
      ImGui::Text("not measured");
    }
    if (is_small(picture)) return;
    label("");
    ImGui::TextColored(quiet_colour, "%s", name_of(gap.source));
  }

  void draw_swatch(const VertexColour& colour, const std::string& text)
  {
    if (text.empty()) {
      ImGui::NewLine();
      return;
    }
    const float side = 0.8F * em_px;
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled(corner, ImVec2(corner.x + side, corner.y + side),
                                              packed(colour));
    ImGui::Dummy(ImVec2(side, side));
    ImGui::SameLine();
    ImGui::TextUnformatted(text.c_str());
  }

  void draw_legend(const Legend& legend)
  {
    const float em = em_px;
    ImGui::BeginGroup();
    ImGui::TextUnformatted(legend.title.c_str());
    ImGui::SameLine();
    draw_swatch(legend.below, legend.below_label);
    draw_bar(legend, legend_width_em * em, 0.8F * em);
    ImGui::Text("%g to %g", legend.lowest, legend.highest);
    if (!legend.beyond_label.empty()) {
      ImGui::SameLine();
      if (legend.beyond)
        draw_swatch(*legend.beyond, legend.beyond_label);
      else
        ImGui::TextColored(quiet_colour, "then %s", legend.beyond_label.c_str());
    }
    ImGui::EndGroup();
  }

  void draw_axis_labels(std::span<const Label> labels)
  {
    int n = 0;
    for (const Label& axis : labels) {
      if (n++ % labels_a_row != 0) ImGui::SameLine(static_cast<float>((n - 1) % labels_a_row) * 7.4F * em_px);
      draw_swatch(axis.colour, axis.name);
    }
  }

  const JointKind& kind() const { return joint_kind(options.joint); }

  GuiOptions options;
  std::vector<std::string> set_labels;
  std::array<std::string, 3> held_labels;                  ///< in the order of holdable
  float em_px, panel_width_px, bar_height_px;              ///< size of the text, and of the controls
  float panel_room_px = 0.0F, panel_text_width_px = 0.0F;  ///< below the controls of the panel, last frame
  float shown_varus_deg = 0.0F;                            ///< while playing, until then
  double varus_until_s = 0.0;
  // Of the present frame.
  const GuiFrame* frame = nullptr;
  const PlayerRange* range = nullptr;
  const Readout* readout = nullptr;
  Viewport uncovered, picture;    ///< left and above of the controls; that below the warnings
  ImVec4 numbers_px, legends_px;  ///< boxes of the last frame
};

}  // namespace

struct Gui::Inner : Panels {
  using Panels::Panels;

  ImGuiContext* context = nullptr;
  OverlayFont font;
  Overlay overlay;
  bool has_open_menu = false, closes_menu = false;
};

Gui::Gui(const GuiOptions& options)
{
  ImGui::SetAllocatorFunctions(counted_allocation, counted_release);
  open(options);
}

void Gui::open(const GuiOptions& options)
{
  inner_ = std::make_unique<Inner>(options);
  inner_->context = ImGui::CreateContext();
  ImGui::SetCurrentContext(inner_->context);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // no settings file
  io.LogFilename = nullptr;
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  set_style(static_cast<float>(options.scale));
  inner_->font = built_font(*io.Fonts, inner_->em_px);
}

Gui::~Gui()
{
  ImGui::DestroyContext(inner_->context);
}

bool Gui::set_scale(double scale)
{
  GuiOptions options = inner_->options;
  if (std::exchange(options.scale, scale) == scale) return false;
  ImGui::DestroyContext(inner_->context);
  open(options);
  return true;
}

const OverlayFont& Gui::font() const
{
  return inner_->font;
}

GuiResult Gui::frame(const GuiFrame& frame, const PlayerState& state, const PlayerRange& range,
                     const Readout& readout)
{
  ImGui::SetCurrentContext(inner_->context);
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = ImVec2(static_cast<float>(frame.width), static_cast<float>(frame.height));
  io.DeltaTime = std::max(static_cast<float>(frame.elapsed_s), least_elapsed_s);
  io.MousePos = ImVec2(static_cast<float>(frame.pointer.x_px), static_cast<float>(frame.pointer.y_px));
  io.MouseDown[0] = frame.pointer.is_left_down;
  io.MouseWheel = static_cast<float>(frame.pointer.wheel);
  ImGui::NewFrame();
  Inner& panels = *inner_;
  panels.frame = &frame;
  panels.range = &range;
  panels.readout = &readout;
  panels.uncovered = panels.area_of(frame.width, frame.height, state, frame.has_controls);
  panels.picture = free_area(frame.width, frame.height, state, frame.has_controls);
  has_open_menu = false;
  closes_menu = std::exchange(panels.closes_menu, false);
  GuiResult answer{state, Action::none};
  panels.draw_warnings(state);
  if (!state.shows_numbers) panels.numbers_px = {};
  panels.draw_labels();
  panels.legends_px = {};
  if (state.shows_numbers) panels.draw_numbers(state);
  panels.draw_legends();
  if (frame.differences != nullptr) panels.draw_differences(state);
  if (frame.has_controls) {
    if (state.shows_panel) answer = panels.with_panel(panels.with_bar(answer));
    if (answer.state.shows_help) answer = panels.with_help(answer);
  }
  panels.has_open_menu = has_open_menu && !closes_menu;
  ImGui::Render();
  Overlay& overlay = inner_->overlay;
  overlay.vertices.clear();
  overlay.indices.clear();
  overlay.commands.clear();
  overlay.panels.clear();
  const ImDrawData& data = *ImGui::GetDrawData();
  for (int i = 0; i < data.CmdListsCount; ++i) append(overlay, *data.CmdLists[i]);
  return answer;
}

const Overlay& Gui::static_overlay(GuiFrame frame, const PlayerState& state, const PlayerRange& range,
                                   const Readout& readout)
{
  // The library hides a new window for one frame and sizes it by the text of the previous frame.
  constexpr int frames_to_fit = 3;
  frame.has_controls = false;
  for (int i = 0; i < frames_to_fit; ++i) this->frame(frame, state, range, readout);
  return inner_->overlay;
}

bool Gui::close_menu()
{
  return inner_->closes_menu = inner_->has_open_menu;
}

const Overlay& Gui::overlay() const
{
  return inner_->overlay;
}

Viewport Gui::free_area(int width, int height, const PlayerState& state, bool has_controls) const
{
  ImGui::SetCurrentContext(inner_->context);
  const Viewport area = inner_->area_of(width, height, state, has_controls);
  const int strip_px = Inner::covered_px(inner_->warnings_height_px(area));
  const int plots_px = Inner::covered_px(inner_->differences_height_px(area));
  return {0, strip_px, area.width, std::max(1, area.height - strip_px - plots_px)};
}

ColourKey colour_key(const JointLayers& layers, const LayerSet& shown)
{
  ColourKey key;
  if (shown.has(Layer::gap_map) && layers.available().has(Layer::gap_map))
    key.gaps = &layers.legend(Layer::gap_map);
  if (shown.has(Layer::ligaments) && layers.available().has(Layer::ligaments))
    key.strain = &layers.legend(Layer::ligaments);
  // The helical axis is the last label.
  const std::span<const Label> labels = JointLayers::axis_labels();
  const std::size_t first = shown.has(Layer::axes) ? 0 : labels.size() - 1;
  const std::size_t last = shown.has(Layer::helical_axis) ? labels.size() : labels.size() - 1;
  key.axes = labels.subspan(first, last - first);
  return key;
}

std::uint64_t gui_allocation_count()
{
  return n_allocations;
}

}  // namespace vrda::view
