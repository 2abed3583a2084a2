/// Draws scenes into images.
#pragma once

#include <memory>

#include "render/image.hpp"
#include "scene/camera.hpp"
#include "scene/scene.hpp"

namespace vrda {

struct RenderOptions {
  int width = 1280;
  int height = 960;
  int samples = 4;  ///< a pixel; 1 for no multisampling
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  /// Takes over the meshes of `scene`. Wanted before `draw`, and again when drawables come or go.
  virtual void load(const Scene& scene) = 0;
  /// Draws the loaded meshes with the poses, materials and lights of `scene`, which must have the same
  /// drawables. The image is valid until the next draw.
  virtual const Image& draw(const Scene& scene, const Camera& camera) = 0;
};

/// Software rendering without any display, by OSMesa.
/// Throws InputError when the library gives no OpenGL 3.3 or the size is beyond its limits.
std::unique_ptr<Renderer> make_offscreen_renderer(const RenderOptions& options);

}  // namespace vrda
