#include "scene/joint_layers.hpp"

#include <gtest/gtest.h>

namespace vrda::palette_test {

Legend legend()
{
  Legend made;
  made.lowest = 2.0;
  made.highest = 12.0;
  made.palette = closeness_palette();
  return made;
}

/// Relative luminance, to which perceived lightness is monotone.
double luminance(const VertexColour& colour)
{
  return Eigen::Vector3f(0.2126F, 0.7152F, 0.0722F).dot(decoded(colour));
}

TEST(Palette, ColoursAreThoseOfThePaletteAndMixedBetween)
{
  const Legend l = legend();
  for (std::size_t k = 0; k < l.palette.size(); ++k)
    EXPECT_EQ(colour_of(l, 2.0 + static_cast<double>(k)), l.palette[k]);
  EXPECT_EQ(colour_of(l, 2.5), mixed(l.palette[0], l.palette[1], 0.5));
  EXPECT_EQ(colour_of(l, -50.0), l.palette.front());
  EXPECT_EQ(colour_of(l, 1e9), l.palette.back());
}

TEST(Palette, ValuesBelowHaveTheirOwnColourWhereTheLegendSaysSo)
{
  Legend l = legend();
  l.below = {1, 2, 3, 255};
  l.below_label = "slack";
  EXPECT_EQ(colour_of(l, 1.999), l.below);
  EXPECT_EQ(colour_of(l, 2.0), l.palette.front());
}

TEST(Palette, ClosenessDarkensWithEveryStep)
{
  for (std::size_t k = 1; k < closeness_palette().size(); ++k)
    EXPECT_LT(luminance(closeness_palette()[k]), luminance(closeness_palette()[k - 1])) << k;
}

TEST(Palette, TensionIsLightestInTheMiddle)
{
  const Palette& palette = tension_palette();
  for (std::size_t k = 1; k < palette.size(); ++k) {
    const bool is_rising = k <= palette.size() / 2;
    EXPECT_EQ(luminance(palette[k]) > luminance(palette[k - 1]), is_rising) << k;
  }
}

TEST(Palette, EncodingAndDecodingAreARoundTrip)
{
  for (int byte = 0; byte < 256; ++byte) {
    const auto b = static_cast<std::uint8_t>(byte);
    const VertexColour colour{b, static_cast<std::uint8_t>(255 - byte), b, 255};
    EXPECT_EQ(encoded(decoded(colour)), colour);
  }
}

}  // namespace vrda::palette_test
