/// The interface of renderers: draws views of a scene (mm) with a graphics card or in software. Sizes are in
/// pixels.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "view/camera.hpp"
#include "view/eye.hpp"
#include "view/image.hpp"
#include "view/scene.hpp"

namespace vrda::view {

/// For animated scenes. An error of half a pixel is invisible in outlines, but removes the shading of small
/// pits.
inline constexpr double moving_coarseness_px = 0.35;

struct RenderOptions {
  int width = 1280;
  int height = 960;
  int samples = 4;  ///< per pixel, limited to the maximum of OpenGL; 1 for no multisampling
  /// Allowed error of surfaces by levels of detail, in pixels; 0 draws every triangle.
  double coarseness_px = 0.0;
  /// A thread computes the levels of detail, and all triangles are drawn until then, so that the first frame
  /// is early but the switch is not reproducible. False: `load` waits for the levels.
  bool has_deferred_levels = false;
};

/// One view of the scene. The camera must have the aspect of the viewport; viewports of a frame do not
/// overlap.
struct Shot {
  Camera camera;
  Viewport viewport;
  bool has_own = true, has_other = true;  ///< whether it shows the scene itself and Scene::other, if any
};

/// Triangles drawn over the rendered scene, as produced by user interfaces.
struct OverlayVertex {
  float x_px = 0.0F, y_px = 0.0F;  ///< from the top left corner
  float u = 0.0F, v = 0.0F;        ///< coordinates in the font image
  VertexColour colour{};
};
struct OverlayCommand {
  std::array<float, 4> clip_px{};  ///< left, top, right, bottom
  std::uint32_t first_index = 0, n_indices = 0, first_vertex = 0;
};
/// An opaque rectangle: while its triangles are those of the last frame, its pixels are copied.
struct OverlayPanel {
  std::array<float, 4> box_px{};  ///< left, top, right, bottom
  std::size_t first_command = 0, n_commands = 0, first_vertex = 0, n_vertices = 0;
};
struct Overlay {
  std::vector<OverlayVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<OverlayCommand> commands;
  std::vector<OverlayPanel> panels = {};  ///< by first_command
};

/// Glyph coverage image; one corner is fully covered, for areas without glyphs.
struct OverlayFont {
  int width = 0, height = 0;
  std::vector<std::uint8_t> coverage;  ///< [height * width]
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  /// Uploads the meshes of `scene`. Required before `draw` and after drawables were added or removed.
  virtual void load(const Scene& scene) = 0;
  /// Required before an overlay is drawn.
  virtual void load(const OverlayFont& font) = 0;
  /// Enables warping: shots are drawn to an image of the warp's source size, which `warp` maps to the output;
  /// overlays are drawn unwarped over the result. A warping renderer ignores resize().
  virtual void load(const Warp& warp) = 0;
  virtual void resize(int width, int height) = 0;
  /// As RenderOptions::samples.
  virtual void set_samples(int samples) = 0;
  virtual int width() const = 0;   ///< pixels
  virtual int height() const = 0;  ///< pixels

  /// Renders the loaded meshes with the poses, materials and lights of `scene`, which must have the same
  /// drawables (and Scene::other); uploads meshes and colours of a new revision. The image is valid until the
  /// next draw. Allocates nothing except for a growing overlay or mesh.
  /// `meanwhile` is called while other threads still draw, and may change the scene.
  virtual const Image& draw(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay,
                            const std::function<void()>& meanwhile = {}) = 0;
  /// Renders to the window, if any, without reading back an image; returns when the frame is complete.
  virtual void present(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay) = 0;
  /// Presents the last picture with another overlay, without drawing its surfaces again. False if it is not
  /// kept, which takes more than one sample per pixel, no warp, and no load or resize since.
  virtual bool present_again(const Overlay* overlay) = 0;

  /// Renders one shot at full size.
  const Image& draw(const Scene& scene, const Camera& camera);
};

enum class Backend {
  osmesa,  ///< software rendering to memory, without display and driver
  egl      ///< surfaceless, on a graphics card if there is one
};

/// Creates a renderer that needs no display. Throws InputError if the library does not support OpenGL 3.3 or
/// the size exceeds its limits.
std::unique_ptr<Renderer> make_offscreen_renderer(const RenderOptions& options,
                                                  Backend backend = Backend::osmesa);

}  // namespace vrda::view
