#include <gtest/gtest.h>

#include "show/session.hpp"
#include "support/allocation_count.hpp"
#include "support/models.hpp"

namespace vrda::session_allocation_test {

constexpr double frame_s = 1.0 / 60.0;

view::InputEvent event_of(view::InputKind kind, double x_px, double y_px)
{
  view::InputEvent event;
  event.kind = kind;
  event.x_px = x_px;
  event.y_px = y_px;
  event.button = view::MouseButton::middle;
  return event;
}

TEST(SessionAllocation, PlayingTurningAndSwitchingSetsAllocateNothing)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  test::ModelPlan plan;
  plan.motion = [](double flexion_deg, double) {
    return store::PoseCoordinates{0, 0.01 * flexion_deg, 0, flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  test::add_smoothed(model, 2, [](int i, int) { return store::PoseCoordinates{0.0, 0.0, 0.0, 2.0 * i}; });
  show::SessionOptions options;
  options.set = "raw";
  options.width = 320;
  options.height = 240;
  show::Session session(std::move(model), options);
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({320, 240, 1});
  session.load_into(*renderer);
  const auto round = [&](int n_frames) {
    for (int i = 0; i < n_frames; ++i) {
      session.take(event_of(view::InputKind::press, 40, 40));
      session.take(event_of(view::InputKind::motion, 40 + i % 17, 40 + i % 11));
      session.take(event_of(view::InputKind::release, 40, 40));
      session.press_key({view::key_of('S')});
      session.advance(frame_s);
      renderer->draw(session.scene(), session.shots(), &session.overlay());
    }
  };
  session.press_key({view::Key::space});
  for (const view::Key key :
       {view::Key::f1, view::Key::f2, view::Key::f3, view::Key::f4, view::Key::f5, view::Key::f6})
    session.press_key({key});
  // The overlay and the interface reach their largest size within one cycle of the motion.
  round(400);
  const long before = test::allocations_of_thread();
  const std::uint64_t gui_before = view::gui_allocation_count();
  round(100);
  EXPECT_EQ(test::allocations_of_thread() - before, 0);
  EXPECT_EQ(view::gui_allocation_count() - gui_before, 0u);
  const std::vector<int> counted(10);
  EXPECT_EQ(test::allocations_of_thread() - before, 1) << "the counter works";
}

}  // namespace vrda::session_allocation_test
