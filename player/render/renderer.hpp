/// Draws scenes into images.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "optics/viewport.hpp"
#include "render/image.hpp"
#include "scene/camera.hpp"
#include "scene/scene.hpp"

namespace vrda {

/// Of a picture that moves. Half a pixel is not seen in an outline, but small pits lose their shade.
inline constexpr double moving_coarseness_px = 0.35;

struct RenderOptions {
  int width = 1280;
  int height = 960;
  int samples = 4;  ///< a pixel, or as many as OpenGL has; 1 for no multisampling
  /// How far, in pixels, surfaces may lie beside their place where fewer triangles are drawn for speed;
  /// 0 draws every triangle.
  double coarseness_px = 0.0;
  /// Fewer triangles are found by a thread, and until then all are drawn: the first picture comes sooner, and
  /// which one has fewer depends on the clock. False: `load` waits for them.
  bool is_coarser_later = false;
};

/// One look at the scene. The camera's aspect is that of the viewport.
struct Shot {
  Camera camera;
  Viewport viewport;
};

/// Triangles over the picture, as user interfaces make them.
struct OverlayVertex {
  float x_px = 0.0F, y_px = 0.0F;  ///< from the top left corner
  float u = 0.0F, v = 0.0F;        ///< of the font's image
  VertexColour colour{};
};
struct OverlayCommand {
  std::array<float, 4> clip_px{};  ///< left, top, right, bottom
  std::uint32_t first_index = 0, n_indices = 0, first_vertex = 0;
};
struct Overlay {
  std::vector<OverlayVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<OverlayCommand> commands;
};

/// How much of each pixel a glyph covers; one corner is wholly covered, for areas without glyphs.
struct OverlayFont {
  int width = 0, height = 0;
  std::vector<std::uint8_t> coverage;  ///< [height * width]
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  /// Takes over the meshes of `scene`. Wanted before `draw`, and again when drawables come or go.
  virtual void load(const Scene& scene) = 0;
  /// Wanted before an overlay is drawn.
  virtual void load(const OverlayFont& font) = 0;
  /// From then on shots are drawn into a picture of the warp's size, and what is shown is that picture
  /// carried over by `warp`; overlays are drawn over it, unwarped. A renderer that warps keeps its size.
  virtual void load(const Warp& warp) = 0;
  virtual void resize(int width, int height) = 0;
  virtual int width() const = 0;   ///< pixels
  virtual int height() const = 0;  ///< pixels

  /// Draws the loaded meshes with the poses, materials and lights of `scene`, which must have the same
  /// drawables; meshes and colours of a new revision are taken over, of the sizes loaded or smaller. The
  /// image is valid until the next draw. Allocates nothing but what the overlay's growth needs.
  virtual const Image& draw(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay) = 0;
  /// The same without an image: into the window, where there is one; returns when it is drawn.
  virtual void present(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay) = 0;

  /// One shot as large as the picture.
  const Image& draw(const Scene& scene, const Camera& camera);
};

enum class Backend {
  osmesa,  ///< in memory; wants no display and no driver
  egl      ///< surfaceless; a graphics card where there is one
};

/// Rendering without any display.
/// Throws InputError when the library gives no OpenGL 3.3 or the size is beyond its limits.
std::unique_ptr<Renderer> make_offscreen_renderer(const RenderOptions& options,
                                                  Backend backend = Backend::osmesa);

}  // namespace vrda
