#include "view/gui.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cfloat>
#include <cmath>
#include <cstdlib>

#include "view/overlay_text.hpp"
#include "view/panels.hpp"

namespace vrda::view {
namespace {

constexpr double text_px = 15.0;  // at scale 1: readable at arm's length at 96 dots per inch
constexpr float panel_width_em = 16.0F, bar_height_em = 4.6F;
constexpr float least_elapsed_s = 1e-4F;  // the library requires a positive time step

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

view::OverlayVertex vertex_of(const ImDrawVert& vertex)
{
  const auto byte = [&](int shift) { return static_cast<std::uint8_t>((vertex.col >> shift) & 0xFFU); };
  return {vertex.pos.x,
          vertex.pos.y,
          vertex.uv.x,
          vertex.uv.y,
          {byte(IM_COL32_R_SHIFT), byte(IM_COL32_G_SHIFT), byte(IM_COL32_B_SHIFT), byte(IM_COL32_A_SHIFT)}};
}

void append(view::Overlay& overlay, const ImDrawList& list)
{
  const auto first_vertex = static_cast<std::uint32_t>(overlay.vertices.size());
  const auto first_index = static_cast<std::uint32_t>(overlay.indices.size());
  for (const ImDrawVert& vertex : list.VtxBuffer) overlay.vertices.push_back(vertex_of(vertex));
  for (const ImDrawIdx index : list.IdxBuffer) overlay.indices.push_back(index);
  for (const ImDrawCmd& command : list.CmdBuffer) {
    if (command.ElemCount == 0) continue;
    const ImVec4& clip = command.ClipRect;
    overlay.commands.push_back({{clip.x, clip.y, clip.z, clip.w},
                                first_index + command.IdxOffset,
                                command.ElemCount,
                                first_vertex + command.VtxOffset});
  }
}

}  // namespace

struct Gui::Inner {
  ImGuiContext* context = nullptr;
  std::string title;
  std::string joint;
  std::vector<std::string> set_labels;
  std::array<std::string, 3> held_labels;  ///< in the order of view::FixedObject
  std::vector<std::string> warnings;
  bool has_doubtful_poses = false;
  GuiLayout layout;
  view::OverlayFont font;
  view::Overlay overlay;
};

Gui::Gui(const GuiOptions& options) : inner_(std::make_unique<Inner>())
{
  ImGui::SetAllocatorFunctions(counted_allocation, counted_release);
  inner_->context = ImGui::CreateContext();
  ImGui::SetCurrentContext(inner_->context);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // no settings file
  io.LogFilename = nullptr;
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  inner_->title = options.title;
  inner_->held_labels = {options.moving + " fixed", options.reference + " fixed", "direction of push fixed"};
  inner_->warnings = options.warnings;
  inner_->has_doubtful_poses = options.has_doubtful_poses;
  inner_->joint = options.joint;
  for (const std::string& set : options.sets) inner_->set_labels.push_back(set_label(set));
  inner_->layout.em_px = static_cast<float>(std::round(text_px * options.scale));
  inner_->layout.panel_width_px = panel_width_em * inner_->layout.em_px;
  inner_->layout.bar_height_px = bar_height_em * inner_->layout.em_px;
  set_style(static_cast<float>(options.scale));
  inner_->font = built_font(*io.Fonts, inner_->layout.em_px);
}

Gui::~Gui()
{
  ImGui::DestroyContext(inner_->context);
}

const view::OverlayFont& Gui::font() const
{
  return inner_->font;
}

GuiResult Gui::frame(const GuiFrame& frame, const view::PlayerState& state, const view::PlayerRange& range,
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
  const PanelView view{frame,
                       inner_->layout,
                       range,
                       readout,
                       inner_->title,
                       inner_->set_labels,
                       inner_->held_labels,
                       joint_kind(inner_->joint),
                       inner_->warnings,
                       free_area(frame.width, frame.height, state, frame.has_controls)};
  GuiResult answer{state, view::Action::none};
  draw_warnings(view);
  draw_labels(view);
  if (state.shows_numbers) draw_numbers(view, state);
  draw_legends(view, state);
  if (frame.has_controls) {
    if (state.shows_panel) answer = with_panel(view, with_bar(view, answer));
    if (answer.state.shows_help) answer = with_help(view, answer);
  }
  ImGui::Render();
  view::Overlay& overlay = inner_->overlay;
  overlay.vertices.clear();
  overlay.indices.clear();
  overlay.commands.clear();
  const ImDrawData& data = *ImGui::GetDrawData();
  for (int i = 0; i < data.CmdListsCount; ++i) append(overlay, *data.CmdLists[i]);
  return answer;
}

const view::Overlay& Gui::static_overlay(GuiFrame frame, const view::PlayerState& state,
                                         const view::PlayerRange& range, const Readout& readout)
{
  // The library hides a new window for one frame and sizes it by the text of the previous frame.
  constexpr int frames_to_fit = 3;
  frame.has_controls = false;
  for (int i = 0; i < frames_to_fit; ++i) this->frame(frame, state, range, readout);
  return inner_->overlay;
}

const view::Overlay& Gui::overlay() const
{
  return inner_->overlay;
}

view::Viewport Gui::free_area(int width, int height, const view::PlayerState& state, bool has_controls) const
{
  ImGui::SetCurrentContext(inner_->context);
  const auto covered = [](float px) { return static_cast<int>(std::ceil(px)); };
  view::Viewport area{0, 0, width, height};
  if (state.shows_panel && has_controls)
    area = {0, 0, std::max(1, width - covered(inner_->layout.panel_width_px)),
            std::max(1, height - covered(inner_->layout.bar_height_px))};
  const int strip_px =
      covered(warnings_height_px(inner_->layout, inner_->warnings, inner_->has_doubtful_poses, area));
  return {0, strip_px, area.width, std::max(1, area.height - strip_px)};
}

ColourKey colour_key(const view::JointLayers& layers, const view::LayerSet& shown)
{
  ColourKey key;
  if (shown.has(view::Layer::gap_map) && layers.available().has(view::Layer::gap_map))
    key.gaps = &layers.gap_legend();
  if (shown.has(view::Layer::ligaments) && layers.available().has(view::Layer::ligaments))
    key.strain = &layers.strain_legend();
  // The helical axis is the last label.
  const std::span<const view::Label> labels = view::JointLayers::axis_labels();
  const std::size_t first = shown.has(view::Layer::axes) ? 0 : labels.size() - 1;
  const std::size_t last = shown.has(view::Layer::helical_axis) ? labels.size() : labels.size() - 1;
  key.axes = labels.subspan(first, last - first);
  return key;
}

std::string set_label(const std::string& set)
{
  if (set == "raw") return "raw cells";
  std::string label = set;
  const std::string suffix = "_recontacted";
  const std::size_t at = label.find(suffix);
  if (at != std::string::npos) label = label.substr(0, at) + ", recontacted";
  std::replace(label.begin(), label.end(), '_', ' ');
  return label;
}

std::uint64_t gui_allocation_count()
{
  return n_allocations;
}

// The warnings of a model above the picture, and the marks on the timeline.

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
