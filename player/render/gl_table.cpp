#include "render/gl_table.hpp"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <array>
#include <string>

#include "core/error.hpp"

namespace vrda {
namespace {

#define VRDA_GL_SAME(name, ...) \
  static_assert(std::is_same_v<decltype(gl##name), __VA_ARGS__>, "gl" #name " has this signature");
VRDA_GL_FUNCTIONS(VRDA_GL_SAME)
VRDA_GL_LATER_FUNCTIONS(VRDA_GL_SAME)
#undef VRDA_GL_SAME

GLuint compiled_shader(const GlTable& gl, GLenum kind, const char* first, const char* source)
{
  const GLuint shader = gl.CreateShader(kind);
  const std::array<const char*, 2> parts{first, source};
  gl.ShaderSource(shader, static_cast<GLsizei>(parts.size()), parts.data(), nullptr);
  gl.CompileShader(shader);
  GLint is_compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &is_compiled);
  if (is_compiled == 0) {
    std::array<char, 1024> log{};
    gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw InternalError("a shader compiles: " + std::string(log.data()));
  }
  return shader;
}

}  // namespace

GlTable table_of(GlContext& context)
{
  GlTable gl;
#define VRDA_GL_LOAD(name, ...)                                                      \
  gl.name = reinterpret_cast<decltype(GlTable::name)>(context.function("gl" #name)); \
  check(gl.name != nullptr, "OpenGL 3.3 has the function gl" #name);
  VRDA_GL_FUNCTIONS(VRDA_GL_LOAD)
#undef VRDA_GL_LOAD
#define VRDA_GL_LOAD(name, ...) \
  gl.name = reinterpret_cast<decltype(GlTable::name)>(context.function("gl" #name));
  VRDA_GL_LATER_FUNCTIONS(VRDA_GL_LOAD)
#undef VRDA_GL_LOAD
  return gl;
}

unsigned linked_program(const GlTable& gl, const char* first, const char* vertex_source,
                        const char* fragment_source)
{
  const GLuint vertex = compiled_shader(gl, GL_VERTEX_SHADER, first, vertex_source);
  const GLuint fragment = compiled_shader(gl, GL_FRAGMENT_SHADER, first, fragment_source);
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, vertex);
  gl.AttachShader(program, fragment);
  gl.LinkProgram(program);
  gl.DeleteShader(vertex);
  gl.DeleteShader(fragment);
  GLint is_linked = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &is_linked);
  check(is_linked != 0, "the shaders of a program link");
  return program;
}

const void* buffer_offset(std::size_t bytes)
{
  return reinterpret_cast<const void*>(bytes);  // NOLINT(performance-no-int-to-ptr)
}

}  // namespace vrda
