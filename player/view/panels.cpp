// The controls: timeline, side panel, help page.
#include "view/panels.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/units.hpp"

namespace vrda::view {
namespace {

constexpr ImGuiWindowFlags fixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav;
// Keys are handled by the player, so sliders accept no typed numbers.
constexpr ImGuiSliderFlags sliding = ImGuiSliderFlags_NoInput | ImGuiSliderFlags_AlwaysClamp;

struct Press {
  const char* label;
  view::Action action;
};

bool is_pressed(const char* label, float width)
{
  return ImGui::Button(label, ImVec2(width, 0.0F));
}

/// Buttons side by side over the available width; returns the action of the pressed one.
view::Action row_of(std::span<const Press> presses)
{
  const float spacing = ImGui::GetStyle().ItemSpacing.x;
  const auto n = static_cast<float>(presses.size());
  const float width = (ImGui::GetContentRegionAvail().x - spacing * (n - 1.0F)) / n;
  view::Action action = view::Action::none;
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

using view::name_of;

/// Combo box over the enum values 0 ... last; returns the chosen value.
template <typename Enum>
Enum choice(const char* id, Enum value, Enum last, float width = -1.0F)
{
  ImGui::SetNextItemWidth(width);
  if (!ImGui::BeginCombo(id, name_of(value))) return value;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    if (ImGui::Selectable(name_of(static_cast<Enum>(i)), static_cast<int>(value) == i))
      value = static_cast<Enum>(i);
  }
  ImGui::EndCombo();
  return value;
}

std::size_t chosen_set(const PanelView& view, std::size_t set)
{
  ImGui::SetNextItemWidth(-1.0F);
  if (!ImGui::BeginCombo("##set", view.set_labels[set].c_str())) return set;
  for (std::size_t i = 0; i < view.set_labels.size(); ++i) {
    if (ImGui::Selectable(view.set_labels[i].c_str(), i == set)) set = i;
  }
  ImGui::EndCombo();
  return set;
}

view::FixedObject chosen_held(const PanelView& view, view::FixedObject held)
{
  const auto label = [&](view::FixedObject one) {
    return view.held_labels[static_cast<std::size_t>(one)].c_str();
  };
  ImGui::SetNextItemWidth(-1.0F);
  if (!ImGui::BeginCombo("##held", label(held))) return held;
  for (const view::FixedObject one :
       {view::FixedObject::moving, view::FixedObject::reference, view::FixedObject::push}) {
    if (ImGui::Selectable(label(one), one == held)) held = one;
  }
  ImGui::EndCombo();
  return held;
}

view::PlayerState with_varus(const PanelView& view, view::PlayerState state)
{
  const view::PlayerRange& range = view.range;
  float varus_deg = as_deg(view::wanted_varus_rad(state, range));
  ImGui::Spacing();
  ImGui::TextDisabled("%s (Up, Down)", view.kind.words[1].positive);
  ImGui::SameLine(10.0F * view.layout.em_px);
  ImGui::Text("%.1f°", static_cast<double>(varus_deg));
  if (range.is_varus_free || range.first_varus_rad >= range.last_varus_rad) {
    ImGui::TextDisabled(range.is_varus_free ? "fixed by this set" : "one angle only");
    return state;
  }
  ImGui::SetNextItemWidth(-1.0F);
  if (ImGui::SliderFloat("##varus", &varus_deg, as_deg(range.first_varus_rad), as_deg(range.last_varus_rad),
                         "", sliding))
    state.varus_rad = rad_from_deg(static_cast<double>(varus_deg));
  bool is_balanced = !state.varus_rad.has_value();
  if (ImGui::Checkbox("balanced (B)", &is_balanced))
    state.varus_rad = is_balanced ? std::nullopt : std::optional(range.balanced_varus_rad);
  return state;
}

view::PlayerState with_layers(const PanelView& view, view::PlayerState state)
{
  struct Row {
    const char* label;
    view::Layer layer;
  };
  heading("layers");
  for (const Row row :
       {Row{"contacts (F1)", view::Layer::contacts}, Row{"normals (F2)", view::Layer::normals},
        Row{"axes (F3)", view::Layer::axes}, Row{"band (U)", view::Layer::band},
        Row{"helical axis (F4)", view::Layer::helical_axis}, Row{"gap map (F5)", view::Layer::gap_map},
        Row{"ligaments (F6)", view::Layer::ligaments}, Row{"paths (F7)", view::Layer::contact_paths},
        Row{"labels (F8)", view::Layer::labels}}) {
    // The panel's height is that of a small screen.
    if (row.layer == view::Layer::labels || row.layer == view::Layer::band)
      ImGui::SameLine(8.0F * view.layout.em_px);
    bool is_shown = state.layers.has(row.layer);
    ImGui::BeginDisabled(!view.range.available.has(row.layer));
    if (ImGui::Checkbox(row.label, &is_shown)) state.layers.set(row.layer, is_shown);
    ImGui::EndDisabled();
  }
  return state;
}

/// Two rows of buttons.
view::Action rows_of(std::span<const Press> first, std::span<const Press> second)
{
  const view::Action upper = row_of(first), lower = row_of(second);
  return upper != view::Action::none ? upper : lower;
}

view::Action pressed_view()
{
  heading("view (1 ... 6, R)");
  return rows_of(
      std::array{Press{"front", view::Action::view_front}, Press{"back", view::Action::view_back},
                 Press{"medial", view::Action::view_medial}},
      std::array{Press{"lateral", view::Action::view_lateral}, Press{"top", view::Action::view_top},
                 Press{"oblique", view::Action::view_oblique}});
}

view::Action pressed_tool()
{
  ImGui::Spacing();
  return rows_of(
      std::array{Press{"reset (R)", view::Action::reset_view},
                 Press{"picture (P)", view::Action::screenshot}},
      std::array{Press{"full (F)", view::Action::full_screen}, Press{"help (H)", view::Action::show_help}});
}

void draw_help_lines(const PanelView& view, const char* title, std::span<const view::HelpLine> lines)
{
  ImGui::TextDisabled("%s", title);
  for (const view::HelpLine& line : lines) {
    ImGui::Text("%s", line.keys);
    ImGui::SameLine(8.0F * view.layout.em_px);
    ImGui::Text("%s", line.description);
  }
}

view::Timeline with_timeline_slider(const PanelView& view, view::Timeline timeline, float em)
{
  const auto steps = [&timeline](double position) {
    return static_cast<float>(view::steps_of_position(timeline.axis, position));
  };
  float at = steps(timeline.position);
  ImGui::AlignTextToFramePadding();
  if (view.range.key_name != nullptr) {
    ImGui::Text("%s %.4g", view.range.key_name, view.readout.pose.key);
  } else {
    ImGui::Text("%s %.1f°", view.kind.words[0].positive, static_cast<double>(at));
  }
  ImGui::SameLine(8.0F * em);
  ImGui::SetNextItemWidth(-1.0F);
  const bool is_moved =
      ImGui::SliderFloat("##flexion", &at, steps(timeline.first), steps(timeline.last), "", sliding);
  draw_marks(view, timeline);
  if (!is_moved) return timeline;
  return view::moved_to(timeline, view::position_of_steps(timeline.axis, static_cast<double>(at)));
}

}  // namespace

GuiResult with_bar(const PanelView& view, GuiResult answer)
{
  const float em = view.layout.em_px;
  const float width = static_cast<float>(view.frame.width) - view.layout.panel_width_px;
  ImGui::SetNextWindowPos(ImVec2(0.0F, static_cast<float>(view.frame.height) - view.layout.bar_height_px));
  ImGui::SetNextWindowSize(ImVec2(width, view.layout.bar_height_px));
  ImGui::Begin("timeline", nullptr, fixed | ImGuiWindowFlags_NoScrollbar);
  view::Timeline& timeline = answer.state.timeline;
  timeline = with_timeline_slider(view, timeline, em);
  constexpr std::array before{Press{"|<", view::Action::go_to_first}, Press{"<", view::Action::step_back}};
  constexpr std::array behind{Press{">", view::Action::step_forward}, Press{">|", view::Action::go_to_last}};
  for (const Press& press : before) {
    if (is_pressed(press.label, 2.4F * em)) answer.action = press.action;
    ImGui::SameLine();
  }
  if (is_pressed(timeline.is_playing ? "pause###play" : "play###play", 5.0F * em))
    answer.action = view::Action::play_pause;
  for (const Press& press : behind) {
    ImGui::SameLine();
    if (is_pressed(press.label, 2.4F * em)) answer.action = press.action;
  }
  ImGui::SameLine(0.0F, em);
  ImGui::PushID("loop");
  if (is_pressed(view::name_of(timeline.loop), 5.5F * em)) answer.action = view::Action::next_loop;
  ImGui::PopID();
  ImGui::SameLine(0.0F, em);
  if (is_pressed("-", 2.0F * em)) answer.action = view::Action::slower;
  ImGui::SameLine();
  if (is_pressed("+", 2.0F * em)) answer.action = view::Action::faster;
  ImGui::SameLine();
  ImGui::Text(timeline.axis == view::TimelineAxis::flexion ? "%.0f°/s" : "%.0f frames/s",
              timeline.speed_steps_s);
  ImGui::End();
  return answer;
}

GuiResult with_panel(const PanelView& view, GuiResult answer)
{
  const float left = static_cast<float>(view.frame.width) - view.layout.panel_width_px;
  ImGui::SetNextWindowPos(ImVec2(left, 0.0F));
  ImGui::SetNextWindowSize(ImVec2(view.layout.panel_width_px, static_cast<float>(view.frame.height)));
  ImGui::Begin("panel", nullptr, fixed);
  ImGui::TextDisabled("set (S)");
  view::PlayerState& state = answer.state;
  state.set = chosen_set(view, state.set);
  state = with_varus(view, state);
  heading("draw mode (M), background (K)");
  state.mode = choice("##mode", state.mode, view::DrawMode::textured, 8.4F * view.layout.em_px);
  ImGui::SameLine();
  state.backdrop = choice("##backdrop", state.backdrop, view::Backdrop::black);
  state = with_layers(view, state);
  heading("fixed on screen (O)");
  state.fixed_object = chosen_held(view, state.fixed_object);
  for (const view::Action action : {pressed_view(), pressed_tool()}) {
    if (action != view::Action::none) answer.action = action;
  }
  ImGui::End();
  return answer;
}

GuiResult with_help(const PanelView& view, GuiResult answer)
{
  const ImVec2 middle(0.5F * static_cast<float>(view.frame.width),
                      0.5F * static_cast<float>(view.frame.height));
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, ImVec2(0.5F, 0.5F));
  ImGui::SetNextWindowFocus();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1.0F);
  ImGui::Begin("help", nullptr, fixed | ImGuiWindowFlags_AlwaysAutoResize);
  draw_help_lines(view, "Keys", view::key_help());
  ImGui::Spacing();
  draw_help_lines(view, "Mouse", view::mouse_help());
  ImGui::Spacing();
  if (is_pressed("close (Esc)", 8.0F * view.layout.em_px)) answer.state.shows_help = false;
  ImGui::End();
  ImGui::PopStyleVar();
  return answer;
}

// Display only: readouts and legends.

namespace {

constexpr ImGuiWindowFlags text_only = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                       ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                                       ImGuiWindowFlags_NoBringToFrontOnFocus;
constexpr float backing =
    0.85F;  // opacity; less leaves too little contrast, since blending is in linear light
constexpr float column_em = 5.0F, legend_width_em = 10.0F, message_width_em = 22.0F;
constexpr int labels_a_row = 3;
const ImVec4 warning_colour(1.0F, 0.72F, 0.30F, 1.0F), quiet_colour(0.72F, 0.76F, 0.80F, 1.0F);

// "plantarflexion" is twice as long as "flexion".
float column_em_of(const PanelView& view)
{
  return has_own_words(view.kind) ? 1.7F * column_em : column_em;
}

void label(const PanelView& view, const char* text)
{
  ImGui::TextColored(quiet_colour, "%s", text);
  ImGui::SameLine(column_em_of(view) * view.layout.em_px);
}

/// Degrees rounded to 0.1, without negative zero.
double shown_deg(double angle_rad)
{
  return std::round(deg_from_rad(angle_rad) * 10.0) / 10.0 + 0.0;
}

void draw_angle(const PanelView& view, const char* name, double angle_rad, const char* remark)
{
  label(view, name);
  ImGui::Text("%.1f°", shown_deg(angle_rad));
  if (remark == nullptr) return;
  ImGui::SameLine(2.0F * column_em_of(view) * view.layout.em_px);
  ImGui::TextColored(quiet_colour, "%s", remark);
}

/// Flexion (0) or varus (1) with the names of the joint's kind; if both directions have names: "abduction 5".
void draw_rotation(const PanelView& view, std::size_t k, double angle_rad, const char* remark)
{
  const bool is_other_way = has_own_words(view.kind) && shown_deg(angle_rad) < 0.0;
  const CoordinateWords& words = view.kind.words[k];
  draw_angle(view, is_other_way ? words.negative : words.positive, is_other_way ? -angle_rad : angle_rad,
             remark);
}

const char* varus_remark(const PanelView& view)
{
  if (view.range.is_varus_free) return "solved";
  if (view.readout.pose.is_varus_clamped) return "end of the range";
  return view.readout.is_varus_balanced ? "balanced" : nullptr;
}

/// Above those of the attitude, with a heading for both.
void draw_own_angles(const PanelView& view, const ClinicalCoordinates& clinical)
{
  ImGui::TextColored(quiet_colour, "joint (Grood-Suntay)");
  draw_rotation(view, 0, clinical.flexion_rad, nullptr);
  draw_rotation(view, 1, clinical.varus_rad, nullptr);
  ImGui::TextColored(quiet_colour, "attitude, about axes turned with Delta");
}

/// Rotation and translation that the attitude does not contain, with the names of their directions.
void draw_joint(const ClinicalCoordinates& joint)
{
  ImGui::Text("%s rotation %.1f°", joint.internal_rotation_rad < 0.0 ? "external" : "internal",
              std::abs(shown_deg(joint.internal_rotation_rad)));
  ImGui::Text("%s %.1f mm", joint.anterior_mm < 0.0 ? "posterior" : "anterior", std::abs(joint.anterior_mm));
}

const char* name_of(view::GapSource source)
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

void draw_gap(const PanelView& view)
{
  const view::GapReading& gap = view.readout.gap;
  if (gap.source == view::GapSource::cells || gap.source == view::GapSource::two_sided) {
    label(view, "gap");
    draw_mm("medial", gap.medial_mm);
    label(view, "");
    draw_mm("lateral", gap.lateral_mm);
  } else if (gap.source != view::GapSource::none) {
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

ImU32 packed(const view::VertexColour& colour)
{
  return IM_COL32(colour[0], colour[1], colour[2], 255);
}

void draw_swatch(const PanelView& view, const view::VertexColour& colour, const std::string& text)
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

/// Interpolates the palette linearly, like colour_of().
void draw_bar(const view::Legend& legend, float width, float height)
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

void draw_legend(const PanelView& view, const view::Legend& legend)
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

void draw_axis_labels(const PanelView& view, std::span<const view::Label> labels)
{
  int n = 0;
  for (const view::Label& axis : labels) {
    if (n++ % labels_a_row != 0)
      ImGui::SameLine(static_cast<float>((n - 1) % labels_a_row) * 7.4F * view.layout.em_px);
    draw_swatch(view, axis.colour, axis.name);
  }
}

}  // namespace

void draw_numbers(const PanelView& view, const view::PlayerState& state)
{
  const store::JointPose& pose = view.readout.pose;
  ImGui::SetNextWindowPos(ImVec2(0.0F, static_cast<float>(view.picture.y)));
  ImGui::SetNextWindowBgAlpha(backing);
  ImGui::Begin("numbers", nullptr, text_only | ImGuiWindowFlags_AlwaysAutoResize);
  if (!view.title.empty()) ImGui::Text("%s", view.title.c_str());
  if (view.readout.clinical) draw_own_angles(view, *view.readout.clinical);
  draw_rotation(view, 0, pose.attitude.flexion_rad, pose.is_flexion_clamped ? "end of the range" : nullptr);
  draw_rotation(view, 1, pose.attitude.varus_rad, varus_remark(view));
  if (pose.status == store::PoseStatus::solved) {
    if (view.readout.joint) draw_joint(*view.readout.joint);
    draw_gap(view);
  } else {
    ImGui::TextColored(warning_colour, "no pose");
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

void draw_legends(const PanelView& view, const view::PlayerState& state)
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

// Names of bones and ligaments over the picture.

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
        const bool is_beside =
            corner.x + size.x + 2.0F * margin < other.x || corner.x > other.z + 2.0F * margin;
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
