/// Table of the OpenGL functions in use, with plain types so that OpenGL headers stay in .cpp files, and what
/// all painters share: objects that delete themselves, programs, textures, vertices and render targets.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>

#include "view/gl_context.hpp"

namespace vrda::view {

// Name without "gl", signature. GLuint, GLenum and GLbitfield are unsigned; GLint and GLsizei are int.
#define VRDA_GL_FUNCTIONS(X)                                                              \
  X(ActiveTexture, void(unsigned))                                                        \
  X(AttachShader, void(unsigned, unsigned))                                               \
  X(BeginQuery, void(unsigned, unsigned))                                                 \
  X(BindBuffer, void(unsigned, unsigned))                                                 \
  X(BindBufferBase, void(unsigned, unsigned, unsigned))                                   \
  X(BindFramebuffer, void(unsigned, unsigned))                                            \
  X(BindRenderbuffer, void(unsigned, unsigned))                                           \
  X(BindTexture, void(unsigned, unsigned))                                                \
  X(BindVertexArray, void(unsigned))                                                      \
  X(BlendFuncSeparate, void(unsigned, unsigned, unsigned, unsigned))                      \
  X(BlitFramebuffer, void(int, int, int, int, int, int, int, int, unsigned, unsigned))    \
  X(BufferData, void(unsigned, std::ptrdiff_t, const void*, unsigned))                    \
  X(BufferSubData, void(unsigned, std::ptrdiff_t, std::ptrdiff_t, const void*))           \
  X(CheckFramebufferStatus, unsigned(unsigned))                                           \
  X(Clear, void(unsigned))                                                                \
  X(ClearColor, void(float, float, float, float))                                         \
  X(ClearDepth, void(double))                                                             \
  X(ColorMask, void(unsigned char, unsigned char, unsigned char, unsigned char))          \
  X(CompileShader, void(unsigned))                                                        \
  X(CreateProgram, unsigned())                                                            \
  X(CreateShader, unsigned(unsigned))                                                     \
  X(DeleteBuffers, void(int, const unsigned*))                                            \
  X(DeleteFramebuffers, void(int, const unsigned*))                                       \
  X(DeleteProgram, void(unsigned))                                                        \
  X(DeleteQueries, void(int, const unsigned*))                                            \
  X(DeleteRenderbuffers, void(int, const unsigned*))                                      \
  X(DeleteShader, void(unsigned))                                                         \
  X(DeleteTextures, void(int, const unsigned*))                                           \
  X(DeleteVertexArrays, void(int, const unsigned*))                                       \
  X(DepthFunc, void(unsigned))                                                            \
  X(DepthMask, void(unsigned char))                                                       \
  X(Disable, void(unsigned))                                                              \
  X(DrawArrays, void(unsigned, int, int))                                                 \
  X(DrawElements, void(unsigned, int, unsigned, const void*))                             \
  X(DrawElementsBaseVertex, void(unsigned, int, unsigned, const void*, int))              \
  X(Enable, void(unsigned))                                                               \
  X(EnableVertexAttribArray, void(unsigned))                                              \
  X(EndQuery, void(unsigned))                                                             \
  X(Finish, void())                                                                       \
  X(Flush, void())                                                                        \
  X(FramebufferRenderbuffer, void(unsigned, unsigned, unsigned, unsigned))                \
  X(FramebufferTexture2D, void(unsigned, unsigned, unsigned, unsigned, int))              \
  X(GenBuffers, void(int, unsigned*))                                                     \
  X(GenFramebuffers, void(int, unsigned*))                                                \
  X(GenerateMipmap, void(unsigned))                                                       \
  X(GenQueries, void(int, unsigned*))                                                     \
  X(GenRenderbuffers, void(int, unsigned*))                                               \
  X(GenTextures, void(int, unsigned*))                                                    \
  X(GenVertexArrays, void(int, unsigned*))                                                \
  X(GetBufferSubData, void(unsigned, std::ptrdiff_t, std::ptrdiff_t, void*))              \
  X(GetError, unsigned())                                                                 \
  X(GetFramebufferAttachmentParameteriv, void(unsigned, unsigned, unsigned, int*))        \
  X(GetIntegerv, void(unsigned, int*))                                                    \
  X(GetProgramiv, void(unsigned, unsigned, int*))                                         \
  X(GetQueryObjectuiv, void(unsigned, unsigned, unsigned*))                               \
  X(GetShaderInfoLog, void(unsigned, int, int*, char*))                                   \
  X(GetShaderiv, void(unsigned, unsigned, int*))                                          \
  X(GetUniformLocation, int(unsigned, const char*))                                       \
  X(LinkProgram, void(unsigned))                                                          \
  X(PixelStorei, void(unsigned, int))                                                     \
  X(PolygonMode, void(unsigned, unsigned))                                                \
  X(PolygonOffset, void(float, float))                                                    \
  X(ReadPixels, void(int, int, int, int, unsigned, unsigned, void*))                      \
  X(RenderbufferStorageMultisample, void(unsigned, int, unsigned, int, int))              \
  X(Scissor, void(int, int, int, int))                                                    \
  X(ShaderSource, void(unsigned, int, const char* const*, const int*))                    \
  X(TexImage2D, void(unsigned, int, int, int, int, int, unsigned, unsigned, const void*)) \
  X(TexImage2DMultisample, void(unsigned, int, unsigned, int, int, unsigned char))        \
  X(TexParameteri, void(unsigned, unsigned, int))                                         \
  X(Uniform1f, void(int, float))                                                          \
  X(Uniform1i, void(int, int))                                                            \
  X(Uniform2f, void(int, float, float))                                                   \
  X(Uniform3fv, void(int, int, const float*))                                             \
  X(UniformMatrix4fv, void(int, int, unsigned char, const float*))                        \
  X(UseProgram, void(unsigned))                                                           \
  X(VertexAttribPointer, void(unsigned, int, unsigned, unsigned char, int, const void*))  \
  X(Viewport, void(int, int, int, int))

/// OpenGL 4.3; null if not supported.
#define VRDA_GL_LATER_FUNCTIONS(X) X(MemoryBarrier, void(unsigned))

struct GlTable {
#define VRDA_GL_MEMBER(name, ...) std::add_pointer_t<__VA_ARGS__> name = nullptr;
  VRDA_GL_FUNCTIONS(VRDA_GL_MEMBER)
  VRDA_GL_LATER_FUNCTIONS(VRDA_GL_MEMBER)
#undef VRDA_GL_MEMBER
};

/// Loads the functions of the current context. Throws InternalError if one of OpenGL 3.3 is missing.
GlTable load_gl_table(GlContext& context);

/// The name of an OpenGL object, which is deleted with it while its context is current.
class GlObject {
 public:
  GlObject() = default;  ///< 0, which OpenGL ignores
  /// `create` and `destroy`: a pair such as GenBuffers and DeleteBuffers.
  GlObject(void (*create)(int, unsigned*), void (*destroy)(int, const unsigned*)) : destroy_(destroy)
  {
    create(1, &name_);
  }
  GlObject(GlObject&& other) noexcept { *this = std::move(other); }
  GlObject& operator=(GlObject&& other) noexcept
  {
    std::swap(destroy_, other.destroy_);
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlObject()
  {
    if (destroy_ != nullptr) destroy_(1, &name_);
  }
  operator unsigned() const { return name_; }

 private:
  void (*destroy_)(int, const unsigned*) = nullptr;
  unsigned name_ = 0;
};

/// A shader program. Uniforms are set while it is in use; those that it lacks are ignored.
class GlProgram {
 public:
  GlProgram() = default;
  /// Compiles and links two shaders. `first`: #version and #define lines before each source; empty: version
  /// 3.30. Throws InternalError if that fails.
  GlProgram(const GlTable& gl, const std::string& first, const char* vertex_source,
            const char* fragment_source);
  GlProgram(GlProgram&& other) noexcept { *this = std::move(other); }
  GlProgram& operator=(GlProgram&& other) noexcept
  {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
    return *this;
  }
  ~GlProgram()
  {
    if (gl_ != nullptr) gl_->DeleteProgram(id_);
  }

  bool is_linked() const { return gl_ != nullptr; }
  void use() const { gl_->UseProgram(id_); }
  void set(const char* name, int value) const { gl_->Uniform1i(at(name), value); }
  void set(const char* name, float value) const { gl_->Uniform1f(at(name), value); }
  /// Two whole numbers as a vec2.
  void set(const char* name, int x, int y) const
  {
    gl_->Uniform2f(at(name), static_cast<float>(x), static_cast<float>(y));
  }
  /// [n][3] numbers as n vec3.
  void set(const char* name, const float* vectors, int n = 1) const { gl_->Uniform3fv(at(name), n, vectors); }
  void set(const char* name, const Eigen::Matrix4f& matrix) const
  {
    gl_->UniformMatrix4fv(at(name), 1, 0, matrix.data());
  }

 private:
  int at(const char* name) const { return gl_->GetUniformLocation(id_, name); }

  const GlTable* gl_ = nullptr;
  unsigned id_ = 0;
};

/// A buffer offset as the pointer that OpenGL expects.
const void* buffer_offset(std::size_t bytes);

/// A part of a vertex: `n` floats, or `n` bytes that mean 0 to 1.
struct VertexPart {
  int n = 0;
  std::size_t offset = 0;  ///< bytes
  bool is_bytes = false;
};
/// Vertices and the indices of their triangles.
struct Geometry {
  GlObject array, vertices, indices;
};
/// Empty buffers, bound, whose vertices have `stride` bytes; part k is attribute k of the vertex shader.
Geometry create_geometry(const GlTable& gl, std::size_t stride, std::initializer_list<VertexPart> parts);
/// Draws over the whole viewport with the program in use, whose vertex shader is background_vertex_shader.
/// `empty_array`: a vertex array without attributes.
void fill_viewport(const GlTable& gl, unsigned empty_array);

/// A texture without mipmaps; enums of OpenGL.
struct TexturePlan {
  int width = 0, height = 0;  ///< pixels
  int format = 0;             ///< of the texture: GL_R8, ...
  unsigned layout = 0;        ///< of the pixels: GL_RED, ...
  unsigned type = 0;          ///< of their channels: GL_UNSIGNED_BYTE, ...
  int filter = 0;             ///< between pixels
  bool is_clamped = false;    ///< continues its border outside; else it repeats
};
/// Bound to the active texture unit. `pixels`: rows without padding, or null.
GlObject create_texture(const GlTable& gl, const TexturePlan& plan, const void* pixels);

/// A new frame buffer, bound.
GlObject create_frame(const GlTable& gl);
/// The same, which draws to a texture.
GlObject create_frame(const GlTable& gl, unsigned texture);

/// Properties of a render target.
struct TargetPlan {
  int width = 0, height = 0;
  int samples = 0;  ///< 0 for no multisampling
  bool has_depth = true;
};

/// A frame buffer. Colour is an sRGB render buffer; depth is a 32-bit texture, so that shaders can read it.
struct Target {
  GlObject frame;
  GlObject colour;  ///< 0: shared with another target
  GlObject depth;   ///< 0: none
};

/// Creates a target. `shared`: the colour buffer of another target in place of its own. Throws InputError if
/// the driver has no memory for it.
Target create_target(const GlTable& gl, const TargetPlan& plan, const Target* shared = nullptr);

/// Rectangle in OpenGL pixels: y from the bottom.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;

  bool is_empty() const { return width <= 0 || height <= 0; }
};
/// The smallest box around both; an empty one counts as nothing.
PixelBox bounding_box(const PixelBox& a, const PixelBox& b);
void set_viewport(const GlTable& gl, const PixelBox& box);
void set_scissor(const GlTable& gl, const PixelBox& box);
/// Copies a box between frame buffers of equal size; `bits`: GL_COLOR_BUFFER_BIT or GL_DEPTH_BUFFER_BIT.
void copy_box(const GlTable& gl, unsigned from, unsigned to, const PixelBox& box, unsigned bits);

}  // namespace vrda::view
