#include "view/gui.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "view/overlay_text.hpp"

namespace vrda::gui_test {

constexpr double frame_s = 1.0 / 60.0;

view::PlayerRange sample_range()
{
  view::PlayerRange range;
  range.n_sets = 3;
  range.first_varus_rad = rad_from_deg(-5.0);
  range.last_varus_rad = rad_from_deg(5.0);
  for (const std::string& name : view::layer_names()) range.available.set(*view::layer_named(name), true);
  return range;
}

view::PlayerState sample_state()
{
  view::PlayerState state;
  state.timeline = view::with_range({}, 0.0, rad_from_deg(90.0));
  return state;
}

view::Legend sample_legend()
{
  view::Legend legend;
  legend.title = "gap, mm";
  legend.highest = 6.0;
  legend.palette = view::gap_palette();
  legend.below_label = "overlap";
  legend.beyond_label = "no colour";
  return legend;
}

/// An interface of a given size with a simulated user.
class Desk {
 public:
  explicit Desk(int width = 800, int height = 600)
      : gui_({"A knee", {"degree_6_recontacted", "degree_6", "raw"}, 1.0})
  {
    frame_.width = width;
    frame_.height = height;
    frame_.elapsed_s = frame_s;
    readout_.pose.status = store::PoseStatus::solved;
    readout_.gap = {view::GapSource::cells, 0.0, 0.1, 0.0, 0.0};
  }

  view::Action step()
  {
    const view::GuiResult answer = gui_.frame(frame_, state_, range_, readout_);
    state_ = answer.state;
    return answer.action;
  }
  /// Clicks there and returns the resulting action.
  view::Action click(double x_px, double y_px)
  {
    frame_.pointer = {x_px, y_px, false, 0.0};
    step();
    frame_.pointer.is_left_down = true;
    const view::Action pressed = step();
    frame_.pointer.is_left_down = false;
    const view::Action released = step();
    return pressed != view::Action::none ? pressed : released;
  }

  view::GuiFrame frame_;
  view::PlayerState state_ = sample_state();
  view::PlayerRange range_ = sample_range();
  view::Readout readout_;
  view::Gui gui_;
};

/// All actions triggered by clicks in the rectangle.
std::vector<view::Action> actions_in(Desk& desk, const view::Viewport& area)
{
  std::vector<view::Action> actions;
  for (int y = area.y + 4; y < area.y + area.height; y += 8) {
    for (int x = area.x + 6; x < area.x + area.width; x += 12) {
      const view::Action action = desk.click(x, y);
      if (action != view::Action::none) actions.push_back(action);
    }
  }
  return actions;
}

bool has(const std::vector<view::Action>& actions, view::Action action)
{
  return std::ranges::find(actions, action) != actions.end();
}

TEST(Gui, SetsAreNamedAsPeopleSayThem)
{
  EXPECT_EQ(view::set_label("raw"), "raw cells");
  EXPECT_EQ(view::set_label("degree_6"), "degree 6");
  EXPECT_EQ(view::set_label("degree_12_recontacted"), "degree 12, recontacted");
  EXPECT_EQ(view::set_label("zero_varus"), "zero varus");
}

TEST(Gui, TheFreeAreaIsThePictureWithoutPanelAndTimeline)
{
  const Desk desk;
  const view::Viewport free = desk.gui_.free_area(800, 600, sample_state());
  EXPECT_EQ(free.x, 0);
  EXPECT_EQ(free.y, 0);
  EXPECT_GT(free.width, 500);
  EXPECT_LT(free.width, 600);
  EXPECT_GT(free.height, 500);
  EXPECT_LT(free.height, 560);
  view::PlayerState bare = sample_state();
  bare.shows_panel = false;
  EXPECT_EQ(desk.gui_.free_area(800, 600, bare).width, 800);
  EXPECT_EQ(desk.gui_.free_area(800, 600, sample_state(), false).height, 600);
  EXPECT_EQ(desk.gui_.free_area(10, 10, sample_state()).width, 1);
}

TEST(Gui, EveryButtonOfTheTimelineCanBePressed)
{
  Desk desk;
  const view::Viewport free = desk.gui_.free_area(800, 600, desk.state_);
  const std::vector<view::Action> actions =
      actions_in(desk, {0, free.height + 30, free.width, 600 - free.height - 30});
  for (const view::Action action :
       {view::Action::go_to_first, view::Action::step_back, view::Action::play_pause,
        view::Action::step_forward, view::Action::go_to_last, view::Action::next_loop, view::Action::slower,
        view::Action::faster})
    EXPECT_TRUE(has(actions, action)) << static_cast<int>(action);
}

TEST(Gui, EveryButtonOfThePanelCanBePressedOnASmallScreen)
{
  Desk desk;
  const view::Viewport free = desk.gui_.free_area(800, 600, desk.state_);
  const std::vector<view::Action> actions = actions_in(desk, {free.width, 450, 800 - free.width, 145});
  for (const view::Action action :
       {view::Action::view_front, view::Action::view_back, view::Action::view_medial,
        view::Action::view_lateral, view::Action::view_top, view::Action::view_oblique,
        view::Action::reset_view, view::Action::screenshot, view::Action::full_screen,
        view::Action::show_help})
    EXPECT_TRUE(has(actions, action)) << static_cast<int>(action);
}

TEST(Gui, TheTimelineSliderLeadsToItsEndsAndPlaysOn)
{
  Desk desk;
  desk.state_.timeline.is_playing = true;
  const view::Viewport free = desk.gui_.free_area(800, 600, desk.state_);
  desk.click(free.width - 10, free.height + 16);
  EXPECT_EQ(desk.state_.timeline.position, desk.state_.timeline.last);
  desk.click(124, free.height + 16);
  EXPECT_EQ(desk.state_.timeline.position, desk.state_.timeline.first);
  EXPECT_TRUE(desk.state_.timeline.is_playing);
}

TEST(Gui, VarusLayersAndListsAreSetInThePanel)
{
  Desk desk;
  const view::Viewport free = desk.gui_.free_area(800, 600, desk.state_);
  const double left = free.width + 14.0;
  desk.click(790, 89);
  ASSERT_TRUE(desk.state_.varus_rad.has_value());
  EXPECT_NEAR(deg_from_rad(*desk.state_.varus_rad), 5.0, 0.3);
  desk.click(left, 115);
  EXPECT_FALSE(desk.state_.varus_rad.has_value());
  desk.click(left, 218);
  EXPECT_TRUE(desk.state_.layers.has(view::Layer::contacts));
  desk.click(left, 347);
  EXPECT_TRUE(desk.state_.layers.has(view::Layer::ligaments));
  // The list of sets opens below; select its second row.
  desk.click(680, 38);
  desk.click(620, 84);
  EXPECT_EQ(desk.state_.set, 1u);
}

TEST(Gui, WhatTheJointHasNotCannotBeSwitchedOn)
{
  Desk desk;
  desk.range_.available.set(view::Layer::contacts, false);
  desk.range_.is_varus_free = true;
  const view::Viewport free = desk.gui_.free_area(800, 600, desk.state_);
  const std::vector<view::Action> none = actions_in(desk, {free.width, 60, 20, 160});
  EXPECT_FALSE(desk.state_.layers.has(view::Layer::contacts));
  EXPECT_FALSE(desk.state_.varus_rad.has_value());
}

/// Bounding box of all vertices.
Eigen::AlignedBox2d extent_of(const view::Overlay& overlay)
{
  Eigen::AlignedBox2d box;
  for (const view::OverlayVertex& vertex : overlay.vertices)
    box.extend(Eigen::Vector2d(static_cast<double>(vertex.x_px), static_cast<double>(vertex.y_px)));
  return box;
}

TEST(Gui, TheHelpPageFitsASmallScreenAndCanBeClosed)
{
  Desk desk;
  desk.state_.shows_help = true;
  for (int i = 0; i < 3; ++i) desk.step();
  const Eigen::AlignedBox2d extent = extent_of(desk.gui_.overlay());
  EXPECT_GE(extent.min().minCoeff(), 0.0);
  EXPECT_LE(extent.max().x(), 800.0);
  EXPECT_LE(extent.max().y(), 600.0);
  for (int y = 540; y < 590 && desk.state_.shows_help; y += 6) desk.click(200, y);
  EXPECT_FALSE(desk.state_.shows_help);
}

TEST(Gui, NumbersAndLegendsDoNotOverlap)
{
  for (const auto& [width, height] : {std::pair(800, 600), std::pair(1280, 960)}) {
    Desk desk(width, height);
    const view::Legend gaps = sample_legend();
    desk.frame_.key = {&gaps, &gaps, view::JointLayers::axis_labels()};
    desk.frame_.has_controls = false;
    desk.readout_.gap = {view::GapSource::travel, 0.0, 0.0, 0.0, 0.125};
    for (int i = 0; i < 3; ++i) desk.step();
    Eigen::AlignedBox2d upper, lower;
    for (const view::OverlayVertex& vertex : desk.gui_.overlay().vertices) {
      const Eigen::Vector2d p(static_cast<double>(vertex.x_px), static_cast<double>(vertex.y_px));
      (p.y() < 0.5 * height ? upper : lower).extend(p);
    }
    EXPECT_LT(upper.max().y(), 0.45 * height);
    EXPECT_GT(lower.min().y(), 0.55 * height);
    EXPECT_LT(upper.max().x(), 0.6 * width);
    EXPECT_LT(lower.max().x(), 0.6 * width);
  }
}

TEST(Gui, EveryStateOfTheNumbersIsDrawn)
{
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Desk desk;
  for (const view::GapReading& gap : {view::GapReading{view::GapSource::cells, 0, nan, nan, nan},
                                      view::GapReading{view::GapSource::two_sided, 0, 0.1, nan, nan},
                                      view::GapReading{view::GapSource::audit, nan, nan, 0.2, 0},
                                      view::GapReading{view::GapSource::travel, nan, nan, 0, 0.3},
                                      view::GapReading{view::GapSource::recontacted, nan, nan, 0, 0},
                                      view::GapReading{view::GapSource::none, nan, nan, nan, nan}}) {
    desk.readout_.gap = gap;
    desk.step();
    EXPECT_FALSE(desk.gui_.overlay().vertices.empty());
  }
  const std::size_t before = desk.gui_.overlay().vertices.size();
  desk.readout_.pose.status = store::PoseStatus::unsolved_cell;
  desk.readout_.message = "image written: knee_flexion_040.png";
  desk.step();
  EXPECT_NE(desk.gui_.overlay().vertices.size(), before);
}

TEST(Gui, TrianglesStayWithinTheirVerticesAndTheFont)
{
  Desk desk;
  for (int i = 0; i < 3; ++i) desk.step();
  const view::Overlay& overlay = desk.gui_.overlay();
  std::size_t n_indices = 0;
  for (const view::OverlayCommand& command : overlay.commands) {
    n_indices += command.n_indices;
    ASSERT_LE(command.first_index + command.n_indices, overlay.indices.size());
    EXPECT_EQ(command.n_indices % 3, 0u);
    for (std::uint32_t i = 0; i < command.n_indices; ++i)
      ASSERT_LT(command.first_vertex + overlay.indices[command.first_index + i], overlay.vertices.size());
  }
  EXPECT_EQ(n_indices, overlay.indices.size());
  const view::OverlayFont& font = desk.gui_.font();
  EXPECT_EQ(font.coverage.size(),
            static_cast<std::size_t>(font.width) * static_cast<std::size_t>(font.height));
  for (const view::OverlayVertex& vertex : overlay.vertices) {
    EXPECT_GE(std::min(vertex.u, vertex.v), 0.0F);
    EXPECT_LE(std::max(vertex.u, vertex.v), 1.0F);
  }
}

TEST(Gui, AWarmFrameAsksForNoMemory)
{
  Desk desk;
  const view::Legend gaps = sample_legend();
  desk.frame_.key = {&gaps, &gaps, view::JointLayers::axis_labels()};
  for (const bool shows_help : {true, false}) {
    desk.state_.shows_help = shows_help;
    for (int i = 0; i < 5; ++i) desk.step();
  }
  const std::uint64_t before = view::gui_allocation_count();
  EXPECT_GT(before, 0u);
  for (int i = 0; i < 200; ++i) {
    desk.state_.timeline = view::moved_to(desk.state_.timeline, rad_from_deg(0.4 * i));
    desk.frame_.pointer = {4.0 * i, 3.0 * i, false, 0.0};
    desk.step();
  }
  EXPECT_EQ(view::gui_allocation_count(), before);
}

TEST(Gui, AStillIsWholeAtOnceWhateverCameBefore)
{
  Desk fresh, used;
  for (int i = 0; i < 5; ++i) used.step();
  used.readout_.message = "a line that makes the window much wider than its numbers are";
  used.step();
  used.readout_.message = nullptr;
  const view::Overlay one =
      fresh.gui_.static_overlay(fresh.frame_, sample_state(), sample_range(), fresh.readout_);
  const view::Overlay& other =
      used.gui_.static_overlay(used.frame_, sample_state(), sample_range(), used.readout_);
  ASSERT_FALSE(one.vertices.empty());
  EXPECT_EQ(one.indices, other.indices);
  EXPECT_EQ(extent_of(one).max(), extent_of(other).max());
}

TEST(Gui, TwoInterfacesDoNotDisturbEachOther)
{
  Desk one, other(1280, 960);
  other.state_.shows_panel = false;
  for (int i = 0; i < 3; ++i) {
    one.step();
    other.step();
  }
  EXPECT_LE(extent_of(one.gui_.overlay()).max().x(), 800.0);
  EXPECT_GT(one.gui_.overlay().vertices.size(), other.gui_.overlay().vertices.size());
}

TEST(OverlayReflector, ReflectsWhatIsInAWindowAndNothingElse)
{
  const view::EyeWindows windows{{100, 0, 200, 100}, {100, 100, 200, 100}};
  const view::OverlayText text(view::panel_text_px);
  const auto drawn = [&](const view::Reflection& reflection) {
    view::Overlay overlay;
    view::clear_overlay(overlay, 300, 200);
    text.add_area(overlay, {0, 0, 100, 200}, view::paper);      // the operator's, up to the window's border
    text.add_area(overlay, {110, 10, 130, 20}, view::amber);    // left eye
    text.add_area(overlay, {250, 150, 300, 160}, view::amber);  // right eye
    view::clip_overlay(overlay, {100, 100, 150, 200});
    const std::array<Eigen::Vector2d, 3> line{Eigen::Vector2d(120, 150), {140, 150}, {140, 190}};
    text.add_line(overlay, line, 1.0, view::green);
    view::finish_overlay(overlay);
    view::OverlayReflector(windows, reflection).reflect(overlay);
    return overlay;
  };
  const view::Overlay plain = drawn({}), mirrored = drawn({true, false}), turned = drawn({true, true});
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(mirrored.vertices[k].x_px, plain.vertices[k].x_px);
  for (std::size_t k = 4; k < plain.vertices.size(); ++k) {
    SCOPED_TRACE(k);
    EXPECT_FLOAT_EQ(mirrored.vertices[k].x_px, 400.0F - plain.vertices[k].x_px);
    EXPECT_EQ(mirrored.vertices[k].y_px, plain.vertices[k].y_px);
    const float across = k < 8 ? 100.0F : 300.0F;
    EXPECT_FLOAT_EQ(turned.vertices[k].y_px, across - plain.vertices[k].y_px);
  }
  EXPECT_EQ(mirrored.commands[0].clip_px, plain.commands[0].clip_px) << "all of the frame buffer";
  EXPECT_EQ(mirrored.commands[1].clip_px, (std::array<float, 4>{250, 100, 300, 200}));
}

}  // namespace vrda::gui_test
