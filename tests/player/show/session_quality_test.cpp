#include <gtest/gtest.h>

#include "show/session.hpp"
#include "support/models.hpp"

namespace vrda::session_quality_test {

constexpr double frame_s = 1.0 / 60.0;
constexpr int width = 640, height = 480;

store::MotionModel small_model()
{
  store::MotionModel model = test::model_of(test::ModelPlan());
  test::add_bodies(model);
  return model;
}

show::SessionOptions small_options()
{
  show::SessionOptions options;
  options.set = "raw";
  options.width = width;
  options.height = height;
  return options;
}

view::InputEvent pointer_event(view::InputKind kind, double x_px, double y_px)
{
  return {.kind = kind, .x_px = x_px, .y_px = y_px};
}

TEST(Session, IsDrawnPlainlyWhileItMovesAndFullyAtRest)
{
  show::SessionOptions options = small_options();
  for (const bool is_plain : {true, false}) {
    options.is_plain_while_moving = is_plain;
    show::Session session(small_model(), options);
    session.advance(show::settle_s);
    const double at_rest_mm = session.scene().occlusion_radius_mm;
    EXPECT_GT(at_rest_mm, 0.0);
    session.take(pointer_event(view::InputKind::press, 300.0, 300.0));
    session.take(pointer_event(view::InputKind::motion, 320.0, 300.0));
    session.advance(frame_s);
    EXPECT_EQ(session.is_plain(), is_plain);
    EXPECT_EQ(session.scene().occlusion_radius_mm, is_plain ? 0.0 : at_rest_mm);
    EXPECT_EQ(session.scene().has_vertex_lighting, is_plain);
    session.take(pointer_event(view::InputKind::release, 320.0, 300.0));
    session.advance(frame_s);
    EXPECT_FALSE(session.is_idle()) << "the picture at rest is due";
    session.advance(show::settle_s);
    EXPECT_FALSE(session.is_plain());
    EXPECT_EQ(session.scene().occlusion_radius_mm, at_rest_mm) << "in the first frame at rest";
    EXPECT_FALSE(session.scene().has_vertex_lighting);
    EXPECT_FALSE(session.is_idle()) << "which is drawn";
  }
}

TEST(Session, APointerThatHoversKeepsThePictureAndAKeyDoesNot)
{
  show::SessionOptions options = small_options();
  options.is_plain_while_moving = true;
  show::Session session(small_model(), options);
  const auto advance = [&](double elapsed_s) {
    session.advance(elapsed_s);
    return session.has_same_picture();
  };
  EXPECT_FALSE(advance(show::settle_s)) << "the first in full quality";
  EXPECT_TRUE(advance(frame_s));
  session.take(pointer_event(view::InputKind::motion, 320.0, 300.0));
  EXPECT_TRUE(advance(frame_s));
  session.take({.kind = view::InputKind::key_press, .key = view::Key::right});
  EXPECT_FALSE(advance(10.0)) << "after a wait for the key";
  EXPECT_TRUE(session.is_plain());
  EXPECT_FALSE(advance(show::settle_s));
  EXPECT_FALSE(session.is_plain());
  EXPECT_TRUE(advance(frame_s));
  session.resize(width + 10, height);
  EXPECT_FALSE(advance(frame_s));
}

}  // namespace vrda::session_quality_test
