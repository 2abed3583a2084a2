#include "render/png_file.hpp"

#include <png.h>

#include "core/error.hpp"

namespace vrda {

void write_png(const Image& image, const std::string& path)
{
  check(image.width > 0 && image.height > 0 &&
            image.rgba.size() ==
                static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 4,
        "an image has four bytes a pixel");
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGBA;
  header.flags = PNG_IMAGE_FLAG_FAST;
  const png_int_32 stride = 4 * image.width;
  if (png_image_write_to_file(&header, path.c_str(), 0, image.rgba.data(), stride, nullptr) == 0) {
    throw InputError({path, "picture", header.message, "a file that can be written"});
  }
}

}  // namespace vrda
