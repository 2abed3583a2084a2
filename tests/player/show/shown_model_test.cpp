// Files dropped on the window: another joint, or one message and the joint that was there.
#include "show/session.hpp"

#include <gtest/gtest.h>

#include "motion/support/models.hpp"
#include "store/motion_model_file.hpp"
#include "support/scratch.hpp"

namespace vrda::shown_model_test {

constexpr double frame_s = 1.0 / 60.0;

MotionModel titled(const std::string& title)
{
  MotionModel model = test::model_of({});
  model.title = title;
  test::add_bodies(model);
  return model;
}

class Dropped : public testing::Test {
 protected:
  static SessionOptions small()
  {
    SessionOptions options;
    options.set = "raw";
    return options;
  }
  test::Scratch scratch_;
  std::unique_ptr<Renderer> renderer_ = make_offscreen_renderer({320, 240, 1});
  ShownModel shown_{"first.h5", titled("first"), small(), *renderer_};
};

TEST_F(Dropped, AMotionModelIsShown)
{
  const std::string file = (scratch_.path() / "second.h5").string();
  MotionModel second = titled("second");
  test::add_smoothed(second, 1, [](int i, int) { return PoseNumbers{0.0, 0.0, 0.0, 2.0 * i}; });
  write_motion_model(file, second);
  EXPECT_TRUE(shown_.open(file));
  EXPECT_EQ(shown_.title(), "second");
  EXPECT_EQ(shown_.file(), file);
  shown_.session().advance(frame_s);
  renderer_->present(shown_.session().scene(), shown_.session().shots(), &shown_.session().overlay());
  EXPECT_EQ(shown_.session().pose().status, PoseStatus::solved);
}

TEST_F(Dropped, AnythingElseIsOneMessageAndTheJointStays)
{
  const Session* before = &shown_.session();
  for (const std::string& file :
       {scratch_.write("notes.h5", "no motion model").string(), scratch_.write("empty.h5", "").string(),
        (scratch_.path() / "absent.h5").string(), scratch_.path().string()}) {
    SCOPED_TRACE(file);
    EXPECT_FALSE(shown_.open(file));
    EXPECT_EQ(&shown_.session(), before);
    EXPECT_FALSE(shown_.session().is_idle());  // the message stands for some seconds
  }
  EXPECT_EQ(shown_.title(), "first");
  EXPECT_EQ(shown_.file(), "first.h5");
}

TEST(ShownAttitude, WhatLiesOutsideTheRangeIsTold)
{
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({320, 240, 1});
  struct Row {
    std::optional<double> flexion_deg, varus_deg;
    const char* told;
  };
  const double within_deg = 1.0, beyond_deg = 170.0;
  for (const Row& row :
       {Row{{}, {}, ""}, Row{within_deg, 0.0, ""},
        Row{beyond_deg, 0.0, "the flexion asked for lies outside the measured range"},
        Row{within_deg, beyond_deg, "the varus asked for lies outside the measured range"},
        Row{beyond_deg, -beyond_deg, "the flexion and varus asked for lie outside the measured range"}}) {
    SessionOptions options;
    options.set = "raw";
    if (row.flexion_deg) options.flexion_rad = rad_from_deg(*row.flexion_deg);
    if (row.varus_deg) options.varus_rad = rad_from_deg(*row.varus_deg);
    ShownModel shown("first.h5", titled("first"), options, *renderer);
    EXPECT_EQ(shown.session().told(), row.told);
  }
}

}  // namespace vrda::shown_model_test
