// The window's frame loop, rendered to memory: no allocation and constant resident memory. VRDA_FRAMES sets
// the number of frames (for long runs), VRDA_FRAMES_MODEL the motion model.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

#include "show/session.hpp"
#include "store/motion_model.hpp"
#include "support/allocation_count.hpp"
#include "support/models.hpp"

namespace vrda::show::frame_loop_test {

constexpr double frame_s = 1.0 / 60.0;
// The motion completes a forward and backward cycle within these.
constexpr long n_warm = 800;
// Detects a leak of half a kilobyte per frame; a driver's caches vary by less.
constexpr long allowed_growth_kb = 1024;

std::string environment(const char* name)
{
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

long resident_kb()
{
  long pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

store::MotionModel model_to_play()
{
  const std::string file = environment("VRDA_FRAMES_MODEL");
  if (!file.empty()) return store::read_motion_model(file);
  test::ModelPlan plan;
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.02 * flexion_deg, -0.1 * varus_deg, 0.0, 0.1 * flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  test::add_smoothed(model, 2, [](int i, int) {
    return store::PoseCoordinates{0.5 * i, -0.1 * i, 0.0, 2.0};
  });
  return model;
}

view::InputEvent drag_event(view::InputKind kind, double x_px, double y_px)
{
  return {.kind = kind, .x_px = x_px, .y_px = y_px, .button = view::MouseButton::middle};
}

/// One frame of the loop of `show`, in which the user drags and changes the set.
void run_frame(Session& session, view::Renderer& renderer, long k)
{
  session.resize(renderer.width(), renderer.height());
  session.take(drag_event(view::InputKind::press, 40, 40));
  session.take(drag_event(view::InputKind::motion, 40.0 + static_cast<double>(k % 17), 40));
  session.take(drag_event(view::InputKind::release, 40, 40));
  session.press_key({view::key_of('S')});
  session.advance(frame_s);
  renderer.present(session.scene(), session.shots(), &session.overlay());
}

TEST(FrameLoop, Memory)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  const std::string wanted = environment("VRDA_FRAMES");
  const long n_frames = wanted.empty() ? 600 : std::stol(wanted);
  SessionOptions options;
  options.set = "raw";
  options.width = 320;
  options.height = 240;
  options.appearance.layers = "contacts,normals,axes,helical-axis,gaps,ligaments,labels";
  const std::unique_ptr<view::Renderer> renderer =
      view::make_offscreen_renderer({options.width, options.height, 1});
  Session session(model_to_play(), options);
  session.load_into(*renderer);
  if (!session.state().timeline.is_playing) session.press_key({view::Key::space});
  ASSERT_TRUE(session.state().timeline.is_playing);
  for (long k = 0; k < n_warm; ++k) run_frame(session, *renderer, k);
  const long before_kb = resident_kb(), allocations_before = test::allocations_of_thread();
  const std::uint64_t gui_before = view::gui_allocation_count();
  double least_rad = 1e9, largest_rad = -1e9;
  for (long k = 0; k < n_frames; ++k) {
    run_frame(session, *renderer, k);
    least_rad = std::min(least_rad, session.pose().attitude.flexion_rad);
    largest_rad = std::max(largest_rad, session.pose().attitude.flexion_rad);
  }
  EXPECT_EQ(test::allocations_of_thread() - allocations_before, 0);
  EXPECT_EQ(view::gui_allocation_count() - gui_before, 0u);
  const long growth_kb = resident_kb() - before_kb;
  EXPECT_LT(growth_kb, allowed_growth_kb);
  EXPECT_GT(largest_rad - least_rad, 1.0);  // it did play
  std::cout << n_frames << " frames: " << before_kb << " KB resident before, " << growth_kb
            << " KB more after\n";
  // The counter works.
  const long counted = test::allocations_of_thread();
  ::operator delete(::operator new(1));
  EXPECT_EQ(test::allocations_of_thread(), counted + 1);
}

}  // namespace vrda::show::frame_loop_test
