#include "view/image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include "core/text.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::view::png_file_test {

/// Odd sizes reveal a wrong stride; every byte differs from its neighbours.
Image pattern()
{
  Image image{37, 11, {}};
  for (int i = 0; i < image.width * image.height * 4; ++i)
    image.rgba.push_back(static_cast<std::uint8_t>(i * 7 + i / 256));
  return image;
}

TEST(PngFile, RoundTrip)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "pattern.png").string();
  const Image image = pattern();
  write_png(image, path);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&header, path.c_str()), 0) << header.message;
  EXPECT_EQ(header.width, 37U);
  EXPECT_EQ(header.height, 11U);
  EXPECT_EQ(header.format & PNG_FORMAT_FLAG_ALPHA, PNG_FORMAT_FLAG_ALPHA);
  header.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(header));
  ASSERT_NE(png_image_finish_read(&header, nullptr, read.data(), 0, nullptr), 0) << header.message;
  EXPECT_EQ(read, image.rgba);
}

TEST(PngFile, EqualBytes)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "pattern.png").string();
  write_png(pattern(), path);
  const std::string bytes = test::read_bytes(path);
  EXPECT_NE(bytes.find("sRGB"), std::string::npos);
  EXPECT_EQ(bytes.find("tIME"), std::string::npos);
  write_png(pattern(), path);
  EXPECT_EQ(test::read_bytes(path), bytes);
}

TEST(PngFile, TextureOverWhite)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "texture.png").string();
  Image image{3, 2, {}};
  for (int i = 0; i < 6; ++i) {
    const auto shade = static_cast<std::uint8_t>(40 * i);
    for (const std::uint8_t byte : {shade, std::uint8_t{7}, std::uint8_t{200}, std::uint8_t{255}})
      image.rgba.push_back(byte);
  }
  image.rgba[7] = 0;  // the second pixel is transparent
  write_png(image, path);
  const Texture texture = read_png_texture(path);
  EXPECT_EQ(texture.width, 3);
  EXPECT_EQ(texture.height, 2);
  ASSERT_EQ(texture.rgb.size(), 18U);
  EXPECT_EQ(texture.rgb[0], 0);
  EXPECT_EQ(texture.rgb[3], 255);  // composited over white
  EXPECT_EQ(texture.rgb[6], 80);
  EXPECT_EQ(texture.rgb[15], 200);
  EXPECT_EQ(texture.rgb[17], 200);
}

TEST(PngFile, RefusedTextures)
{
  const test::Scratch scratch;
  const auto refused = [](const std::string& path) {
    return test::input_error([&] { read_png_texture(path); });
  };
  const std::string missing = (scratch.path() / "none.png").string();
  EXPECT_EQ(refused(missing).file, missing);
  EXPECT_EQ(refused(missing).field, "texture");
  EXPECT_FALSE(refused(scratch.write("text.png", "no picture").string()).found.empty());
  const std::string whole = (scratch.path() / "whole.png").string();
  write_png(pattern(), whole);
  const std::string bytes = test::read_bytes(whole);
  EXPECT_FALSE(refused(scratch.write("cut.png", bytes.substr(0, bytes.size() / 2)).string()).found.empty());
  // The size in its header exceeds the limit of textures.
  write_png({4097, 1, std::vector<std::uint8_t>(4 * 4097)}, whole);
  EXPECT_THAT(refused(whole), test::refuses({.field = "texture", .found = {"4097", "1"}}));
}

}  // namespace vrda::view::png_file_test
