#include "view/gl_table.hpp"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <algorithm>
#include <array>

#include "core/text.hpp"

namespace vrda::view {
namespace {

#define VRDA_GL_SAME(name, ...) \
  static_assert(std::is_same_v<decltype(gl##name), __VA_ARGS__>, "gl" #name " has this signature");
VRDA_GL_FUNCTIONS(VRDA_GL_SAME)
VRDA_GL_LATER_FUNCTIONS(VRDA_GL_SAME)
#undef VRDA_GL_SAME

GLuint compiled_shader(const GlTable& gl, GLenum kind, const std::string& first, const char* source)
{
  const GLuint shader = gl.CreateShader(kind);
  const std::array<const char*, 2> parts{first.empty() ? "#version 330 core\n" : first.c_str(), source};
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

GlProgram::GlProgram(const GlTable& gl, const std::string& first, const char* vertex_source,
                     const char* fragment_source)
    : gl_(&gl), id_(gl.CreateProgram())
{
  const GLuint vertex = compiled_shader(gl, GL_VERTEX_SHADER, first, vertex_source);
  const GLuint fragment = compiled_shader(gl, GL_FRAGMENT_SHADER, first, fragment_source);
  gl.AttachShader(id_, vertex);
  gl.AttachShader(id_, fragment);
  gl.LinkProgram(id_);
  gl.DeleteShader(vertex);
  gl.DeleteShader(fragment);
  GLint is_linked = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &is_linked);
  check(is_linked != 0, "the shader program links");
}

const void* buffer_offset(std::size_t bytes)
{
  return reinterpret_cast<const void*>(bytes);  // NOLINT(performance-no-int-to-ptr)
}

Geometry create_geometry(const GlTable& gl, std::size_t stride, std::initializer_list<VertexPart> parts)
{
  Geometry made{{gl.GenVertexArrays, gl.DeleteVertexArrays},
                {gl.GenBuffers, gl.DeleteBuffers},
                {gl.GenBuffers, gl.DeleteBuffers}};
  gl.BindVertexArray(made.array);
  gl.BindBuffer(GL_ARRAY_BUFFER, made.vertices);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, made.indices);
  GLuint attribute = 0;
  for (const VertexPart& part : parts) {
    gl.EnableVertexAttribArray(attribute);
    gl.VertexAttribPointer(attribute, part.n, part.is_bytes ? GL_UNSIGNED_BYTE : GL_FLOAT,
                           part.is_bytes ? GL_TRUE : GL_FALSE, static_cast<GLsizei>(stride),
                           buffer_offset(part.offset));
    ++attribute;
  }
  return made;
}

void fill_viewport(const GlTable& gl, unsigned empty_array)
{
  gl.BindVertexArray(empty_array);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

GlObject create_texture(const GlTable& gl, const TexturePlan& plan, const void* pixels)
{
  GlObject made(gl.GenTextures, gl.DeleteTextures);
  gl.BindTexture(GL_TEXTURE_2D, made);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage2D(GL_TEXTURE_2D, 0, plan.format, plan.width, plan.height, 0, plan.layout, plan.type, pixels);
  for (const int use : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    gl.TexParameteri(GL_TEXTURE_2D, static_cast<GLenum>(use), plan.filter);
  for (const int axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    gl.TexParameteri(GL_TEXTURE_2D, static_cast<GLenum>(axis),
                     plan.is_clamped ? GL_CLAMP_TO_EDGE : GL_REPEAT);
  return made;
}

GlObject create_frame(const GlTable& gl)
{
  GlObject made(gl.GenFramebuffers, gl.DeleteFramebuffers);
  gl.BindFramebuffer(GL_FRAMEBUFFER, made);
  return made;
}

GlObject create_frame(const GlTable& gl, unsigned texture)
{
  GlObject made = create_frame(gl);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  return made;
}

namespace {

GlObject create_colour(const GlTable& gl, const TargetPlan& plan)
{
  GlObject made(gl.GenRenderbuffers, gl.DeleteRenderbuffers);
  gl.BindRenderbuffer(GL_RENDERBUFFER, made);
  gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, plan.samples, GL_SRGB8_ALPHA8, plan.width, plan.height);
  return made;
}

GlObject create_depth(const GlTable& gl, const TargetPlan& plan)
{
  if (plan.samples == 0)
    return create_texture(
        gl, {plan.width, plan.height, GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, GL_NEAREST},
        nullptr);
  GlObject made(gl.GenTextures, gl.DeleteTextures);
  gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, made);
  // Fixed sample locations, to match the render buffer of the colour.
  gl.TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, plan.samples, GL_DEPTH_COMPONENT32F, plan.width,
                           plan.height, GL_TRUE);
  return made;
}

}  // namespace

Target create_target(const GlTable& gl, const TargetPlan& plan, const Target* shared)
{
  Target target;
  target.frame = create_frame(gl);
  if (shared == nullptr) target.colour = create_colour(gl, plan);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                             shared == nullptr ? target.colour : shared->colour);
  if (plan.has_depth) {
    target.depth = create_depth(gl, plan);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                            plan.samples > 0 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, target.depth, 0);
  }
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return target;
  throw InputError({"graphics driver", "",
                    "no frame buffer of " + std::to_string(plan.width) + " x " + std::to_string(plan.height) +
                        " pixels with " + std::to_string(std::max(plan.samples, 1)) + " samples each",
                    "a smaller display or picture, or fewer --samples"});
}

PixelBox bounding_box(const PixelBox& a, const PixelBox& b)
{
  if (a.is_empty()) return b;
  if (b.is_empty()) return a;
  const int x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

void set_viewport(const GlTable& gl, const PixelBox& box)
{
  gl.Viewport(box.x, box.y, box.width, box.height);
}

void set_scissor(const GlTable& gl, const PixelBox& box)
{
  gl.Scissor(box.x, box.y, box.width, box.height);
}

void copy_box(const GlTable& gl, unsigned from, unsigned to, const PixelBox& box, unsigned bits)
{
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, from);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
  const int right = box.x + box.width, top = box.y + box.height;
  gl.BlitFramebuffer(box.x, box.y, right, top, box.x, box.y, right, top, bits, GL_NEAREST);
}

}  // namespace vrda::view
