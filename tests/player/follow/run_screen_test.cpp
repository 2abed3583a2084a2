// The screen of a followed run, checked by its pixels.
#include "follow/run_screen.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "motion/support/models.hpp"

namespace vrda::run_screen_test {

MotionModel model()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20};
  plan.varus_deg = {-1, 0, 1};
  MotionModel made = test::model_of(plan);
  test::add_bodies(made);
  return made;
}

RunScreenOptions options()
{
  RunScreenOptions asked;
  asked.width = 640;
  asked.height = 480;
  asked.scene.layers.set(Layer::contacts, true);
  asked.scene.layers.set(Layer::normals, true);
  asked.views = {named_view("front", View::front, Side::right),
                 named_view("lateral", View::lateral, Side::right)};
  return asked;
}

SeenStep step(int flexion, int varus, StepStatus status, int n_contacts)
{
  SeenStep seen;
  seen.key = {StepKind::row, flexion, varus};
  seen.status = status;
  seen.attitude = {rad_from_deg(10.0 * flexion), rad_from_deg(varus - 1.0)};
  for (int k = 0; k < n_contacts; ++k)
    seen.contacts.push_back({{0.1 * k, 25.0, 0.0}, {0, -1, 0}, 0.0, 0, 0, 0});
  return seen;
}

/// Pixels of exactly this colour within the area.
int count(const Image& image, const Viewport& area, const VertexColour& colour)
{
  int n = 0;
  for (int y = area.y; y < area.y + area.height; ++y) {
    for (int x = area.x; x < area.x + area.width; ++x) {
      const std::size_t at = 4 * static_cast<std::size_t>(y * image.width + x);
      n += image.rgba[at] == colour[0] && image.rgba[at + 1] == colour[1] && image.rgba[at + 2] == colour[2]
               ? 1
               : 0;
    }
  }
  return n;
}

/// Number of pixels that differ between two images within the area.
int differing(const Image& a, const Image& b, const Viewport& area)
{
  int n = 0;
  for (int y = area.y; y < area.y + area.height; ++y) {
    for (int x = area.x; x < area.x + area.width; ++x) {
      const std::size_t at = 4 * static_cast<std::size_t>(y * a.width + x);
      n += std::equal(a.rgba.begin() + static_cast<std::ptrdiff_t>(at),
                      a.rgba.begin() + static_cast<std::ptrdiff_t>(at + 3),
                      b.rgba.begin() + static_cast<std::ptrdiff_t>(at))
               ? 0
               : 1;
    }
  }
  return n;
}

class Screen : public testing::Test {
 protected:
  Image picture()
  {
    screen_.show(state_, {});
    screen_.load(*renderer_);
    return renderer_->draw(screen_.scene(), screen_.shots(), &screen_.overlay());
  }
  Viewport panel() const { return {480, 0, 160, 480}; }

  MotionModel model_ = model();
  RunState state_{with_pending_cells(model_), StepChoice::stable};
  RunScreen screen_{with_pending_cells(model_), options()};
  std::unique_ptr<Renderer> renderer_ = make_offscreen_renderer({640, 480, 1});
};

TEST_F(Screen, EveryStatusFillsItsCellOfTheGrid)
{
  const auto stable_pixels = [&](const Image& image) {
    return count(image, panel(), colour_of(StepStatus::stable));
  };
  const int in_legend = stable_pixels(picture());
  EXPECT_GT(in_legend, 0);
  state_.take(step(0, 1, StepStatus::stable, 1));
  const int with_one = stable_pixels(picture());
  state_.take(step(0, 2, StepStatus::stable, 1));
  state_.take(step(1, 1, StepStatus::stable, 1));
  const int a_cell = with_one - in_legend;
  EXPECT_GT(a_cell, 0);
  // Cells are at most 48 pixels wide, rounded to whole pixels on both sides.
  EXPECT_NEAR(stable_pixels(picture()), in_legend + 3 * a_cell, 2 * 3 * 48);
  state_.take(step(2, 1, StepStatus::unbounded, 0));
  EXPECT_GT(count(picture(), panel(), colour_of(StepStatus::unbounded)), a_cell / 2);
}

TEST_F(Screen, EachViewShowsTheStepAndTheCamerasStay)
{
  state_.take(step(0, 1, StepStatus::stable, 1));
  const Image before = picture();
  const Camera camera = screen_.shots()[0].camera;
  SeenStep moved = step(0, 2, StepStatus::stable, 1);
  moved.pose.translation_mm = {3.0, 0.0, 3.0};
  state_.take(moved);
  const Image after = picture();
  for (const Shot& shot : screen_.shots()) EXPECT_GT(differing(before, after, shot.viewport), 100);
  EXPECT_TRUE(screen_.shots()[0].camera.X_world_camera.isApprox(camera.X_world_camera, 0.0));
}

TEST_F(Screen, ManyContactsAreShownToo)
{
  state_.take(step(0, 1, StepStatus::stable, 3));
  const Image few = picture();
  state_.take(step(0, 1, StepStatus::stable, 200));
  const Image many = picture();
  int n = 0;
  for (const Shot& shot : screen_.shots()) n += differing(few, many, shot.viewport);
  EXPECT_GT(n, 20);
}

TEST_F(Screen, APointerFindsItsViewAndTurnsThatAlone)
{
  EXPECT_EQ(screen_.view_at({10, 10}), 0u);
  EXPECT_EQ(screen_.view_at({10, 470}), 1u);
  EXPECT_EQ(screen_.view_at({600, 10}), std::nullopt);
  state_.take(step(0, 1, StepStatus::stable, 1));
  const Image before = picture();
  screen_.look(1, nearer(screen_.gaze(1), 3.0));
  const Image after = picture();
  EXPECT_EQ(differing(before, after, screen_.shots()[0].viewport), 0);
  EXPECT_GT(differing(before, after, screen_.shots()[1].viewport), 100);
  screen_.reset_views();
  EXPECT_EQ(differing(before, picture(), screen_.shots()[1].viewport), 0);
}

TEST_F(Screen, AnotherSizeAndAnotherRunAreLoadedAgain)
{
  state_.take(step(0, 1, StepStatus::stable, 1));
  picture();
  EXPECT_FALSE(screen_.resize(640, 480));
  EXPECT_TRUE(screen_.resize(320, 240));
  renderer_->resize(320, 240);
  EXPECT_EQ(picture().width, 320);
  screen_.begin(with_pending_cells(model_));
  state_ = RunState(with_pending_cells(model_), StepChoice::stable);
  picture();
  screen_.finish(model_);
  state_.finish(model_);
  const Motion motion(model_, "raw");
  screen_.show(state_, {}, motion.at({0.1, 0.0}), motion);
  screen_.load(*renderer_);
  const Image& image = renderer_->draw(screen_.scene(), screen_.shots(), &screen_.overlay());
  EXPECT_GT(count(image, {160, 0, 160, 240}, colour_of(StepStatus::stable)), 1000);
}

}  // namespace vrda::run_screen_test
