#include "render/gl_warp.hpp"

#include <GL/glcorearb.h>

#include <cstddef>

#include "core/error.hpp"
#include "render/shaders.hpp"

namespace vrda {

WarpPainter::WarpPainter(const GlTable& gl, const Warp& warp, int picture_width, int picture_height)
    : gl_(gl),
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
  gl_.GenFramebuffers(1, &picture_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, picture_);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_texture_, 0);
  warped_ = opened_target(gl_, {width_, height_, 0, false});
}

WarpPainter::~WarpPainter()
{
  close_target(gl_, warped_);
  gl_.DeleteFramebuffers(1, &picture_);
  gl_.DeleteTextures(1, &picture_texture_);
  gl_.DeleteBuffers(2, buffers_.data());
  gl_.DeleteVertexArrays(1, &vertex_array_);
  gl_.DeleteProgram(program_);
}

void WarpPainter::upload(const WarpMesh& mesh)
{
  for (const std::uint32_t k : mesh.triangles)
    check(k < mesh.vertices.size(), "a warp's triangles have vertices");
  n_indices_ = static_cast<int>(mesh.triangles.size());
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.GenBuffers(2, buffers_.data());
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[1]);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(WarpVertex)),
                 mesh.vertices.data(), GL_STATIC_DRAW);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(std::uint32_t)),
                 mesh.triangles.data(), GL_STATIC_DRAW);
  for (GLuint i = 0; i < 2; ++i) gl_.EnableVertexAttribArray(i);
  constexpr GLsizei stride = sizeof(WarpVertex);
  gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(WarpVertex, x_px)));
  gl_.VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(WarpVertex, u)));
}

void WarpPainter::draw(unsigned picture)
{
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, picture);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, picture_);
  gl_.BlitFramebuffer(0, 0, picture_width_, picture_height_, 0, 0, picture_width_, picture_height_,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, warped_.frame);
  gl_.Viewport(0, 0, width_, height_);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.UseProgram(program_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, picture_texture_);
  gl_.BindVertexArray(vertex_array_);
  gl_.DrawElements(GL_TRIANGLES, n_indices_, GL_UNSIGNED_INT, nullptr);
}

}  // namespace vrda
