// Draws scenes by OpenGL into a frame buffer: background, opaque and translucent surfaces, overlay,
// distortion.
#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "view/gl_context.hpp"
#include "view/gl_mesh.hpp"
#include "view/gl_table.hpp"
#include "view/shaders.hpp"

namespace vrda::view {
namespace {

/// Draws an overlay, such as text and controls.
class OverlayPainter {
 public:
  explicit OverlayPainter(const GlTable& gl)
      : gl_(gl),
        program_(gl, "", overlay_vertex_shader, overlay_fragment_shader),
        geometry_(create_geometry(gl, sizeof(OverlayVertex),
                                  {{2, offsetof(OverlayVertex, x_px)},
                                   {2, offsetof(OverlayVertex, u)},
                                   {4, offsetof(OverlayVertex, colour), true}}))
  {
  }

  void load(const OverlayFont& font)
  {
    check(
        font.coverage.size() == static_cast<std::size_t>(font.width) * static_cast<std::size_t>(font.height),
        "a font image has one byte per pixel");
    font_ = create_texture(gl_, {font.width, font.height, GL_R8, GL_RED, GL_UNSIGNED_BYTE, GL_LINEAR, true},
                           font.coverage.data());
    kept_.clear();
  }

  /// Draws onto the bound frame buffer `frame` of `width` x `height` pixels.
  void draw(const Overlay& overlay, unsigned frame, int width, int height)
  {
    if (overlay.commands.empty() || overlay.indices.empty()) return;
    check(font_ != 0, "a font is loaded before an overlay is drawn");
    program_.use();
    program_.set("size_px", width, height);
    gl_.BindTexture(GL_TEXTURE_2D, font_);
    gl_.BindVertexArray(geometry_.array);
    upload(overlay);
    gl_.Viewport(0, 0, width, height);
    gl_.Disable(GL_DEPTH_TEST);
    gl_.Enable(GL_BLEND);
    gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    gl_.Enable(GL_SCISSOR_TEST);
    size_ = {width, height};
    std::size_t next = 0;
    for (std::size_t k = 0; k < overlay.panels.size() && frame != 0; ++k) {
      const OverlayPanel& panel = overlay.panels[k];
      draw_commands(overlay, next, panel.first_command);
      next = panel.first_command + panel.n_commands;
      draw_panel(overlay, k, frame);
    }
    draw_commands(overlay, next, overlay.commands.size());
    gl_.Disable(GL_SCISSOR_TEST);
    gl_.Disable(GL_BLEND);
  }

 private:
  struct Kept {
    std::vector<OverlayVertex> vertices;
    std::array<float, 4> box_px{};
  };

  void draw_commands(const Overlay& overlay, std::size_t first, std::size_t last)
  {
    const auto pixel = [](float value_px, int most) {
      return static_cast<int>(std::clamp(value_px, 0.0F, static_cast<float>(most)));
    };
    for (std::size_t k = first; k < last; ++k) {
      const OverlayCommand& command = overlay.commands[k];
      check(std::size_t{command.first_index} + command.n_indices <= overlay.indices.size(),
            "an overlay's commands are within its indices");
      const int left = pixel(command.clip_px[0], size_[0]), top = pixel(command.clip_px[1], size_[1]);
      const int right = pixel(command.clip_px[2], size_[0]), bottom = pixel(command.clip_px[3], size_[1]);
      if (right <= left || bottom <= top) continue;
      gl_.Scissor(left, size_[1] - bottom, right - left, bottom - top);
      gl_.DrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(command.n_indices), GL_UNSIGNED_INT,
                                 buffer_offset(command.first_index * sizeof(std::uint32_t)),
                                 static_cast<GLint>(command.first_vertex));
    }
  }

  /// Triangles of the interface follow from their vertices.
  void draw_panel(const Overlay& overlay, std::size_t row, unsigned frame)
  {
    const OverlayPanel& panel = overlay.panels[row];
    if (panels_size_ != size_) {
      panels_ = create_target(gl_, {size_[0], size_[1], 0, false});
      panels_size_ = size_;
      kept_.clear();
    }
    if (kept_.size() <= row) kept_.resize(row + 1);
    Kept& kept = kept_[row];
    const std::span<const OverlayVertex> vertices =
        std::span(overlay.vertices).subspan(panel.first_vertex, panel.n_vertices);
    const bool is_kept = kept.box_px == panel.box_px && kept.vertices.size() == vertices.size() &&
                         std::memcmp(kept.vertices.data(), vertices.data(), vertices.size_bytes()) == 0;
    const std::array<float, 4>& at = panel.box_px;
    const int left = std::max(0, static_cast<int>(at[0])), top = std::max(0, static_cast<int>(at[1]));
    const int right = std::min(size_[0], static_cast<int>(at[2])),
              bottom = std::min(size_[1], static_cast<int>(at[3]));
    const PixelBox box{left, size_[1] - bottom, right - left, bottom - top};
    if (box.width <= 0 || box.height <= 0) return;
    gl_.BindFramebuffer(GL_FRAMEBUFFER, frame);
    if (!is_kept) draw_commands(overlay, panel.first_command, panel.first_command + panel.n_commands);
    gl_.Disable(GL_SCISSOR_TEST);
    gl_.Disable(GL_FRAMEBUFFER_SRGB);  // values are copied unchanged
    if (is_kept)
      copy_box(gl_, panels_.frame, frame, box, GL_COLOR_BUFFER_BIT);
    else
      copy_box(gl_, frame, panels_.frame, box, GL_COLOR_BUFFER_BIT);
    gl_.Enable(GL_FRAMEBUFFER_SRGB);
    gl_.Enable(GL_SCISSOR_TEST);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, frame);
    if (is_kept) return;
    kept.vertices.assign(vertices.begin(), vertices.end());
    kept.box_px = panel.box_px;
  }

  void upload(const Overlay& overlay)
  {
    const auto fill = [&](GLsizeiptr& room_bytes, GLenum kind, std::size_t n_bytes, const void* data) {
      const auto size = static_cast<GLsizeiptr>(n_bytes);
      // Twice the required size, so that a growing overlay does not reallocate every frame.
      if (size > room_bytes) room_bytes = 2 * size;
      // Orphan the previous storage, which the GPU may still be reading.
      gl_.BufferData(kind, room_bytes, nullptr, GL_STREAM_DRAW);
      gl_.BufferSubData(kind, 0, size, data);
    };
    gl_.BindBuffer(GL_ARRAY_BUFFER, geometry_.vertices);
    fill(vertex_bytes_, GL_ARRAY_BUFFER, overlay.vertices.size() * sizeof(OverlayVertex),
         overlay.vertices.data());
    fill(index_bytes_, GL_ELEMENT_ARRAY_BUFFER, overlay.indices.size() * sizeof(std::uint32_t),
         overlay.indices.data());
  }

  const GlTable& gl_;
  GlProgram program_;
  Geometry geometry_;
  GlObject font_;
  GLsizeiptr vertex_bytes_ = 0, index_bytes_ = 0;  // room in the buffers
  std::array<int, 2> size_{}, panels_size_{};
  Target panels_;           // pixels of the panels
  std::vector<Kept> kept_;  // what they show
};

/// Of the extension EXT_texture_sRGB_decode.
constexpr GLenum texture_srgb_decode = 0x8A48;
constexpr GLint skip_decode = 0x8A4A;

/// Warps a rendered image by a mesh.
class WarpPainter {
 public:
  WarpPainter(const GlTable& gl, const Warp& warp, int picture_width, int picture_height)
      : gl_(gl),
        mesh_(warp.mesh),
        width_(warp.width),
        height_(warp.height),
        picture_width_(picture_width),
        picture_height_(picture_height),
        program_(gl, "", warp_vertex_shader, warp_fragment_shader),
        geometry_(create_geometry(gl, sizeof(WarpVertex),
                                  {{2, offsetof(WarpVertex, x_px)}, {2, offsetof(WarpVertex, u)}}))
  {
    for (const std::uint32_t k : mesh_.triangles)
      check(k < mesh_.vertices.size(), "a warp's triangles are within its vertices");
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh_.vertices.size() * sizeof(WarpVertex)),
                   mesh_.vertices.data(), GL_STATIC_DRAW);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(mesh_.triangles.size() * sizeof(std::uint32_t)),
                   mesh_.triangles.data(), GL_STATIC_DRAW);
    program_.use();
    program_.set("size_px", width_, height_);
    picture_texture_ = create_texture(
        gl_, {picture_width, picture_height, GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE, GL_LINEAR, true},
        nullptr);
    gl_.TexParameteri(GL_TEXTURE_2D, texture_srgb_decode, skip_decode);
    is_encoded_ = gl_.GetError() == GL_NO_ERROR;
    picture_ = create_frame(gl_, picture_texture_);
    warped_ = create_target(gl_, {width_, height_, 0, false});
  }

  /// Reads the boxes `changed` of the frame buffer `picture`, which may be multisampled, and warps the boxes
  /// `used`, outside which it is black, to the frame buffer `to`, which is bound afterwards.
  void draw(unsigned picture, std::span<const PixelBox> changed, std::span<const PixelBox> used, unsigned to)
  {
    for (const PixelBox& box : changed) {
      if (!box.is_empty()) copy_box(gl_, picture, picture_, box, GL_COLOR_BUFFER_BIT);
    }
    gl_.BindFramebuffer(GL_FRAMEBUFFER, to);
    gl_.Viewport(0, 0, width_, height_);
    gl_.Clear(GL_COLOR_BUFFER_BIT);
    gl_.Disable(GL_DEPTH_TEST);
    program_.use();
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_2D, picture_texture_);
    gl_.BindVertexArray(geometry_.array);
    gl_.Enable(GL_SCISSOR_TEST);
    if (is_encoded_) gl_.Disable(GL_FRAMEBUFFER_SRGB);
    for (const PixelBox& box : used) {
      const PixelBox out = box.is_empty() ? PixelBox{} : warped_box(box);
      if (out.is_empty()) continue;
      set_scissor(gl_, out);
      gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(mesh_.triangles.size()), GL_UNSIGNED_INT, nullptr);
    }
    gl_.Enable(GL_FRAMEBUFFER_SRGB);
    gl_.Disable(GL_SCISSOR_TEST);
  }

  const Target& warped() const { return warped_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  /// Bounds of the triangles that sample a box of the picture, with a pixel of margin for interpolation.
  PixelBox warped_box(const PixelBox& used) const
  {
    const auto w = static_cast<float>(picture_width_), h = static_cast<float>(picture_height_);
    const float left = static_cast<float>(used.x) - 1.0F,
                right = static_cast<float>(used.x + used.width) + 1.0F;
    const float top = h - static_cast<float>(used.y + used.height) - 1.0F,
                bottom = h - static_cast<float>(used.y) + 1.0F;
    float low_x = static_cast<float>(width_), low_y = static_cast<float>(height_), high_x = 0.0F,
          high_y = 0.0F;
    for (std::size_t k = 0; k + 2 < mesh_.triangles.size(); k += 3) {
      const std::array<const WarpVertex*, 3> corners{&mesh_.vertices[mesh_.triangles[k]],
                                                     &mesh_.vertices[mesh_.triangles[k + 1]],
                                                     &mesh_.vertices[mesh_.triangles[k + 2]]};
      const auto [u0, u1] = std::minmax({corners[0]->u, corners[1]->u, corners[2]->u});
      const auto [v0, v1] = std::minmax({corners[0]->v, corners[1]->v, corners[2]->v});
      if (u1 * w < left || u0 * w > right || v1 * h < top || v0 * h > bottom) continue;
      for (const WarpVertex* const corner : corners) {
        low_x = std::min(low_x, corner->x_px);
        low_y = std::min(low_y, corner->y_px);
        high_x = std::max(high_x, corner->x_px);
        high_y = std::max(high_y, corner->y_px);
      }
    }
    if (high_x <= low_x || high_y <= low_y) return {};
    const int x = static_cast<int>(std::floor(low_x)), y = static_cast<int>(std::floor(low_y));
    const int width = static_cast<int>(std::ceil(high_x)) - x,
              height = static_cast<int>(std::ceil(high_y)) - y;
    return {x, height_ - y - height, width, height};
  }

  const GlTable& gl_;
  WarpMesh mesh_;
  int width_ = 0, height_ = 0, picture_width_ = 0, picture_height_ = 0;
  bool is_encoded_ = false;  ///< interpolates sRGB values, without decoding and encoding
  GlProgram program_;
  Geometry geometry_;
  GlObject picture_, picture_texture_;  // frame buffer and its colour texture
  Target warped_;
};

/// Ambient occlusion in screen space: darkens opaque surfaces in clefts and where bodies touch. It is
/// computed at every second pixel in both directions. Source: McGuire, Mara and Luebke (2012), Scalable
/// ambient obscurance; without its mip levels.
class OcclusionPainter {
 public:
  /// `drawn` is the target to be darkened; all of its samples get the value of the first one.
  OcclusionPainter(const GlTable& gl, const TargetPlan& plan, const Target& drawn)
      : gl_(gl),
        plan_(plan),
        empty_array_(gl.GenVertexArrays, gl.DeleteVertexArrays),
        found_(half_layer()),
        smoothed_(half_layer()),
        find_(gl, "", background_vertex_shader, occlusion_fragment_shader),
        smooth_(gl, "", background_vertex_shader, smoothing_fragment_shader),
        apply_(gl, "", background_vertex_shader, darkening_fragment_shader)
  {
    if (plan.samples > 0) depth_ = create_target(gl_, {plan.width, plan.height, 0});
    colour_frame_ = create_frame(gl_);
    gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, drawn.colour);
  }

  struct View {
    PixelBox box;                ///< of the shot
    PixelBox content;            ///< all surfaces are within it
    Eigen::Matrix4f projection;  ///< of its camera
    float radius_mm = 0.0F;      ///< above 0
  };
  /// Requires the scissor test and the depth of `drawn`; leaves `drawn` bound.
  void draw(const View& view, const Target& drawn)
  {
    const bool is_multisampled = plan_.samples > 0;
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.Disable(GL_DEPTH_TEST);
    if (is_multisampled) {
      set_scissor(gl_, view.box);
      gl_.BindFramebuffer(GL_FRAMEBUFFER, depth_.frame);
      gl_.Clear(GL_DEPTH_BUFFER_BIT);
      copy_box(gl_, drawn.frame, depth_.frame, view.content, GL_DEPTH_BUFFER_BIT);
    }
    const PixelBox box = with_margin(view);
    const PixelBox half{box.x / 2, box.y / 2, (box.x + box.width + 1) / 2 - box.x / 2,
                        (box.y + box.height + 1) / 2 - box.y / 2};
    pass(find_, view, half, is_multisampled ? depth_.depth : drawn.depth, found_.frame);
    pass(smooth_, view, half, found_.texture, smoothed_.frame);
    gl_.Enable(GL_BLEND);
    gl_.BlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE);
    pass(apply_, view, view.content, smoothed_.texture, colour_frame_);
    gl_.Disable(GL_BLEND);
    gl_.Enable(GL_DEPTH_TEST);
    set_viewport(gl_, view.box);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn.frame);
  }

 private:
  /// Darkening and smoothing read three half pixels beyond the surfaces.
  static PixelBox with_margin(const View& view)
  {
    constexpr int margin = 8;
    const int x = std::max(view.box.x, view.content.x - margin),
              y = std::max(view.box.y, view.content.y - margin);
    const int right = std::min(view.box.x + view.box.width, view.content.x + view.content.width + margin),
              top = std::min(view.box.y + view.box.height, view.content.y + view.content.height + margin);
    return {x, y, right - x, top - y};
  }

  /// Part of the light and depth in mm.
  struct Layer {
    GlObject texture, frame;
  };
  Layer half_layer() const
  {
    GlObject texture = create_texture(
        gl_, {(plan_.width + 1) / 2, (plan_.height + 1) / 2, GL_RG16F, GL_RG, GL_FLOAT, GL_NEAREST}, nullptr);
    GlObject frame = create_frame(gl_, texture);
    return {std::move(texture), std::move(frame)};
  }

  /// Computes the box `area` of the frame buffer `to` from a texture.
  void pass(const GlProgram& program, const View& view, const PixelBox& area, unsigned texture,
            unsigned to) const
  {
    set_viewport(gl_, area);
    set_scissor(gl_, area);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, to);
    program.use();
    gl_.BindTexture(GL_TEXTURE_2D, texture);
    program.set("source", 0);
    program.set("radius_mm", view.radius_mm);
    program.set("corner_px", view.box.x, view.box.y);
    program.set("size_px", view.box.width, view.box.height);
    program.set("projection", view.projection);
    fill_viewport(gl_, empty_array_);
  }

  const GlTable& gl_;
  TargetPlan plan_;
  GlObject empty_array_;
  Target depth_;           ///< the first sample's; empty without multisampling
  GlObject colour_frame_;  ///< the colour of the target without its depth
  Layer found_, smoothed_;
  GlProgram find_, smooth_, apply_;
};

// Order-independent transparency on the graphics card, by depth peeling or by lists of fragments per pixel.
// In: a scene (mm) and the target with its opaque surfaces. Out: translucent surfaces blended into that
// target.

/// Limit for malicious scenes; further (nearer) layers are omitted.
constexpr int most_layers = 64;

/// The depth of the nearest surfaces of a structure.
class FrontSurfaces {
 public:
  FrontSurfaces(const GlTable& gl, const TargetPlan& plan, const Target& drawn)
      : gl_(gl), is_multisampled_(plan.samples > 0), depth_(create_target(gl, plan, &drawn))
  {
  }

  /// Calls `draw(row)` for each translucent group of the shot with its depth in the unit `front_unit`, the
  /// frame buffer `to` bound and the scissor box of the group set.
  template <typename Draw>
  void for_each(SurfacePainter& surfaces, const Scene& scene, unsigned to, const Draw& draw)
  {
    gl_.ActiveTexture(GL_TEXTURE0 + front_unit);
    gl_.BindTexture(is_multisampled_ ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, depth_.depth);
    gl_.ActiveTexture(GL_TEXTURE0);
    for (const SurfacePainter::Group& group : surfaces.translucent_groups()) {
      set_scissor(gl_, group.box);
      find(surfaces, scene, group);
      gl_.BindFramebuffer(GL_FRAMEBUFFER, to);
      draw(group.row);
    }
  }

 private:
  void find(SurfacePainter& surfaces, const Scene& scene, const SurfacePainter::Group& group)
  {
    gl_.DepthMask(GL_TRUE);
    gl_.DepthFunc(GL_LESS);
    if (!group.is_structure) return;
    gl_.BindFramebuffer(GL_FRAMEBUFFER, depth_.frame);
    gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    gl_.ClearDepth(1.0);
    gl_.Clear(GL_DEPTH_BUFFER_BIT);
    surfaces.draw(scene, SurfacePass::front_depth, group.row);
    gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  }

  const GlTable& gl_;
  bool is_multisampled_;
  Target depth_;
};

/// Depth peeling from the farthest layer: one pass finds the farthest translucent depth in front of the
/// previous layer, a second one blends the fragments of exactly that depth. Source: Everitt (2001),
/// "Interactive order-independent transparency"; here back to front, which needs no second colour buffer.
class LayerPeeler {
 public:
  LayerPeeler(const GlTable& gl, const TargetPlan& plan, const Target& drawn)
      : gl_(gl),
        is_multisampled_(plan.samples > 0),
        query_(gl.GenQueries, gl.DeleteQueries),
        last_query_(gl.GenQueries, gl.DeleteQueries)
  {
    for (Target& layer : layers_) layer = create_target(gl_, plan, &drawn);
  }

  /// Blends over the opaque surfaces in `drawn`, which stays bound.
  void draw(SurfacePainter& surfaces, FrontSurfaces& fronts, const Scene& scene, const Target& drawn)
  {
    const PixelBox& box = surfaces.translucent_box();
    if (box.is_empty()) return;
    gl_.Enable(GL_SCISSOR_TEST);
    gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    // Reading a query waits until the layer is drawn. Therefore as many layers as in the previous frame are
    // drawn without queries (an empty one draws nothing), and the query of the last one is read a frame
    // later.
    if (n_expected_ > 0 && !is_found(last_query_)) --n_expected_;
    unsigned behind = drawn.depth;
    for (int i = 0; i < most_layers; ++i) {
      const Target& layer = layers_[static_cast<std::size_t>(i % 2)];
      const bool is_expected = i < n_expected_;
      const bool is_last_expected = i + 1 == n_expected_;
      set_scissor(gl_, box);
      clear(layer);
      fronts.for_each(surfaces, scene, layer.frame,
                      [&](std::size_t group) { peel(surfaces, scene, behind, group); });
      set_scissor(gl_, box);
      gl_.DepthMask(GL_FALSE);
      gl_.DepthFunc(GL_EQUAL);
      gl_.Enable(GL_BLEND);
      const unsigned query = is_last_expected ? last_query_ : is_expected ? 0U : query_;
      if (query != 0) gl_.BeginQuery(GL_ANY_SAMPLES_PASSED, query);
      surfaces.draw(scene, SurfacePass::translucent_colour);
      if (query != 0) gl_.EndQuery(GL_ANY_SAMPLES_PASSED);
      gl_.Disable(GL_BLEND);
      if (!is_expected) {
        if (!is_found(query_)) break;
        n_expected_ = i + 1;
        std::swap(query_, last_query_);
      }
      behind = layer.depth;
    }
    gl_.DepthMask(GL_TRUE);
    gl_.DepthFunc(GL_LESS);
    gl_.ClearDepth(1.0);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn.frame);
  }

 private:
  bool is_found(unsigned query) const
  {
    GLuint is_found = 0;
    gl_.GetQueryObjectuiv(query, GL_QUERY_RESULT, &is_found);
    return is_found != 0;
  }

  /// Before the farthest depths are found.
  void clear(const Target& layer)
  {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, layer.frame);
    gl_.DepthMask(GL_TRUE);
    gl_.ClearDepth(0.0);
    gl_.Clear(GL_DEPTH_BUFFER_BIT);
  }

  /// Finds the farthest depths of a group in front of `behind`.
  void peel(SurfacePainter& surfaces, const Scene& scene, unsigned behind, std::size_t group)
  {
    gl_.BindTexture(is_multisampled_ ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, behind);
    gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    gl_.DepthFunc(GL_GREATER);
    surfaces.draw(scene, SurfacePass::translucent_depth, group);
    gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  }

  const GlTable& gl_;
  bool is_multisampled_;
  std::array<Target, 2> layers_{};  // the previous and the present layer
  int n_expected_ = 0;              // layers of the previous frame
  GlObject query_, last_query_;     // for the layer after those, and for the last of those
};

/// Next node, depth, and colour in two words.
constexpr std::size_t node_bytes = 16;

/// Initial capacity per pixel: transparent bones have about four fragments in half of the image.
constexpr std::size_t first_nodes_a_pixel = 2;

/// Per-pixel linked lists: one pass stores all translucent fragments, a second one blends each list back to
/// front. Requires OpenGL 4.3 and one sample per pixel. Source: Yang et al. (2010), "Real-time concurrent
/// linked list construction on the GPU".
class FragmentLists {
 public:
  static bool is_supported(const GlTable& gl)
  {
    GLint major = 0, minor = 0, n_blocks = 0;
    gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    if (10 * major + minor < 43 || gl.MemoryBarrier == nullptr) return false;
    gl.GetIntegerv(GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS, &n_blocks);
    return n_blocks >= 3;
  }

  explicit FragmentLists(const GlTable& gl) : gl_(gl)
  {
    GLint most_bytes = 0;
    gl_.GetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most_bytes);
    most_nodes_ = static_cast<std::size_t>(std::max(most_bytes, 0)) / node_bytes;
  }

  /// Must be called before the first draw and after every change of size.
  void resize(int width, int height)
  {
    width_ = static_cast<unsigned>(width);
    height_ = static_cast<unsigned>(height);
    is_open_ = false;
  }

  /// Blends over the opaque surfaces in `drawn`, which is bound. Returns false without drawing if the
  /// fragments exceed the largest buffer.
  bool draw(SurfacePainter& surfaces, FrontSurfaces& fronts, const Scene& scene, const Target& drawn)
  {
    const PixelBox& box = surfaces.translucent_box();
    if (box.is_empty()) return true;
    if (!is_open_) open();
    const std::size_t n_nodes = store(surfaces, fronts, scene, drawn);
    if (n_nodes > capacity_) {
      clear_heads();
      if (n_nodes > most_nodes_) return false;
      reserve(2 * n_nodes);
      store(surfaces, fronts, scene, drawn);
    }
    set_scissor(gl_, box);
    gl_.Disable(GL_DEPTH_TEST);
    gl_.Enable(GL_BLEND);
    gl_.BlendFuncSeparate(GL_ONE, GL_SRC_ALPHA, GL_ZERO, GL_ONE);
    blend_.use();
    fill_viewport(gl_, empty_array_);
    gl_.Disable(GL_BLEND);
    gl_.Enable(GL_DEPTH_TEST);
    return true;
  }

 private:
  /// Makes the buffers for the present size and, on first use, the program.
  void open()
  {
    if (!blend_.is_linked()) {
      blend_ = GlProgram(gl_, "#version 430 core\n#define MOST_LAYERS " + std::to_string(most_layers) + "\n",
                         background_vertex_shader, blend_fragment_shader);
      empty_array_ = {gl_.GenVertexArrays, gl_.DeleteVertexArrays};
      for (GlObject* const buffer : {&heads_, &nodes_, &count_})
        *buffer = {gl_.GenBuffers, gl_.DeleteBuffers};
    }
    clear_heads();
    reserve(std::size_t{first_nodes_a_pixel} * width_ * height_);
    is_open_ = true;
  }

  void fill(unsigned buffer, std::size_t n_bytes, const void* data, GLenum use = GL_DYNAMIC_COPY)
  {
    gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    gl_.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(n_bytes), data, use);
  }

  void clear_heads()
  {
    const std::vector<std::uint32_t> none(static_cast<std::size_t>(width_) * height_, 0U);
    fill(heads_, none.size() * sizeof(std::uint32_t), none.data());
  }

  void reserve(std::size_t n_nodes)
  {
    capacity_ = std::min(n_nodes, most_nodes_);
    fill(nodes_, capacity_ * node_bytes, nullptr);
  }

  /// Fills the lists; returns the number of nodes required, which may exceed the capacity.
  std::size_t store(SurfacePainter& surfaces, FrontSurfaces& fronts, const Scene& scene, const Target& drawn)
  {
    // Node 0 is the end of every list.
    const std::array<std::uint32_t, 2> begun{1U, width_};
    fill(count_, sizeof(begun), begun.data(), GL_DYNAMIC_READ);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, heads_);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, nodes_);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, count_);
    fronts.for_each(surfaces, scene, drawn.frame, [&](std::size_t group) {
      gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
      gl_.DepthMask(GL_FALSE);
      surfaces.draw(scene, SurfacePass::translucent_store, group);
      gl_.DepthMask(GL_TRUE);
      gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    });
    gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    std::uint32_t n_nodes = 0;
    gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, count_);
    gl_.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof(n_nodes), &n_nodes);
    return n_nodes;
  }

  const GlTable& gl_;
  unsigned width_ = 0, height_ = 0;
  GlObject empty_array_, heads_, nodes_, count_;
  std::size_t capacity_ = 0, most_nodes_ = 0;
  GlProgram blend_;
  bool is_open_ = false;
};

bool is_black(const Background& background)
{
  return background.top.isZero(0.0F) && background.bottom.isZero(0.0F);
}

class GlRenderer final : public Renderer {
 public:
  GlRenderer(std::unique_ptr<GlContext> context, const RenderOptions& options)
      : context_(std::move(context)), options_(options)
  {
    context_->make_current();
    gl_ = load_gl_table(*context_);
    check_size(options);
    GLint most_samples = 0, most_depth_samples = 0;
    gl_.GetIntegerv(GL_MAX_SAMPLES, &most_samples);
    gl_.GetIntegerv(GL_MAX_DEPTH_TEXTURE_SAMPLES, &most_depth_samples);
    most_samples_ = std::max(1, std::min(most_samples, most_depth_samples));
    options_.samples = possible_samples(options.samples);
    background_ = GlProgram(gl_, "", background_vertex_shader, background_fragment_shader);
    empty_array_ = {gl_.GenVertexArrays, gl_.DeleteVertexArrays};
    gl_.ClearColor(0.0F, 0.0F, 0.0F, 1.0F);  // between the shots
    surfaces_.emplace(gl_, SurfaceOptions{options_.coarseness_px, options_.has_deferred_levels});
    overlays_.emplace(gl_);
    has_srgb_screen_ = finds_srgb_screen();
    open_targets();
    check(gl_.GetError() == GL_NO_ERROR, "the renderer opens without an OpenGL error");
  }

  ~GlRenderer() override { context_->make_current(); }

  void load(const Scene& scene) override
  {
    context_->make_current();
    is_picture_kept_ = false;
    surfaces_->load(scene);
    check(gl_.GetError() == GL_NO_ERROR, "meshes load without an OpenGL error");
  }

  void load(const OverlayFont& font) override
  {
    context_->make_current();
    overlays_->load(font);
    check(gl_.GetError() == GL_NO_ERROR, "a font loads without an OpenGL error");
  }

  void load(const Warp& warp) override
  {
    context_->make_current();
    RenderOptions shown = options_;
    shown.width = warp.width;
    shown.height = warp.height;
    check_size(shown);
    warper_.reset();
    is_sparse_ = false;
    if (warp.source_width > 0) size_picture(warp.source_width, warp.source_height);
    warper_.emplace(gl_, warp, options_.width, options_.height);
    size_image();
    check(gl_.GetError() == GL_NO_ERROR, "a warp loads without an OpenGL error");
  }

  void resize(int width, int height) override
  {
    if (width == options_.width && height == options_.height) return;
    context_->make_current();
    if (warper_) return;
    size_picture(width, height);
  }

  void set_samples(int samples) override
  {
    if (possible_samples(samples) == options_.samples) return;
    context_->make_current();
    std::swap(set_, other_set_);
    is_sparse_ = is_picture_kept_ = false;
    options_.samples = possible_samples(samples);
    if (set_.samples != options_.samples) {
      set_ = {};
      open_targets();
    }
    check(gl_.GetError() == GL_NO_ERROR, "the samples change without an OpenGL error");
  }

  int width() const override { return options_.width; }
  int height() const override { return options_.height; }
  const Image& draw(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay,
                    const std::function<void()>& meanwhile) override
  {
    draw_frame(scene, shots, overlay, false);
    if (meanwhile) {
      gl_.Flush();
      meanwhile();
    }
    read_pixels();
    check(gl_.GetError() == GL_NO_ERROR, "a frame is drawn without an OpenGL error");
    return image_;
  }

  void present(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay) override
  {
    draw_frame(scene, shots, overlay, true);
    show_on_screen();
  }

  bool present_again(const Overlay* overlay) override
  {
    if (!is_picture_kept_) return false;
    context_->make_current();
    is_on_screen_ = false;
    draw_overlay(overlay, shown().frame);
    show_on_screen();
    return true;
  }

 private:
  void check_size(const RenderOptions& options) const
  {
    GLint most = 0;
    gl_.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
    if (std::min(options.width, options.height) < 1 || std::max(options.width, options.height) > most) {
      throw InputError({"image", "size", std::to_string(options.width) + "x" + std::to_string(options.height),
                        "1 to " + std::to_string(most) + " pixels each way"});
    }
    check(options.samples >= 1, "there is at least one sample per pixel");
  }

  void open_targets()
  {
    const int w = options_.width, h = options_.height;
    set_.drawn = create_target(gl_, plan());
    set_.samples = options_.samples;
    set_.fronts = std::make_unique<FrontSurfaces>(gl_, plan(), set_.drawn);
    set_.peeler = std::make_unique<LayerPeeler>(gl_, plan(), set_.drawn);
    if (!lists_ && !is_multisampled() && FragmentLists::is_supported(gl_)) lists_.emplace(gl_);
    if (lists_) lists_->resize(w, h);
    if (is_multisampled()) set_.resolved = create_target(gl_, {w, h, 0, false});
    size_image();
  }

  void close_targets()
  {
    set_ = {};
    other_set_ = {};
    is_sparse_ = is_picture_kept_ = false;
  }

  void size_picture(int width, int height)
  {
    RenderOptions resized = options_;
    resized.width = width;
    resized.height = height;
    check_size(resized);
    close_targets();
    options_ = resized;
    open_targets();
    check(gl_.GetError() == GL_NO_ERROR, "the renderer is resized without an OpenGL error");
  }

  void draw_background(const Background& background)
  {
    gl_.Disable(GL_DEPTH_TEST);
    background_.use();
    background_.set("top", background.top.data());
    background_.set("bottom", background.bottom.data());
    fill_viewport(gl_, empty_array_);
  }

  void draw_occlusion(const Scene& scene, const Camera& camera, const PixelBox& box)
  {
    const bool is_shaded = scene.mode != DrawMode::wire && scene.mode != DrawMode::hidden_line;
    if (!is_shaded || !(scene.occlusion_radius_mm > 0.0)) return;
    if (!set_.occlusion) set_.occlusion = std::make_unique<OcclusionPainter>(gl_, plan(), set_.drawn);
    set_.occlusion->draw({box, surfaces_->content_box(), projection(camera).cast<float>(),
                          static_cast<float>(scene.occlusion_radius_mm)},
                         set_.drawn);
  }

  void draw_shot(const Scene& scene, std::size_t row, const Shot& shot)
  {
    const Viewport& view = shot.viewport;
    const PixelBox box{view.x, options_.height - view.y - view.height, view.width, view.height};
    surfaces_->begin(scene, shot, box, is_multisampled());
    const PixelBox used = is_sparse_ || is_resolved() ? surfaces_->content_box() : box;
    changed_[row] = is_sparse_ ? bounding_box(used, used_[row]) : used;
    used_[row] = used;
    boxes_[row] = box;
    if (changed_[row].is_empty()) return;
    set_viewport(gl_, box);
    gl_.Enable(GL_SCISSOR_TEST);
    set_scissor(gl_, changed_[row]);
    if (is_sparse_) gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    // The frame buffer was cleared to black.
    if (!is_black(scene.background)) draw_background(scene.background);
    gl_.Enable(GL_DEPTH_TEST);
    surfaces_->draw(scene, SurfacePass::opaque);
    draw_occlusion(scene, shot.camera, box);
    FrontSurfaces& fronts = *set_.fronts;
    const bool is_blended =
        !is_multisampled() && lists_ && lists_->draw(*surfaces_, fronts, scene, set_.drawn);
    if (!is_blended) set_.peeler->draw(*surfaces_, fronts, scene, set_.drawn);
    gl_.Disable(GL_SCISSOR_TEST);
  }

  void draw_frame(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay, bool is_for_screen)
  {
    context_->make_current();
    // Copying a frame to the window takes as long in software as warping it.
    is_on_screen_ = is_for_screen && warper_ && has_srgb_screen_;
    const unsigned output = is_on_screen_ ? 0 : shown().frame;
    surfaces_->refresh(scene);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, set_.drawn.frame);
    gl_.Enable(GL_FRAMEBUFFER_SRGB);
    const bool can_be_sparse = warper_ && is_black(scene.background);
    is_sparse_ = is_sparse_ && can_be_sparse && used_.size() == shots.size();
    used_.resize(shots.size());
    changed_.resize(shots.size());
    boxes_.resize(shots.size());
    // Without scissors software rendering clears faster.
    if (!is_sparse_) gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    for (std::size_t k = 0; k < shots.size(); ++k) draw_shot(scene, k, shots[k]);
    if (warper_) {
      // The first frame warps all of it, the gaps between the shots too.
      if (!is_sparse_) changed_.assign(1, {0, 0, options_.width, options_.height});
      warper_->draw(set_.drawn.frame, changed_, used_, output);
    }
    is_sparse_ = can_be_sparse;
    is_picture_kept_ = is_resolved();
    backdrop_ = scene.background;
    draw_overlay(overlay, output);
  }

  /// The background, of one sample, and the resolved samples of the surfaces.
  void resolve()
  {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, set_.resolved.frame);
    gl_.Clear(GL_COLOR_BUFFER_BIT);
    gl_.Enable(GL_SCISSOR_TEST);
    for (const PixelBox& box : boxes_) {
      set_viewport(gl_, box);
      set_scissor(gl_, box);
      if (!is_black(backdrop_)) draw_background(backdrop_);
    }
    gl_.Disable(GL_SCISSOR_TEST);
    // Samples are averaged in linear light.
    for (const PixelBox& box : used_)
      if (!box.is_empty()) copy_box(gl_, set_.drawn.frame, set_.resolved.frame, box, GL_COLOR_BUFFER_BIT);
  }

  /// Draws the overlay over the finished picture.
  void draw_overlay(const Overlay* overlay, unsigned frame)
  {
    gl_.Enable(GL_FRAMEBUFFER_SRGB);
    if (is_resolved()) resolve();
    gl_.BindFramebuffer(GL_FRAMEBUFFER, frame);
    if (overlay != nullptr) overlays_->draw(*overlay, frame, shown_width(), shown_height());
  }

  void show_on_screen()
  {
    if (context_->has_screen() && !is_on_screen_) {
      gl_.Disable(GL_FRAMEBUFFER_SRGB);  // values are copied unchanged
      copy_box(gl_, shown().frame, 0, {0, 0, shown_width(), shown_height()}, GL_COLOR_BUFFER_BIT);
    }
    gl_.Finish();
    check(gl_.GetError() == GL_NO_ERROR, "a frame is shown without an OpenGL error");
  }

  void read_pixels()
  {
    const int w = shown_width(), h = shown_height();
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.ReadPixels(0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, upside_down_.data());
    const std::ptrdiff_t stride = 4 * static_cast<std::ptrdiff_t>(w);
    for (int row = 0; row < h; ++row)
      std::copy_n(upside_down_.begin() + (h - 1 - row) * stride, stride, image_.rgba.begin() + row * stride);
  }

  int possible_samples(int samples) const { return std::min(samples, most_samples_); }
  bool is_multisampled() const { return options_.samples > 1; }
  /// A warp resolves the samples itself.
  bool is_resolved() const { return is_multisampled() && !warper_; }
  TargetPlan plan() const
  {
    return {options_.width, options_.height, is_multisampled() ? options_.samples : 0};
  }

  /// The complete frame: drawn directly, or resolved from samples.
  const Target& finished() const { return is_multisampled() ? set_.resolved : set_.drawn; }
  /// The output after warping, and its size.
  const Target& shown() const { return warper_ ? warper_->warped() : finished(); }
  int shown_width() const { return warper_ ? warper_->width() : options_.width; }
  int shown_height() const { return warper_ ? warper_->height() : options_.height; }
  void size_image()
  {
    image_.width = shown_width();
    image_.height = shown_height();
    image_.rgba.resize(static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height) * 4);
    upside_down_.resize(image_.rgba.size());
  }

  bool finds_srgb_screen() const
  {
    if (!context_->has_screen()) return false;
    gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
    GLint encoding = GL_LINEAR;
    gl_.GetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, GL_BACK_LEFT,
                                            GL_FRAMEBUFFER_ATTACHMENT_COLOR_ENCODING, &encoding);
    return encoding == GL_SRGB;
  }

  std::unique_ptr<GlContext> context_;
  GlTable gl_;
  RenderOptions options_;
  int most_samples_ = 1;
  GlProgram background_;
  GlObject empty_array_;
  // Created after the context is current and destroyed while it still is.
  std::optional<SurfacePainter> surfaces_;
  std::optional<OverlayPainter> overlays_;
  std::optional<WarpPainter> warper_;
  std::optional<FragmentLists> lists_;
  /// Frame buffers of one number of samples, and what draws to them.
  struct TargetSet {
    int samples = 0;  ///< 0: not open
    Target drawn, resolved;
    std::unique_ptr<FrontSurfaces> fronts;
    std::unique_ptr<LayerPeeler> peeler;
    std::unique_ptr<OcclusionPainter> occlusion;  ///< from its first use on
  };
  TargetSet set_;
  TargetSet other_set_;  ///< kept, so that set_samples() between two numbers takes no time
  /// By shot: what is drawn, and what changed since the last frame. Outside the former `set_.drawn` is black
  /// if `is_sparse_` or `is_resolved()`, so that software rendering clears, resolves and warps a fraction of
  /// the pixels.
  std::vector<PixelBox> used_, changed_;
  std::vector<PixelBox> boxes_;  ///< by shot
  Background backdrop_;          ///< of the last frame
  bool is_sparse_ = false;
  /// The frame of the window can be drawn to, as its values are encoded like those of warped().
  bool has_srgb_screen_ = false;
  bool is_on_screen_ = false;     ///< the last frame was drawn to the window itself
  bool is_picture_kept_ = false;  ///< `set_.drawn` has the last frame's surfaces, without its overlay
  std::vector<std::uint8_t> upside_down_;
  Image image_;
};

}  // namespace

const Image& Renderer::draw(const Scene& scene, const Camera& camera)
{
  const Shot shot{camera, {0, 0, width(), height()}};
  return draw(scene, {&shot, 1}, nullptr);
}

std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, const RenderOptions& options)
{
  return std::make_unique<GlRenderer>(std::move(context), options);
}

std::unique_ptr<Renderer> make_offscreen_renderer(const RenderOptions& options, Backend backend)
{
  return make_gl_renderer(backend == Backend::egl ? make_egl_context() : make_osmesa_context(), options);
}

}  // namespace vrda::view
