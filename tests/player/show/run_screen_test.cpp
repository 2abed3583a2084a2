// The screen of a followed run, checked by its pixels.
#include "show/follow.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "support/models.hpp"

namespace vrda::run_screen_test {

store::MotionModel model()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20};
  plan.varus_deg = {-1, 0, 1};
  store::MotionModel made = test::model_of(plan);
  test::add_bodies(made);
  return made;
}

show::RunScreenOptions options()
{
  show::RunScreenOptions requested;
  requested.width = 640;
  requested.height = 480;
  requested.scene.layers.set(view::Layer::contacts, true);
  requested.scene.layers.set(view::Layer::normals, true);
  // Bodies that let the contacts inside them through.
  requested.scene.apply_appearance = [](view::Scene& bare) {
    for (view::Drawable& drawable : bare.drawables) drawable.material.opacity = 0.3F;
  };
  requested.views = {view::named_view("front", view::View::front, Side::right),
                     view::named_view("lateral", view::View::lateral, Side::right)};
  return requested;
}

show::RunStep step(int flexion, int varus, StepStatus status, int n_contacts)
{
  show::RunStep seen;
  seen.key = {StepKind::row, flexion, varus};
  seen.status = status;
  seen.attitude = {rad_from_deg(10.0 * flexion), rad_from_deg(varus - 1.0)};
  for (int k = 0; k < n_contacts; ++k)
    seen.contacts.push_back({{0.1 * k, 25.0, 0.0}, {0, -1, 0}, 0.0, 0, 0, 0});
  return seen;
}

/// Number of pixels of the area for whose index in the image `is_counted`.
template <typename Predicate>
int n_pixels(const view::Image& image, const view::Viewport& area, const Predicate& is_counted)
{
  int n = 0;
  for (int y = area.y; y < area.y + area.height; ++y) {
    for (int x = area.x; x < area.x + area.width; ++x) n += is_counted(4 * (y * image.width + x)) ? 1 : 0;
  }
  return n;
}

/// Pixels of exactly this colour within the area.
int count(const view::Image& image, const view::Viewport& area, const view::VertexColour& colour)
{
  return n_pixels(image, area, [&](int at) {
    return std::equal(colour.begin(), colour.begin() + 3, image.rgba.begin() + at);
  });
}

/// Number of pixels that differ between two images within the area.
int differing(const view::Image& a, const view::Image& b, const view::Viewport& area)
{
  return n_pixels(a, area, [&](int at) {
    return !std::equal(a.rgba.begin() + at, a.rgba.begin() + at + 3, b.rgba.begin() + at);
  });
}

class Screen : public testing::Test {
 protected:
  view::Image picture()
  {
    screen_.show(state_, {});
    screen_.load(*renderer_);
    return renderer_->draw(screen_.scene(), screen_.shots(), &screen_.overlay());
  }
  view::Viewport panel() const { return {480, 0, 160, 480}; }

  store::MotionModel model_ = model();
  show::RunState state_{store::with_pending_cells(model_), show::StepChoice::stable};
  show::RunScreen screen_{store::with_pending_cells(model_), options()};
  std::unique_ptr<view::Renderer> renderer_ = view::make_offscreen_renderer({640, 480, 1});
};

TEST_F(Screen, EveryStatusFillsItsCellOfTheGrid)
{
  const auto stable_pixels = [&](const view::Image& image) {
    return count(image, panel(), show::colour_of(StepStatus::stable));
  };
  const int in_legend = stable_pixels(picture());
  EXPECT_GT(in_legend, 0);
  state_.add_step(step(0, 1, StepStatus::stable, 1));
  const int with_one = stable_pixels(picture());
  state_.add_step(step(0, 2, StepStatus::stable, 1));
  state_.add_step(step(1, 1, StepStatus::stable, 1));
  const int a_cell = with_one - in_legend;
  EXPECT_GT(a_cell, 0);
  // Cells are at most 48 pixels wide, rounded to whole pixels on both sides.
  EXPECT_NEAR(stable_pixels(picture()), in_legend + 3 * a_cell, 2 * 3 * 48);
  state_.add_step(step(2, 1, StepStatus::unbounded, 0));
  EXPECT_GT(count(picture(), panel(), show::colour_of(StepStatus::unbounded)), a_cell / 2);
}

TEST_F(Screen, EachViewShowsTheStepAndTheCamerasStay)
{
  state_.add_step(step(0, 1, StepStatus::stable, 1));
  const view::Image before = picture();
  const view::Camera camera = screen_.shots()[0].camera;
  show::RunStep moved = step(0, 2, StepStatus::stable, 1);
  moved.pose.translation_mm = {3.0, 0.0, 3.0};
  state_.add_step(moved);
  const view::Image after = picture();
  for (const view::Shot& shot : screen_.shots()) EXPECT_GT(differing(before, after, shot.viewport), 100);
  EXPECT_TRUE(screen_.shots()[0].camera.X_world_camera.isApprox(camera.X_world_camera, 0.0));
}

TEST_F(Screen, ManyContactsAreShownToo)
{
  state_.add_step(step(0, 1, StepStatus::stable, 3));
  const view::Image few = picture();
  state_.add_step(step(0, 1, StepStatus::stable, 200));
  const view::Image many = picture();
  int n = 0;
  for (const view::Shot& shot : screen_.shots()) n += differing(few, many, shot.viewport);
  EXPECT_GT(n, 20);
}

TEST_F(Screen, APointerFindsItsViewAndTurnsThatAlone)
{
  EXPECT_EQ(screen_.view_at({10, 10}), 0u);
  EXPECT_EQ(screen_.view_at({10, 470}), 1u);
  EXPECT_EQ(screen_.view_at({600, 10}), std::nullopt);
  state_.add_step(step(0, 1, StepStatus::stable, 1));
  const view::Image before = picture();
  screen_.set_orbit_camera(1, view::moved_closer(screen_.orbit_camera(1), 3.0));
  const view::Image after = picture();
  EXPECT_EQ(differing(before, after, screen_.shots()[0].viewport), 0);
  EXPECT_GT(differing(before, after, screen_.shots()[1].viewport), 100);
  screen_.fit_cameras();
  EXPECT_EQ(differing(before, picture(), screen_.shots()[1].viewport), 0);
}

TEST_F(Screen, AnotherSizeAndAnotherRunAreLoadedAgain)
{
  state_.add_step(step(0, 1, StepStatus::stable, 1));
  picture();
  EXPECT_FALSE(screen_.resize(640, 480));
  EXPECT_TRUE(screen_.resize(320, 240));
  renderer_->resize(320, 240);
  EXPECT_EQ(picture().width, 320);
  screen_.restart(store::with_pending_cells(model_));
  state_ = show::RunState(store::with_pending_cells(model_), show::StepChoice::stable);
  picture();
  screen_.finish(model_);
  state_.finish(model_);
  const store::Motion motion(model_, "raw");
  screen_.show(state_, {}, motion.at({0.1, 0.0}), motion);
  screen_.load(*renderer_);
  const view::Image& image = renderer_->draw(screen_.scene(), screen_.shots(), &screen_.overlay());
  EXPECT_GT(count(image, {160, 0, 160, 240}, show::colour_of(StepStatus::stable)), 1000);
}

TEST_F(Screen, WithoutAPoseOfTheResultTheReferenceIsDrawnAlone)
{
  store::MotionModel model = model_;
  test::unsolve(model, 0, 0);
  screen_.finish(model);
  const store::Motion motion(model, "raw");
  const auto n_moving = [&](const store::JointPose& pose) {
    screen_.show(state_, {}, pose, motion);
    return std::ranges::count_if(screen_.scene().drawables, [](const view::Drawable& drawable) {
      return drawable.layer == view::Layer::bodies && drawable.is_shown &&
             drawable.parent == view::ParentFrame::moving;
    });
  };
  const store::JointPose missing = motion.at({motion.first_flexion_rad(), motion.first_varus_rad()}),
                         solved = motion.at({motion.last_flexion_rad(), motion.last_varus_rad()});
  ASSERT_EQ(missing.status, store::PoseStatus::unsolved_cell);
  EXPECT_GT(n_moving(solved), 0);
  EXPECT_EQ(n_moving(missing), 0);
  EXPECT_GT(n_moving(solved), 0);
}

}  // namespace vrda::run_screen_test
