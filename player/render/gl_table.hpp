/// The OpenGL functions used, in plain types so that OpenGL's headers stay in .cpp files; frame buffers.
#pragma once

#include <cstddef>
#include <type_traits>

#include "render/gl_context.hpp"

namespace vrda {

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

/// Of OpenGL 4.3, null without.
#define VRDA_GL_LATER_FUNCTIONS(X) X(MemoryBarrier, void(unsigned))

struct GlTable {
#define VRDA_GL_MEMBER(name, ...) std::add_pointer_t<__VA_ARGS__> name = nullptr;
  VRDA_GL_FUNCTIONS(VRDA_GL_MEMBER)
  VRDA_GL_LATER_FUNCTIONS(VRDA_GL_MEMBER)
#undef VRDA_GL_MEMBER
};

/// Of the current context. A function that is missing breaks the promise of OpenGL 3.3.
GlTable table_of(GlContext& context);

/// A program of two shaders, each `first` (its #version and #define lines) followed by its source.
unsigned linked_program(const GlTable& gl, const char* first, const char* vertex_source,
                        const char* fragment_source);

/// An offset into a buffer, in the form OpenGL takes it.
const void* buffer_offset(std::size_t bytes);

/// Frame buffers to draw to.
struct TargetPlan {
  int width = 0, height = 0;
  int samples = 0;  ///< 0 for no multisampling
  bool has_depth = true;
};

/// Colour is a render buffer, sRGB; depth is a texture (32-bit), so that shaders may compare with it.
struct Target {
  unsigned frame = 0;
  unsigned colour = 0;  ///< 0: shares that of another
  unsigned depth = 0;   ///< 0: none
};

/// With colour of its own.
Target opened_target(const GlTable& gl, const TargetPlan& plan);
/// With depth of its own, drawing into the colour of `other`.
Target opened_layer(const GlTable& gl, const TargetPlan& plan, const Target& other);
void close_target(const GlTable& gl, Target& target);

}  // namespace vrda
