#include "view/gl_table.hpp"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <string>

#include "core/text.hpp"

namespace vrda::view {
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
    throw InternalError("a shader does not compile: " + std::string(log.data()));
  }
  return shader;
}

}  // namespace

GlTable load_gl_table(GlContext& context)
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
  check(is_linked != 0, "the shader program links");
  return program;
}

const void* buffer_offset(std::size_t bytes)
{
  return reinterpret_cast<const void*>(bytes);  // NOLINT(performance-no-int-to-ptr)
}

namespace {

void attach_colour(const GlTable& gl, const TargetPlan& plan, Target& target)
{
  gl.GenRenderbuffers(1, &target.colour);
  gl.BindRenderbuffer(GL_RENDERBUFFER, target.colour);
  gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, plan.samples, GL_SRGB8_ALPHA8, plan.width, plan.height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target.colour);
}

void attach_depth(const GlTable& gl, const TargetPlan& plan, Target& target)
{
  const GLenum kind = plan.samples > 0 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
  gl.GenTextures(1, &target.depth);
  gl.BindTexture(kind, target.depth);
  if (plan.samples > 0) {
    // Fixed sample locations, to match the render buffer of the colour.
    gl.TexImage2DMultisample(kind, plan.samples, GL_DEPTH_COMPONENT32F, plan.width, plan.height, GL_TRUE);
  } else {
    gl.TexImage2D(kind, 0, GL_DEPTH_COMPONENT32F, plan.width, plan.height, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                  nullptr);
    gl.TexParameteri(kind, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(kind, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, kind, target.depth, 0);
}

Target framed(const GlTable& gl)
{
  Target target;
  gl.GenFramebuffers(1, &target.frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.frame);
  return target;
}

void require_complete(const GlTable& gl, const TargetPlan& plan)
{
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return;
  throw InputError({"graphics driver", "",
                    "no frame buffer of " + std::to_string(plan.width) + " x " + std::to_string(plan.height) +
                        " pixels with " + std::to_string(std::max(plan.samples, 1)) + " samples each",
                    "a smaller display or picture, or fewer --samples"});
}

}  // namespace

Target create_target(const GlTable& gl, const TargetPlan& plan)
{
  Target target = framed(gl);
  attach_colour(gl, plan, target);
  if (plan.has_depth) attach_depth(gl, plan, target);
  require_complete(gl, plan);
  return target;
}

Target create_layer_target(const GlTable& gl, const TargetPlan& plan, const Target& other)
{
  Target target = framed(gl);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, other.colour);
  attach_depth(gl, plan, target);
  require_complete(gl, plan);
  return target;
}

void destroy_target(const GlTable& gl, Target& target)
{
  // OpenGL ignores the name 0.
  gl.DeleteFramebuffers(1, &target.frame);
  gl.DeleteRenderbuffers(1, &target.colour);
  gl.DeleteTextures(1, &target.depth);
  target = {};
}

}  // namespace vrda::view
