#include "view/gui.hpp"

#include <gtest/gtest.h>

#include <set>

#include "store/sample_model.hpp"
#include "view/overlay_text.hpp"

namespace vrda::view::gui_test {

constexpr double frame_s = 1.0 / 60.0;

PlayerRange sample_range()
{
  PlayerRange range;
  range.n_sets = 3;
  range.first_varus_rad = rad_from_deg(-5.0);
  range.last_varus_rad = rad_from_deg(5.0);
  for (const std::string& name : layer_names()) range.available.set(*layer_named(name), true);
  return range;
}

PlayerState sample_state()
{
  PlayerState state;
  state.timeline = with_range({}, 0.0, rad_from_deg(90.0));
  return state;
}

/// An interface of a given size with a simulated user.
class Desk {
 public:
  explicit Desk(int width = 800, int height = 600,
                const GuiOptions& options = {"A knee", {"degree_6_recontacted", "degree_6", "raw"}, 1.0})
      : gui_(options)
  {
    frame_.width = width;
    frame_.height = height;
    frame_.elapsed_s = frame_s;
    readout_.pose.status = store::PoseStatus::solved;
    readout_.gap = {GapSource::cells, 0.0, 0.1, 0.0, 0.0};
  }

  Action step()
  {
    const GuiResult answer = gui_.frame(frame_, state_, range_, readout_);
    state_ = answer.state;
    return answer.action;
  }
  /// Clicks there and returns the resulting action.
  Action click(double x_px, double y_px)
  {
    frame_.pointer = {x_px, y_px, false, 0.0};
    step();
    frame_.pointer.is_left_down = true;
    const Action pressed = step();
    frame_.pointer.is_left_down = false;
    const Action released = step();
    return pressed != Action::none ? pressed : released;
  }

  GuiFrame frame_;
  PlayerState state_ = sample_state();
  PlayerRange range_ = sample_range();
  Readout readout_;
  Gui gui_;
};

/// All actions triggered by clicks in the rectangle.
std::set<Action> actions_in(Desk& desk, const Viewport& area)
{
  std::set<Action> actions;
  for (int y = area.y + 4; y < area.y + area.height; y += 8) {
    for (int x = area.x + 6; x < area.x + area.width; x += 12) actions.insert(desk.click(x, y));
  }
  return actions;
}

TEST(Gui, EveryButton)
{
  Desk desk;
  const Viewport free = desk.gui_.free_area(800, 600, desk.state_);
  std::set<Action> actions = actions_in(desk, {0, free.height + 30, free.width, 600 - free.height - 30});
  actions.merge(actions_in(desk, {free.width, 450, 800 - free.width, 145}));
  for (const Action action :
       {Action::go_to_first, Action::step_back, Action::play_pause, Action::step_forward, Action::go_to_last,
        Action::next_loop, Action::slower, Action::faster, Action::view_front, Action::view_back,
        Action::view_medial, Action::view_lateral, Action::view_top, Action::view_oblique, Action::reset_view,
        Action::screenshot, Action::full_screen, Action::show_help})
    EXPECT_TRUE(actions.contains(action)) << static_cast<int>(action);
}

TEST(Gui, UnavailableLayer)
{
  Desk desk;
  desk.range_.available.set(Layer::contacts, false);
  desk.range_.is_varus_free = true;
  const Viewport free = desk.gui_.free_area(800, 600, desk.state_);
  actions_in(desk, {free.width, 60, 20, 160});
  EXPECT_FALSE(desk.state_.layers.has(Layer::contacts));
  EXPECT_FALSE(desk.state_.varus_rad.has_value());
}

/// Bounding box of all vertices.
Eigen::AlignedBox2d extent_of(const Overlay& overlay)
{
  Eigen::AlignedBox2d box;
  for (const OverlayVertex& vertex : overlay.vertices)
    box.extend(Eigen::Vector2d(static_cast<double>(vertex.x_px), static_cast<double>(vertex.y_px)));
  return box;
}

// The numbers show the verdict on the shown set only.
TEST(Gui, VerdictOfTheShownSet)
{
  const auto n_vertices = [](const std::vector<std::string>& verdicts, std::size_t set) {
    GuiOptions options{"A knee", {"two_sided", "raw"}};
    options.verdicts = verdicts;
    Gui gui(options);
    PlayerState state = sample_state();
    state.set = set;
    Readout readout;
    readout.pose.status = store::PoseStatus::solved;
    GuiFrame frame;
    frame.width = 800;
    frame.height = 600;
    return gui.static_overlay(frame, state, sample_range(), readout).vertices.size();
  };
  const std::vector<std::string> of_raw{"", "outside the published range"};
  EXPECT_EQ(n_vertices(of_raw, 0), n_vertices({}, 0));
  EXPECT_GT(n_vertices(of_raw, 1), n_vertices({}, 1));
}

// The shown motion and, thinner, that of the bones alone, which has no pose at the first flexion; only of a
// model with a prior.
TEST(Gui, RotationBesideThatOfTheBonesAlone)
{
  store::MotionModel model = test::whole_model();
  const std::vector<std::string> sets{"raw", "bones_alone"};
  const RotationPlots plots = rotation_plots(model, sets);
  ASSERT_EQ(plots.of_sets.size(), 2);
  ASSERT_EQ(plots.of_sets[0].size(), 2);
  EXPECT_EQ(plots.of_sets[1].size(), 1);
  const CurveLine &raw = plots.of_sets[0][0], &alone = plots.of_sets[0][1];
  EXPECT_EQ(alone.name, "bones alone");
  EXPECT_LT(alone.width_px, raw.width_px);
  EXPECT_TRUE(std::isnan(alone.values.front()));
  const double last_rad = rad_from_deg(model.flexion_deg.back());
  EXPECT_DOUBLE_EQ(plots.last_flexion_rad, last_rad);
  const auto wanted_deg = [&](const std::string& set) {
    const store::Motion motion(model, set);
    const store::JointPose pose = motion.at({last_rad, motion.balanced_varus_rad(last_rad)});
    return deg_from_rad(motion.own_coordinates(pose)->internal_rotation_rad);
  };
  EXPECT_NEAR(raw.values.back(), wanted_deg("raw"), 1e-5);
  EXPECT_NEAR(alone.values.back(), wanted_deg("bones_alone"), 1e-5);
  EXPECT_NE(raw.values.back(), alone.values.back());
  model.prior.reset();
  EXPECT_TRUE(rotation_plots(model, sets).of_sets.empty());
}

TEST(Gui, CardOfABundleHasItsStrain)
{
  const std::vector<Structure> structures{{"ligaments/ACL", "ACL", "", StructureGroup::ligaments}};
  Looks looks{{StructureLook{}}, 0};
  const CurveLine strain{"ACL", {-1.0F, 2.0F, 5.0F}};
  const auto n_vertices = [&](std::span<const CurveLine> lines) {
    Desk desk;
    StructureList list{structures, looks, {{}, lines, 0.5}};
    desk.frame_.list = &list;
    desk.state_.shows_structures = true;
    for (int frame = 0; frame < 3; ++frame) desk.step();
    return desk.gui_.overlay().vertices.size();
  };
  EXPECT_GT(n_vertices({&strain, 1}), n_vertices({}));
}

// In a small window all warnings are complete above the picture; a large one has that of the set in its
// panel. None is over the joint.
TEST(Gui, WarningsAreBesideThePicture)
{
  constexpr VertexColour amber{255, 184, 77, 255};
  const std::string sentence =
      "A warning that is as long as those on the meshes of a scanned knee, with numbers.";
  for (const int height : {600, 1200}) {
    SCOPED_TRACE(height);
    GuiOptions options{"A knee", {"raw"}, 1.0};
    options.warnings.assign(5, sentence);
    options.remark = sentence + " " + sentence + " " + sentence;
    options.remarked_set = 0;
    Desk desk(height * 4 / 3, height, options);
    for (int i = 0; i < 3; ++i) desk.step();
    const Viewport free = desk.gui_.free_area(desk.frame_.width, height, desk.state_);
    int n_over = 0, n_beside = 0;
    for (const OverlayVertex& vertex : desk.gui_.overlay().vertices) {
      if (!(vertex.colour == amber) || vertex.y_px <= static_cast<float>(free.y)) continue;
      ++(vertex.x_px < static_cast<float>(free.width) ? n_over : n_beside);
    }
    EXPECT_EQ(n_over, 0);
    EXPECT_EQ(n_beside > 0, height > 600);
    EXPECT_LT(free.y, (free.y + free.height) / 3);
  }
}

TEST(Gui, NumbersOfTwoJointsAreBelowThem)
{
  Desk desk(1280, 960, {.title = "A knee", .sets = {"raw"}, .has_differences = true});
  Differences differences;
  differences.captions = {"First: flexion 30", "Second: flexion 30"};
  desk.frame_.differences = &differences;
  desk.state_.shows_numbers = true;
  desk.range_.n_sets = 1;
  const Overlay& drawn = desk.gui_.static_overlay(desk.frame_, desk.state_, desk.range_, desk.readout_);
  const Viewport free = desk.gui_.free_area(1280, 960, desk.state_, false);
  EXPECT_GE(extent_of(drawn).min().y(), free.y + free.height);
}

// A menu of the panel is closed by Escape alone, and only then is nothing left to close.
TEST(Gui, MenuClosesWithoutAChoice)
{
  Desk desk;
  const Viewport free = desk.gui_.free_area(800, 600, desk.state_);
  desk.step();
  int n_opened = 0;
  for (int y = 60; y < 600; y += 8) {
    desk.click(free.width + 40.0, y);
    desk.step();
    const PlayerState before = desk.state_;
    if (!desk.gui_.close_menu()) continue;
    ++n_opened;
    desk.step();
    desk.step();
    EXPECT_FALSE(desk.gui_.close_menu());
    EXPECT_EQ(desk.state_.set, before.set);
    EXPECT_EQ(desk.state_.mode, before.mode);
  }
  EXPECT_GT(n_opened, 2);
}

// Over a small picture the numbers are smaller and leave out what is not a number.
TEST(Gui, SmallPicture)
{
  const auto corner_px = [](int width, int height) {
    Desk desk(width, height);
    Eigen::Array2f corner(0.0F, 0.0F);
    for (const OverlayVertex& vertex :
         desk.gui_.static_overlay(desk.frame_, desk.state_, desk.range_, desk.readout_).vertices)
      corner = corner.max(Eigen::Array2f(vertex.x_px, vertex.y_px));
    return corner;
  };
  // A window of 800 x 600 with its panel leaves a picture of this width.
  const Eigen::Array2f large = corner_px(1280, 960), small = corner_px(560, 531);
  EXPECT_LT(small.x(), 0.85F * large.x());
  EXPECT_LT(small.y(), 0.8F * large.y() - 15.0F) << "without the title";
}

// The help page fits a small screen and can be closed.
TEST(Gui, HelpPage)
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

TEST(OverlayReflector, WindowsOnly)
{
  const EyeWindows windows{{100, 0, 200, 100}, {100, 100, 200, 100}};
  const OverlayText text(panel_text_px);
  const auto drawn = [&](const Reflection& reflection) {
    Overlay overlay;
    clear_overlay(overlay, 300, 200);
    text.add_area(overlay, {0, 0, 100, 200}, paper);      // the operator's, up to the window's border
    text.add_area(overlay, {110, 10, 130, 20}, amber);    // left eye
    text.add_area(overlay, {250, 150, 300, 160}, amber);  // right eye
    clip_overlay(overlay, {100, 100, 150, 200});
    const std::array<Eigen::Vector2d, 3> line{Eigen::Vector2d(120, 150), {140, 150}, {140, 190}};
    text.add_line(overlay, line, 1.0, green);
    finish_overlay(overlay);
    OverlayReflector(windows, reflection).reflect(overlay);
    return overlay;
  };
  const Overlay plain = drawn({}), mirrored = drawn({true, false}), turned = drawn({true, true});
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

}  // namespace vrda::view::gui_test
