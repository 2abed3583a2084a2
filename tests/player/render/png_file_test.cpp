#include "render/png_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include "core/error.hpp"
#include "support/scratch.hpp"

namespace vrda {
namespace {

/// Odd sizes, so that a wrong stride shows; every byte differs from its neighbours.
Image pattern()
{
  Image image{37, 11, {}};
  for (int i = 0; i < image.width * image.height * 4; ++i)
    image.rgba.push_back(static_cast<std::uint8_t>(i * 7 + i / 256));
  return image;
}

TEST(PngFile, WhatIsWrittenIsReadBack)
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

TEST(PngFile, ItIsMarkedAsSrgbAndHasNoTime)
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

TEST(PngFile, AnUnwritablePathIsNamed)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "absent" / "picture.png").string();
  try {
    write_png(pattern(), path);
    FAIL() << "written";
  } catch (const InputError& error) {
    EXPECT_EQ(error.facts().file, path);
    EXPECT_EQ(error.facts().field, "picture");
    EXPECT_THAT(error.facts().found, testing::HasSubstr("No such file"));
  }
}

TEST(PngFile, AMisshapenImageIsABrokenPromise)
{
  Image image = pattern();
  image.rgba.pop_back();
  EXPECT_THROW(write_png(image, "never.png"), InternalError);
}

}  // namespace
}  // namespace vrda
