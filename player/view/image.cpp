#include "view/image.hpp"

#include <png.h>

#include "core/files.hpp"
#include "core/text.hpp"

namespace vrda::view {

void write_png(const Image& image, const std::string& path)
{
  check(image.width > 0 && image.height > 0 &&
            image.rgba.size() ==
                static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 4,
        "an image has four bytes per pixel");
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGBA;
  header.flags = PNG_IMAGE_FLAG_FAST;
  const png_int_32 stride = 4 * image.width;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, image.rgba.data(), stride, nullptr) == 0)
    throw InputError({path, "image", header.message, "an image that PNG supports"});
  write_atomically(path, {std::string_view(bytes).substr(0, size)});
}

Texture read_png_texture(const std::string& path)
{
  constexpr png_uint_32 longest_side = 4096;  // 50 MB; supported as a texture by every OpenGL 3.3
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  const auto refuse = [&](const std::string& found) {
    png_image_free(&header);
    throw InputError({path, "texture", found, "a PNG image of at most 4096 x 4096 pixels"});
  };
  if (png_image_begin_read_from_file(&header, path.c_str()) == 0) refuse(header.message);
  if (header.width > longest_side || header.height > longest_side)
    refuse(std::to_string(header.width) + " x " + std::to_string(header.height) + " pixels");
  header.format = PNG_FORMAT_RGB;
  Texture texture;
  texture.width = static_cast<int>(header.width);
  texture.height = static_cast<int>(header.height);
  texture.rgb.resize(PNG_IMAGE_SIZE(header));
  const png_color white{255, 255, 255};
  if (png_image_finish_read(&header, &white, texture.rgb.data(), 0, nullptr) == 0) refuse(header.message);
  png_image_free(&header);
  return texture;
}

}  // namespace vrda::view
