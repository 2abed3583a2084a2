/// Table of the OpenGL functions in use, with plain types so that OpenGL headers stay in .cpp files; render
/// targets.
#pragma once

#include <cstddef>
#include <type_traits>

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

/// Compiles and links two shaders; `first` (#version and #define lines) precedes each source.
unsigned linked_program(const GlTable& gl, const char* first, const char* vertex_source,
                        const char* fragment_source);

/// A buffer offset as the pointer that OpenGL expects.
const void* buffer_offset(std::size_t bytes);

/// Properties of a render target.
struct TargetPlan {
  int width = 0, height = 0;
  int samples = 0;  ///< 0 for no multisampling
  bool has_depth = true;
};

/// A frame buffer. Colour is an sRGB render buffer; depth is a 32-bit texture, so that shaders can read it.
struct Target {
  unsigned frame = 0;
  unsigned colour = 0;  ///< 0: shared with another target
  unsigned depth = 0;   ///< 0: none
};

/// Creates a target with its own colour buffer.
Target create_target(const GlTable& gl, const TargetPlan& plan);
/// Creates a target with its own depth that shares the colour buffer of `other`.
Target create_layer_target(const GlTable& gl, const TargetPlan& plan, const Target& other);
void destroy_target(const GlTable& gl, Target& target);

}  // namespace vrda::view
