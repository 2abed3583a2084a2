/// Images as PNG files.
#pragma once

#include <string>

#include "render/image.hpp"

namespace vrda {

/// Writes 8-bit RGBA marked as sRGB, without times: equal images give equal bytes.
/// Throws InputError when the file cannot be written.
void write_png(const Image& image, const std::string& path);

}  // namespace vrda
