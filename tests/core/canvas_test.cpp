/// Text of a raster image.
#include "core/canvas.hpp"

#include <gtest/gtest.h>

namespace vrda::inline core {
namespace {

std::string text_at(const Eigen::Vector2d& at_px, TextAlign align)
{
  Canvas canvas(200, 60);
  canvas.set_clip({20.0, 0.0}, {180.0, 60.0});
  canvas.draw_text(at_px, 20.0, "push, 20 N", align, Colour::Zero());
  return canvas.png();
}

TEST(Canvas, text_stays_inside)
{
  const std::string at_the_left = text_at({20.0, 40.0}, TextAlign::left);
  for (const TextAlign align : {TextAlign::left, TextAlign::centre, TextAlign::right})
    EXPECT_EQ(text_at({-30.0, 40.0}, align), at_the_left);
  const std::string at_the_right = text_at({230.0, 40.0}, TextAlign::left);
  for (const TextAlign align : {TextAlign::centre, TextAlign::right})
    EXPECT_EQ(text_at({230.0, 40.0}, align), at_the_right);
  EXPECT_NE(at_the_right, at_the_left);
}

TEST(Canvas, text_that_fits)
{
  EXPECT_NE(text_at({40.0, 40.0}, TextAlign::left), text_at({20.0, 40.0}, TextAlign::left));
}

}  // namespace
}  // namespace vrda::inline core
