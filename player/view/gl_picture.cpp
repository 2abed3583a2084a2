#include "view/gl_picture.hpp"

#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/error.hpp"
#include "view/shaders.hpp"

namespace vrda::view {
namespace {

/// Of the extension EXT_texture_sRGB_decode.
constexpr GLenum texture_srgb_decode = 0x8A48;
constexpr GLint skip_decode = 0x8A4A;

}  // namespace

OverlayPainter::OverlayPainter(const GlTable& gl) : gl_(gl)
{
  program_ = linked_program(gl_, "#version 330 core\n", overlay_vertex_shader, overlay_fragment_shader);
  size_px_ = gl_.GetUniformLocation(program_, "size_px");
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.GenBuffers(2, buffers_.data());
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[1]);
  for (GLuint i = 0; i < 3; ++i) gl_.EnableVertexAttribArray(i);
  constexpr GLsizei stride = sizeof(OverlayVertex);
  gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(OverlayVertex, x_px)));
  gl_.VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(OverlayVertex, u)));
  gl_.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, stride,
                          buffer_offset(offsetof(OverlayVertex, colour)));
}

OverlayPainter::~OverlayPainter()
{
  gl_.DeleteTextures(1, &font_);
  gl_.DeleteBuffers(2, buffers_.data());
  gl_.DeleteVertexArrays(1, &vertex_array_);
  gl_.DeleteProgram(program_);
}

void OverlayPainter::load(const OverlayFont& font)
{
  check(font.coverage.size() == static_cast<std::size_t>(font.width) * static_cast<std::size_t>(font.height),
        "a font image has one byte per pixel");
  if (font_ == 0) gl_.GenTextures(1, &font_);
  gl_.BindTexture(GL_TEXTURE_2D, font_);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, font.width, font.height, 0, GL_RED, GL_UNSIGNED_BYTE,
                 font.coverage.data());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void OverlayPainter::upload(const Overlay& overlay)
{
  const auto fill = [&](std::size_t i, GLenum kind, std::size_t n_bytes, const void* data) {
    const auto size = static_cast<GLsizeiptr>(n_bytes);
    // Twice the required size, so that a growing overlay does not reallocate every frame.
    if (size > room_bytes_[i]) room_bytes_[i] = 2 * size;
    // Orphan the previous storage, which the GPU may still be reading.
    gl_.BufferData(kind, room_bytes_[i], nullptr, GL_STREAM_DRAW);
    gl_.BufferSubData(kind, 0, size, data);
  };
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  fill(0, GL_ARRAY_BUFFER, overlay.vertices.size() * sizeof(OverlayVertex), overlay.vertices.data());
  fill(1, GL_ELEMENT_ARRAY_BUFFER, overlay.indices.size() * sizeof(std::uint32_t), overlay.indices.data());
}

void OverlayPainter::draw(const Overlay& overlay, int width, int height)
{
  if (overlay.commands.empty() || overlay.indices.empty()) return;
  check(font_ != 0, "a font is loaded before an overlay is drawn");
  gl_.UseProgram(program_);
  gl_.Uniform2f(size_px_, static_cast<float>(width), static_cast<float>(height));
  gl_.BindTexture(GL_TEXTURE_2D, font_);
  gl_.BindVertexArray(vertex_array_);
  upload(overlay);
  gl_.Viewport(0, 0, width, height);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl_.Enable(GL_SCISSOR_TEST);
  const auto pixel = [](float value_px, int most) {
    return static_cast<int>(std::clamp(value_px, 0.0F, static_cast<float>(most)));
  };
  for (const OverlayCommand& command : overlay.commands) {
    check(std::size_t{command.first_index} + command.n_indices <= overlay.indices.size(),
          "an overlay's commands are within its indices");
    const int left = pixel(command.clip_px[0], width), top = pixel(command.clip_px[1], height);
    const int right = pixel(command.clip_px[2], width), bottom = pixel(command.clip_px[3], height);
    if (right <= left || bottom <= top) continue;
    gl_.Scissor(left, height - bottom, right - left, bottom - top);
    gl_.DrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(command.n_indices), GL_UNSIGNED_INT,
                               buffer_offset(command.first_index * sizeof(std::uint32_t)),
                               static_cast<GLint>(command.first_vertex));
  }
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.Disable(GL_BLEND);
}

WarpPainter::WarpPainter(const GlTable& gl, const view::Warp& warp, int picture_width, int picture_height)
    : gl_(gl),
      mesh_(warp.mesh),
      width_(warp.width),
      height_(warp.height),
      picture_width_(picture_width),
      picture_height_(picture_height)
{
  program_ = linked_program(gl_, "#version 330 core\n", warp_vertex_shader, warp_fragment_shader);
  gl_.UseProgram(program_);
  gl_.Uniform2f(gl_.GetUniformLocation(program_, "size_px"), static_cast<float>(width_),
                static_cast<float>(height_));
  upload(warp.mesh);
  gl_.GenTextures(1, &picture_texture_);
  gl_.BindTexture(GL_TEXTURE_2D, picture_texture_);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, picture_width, picture_height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, nullptr);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, texture_srgb_decode, skip_decode);
  is_encoded_ = gl_.GetError() == GL_NO_ERROR;
  gl_.GenFramebuffers(1, &picture_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, picture_);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_texture_, 0);
  warped_ = create_target(gl_, {width_, height_, 0, false});
}

WarpPainter::~WarpPainter()
{
  destroy_target(gl_, warped_);
  gl_.DeleteFramebuffers(1, &picture_);
  gl_.DeleteTextures(1, &picture_texture_);
  gl_.DeleteBuffers(2, buffers_.data());
  gl_.DeleteVertexArrays(1, &vertex_array_);
  gl_.DeleteProgram(program_);
}

void WarpPainter::upload(const view::WarpMesh& mesh)
{
  for (const std::uint32_t k : mesh.triangles)
    check(k < mesh.vertices.size(), "a warp's triangles are within its vertices");
  n_indices_ = static_cast<int>(mesh.triangles.size());
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.GenBuffers(2, buffers_.data());
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[1]);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(view::WarpVertex)),
                 mesh.vertices.data(), GL_STATIC_DRAW);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(std::uint32_t)),
                 mesh.triangles.data(), GL_STATIC_DRAW);
  for (GLuint i = 0; i < 2; ++i) gl_.EnableVertexAttribArray(i);
  constexpr GLsizei stride = sizeof(view::WarpVertex);
  gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, stride,
                          buffer_offset(offsetof(view::WarpVertex, x_px)));
  gl_.VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(view::WarpVertex, u)));
}

/// Bounds of the triangles that sample a box of the picture, with a pixel of margin for interpolation.
PixelBox WarpPainter::warped_box(const PixelBox& used) const
{
  const auto w = static_cast<float>(picture_width_), h = static_cast<float>(picture_height_);
  const float left = static_cast<float>(used.x) - 1.0F,
              right = static_cast<float>(used.x + used.width) + 1.0F;
  const float top = h - static_cast<float>(used.y + used.height) - 1.0F,
              bottom = h - static_cast<float>(used.y) + 1.0F;
  float low_x = static_cast<float>(width_), low_y = static_cast<float>(height_), high_x = 0.0F, high_y = 0.0F;
  for (std::size_t k = 0; k + 2 < mesh_.triangles.size(); k += 3) {
    const std::array<const view::WarpVertex*, 3> corners{&mesh_.vertices[mesh_.triangles[k]],
                                                           &mesh_.vertices[mesh_.triangles[k + 1]],
                                                           &mesh_.vertices[mesh_.triangles[k + 2]]};
    const auto [u0, u1] = std::minmax({corners[0]->u, corners[1]->u, corners[2]->u});
    const auto [v0, v1] = std::minmax({corners[0]->v, corners[1]->v, corners[2]->v});
    if (u1 * w < left || u0 * w > right || v1 * h < top || v0 * h > bottom) continue;
    for (const view::WarpVertex* const corner : corners) {
      low_x = std::min(low_x, corner->x_px);
      low_y = std::min(low_y, corner->y_px);
      high_x = std::max(high_x, corner->x_px);
      high_y = std::max(high_y, corner->y_px);
    }
  }
  if (high_x <= low_x || high_y <= low_y) return {};
  const int x = static_cast<int>(std::floor(low_x)), y = static_cast<int>(std::floor(low_y));
  const int width = static_cast<int>(std::ceil(high_x)) - x, height = static_cast<int>(std::ceil(high_y)) - y;
  return {x, height_ - y - height, width, height};
}

void WarpPainter::draw(unsigned picture, std::span<const PixelBox> changed, std::span<const PixelBox> used,
                       unsigned to)
{
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, picture);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, picture_);
  for (const PixelBox& box : changed) {
    if (box.is_empty()) continue;
    const int right = box.x + box.width, top = box.y + box.height;
    gl_.BlitFramebuffer(box.x, box.y, right, top, box.x, box.y, right, top, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  gl_.BindFramebuffer(GL_FRAMEBUFFER, to);
  gl_.Viewport(0, 0, width_, height_);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.UseProgram(program_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, picture_texture_);
  gl_.BindVertexArray(vertex_array_);
  gl_.Enable(GL_SCISSOR_TEST);
  if (is_encoded_) gl_.Disable(GL_FRAMEBUFFER_SRGB);
  for (const PixelBox& box : used) {
    const PixelBox out = box.is_empty() ? PixelBox{} : warped_box(box);
    if (out.is_empty()) continue;
    gl_.Scissor(out.x, out.y, out.width, out.height);
    gl_.DrawElements(GL_TRIANGLES, n_indices_, GL_UNSIGNED_INT, nullptr);
  }
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
  gl_.Disable(GL_SCISSOR_TEST);
}

}  // namespace vrda::view
