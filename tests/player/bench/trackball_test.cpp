#include "bench/bench_state.hpp"

#include <gtest/gtest.h>

#include "bench/bench_run.hpp"
#include "core/units.hpp"
#include "player/bench/bench_samples.hpp"

namespace vrda::trackball_test {

/// A bench with a leg 1 m in front of the eyes, and the pointer.
struct Desk {
  explicit Desk(const view::Reflection& reflection = {})
      : bench(test::two_bodies_text()), display(bench.bench.display)
  {
    display.reflection = reflection;
    ball.emplace(display, Eigen::Vector3d(5.0, 3.0, 1.0));
    bench.take_leg(test::some_pose(1), {rad_from_deg(30.0), 0.0, 0.0}, 1, 1);
    frame = bench.state.frame(2);
    // Eyes that look at the joint, upright in its axes.
    Pose X_reference_eyes = Pose::Identity();
    X_reference_eyes.translation() = Eigen::Vector3d(5.0, 3.0, 801.0);
    frame.X_tracker_eyes = frame.X_tracker_reference * X_reference_eyes;
  }
  /// Passes the event to the trackball, and its sample, if any, to the bench.
  void move(view::InputKind kind, double x_px, double y_px,
            view::MouseButton button = view::MouseButton::left)
  {
    view::InputEvent event;
    event.kind = kind;
    event.x_px = x_px;
    event.y_px = y_px;
    event.button = button;
    last = ball->take(event, bench.state, frame, 3);
    if (last) bench.state.take(*last);
  }
  Eigen::Vector2d middle_px() const { return view::middle_px(display.windows.left); }

  test::SmallBench bench;
  bench::DisplaySettings display;
  std::optional<bench::Trackball> ball;
  bench::BenchFrame frame;
  std::optional<bench::Sample> last;
};

TEST(Trackball, TheRightButtonMovesTheJointWithThePointer)
{
  Desk desk;
  const Eigen::Vector2d from = desk.middle_px();
  desk.move(view::InputKind::motion, from.x(), from.y());
  EXPECT_FALSE(desk.last) << "no button";
  desk.move(view::InputKind::press, from.x(), from.y(), view::MouseButton::right);
  desk.move(view::InputKind::motion, from.x() + 88.0, from.y());
  // At the pivot's depth of 800 mm a pixel of the left eye is 800 / distance_px wide.
  const view::Eye& eye = desk.bench.state.values().calibration.eyes.left;
  const double wanted_mm = 88.0 * (800.0 + eye.position_head_mm.z()) / eye.distance_px;
  EXPECT_NEAR(desk.bench.state.X_leg_joint().translation().x(), wanted_mm, 0.01 * wanted_mm);
  EXPECT_NEAR(desk.bench.state.X_leg_joint().translation().z(), 0.0, 1e-6);
  EXPECT_TRUE(desk.bench.state.frame(4).is_moved_aside);
  desk.move(view::InputKind::motion, from.x(), from.y());
  EXPECT_LT(test::distance_of(desk.bench.state.X_leg_joint(), Pose::Identity()), 1e-9) << "back at the press";
  desk.move(view::InputKind::release, from.x(), from.y(), view::MouseButton::right);
  desk.move(view::InputKind::motion, from.x() + 50.0, from.y());
  EXPECT_FALSE(desk.last) << "released";
}

TEST(Trackball, TheLeftButtonTurnsAboutTheCentreAndKeyRPutsBack)
{
  Desk desk;
  const Eigen::Vector2d from = desk.middle_px();
  desk.move(view::InputKind::press, from.x(), from.y());
  desk.move(view::InputKind::motion, from.x() + 60.0, from.y());
  const Pose X = desk.bench.state.X_leg_joint();
  EXPECT_GT(Eigen::AngleAxisd(X.linear()).angle(), rad_from_deg(10.0));
  const Eigen::Vector3d centre(5.0, 3.0, 1.0);
  EXPECT_LT((X * centre - centre).norm(), 1e-6) << "the centre stays";
  bench::apply_key(desk.bench.state, {view::key_of('R')});
  EXPECT_FALSE(desk.bench.state.frame(5).is_moved_aside);
}

TEST(Trackball, BehindAMirrorTheJointFollowsWhatIsSeen)
{
  Desk desk({true, false});
  const Eigen::Vector2d from = desk.middle_px();
  desk.move(view::InputKind::press, from.x(), from.y(), view::MouseButton::right);
  desk.move(view::InputKind::motion, from.x() + 88.0, from.y());
  EXPECT_LT(desk.bench.state.X_leg_joint().translation().x(), -10.0);
}

TEST(Trackball, OutsideTheEyesWindowsNothingIsHeld)
{
  Desk desk;
  desk.move(view::InputKind::press, 3.0, 3.0);
  desk.move(view::InputKind::motion, 300.0, 300.0);
  EXPECT_FALSE(desk.last);
}

}  // namespace vrda::trackball_test
