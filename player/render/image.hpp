/// Pixels, and PNG files of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace vrda {

/// Top row first, rows without padding; sRGB with straight alpha.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  ///< [height * width * 4]
};

/// Writes 8-bit RGBA marked as sRGB, without times: equal images give equal bytes.
/// Throws InputError when the file cannot be written.
void write_png(const Image& image, const std::string& path);

/// A picture as a texture, whatever kind of PNG it is; transparency is laid over white. Throws InputError
/// when the file cannot be read, is damaged, or has more than 4096 pixels along a side.
Texture read_png_texture(const std::string& path);

}  // namespace vrda
