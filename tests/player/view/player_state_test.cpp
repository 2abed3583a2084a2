// The state of a window, what is wrong with its pose, and how the scene looks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <regex>

#include "support/models.hpp"
#include "support/real_knees.hpp"
#include "support/scratch.hpp"
#include "view/image.hpp"
#include "view/player_state.hpp"

namespace vrda::view::player_state_test {

PlayerState sample_state()
{
  PlayerState state;
  state.timeline = with_range({}, 0.0, rad_from_deg(90.0));
  state.timeline.is_playing = true;
  state.timeline = moved_to(state.timeline, rad_from_deg(40.0));
  return state;
}

PlayerRange sample_range()
{
  PlayerRange range;
  range.n_sets = 3;
  range.first_varus_rad = rad_from_deg(-5.0);
  range.last_varus_rad = rad_from_deg(5.0);
  range.balanced_varus_rad = rad_from_deg(1.25);
  for (const std::string& name : layer_names()) range.available.set(*layer_named(name), true);
  return range;
}

TEST(PlayerState, NextSet)
{
  PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(2.0);
  for (const std::size_t expected : {1u, 2u, 0u}) {
    const PlayerState next = apply_action(state, Action::next_set, sample_range());
    EXPECT_EQ(next.set, expected);
    EXPECT_EQ(apply_action(next, Action::previous_set, sample_range()).set, state.set);
    EXPECT_TRUE(next.timeline.is_playing);
    EXPECT_EQ(next.timeline.position, state.timeline.position);
    EXPECT_EQ(next.varus_rad, state.varus_rad);
    state = next;
  }
}

TEST(PlayerState, VarusSteps)
{
  PlayerState state = apply_action(sample_state(), Action::varus_up, sample_range());
  EXPECT_NEAR(deg_from_rad(wanted_varus_rad(state, sample_range())), 2.25, 1e-12);
  for (int i = 0; i < 30; ++i) state = apply_action(state, Action::varus_down, sample_range());
  EXPECT_EQ(wanted_varus_rad(state, sample_range()), rad_from_deg(-5.0));
  state = apply_action(state, Action::varus_balanced, sample_range());
  EXPECT_EQ(wanted_varus_rad(state, sample_range()), rad_from_deg(1.25));
}

TEST(PlayerState, FreeVarus)
{
  PlayerRange range = sample_range();
  range.is_varus_free = true;
  PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(-3.0);
  EXPECT_EQ(wanted_varus_rad(state, range), range.balanced_varus_rad);
  EXPECT_EQ(apply_action(state, Action::varus_up, range).varus_rad, state.varus_rad);
}

TEST(PlayerState, CyclesComeRound)
{
  const PlayerState state = sample_state();
  struct Row {
    Action action;
    int n;
  };
  for (const Row row : {Row{Action::next_mode, 5}, Row{Action::next_loop, 3}, Row{Action::next_backdrop, 3},
                        Row{Action::next_fixed_object, 3}}) {
    PlayerState turned = state;
    for (int i = 0; i < row.n; ++i) {
      turned = apply_action(turned, row.action, sample_range());
      const bool is_back = turned.mode == state.mode && turned.timeline.loop == state.timeline.loop &&
                           turned.backdrop == state.backdrop && turned.fixed_object == state.fixed_object;
      EXPECT_EQ(is_back, i == row.n - 1) << i;
    }
  }
}

TEST(PlayerState, Layers)
{
  PlayerRange range = sample_range();
  range.available.set(Layer::ligaments, false);
  struct Row {
    Action action;
    Layer layer;
    bool is_there;
  };
  for (const Row row :
       {Row{Action::show_contacts, Layer::contacts, true}, Row{Action::show_normals, Layer::normals, true},
        Row{Action::show_axes, Layer::axes, true}, Row{Action::show_helical_axis, Layer::helical_axis, true},
        Row{Action::show_gap_map, Layer::gap_map, true},
        Row{Action::show_ligaments, Layer::ligaments, false}}) {
    SCOPED_TRACE(name_of(row.layer));
    const PlayerState shown = apply_action(sample_state(), row.action, range);
    EXPECT_EQ(shown.layers.has(row.layer), row.is_there);
    EXPECT_FALSE(apply_action(shown, row.action, range).layers.has(row.layer));
  }
}

TEST(PlayerState, Escape)
{
  const PlayerState helped = apply_action(sample_state(), Action::show_help, sample_range());
  EXPECT_TRUE(helped.shows_help);
  const PlayerState closed = apply_action(helped, Action::leave, sample_range());
  EXPECT_FALSE(closed.shows_help);
  EXPECT_FALSE(closed.is_done);
  EXPECT_FALSE(apply_action(closed, Action::leave, sample_range()).is_done);
  EXPECT_TRUE(apply_action(helped, Action::quit, sample_range()).is_done);
}

TEST(PlayerState, KeysOfViewsNameThem)
{
  const std::array wanted{View::front, View::back, View::medial, View::lateral, View::top, View::oblique};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Action action = action_of({key_of(static_cast<char>('1' + static_cast<int>(i)))});
    EXPECT_EQ(view_of(action), wanted[i]);
  }
  EXPECT_EQ(view_of(Action::quit), std::nullopt);
}

constexpr double rounding_rad = 1e-9;

Timeline playing(LoopMode loop)
{
  Timeline timeline;
  timeline.last = rad_from_deg(90.0);
  timeline.speed_steps_s = 30.0;
  timeline.loop = loop;
  timeline.is_playing = true;
  return timeline;
}

double deg_after(LoopMode loop, double elapsed_s)
{
  return deg_from_rad(advanced(playing(loop), elapsed_s).position);
}

TEST(Timeline, GoesTheWayOfEachMode)
{
  struct Row {
    double elapsed_s, once_deg, wrap_deg, bounce_deg;
  };
  for (const Row row : {Row{1, 30, 30, 30}, Row{2.5, 75, 75, 75}, Row{4, 90, 30, 60}, Row{5.5, 90, 75, 15},
                        Row{7, 90, 30, 30}, Row{600001, 90, 30, 30}}) {
    SCOPED_TRACE(row.elapsed_s);
    EXPECT_NEAR(deg_after(LoopMode::once, row.elapsed_s), row.once_deg, 1e-6);
    EXPECT_NEAR(deg_after(LoopMode::wrap, row.elapsed_s), row.wrap_deg, 1e-6);
    EXPECT_NEAR(deg_after(LoopMode::bounce, row.elapsed_s), row.bounce_deg, 1e-6);
  }
}

TEST(Timeline, TimeInParts)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> elapsed(0.0, 2.0);
  for (const LoopMode loop : {LoopMode::once, LoopMode::wrap, LoopMode::bounce}) {
    Timeline parts = playing(loop);
    double whole_s = 0.0;
    int n_back = 0;
    for (int i = 0; i < 500; ++i) {
      const double part_s = elapsed(random);
      whole_s += part_s;
      parts = advanced(parts, part_s);
      n_back += parts.direction < 0 ? 1 : 0;
      EXPECT_GE(parts.position, parts.first);
      EXPECT_LE(parts.position, parts.last);
    }
    EXPECT_NEAR(parts.position, advanced(playing(loop), whole_s).position, rounding_rad);
    EXPECT_EQ(n_back > 100, loop == LoopMode::bounce);
  }
}

TEST(Timeline, Once)
{
  const Timeline over = advanced(playing(LoopMode::once), 100.0);
  EXPECT_FALSE(over.is_playing);
  EXPECT_EQ(over.position, over.last);
  const Timeline again = toggled(over);
  EXPECT_TRUE(again.is_playing);
  EXPECT_EQ(again.position, again.first);
}

TEST(Timeline, Steps)
{
  Timeline timeline = advanced(playing(LoopMode::bounce), 1.0);
  timeline = stepped(timeline, 1.0);
  EXPECT_FALSE(timeline.is_playing);
  EXPECT_NEAR(deg_from_rad(timeline.position), 31.0, rounding_rad);
  EXPECT_EQ(stepped(timeline, 500.0).position, timeline.last);
  EXPECT_EQ(stepped(timeline, -500.0).position, timeline.first);
}

// Speeds climb and fall through the same steps within limits.
TEST(Timeline, Speeds)
{
  Timeline timeline = playing(LoopMode::wrap);
  const double speed_steps_s = timeline.speed_steps_s;
  EXPECT_EQ(slower(faster(timeline)).speed_steps_s, speed_steps_s);
  for (int i = 0; i < 30; ++i) timeline = faster(timeline);
  EXPECT_EQ(timeline.speed_steps_s, fastest_steps_s);
  for (int i = 0; i < 30; ++i) timeline = slower(timeline);
  EXPECT_EQ(timeline.speed_steps_s, slowest_steps_s);
}

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// Flexion 0 to 40 by 10, varus -1 to 1: border contact at 20 and varus 0, dislocated at 30 and varus 1,
/// no pose at 0 and varus -1.
store::MotionModel doubtful_model()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30, 40};
  plan.varus_deg = {-1, 0, 1};
  store::MotionModel model = test::model_of(plan);
  model.plausibility = store::GridB::Constant(5, 3, static_cast<std::int8_t>(Plausibility::nothing_found));
  model.plausibility(2, 1) = static_cast<std::int8_t>(Plausibility::border_contact);
  model.plausibility(3, 2) = static_cast<std::int8_t>(Plausibility::dislocated);
  test::unsolve(model, 0, 0);
  model.job.warnings = {"the femur is coarse"};
  test::add_smoothed(model, 1, [](int, int) { return store::PoseCoordinates{}; });
  return model;
}

TEST(Doubts, CellsAroundAPose)
{
  struct Row {
    const char* set;
    double flexion_deg, varus_deg;
    const char* text;
  };
  const store::MotionModel model = doubtful_model();
  const DoubtReader reader(model);
  for (const Row& row :
       {Row{"raw", 20, 0, "border contact: a contact at an edge"}, Row{"raw", 15, 0, "border contact: "},
        Row{"raw", 10, 0, ""}, Row{"raw", 20, 1, ""}, Row{"raw", 25, 0.5, "dislocated: further from"},
        Row{"raw", 0, -1, "no pose at 0 degrees: "}, Row{"raw", 5, -0.5, "no pose at 5 degrees: "},
        Row{"degree_1", 5, -0.5, "beside an attitude without a pose"},
        Row{"degree_1", 20, 0, "border contact"}, Row{"degree_1", 10, 1, ""}}) {
    SCOPED_TRACE(std::string(row.set) + " " + std::to_string(row.flexion_deg));
    const store::JointPose pose =
        store::Motion(model, row.set).at({rad_from_deg(row.flexion_deg), rad_from_deg(row.varus_deg)});
    const std::string text = doubt_text(pose, reader.at(pose), "femur").data();
    EXPECT_THAT(text, StartsWith(row.text));
    EXPECT_EQ(text.empty(), std::string(row.text).empty());
  }
}

// A follower is named where the joint has no doubt.
TEST(Doubts, OfAFollower)
{
  store::MotionModel model = doubtful_model();
  test::add_follower(model, BodyIndex::reference, {40, 0, 0},
                     [](double, double) { return JointCoordinates(JointCoordinates::Zero()); });
  store::FollowerRows& follower = model.followers[0];
  follower.name = "patella";
  follower.plausibility = store::GridB::Constant(5, 3, static_cast<std::int8_t>(Plausibility::nothing_found));
  follower.plausibility(1, 0) = follower.plausibility(2, 1) =
      static_cast<std::int8_t>(Plausibility::dislocated);
  follower.status(4, 1) = 5;  // overlapping
  const store::Motion motion(model, "raw");
  const auto text_at = [&](double flexion_deg, double varus_deg) -> std::string {
    const store::JointPose pose = motion.at({rad_from_deg(flexion_deg), rad_from_deg(varus_deg)});
    return doubt_text(pose, DoubtReader(model).at(pose), "femur").data();
  };
  EXPECT_THAT(text_at(10, -1), StartsWith("patella: dislocated: further from"));
  EXPECT_THAT(text_at(20, 0), StartsWith("border contact")) << "of the joint";
  EXPECT_EQ(text_at(40, 0), "patella: no pose at or beside this attitude");
  EXPECT_EQ(text_at(10, 1), "");
  EXPECT_THAT(model_warnings(model),
              testing::IsSupersetOf({StartsWith("patella: 2 of 13 poses: dislocated: "),
                                     StartsWith("patella: no pose at 1 of 14 attitudes")}));
}

// Are marked on the timeline between the neighbours.
TEST(Doubts, MarkedSpans)
{
  const store::MotionModel model = doubtful_model();
  const auto spans_at = [&](const char* set, double varus_deg) {
    std::string text;
    for (const MarkedSpan& span :
         DoubtReader(model).marks(store::Motion(model, set), rad_from_deg(varus_deg)))
      text += std::to_string(std::lround(deg_from_rad(span.first))) + "-" +
              std::to_string(std::lround(deg_from_rad(span.last))) + (span.has_pose ? " " : "! ");
    return text;
  };
  EXPECT_EQ(spans_at("raw", 0), "10-30 ");
  EXPECT_EQ(spans_at("raw", 1), "20-40 ");
  EXPECT_EQ(spans_at("raw", -1), "0-10! ");
  EXPECT_EQ(spans_at("degree_1", -1), "0-10 ");
}

// Of the model are counted with their reasons before the warnings of the job.
TEST(Doubts, ModelWarnings)
{
  EXPECT_THAT(model_warnings(doubtful_model()),
              ElementsAre(StartsWith("1 of 14 poses: dislocated: further"),
                          StartsWith("1 of 14 poses: border contact: a contact at an edge"),
                          "1 of 15 attitudes have no pose", "the femur is coarse"));
  EXPECT_TRUE(has_doubtful_poses(doubtful_model()));
  EXPECT_THAT(model_warnings(test::model_of({})), ElementsAre());
}

// The page has its own copy of the reasons, in the same order.
TEST(Doubts, PageHasTheSameReasons)
{
  const std::string page = test::read_bytes(test::source_directory() / "player/web/page/readings.js");
  const std::regex row("\\{ code: (\\d+), name: \"([a-z ]+)\",.* meaning: \"([^\"]+)\" \\}");
  std::vector<std::string> found, wanted;
  for (std::sregex_iterator it(page.begin(), page.end(), row); it != std::sregex_iterator(); ++it)
    found.push_back((*it)[1].str() + " " + (*it)[2].str() + ": " + (*it)[3].str());
  for (const Plausibility plausibility : doubtful_plausibilities) {
    std::string name = name_of(plausibility);
    std::ranges::replace(name, '_', ' ');
    wanted.push_back(std::to_string(static_cast<int>(plausibility)) + " " + name + ": " +
                     meaning_of(plausibility));
  }
  EXPECT_EQ(found, wanted);
}

TEST(JobViews, AreThoseOfTheJob)
{
  const JobViews job = job_views(
      "title = \"a\"\nzoom = 9\n\n[player]\ndisplay_px = [1280, 1024]\nzoom = 2.5\nrender = \"wire\"\n\n"
      "[[player.view]]\nnumber = 2\nshift_mm = [-50, 0, 1.5e1]\norientation_deg = [0, 90, -0.5]\n\n"
      "[[player.view]]\nnumber = 0\n\n[limits]\nunsolved_fraction = 0\nzoom = 7\n");
  EXPECT_EQ(job.zoom, 2.5);
  EXPECT_EQ(job.render, "wire");
  EXPECT_EQ(job.width_px, 1280);
  EXPECT_EQ(job.height_px, 1024);
  ASSERT_EQ(job.views.size(), 2u);
  EXPECT_EQ(job.views[0].number, 2);
  EXPECT_EQ(job.views[0].shift_mm, Eigen::Vector3d(-50, 0, 15));
  EXPECT_EQ(job.views[0].orientation_deg, Eigen::Vector3d(0, 90, -0.5));
  EXPECT_EQ(job.views[1].number, 0);
  EXPECT_EQ(job.views[1].shift_mm, Eigen::Vector3d::Zero());
}

TEST(JobViews, MalformedJob)
{
  for (const char* text :
       {"", "[player]", "[player]\nzoom = -1\nrender = \n", "[player]\ndisplay_px = [nan, inf]\nzoom = nan",
        "[player]\ndisplay_px = [1280]\nzoom = \"x\"\nrender = 1", "[[player.view", "zoom = 3", "player = 3",
        "[player]\nview = 3\ndisplay_px = [1, \"2\"]"}) {
    SCOPED_TRACE(text);
    const JobViews job = job_views(text);
    EXPECT_EQ(job.zoom, 1.0);
    EXPECT_EQ(job.render, "");
    EXPECT_EQ(job.width_px, 0);
    EXPECT_TRUE(job.views.empty());
  }
  const JobViews job = job_views("[[player.view]]\nshift_mm = [1, 2]\norientation_deg = \"nothing\"\n");
  ASSERT_EQ(job.views.size(), 1u);
  EXPECT_EQ(job.views[0].shift_mm, Eigen::Vector3d::Zero());
  EXPECT_EQ(job.views[0].orientation_deg, Eigen::Vector3d::Zero());
}

Scene some_scene()
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  return scene_of(model.reference, model.moving, model.rotation_centre_mm);
}

TEST(Look, LayersAreNamed)
{
  EXPECT_EQ(parsed_layers(""), LayerSet{});
  const LayerSet layers = parsed_layers("gaps,helical-axis");
  EXPECT_TRUE(layers.has(Layer::gap_map));
  EXPECT_TRUE(layers.has(Layer::helical_axis));
  EXPECT_FALSE(layers.has(Layer::contacts));
}

// Mode texture lights and transparency are taken over.
TEST(Look, OptionsApply)
{
  const test::Scratch scratch;
  AppearanceOptions look;
  look.mode = DrawMode::hidden_line;
  look.texture = (scratch.path() / "bone.png").string();
  look.texture_scale_mm = 25.0;
  write_png({2, 1, {1, 2, 3, 255, 4, 5, 6, 255}}, look.texture);
  look.lights = scratch
                    .write("lights.toml",
                           "[hemisphere]\nsky = [0.5, 0.5, 0.5]\nground = [0, 0, 0]\n"
                           "[background]\ntop = [0, 0, 1]\nbottom = [1, 0, 0]\n")
                    .string();
  look.see_through = "reference";
  Scene scene = some_scene();
  add_layer(scene, Layer::ligaments, BodyIndex::reference, "a layer of the reference");
  apply_appearance(scene, look);
  EXPECT_EQ(scene.mode, DrawMode::hidden_line);
  EXPECT_EQ(scene.texture.width, 2);
  EXPECT_EQ(scene.texture.scale_mm, 25.0);
  EXPECT_EQ(scene.lighting.sky, Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  EXPECT_TRUE(scene.lighting.lights.empty());
  EXPECT_EQ(scene.background.top, Eigen::Vector3f(0, 0, 1));
  for (const Drawable& drawable : scene.drawables) {
    const float own = material_of(drawable.name == "plate" ? "meniscus" : "bone").opacity;
    const bool is_body = drawable.parent == BodyIndex::reference && drawable.layer == Layer::bodies;
    EXPECT_EQ(drawable.material.opacity < own, is_body) << drawable.name;
  }
}

TEST(Look, HiddenObject)
{
  Scene scene = some_scene();
  const Sphere before = joint_sphere(scene);
  const std::size_t n_points = points_within(scene, {}).size();
  AppearanceOptions look;
  look.hidden = "reference";
  apply_appearance(scene, look);
  for (const Drawable& drawable : scene.drawables)
    EXPECT_EQ(drawable.is_shown, drawable.parent == BodyIndex::moving) << drawable.name;
  EXPECT_EQ(joint_sphere(scene).radius_mm, before.radius_mm);
  EXPECT_LT(points_within(scene, {}).size(), n_points);
  EXPECT_GT(points_within(scene, {}).size(), 0U);
}

TEST(Look, AnObjectHasItsOwnName)
{
  // Of an ankle the tibia is the reference, of a hip the femur is the moving object.
  struct Row {
    const char *reference, *moving, *hidden;
    BodyIndex parent;
  };
  for (const Row& row :
       {Row{"tibia", "talus", "tibia", BodyIndex::reference},
        Row{"tibia", "talus", "talus", BodyIndex::moving}, Row{"pelvis", "femur", "femur", BodyIndex::moving},
        Row{"pelvis", "femur", "reference", BodyIndex::reference},
        Row{"femur", "tibia", "tibia", BodyIndex::moving}}) {
    SCOPED_TRACE(row.hidden);
    Scene scene = some_scene();
    scene.reference_name = row.reference;
    scene.moving_name = row.moving;
    AppearanceOptions look;
    look.hidden = row.hidden;
    apply_appearance(scene, look);
    for (const Drawable& drawable : scene.drawables)
      EXPECT_EQ(drawable.is_shown, drawable.parent != row.parent) << drawable.name;
  }
}

}  // namespace vrda::view::player_state_test
