// The screen of a followed run: what is placed and framed.
#include "show/follow.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "support/models.hpp"

namespace vrda::show::run_screen_test {

store::MotionModel model()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20};
  plan.varus_deg = {-1, 0, 1};
  store::MotionModel made = test::model_of(plan);
  test::add_bodies(made);
  return made;
}

RunScreenOptions options()
{
  FollowOptions requested;
  requested.size = "640x480";
  return screen_options(requested, model());
}

RunStep step(int varus, const Eigen::Vector3d& translation_mm, int n_contacts = 1)
{
  RunStep seen;
  seen.key = {StepKind::row, 0, varus};
  seen.status = StepStatus::stable;
  seen.attitude = {0.0, rad_from_deg(varus - 1.0)};
  seen.pose.translation_mm = translation_mm;
  for (int k = 0; k < n_contacts; ++k)
    seen.contacts.push_back({{0.1 * k, 25.0, 0.0}, {0, -1, 0}, 0.0, 0, 0, 0});
  return seen;
}

class Screen : public testing::Test {
 protected:
  void show(const RunStep& next)
  {
    state_.add_step(next);
    screen_.show(state_, {});
  }
  const view::Drawable& drawable(view::Layer layer, BodyIndex parent) const
  {
    return *std::ranges::find_if(screen_.scene().drawables, [&](const view::Drawable& one) {
      return one.layer == layer && one.parent == parent;
    });
  }
  const view::Drawable& moving() const { return drawable(view::Layer::bodies, BodyIndex::moving); }

  store::MotionModel model_ = model();
  RunState state_{store::with_pending_cells(model_), StepChoice::stable};
  RunScreen screen_{store::with_pending_cells(model_), options()};
};

TEST_F(Screen, Steps)
{
  show(step(1, {0, 0, 0}));
  const Pose before = moving().X_world_mesh;
  const view::Camera camera = screen_.shots()[0].camera;
  const view::Drawable& balls = drawable(view::Layer::contacts, BodyIndex::world);
  EXPECT_TRUE(balls.is_shown);
  // More contacts than there is room for at first.
  show(step(1, {3.0, 0.0, 3.0}, 200));
  const Pose moved = before.inverse() * moving().X_world_mesh;
  EXPECT_NEAR(moved.translation().norm(), std::sqrt(18.0), 1e-9);
  EXPECT_EQ(screen_.shots()[0].camera.X_world_camera.matrix(), camera.X_world_camera.matrix());
  EXPECT_GE(balls.mesh.triangles.size(), 200 * view::ball_size().n_indices);
  show(step(1, {0, 0, 0}, 0));
  EXPECT_FALSE(balls.is_shown);
}

TEST_F(Screen, Pointer)
{
  EXPECT_EQ(screen_.view_at({10, 10}), 0u);
  EXPECT_EQ(screen_.view_at({10, 470}), 1u);
  EXPECT_EQ(screen_.view_at({600, 10}), std::nullopt);
  show(step(1, {0, 0, 0}));
  const auto place = [&](std::size_t k) { return screen_.shots()[k].camera.X_world_camera.matrix(); };
  const Eigen::Matrix4d first = place(0), second = place(1);
  screen_.set_orbit_camera(1, view::moved_closer(screen_.orbit_camera(1), 3.0));
  EXPECT_EQ(place(0), first);
  EXPECT_NE(place(1), second);
  screen_.fit_cameras();
  EXPECT_EQ(place(1), second);
}

TEST_F(Screen, SizeAndRestart)
{
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({640, 480, 1});
  const auto draw = [&] {
    screen_.load(*renderer);
    return renderer->draw(screen_.scene(), screen_.shots(), &screen_.overlay()).width;
  };
  show(step(1, {0, 0, 0}));
  EXPECT_EQ(draw(), 640);
  EXPECT_FALSE(screen_.resize(640, 480));
  EXPECT_TRUE(screen_.resize(320, 240));
  renderer->resize(320, 240);
  screen_.restart(store::with_pending_cells(model_));
  state_ = RunState(store::with_pending_cells(model_), StepChoice::stable);
  screen_.show(state_, {});
  EXPECT_EQ(draw(), 320);
}

// Without a pose of the result the reference is drawn alone.
TEST_F(Screen, MissingPose)
{
  test::unsolve(model_, 0, 0);
  screen_.finish(model_);
  const store::Motion motion(model_, "raw");
  const store::JointPose missing = motion.at({motion.first_flexion_rad(), motion.first_varus_rad()}),
                         solved = motion.at({motion.last_flexion_rad(), motion.last_varus_rad()});
  ASSERT_EQ(missing.status, store::PoseStatus::unsolved_cell);
  for (const store::JointPose& pose : {solved, missing, solved}) {
    screen_.show(state_, {}, pose, motion);
    EXPECT_EQ(moving().is_shown, pose.status == store::PoseStatus::solved);
    EXPECT_TRUE(drawable(view::Layer::bodies, BodyIndex::reference).is_shown);
  }
}

}  // namespace vrda::show::run_screen_test
