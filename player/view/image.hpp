/// Images and PNG files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "view/scene.hpp"

namespace vrda::view {

/// Top row first, rows without padding; sRGB with straight alpha.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< [height * width * 4]
};

/// Writes 8-bit RGBA tagged as sRGB, without time stamps: equal images give equal bytes.
/// Throws InputError if the file cannot be written.
void write_png(const Image& image, const std::string& path);

/// Reads any kind of PNG as a texture; transparent pixels are composited over white. Throws InputError if the
/// file cannot be read, is damaged, or has more than 4096 pixels along a side.
Texture read_png_texture(const std::string& path);

}  // namespace vrda::view
