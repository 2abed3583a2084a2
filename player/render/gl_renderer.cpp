#include "render/gl_renderer.hpp"

#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "core/error.hpp"
#include "render/shaders.hpp"

namespace vrda {
namespace {

// Every function used: type of its pointer, name without "gl".
#define VRDA_GL_FUNCTIONS(X)                                                 \
  X(PFNGLATTACHSHADERPROC, AttachShader)                                     \
  X(PFNGLBINDBUFFERPROC, BindBuffer)                                         \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                               \
  X(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer)                             \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                               \
  X(PFNGLBLENDFUNCSEPARATEPROC, BlendFuncSeparate)                           \
  X(PFNGLBLITFRAMEBUFFERPROC, BlitFramebuffer)                               \
  X(PFNGLBUFFERDATAPROC, BufferData)                                         \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                 \
  X(PFNGLCLEARPROC, Clear)                                                   \
  X(PFNGLCOMPILESHADERPROC, CompileShader)                                   \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                   \
  X(PFNGLCREATESHADERPROC, CreateShader)                                     \
  X(PFNGLCULLFACEPROC, CullFace)                                             \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                   \
  X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                         \
  X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                   \
  X(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers)                       \
  X(PFNGLDELETESHADERPROC, DeleteShader)                                     \
  X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                         \
  X(PFNGLDEPTHMASKPROC, DepthMask)                                           \
  X(PFNGLDISABLEPROC, Disable)                                               \
  X(PFNGLDRAWARRAYSPROC, DrawArrays)                                         \
  X(PFNGLDRAWELEMENTSPROC, DrawElements)                                     \
  X(PFNGLENABLEPROC, Enable)                                                 \
  X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)               \
  X(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer)               \
  X(PFNGLGENBUFFERSPROC, GenBuffers)                                         \
  X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                               \
  X(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers)                             \
  X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                               \
  X(PFNGLGETERRORPROC, GetError)                                             \
  X(PFNGLGETINTEGERVPROC, GetIntegerv)                                       \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                     \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                             \
  X(PFNGLGETSHADERIVPROC, GetShaderiv)                                       \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                         \
  X(PFNGLLINKPROGRAMPROC, LinkProgram)                                       \
  X(PFNGLPIXELSTOREIPROC, PixelStorei)                                       \
  X(PFNGLREADPIXELSPROC, ReadPixels)                                         \
  X(PFNGLRENDERBUFFERSTORAGEMULTISAMPLEPROC, RenderbufferStorageMultisample) \
  X(PFNGLSHADERSOURCEPROC, ShaderSource)                                     \
  X(PFNGLUNIFORM1FPROC, Uniform1f)                                           \
  X(PFNGLUNIFORM1IPROC, Uniform1i)                                           \
  X(PFNGLUNIFORM3FVPROC, Uniform3fv)                                         \
  X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                             \
  X(PFNGLUSEPROGRAMPROC, UseProgram)                                         \
  X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                       \
  X(PFNGLVIEWPORTPROC, Viewport)

struct GlTable {
#define VRDA_GL_MEMBER(type, name) type name = nullptr;
  VRDA_GL_FUNCTIONS(VRDA_GL_MEMBER)
#undef VRDA_GL_MEMBER
};

GlTable table_of(GlContext& context)
{
  GlTable gl;
#define VRDA_GL_LOAD(type, name)                                  \
  gl.name = reinterpret_cast<type>(context.function("gl" #name)); \
  check(gl.name != nullptr, "OpenGL 3.3 has the function gl" #name);
  VRDA_GL_FUNCTIONS(VRDA_GL_LOAD)
#undef VRDA_GL_LOAD
  return gl;
}

GLuint compiled_shader(const GlTable& gl, GLenum kind, const char* source)
{
  const GLuint shader = gl.CreateShader(kind);
  gl.ShaderSource(shader, 1, &source, nullptr);
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

GLuint linked_program(const GlTable& gl, const char* vertex_source, const char* fragment_source)
{
  const GLuint vertex = compiled_shader(gl, GL_VERTEX_SHADER, vertex_source);
  const GLuint fragment = compiled_shader(gl, GL_FRAGMENT_SHADER, fragment_source);
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

struct GpuMesh {
  GLuint vertex_array = 0;
  std::array<GLuint, 2> buffers{};  // vertices, triangles
  GLsizei n_indices = 0;
};

GpuMesh uploaded(const GlTable& gl, const DrawMesh& mesh)
{
  GpuMesh gpu;
  gl.GenVertexArrays(1, &gpu.vertex_array);
  gl.GenBuffers(2, gpu.buffers.data());
  gl.BindVertexArray(gpu.vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, gpu.buffers[0]);
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(DrawVertex)),
                mesh.vertices.data(), GL_STATIC_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, gpu.buffers[1]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(std::uint32_t)), mesh.triangles.data(),
                GL_STATIC_DRAW);
  gl.EnableVertexAttribArray(0);
  gl.EnableVertexAttribArray(1);
  constexpr GLsizei stride = sizeof(DrawVertex);
  gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, nullptr);
  // OpenGL wants the offset as a pointer. NOLINTNEXTLINE(performance-no-int-to-ptr)
  const void* const normal_offset = reinterpret_cast<const void*>(offsetof(DrawVertex, normal));
  gl.VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride, normal_offset);
  gpu.n_indices = static_cast<GLsizei>(mesh.triangles.size());
  return gpu;
}

/// Frame buffer with colour, and depth where it is drawn to.
struct Target {
  GLuint frame = 0;
  std::array<GLuint, 2> buffers{};  // colour, depth
};

struct TargetPlan {
  int width = 0, height = 0, samples = 0;
  bool has_depth = false;
};

Target opened_target(const GlTable& gl, const TargetPlan& plan)
{
  Target target;
  gl.GenFramebuffers(1, &target.frame);
  gl.GenRenderbuffers(2, target.buffers.data());
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.frame);
  const auto attach = [&](GLuint buffer, GLenum format, GLenum attachment) {
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, plan.samples, format, plan.width, plan.height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  };
  attach(target.buffers[0], GL_SRGB8_ALPHA8, GL_COLOR_ATTACHMENT0);
  if (plan.has_depth) attach(target.buffers[1], GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  check(gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE, "a frame buffer is complete");
  return target;
}

struct SurfaceUniforms {
  GLint X_camera_mesh, projection, colour, opacity, specular, shininess, mottling, up_camera, sky, ground,
      n_lights, light_direction, light_colour;
};

SurfaceUniforms surface_uniforms(const GlTable& gl, GLuint program)
{
  const auto at = [&](const char* name) { return gl.GetUniformLocation(program, name); };
  return {at("X_camera_mesh"), at("projection"),      at("colour"),      at("opacity"), at("specular"),
          at("shininess"),     at("mottling"),        at("up_camera"),   at("sky"),     at("ground"),
          at("n_lights"),      at("light_direction"), at("light_colour")};
}

class GlRenderer final : public Renderer {
 public:
  GlRenderer(std::unique_ptr<GlContext> context, const RenderOptions& options);
  ~GlRenderer() override;
  GlRenderer(const GlRenderer&) = delete;
  GlRenderer& operator=(const GlRenderer&) = delete;

  void load(const Scene& scene) override;
  void load(const OverlayFont& font) override;
  void resize(int width, int height) override;
  int width() const override { return options_.width; }
  int height() const override { return options_.height; }
  const Image& draw(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay) override;
  void present(const Scene& scene, std::span<const Shot> shots, const Overlay* overlay) override;

 private:
  void drop_meshes();
  void draw_shots(const Scene& scene, std::span<const Shot> shots);
  void draw_background(const Background& background);
  void set_lights(const Lighting& lighting, const Camera& camera);
  void draw_mesh(const Drawable& drawable, const GpuMesh& mesh);
  void draw_opaque(const Scene& scene);
  void draw_translucent(const Scene& scene);
  void read_pixels();

  std::unique_ptr<GlContext> context_;
  GlTable gl_;
  RenderOptions options_;
  GLuint surface_program_ = 0, background_program_ = 0, empty_array_ = 0;
  SurfaceUniforms uniforms_{};
  GLint top_ = -1, bottom_ = -1;
  Target drawn_, resolved_;
  std::vector<GpuMesh> meshes_;
  std::vector<std::pair<double, std::size_t>> far_to_near_;
  Pose X_camera_world_ = Pose::Identity();
  std::vector<std::uint8_t> upside_down_;
  Image image_;
};

void check_size(const GlTable& gl, const RenderOptions& options)
{
  GLint most = 0, most_samples = 0;
  gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
  gl.GetIntegerv(GL_MAX_SAMPLES, &most_samples);
  if (std::min(options.width, options.height) < 1 || std::max(options.width, options.height) > most) {
    throw InputError({"picture", "size", std::to_string(options.width) + "x" + std::to_string(options.height),
                      "1 to " + std::to_string(most) + " pixels each way"});
  }
  check(options.samples >= 1 && options.samples <= most_samples,
        "the samples of a pixel are within OpenGL's limit");
}

GlRenderer::GlRenderer(std::unique_ptr<GlContext> context, const RenderOptions& options)
    : context_(std::move(context)), options_(options)
{
  context_->make_current();
  gl_ = table_of(*context_);
  check_size(gl_, options);
  surface_program_ = linked_program(gl_, surface_vertex_shader, surface_fragment_shader);
  background_program_ = linked_program(gl_, background_vertex_shader, background_fragment_shader);
  uniforms_ = surface_uniforms(gl_, surface_program_);
  top_ = gl_.GetUniformLocation(background_program_, "top");
  bottom_ = gl_.GetUniformLocation(background_program_, "bottom");
  gl_.GenVertexArrays(1, &empty_array_);
  const int samples = options.samples > 1 ? options.samples : 0;
  drawn_ = opened_target(gl_, {options.width, options.height, samples, true});
  resolved_ = opened_target(gl_, {options.width, options.height, 0, false});
  image_.width = options.width;
  image_.height = options.height;
  image_.rgba.resize(static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height) * 4);
  upside_down_.resize(image_.rgba.size());
  check(gl_.GetError() == GL_NO_ERROR, "the renderer opens without an OpenGL error");
}

GlRenderer::~GlRenderer()
{
  context_->make_current();
  drop_meshes();
  for (const Target& target : {drawn_, resolved_}) {
    gl_.DeleteFramebuffers(1, &target.frame);
    gl_.DeleteRenderbuffers(2, target.buffers.data());
  }
  gl_.DeleteVertexArrays(1, &empty_array_);
  gl_.DeleteProgram(surface_program_);
  gl_.DeleteProgram(background_program_);
}

void GlRenderer::drop_meshes()
{
  for (const GpuMesh& mesh : meshes_) {
    gl_.DeleteVertexArrays(1, &mesh.vertex_array);
    gl_.DeleteBuffers(2, mesh.buffers.data());
  }
  meshes_.clear();
}

void GlRenderer::load(const Scene& scene)
{
  context_->make_current();
  drop_meshes();
  for (const Drawable& drawable : scene.drawables) meshes_.push_back(uploaded(gl_, drawable.mesh));
  far_to_near_.reserve(meshes_.size());
  check(gl_.GetError() == GL_NO_ERROR, "meshes load without an OpenGL error");
}

void GlRenderer::draw_background(const Background& background)
{
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Disable(GL_CULL_FACE);
  gl_.Disable(GL_BLEND);
  gl_.UseProgram(background_program_);
  gl_.Uniform3fv(top_, 1, background.top.data());
  gl_.Uniform3fv(bottom_, 1, background.bottom.data());
  gl_.BindVertexArray(empty_array_);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void GlRenderer::set_lights(const Lighting& lighting, const Camera& camera)
{
  check(lighting.lights.size() <= most_lights, "a scene has at most four lights");
  std::array<float, 3 * most_lights> direction{}, colour{};
  for (std::size_t i = 0; i < lighting.lights.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      direction[3 * i + k] = lighting.lights[i].towards_camera[static_cast<Eigen::Index>(k)];
      colour[3 * i + k] = lighting.lights[i].colour[static_cast<Eigen::Index>(k)];
    }
  }
  const Eigen::Vector3f up_camera = camera.X_world_camera.linear().row(1).transpose().cast<float>();
  const Eigen::Matrix4f P = projection(camera).cast<float>();
  gl_.UniformMatrix4fv(uniforms_.projection, 1, GL_FALSE, P.data());
  gl_.Uniform3fv(uniforms_.up_camera, 1, up_camera.data());
  gl_.Uniform3fv(uniforms_.sky, 1, lighting.sky.data());
  gl_.Uniform3fv(uniforms_.ground, 1, lighting.ground.data());
  gl_.Uniform1i(uniforms_.n_lights, static_cast<GLint>(lighting.lights.size()));
  gl_.Uniform3fv(uniforms_.light_direction, most_lights, direction.data());
  gl_.Uniform3fv(uniforms_.light_colour, most_lights, colour.data());
}

void GlRenderer::draw_mesh(const Drawable& drawable, const GpuMesh& mesh)
{
  const Material& material = drawable.material;
  const Eigen::Matrix4f X_camera_mesh = (X_camera_world_ * drawable.X_world_mesh).matrix().cast<float>();
  gl_.UniformMatrix4fv(uniforms_.X_camera_mesh, 1, GL_FALSE, X_camera_mesh.data());
  gl_.Uniform3fv(uniforms_.colour, 1, material.colour.data());
  gl_.Uniform1f(uniforms_.opacity, material.opacity);
  gl_.Uniform1f(uniforms_.specular, material.specular);
  gl_.Uniform1f(uniforms_.shininess, material.shininess);
  gl_.Uniform1f(uniforms_.mottling, material.mottling);
  gl_.BindVertexArray(mesh.vertex_array);
  gl_.DrawElements(GL_TRIANGLES, mesh.n_indices, GL_UNSIGNED_INT, nullptr);
}

void GlRenderer::draw_opaque(const Scene& scene)
{
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    if (scene.drawables[i].material.opacity >= 1.0F) draw_mesh(scene.drawables[i], meshes_[i]);
  }
}

void GlRenderer::draw_translucent(const Scene& scene)
{
  far_to_near_.clear();
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const Drawable& drawable = scene.drawables[i];
    if (drawable.material.opacity >= 1.0F) continue;
    const Eigen::Vector3d middle_mm = 0.5 * (drawable.box_mm.min_mm + drawable.box_mm.max_mm);
    far_to_near_.emplace_back((X_camera_world_ * (drawable.X_world_mesh * middle_mm)).z(), i);
  }
  std::sort(far_to_near_.begin(), far_to_near_.end());
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl_.DepthMask(GL_FALSE);
  gl_.Enable(GL_CULL_FACE);
  for (const auto& [z_mm, i] : far_to_near_) {
    for (const GLenum hidden : {GLenum{GL_FRONT}, GLenum{GL_BACK}}) {
      gl_.CullFace(hidden);
      draw_mesh(scene.drawables[i], meshes_[i]);
    }
  }
  gl_.DepthMask(GL_TRUE);
}

void GlRenderer::read_pixels()
{
  const int w = options_.width, h = options_.height;
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, drawn_.frame);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.frame);
  gl_.BlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.frame);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.ReadPixels(0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, upside_down_.data());
  const std::ptrdiff_t stride = 4 * static_cast<std::ptrdiff_t>(w);
  for (int row = 0; row < h; ++row) {
    std::copy_n(upside_down_.begin() + (h - 1 - row) * stride, stride, image_.rgba.begin() + row * stride);
  }
}

void GlRenderer::draw_shots(const Scene& scene, std::span<const Shot> shots)
{
  check(scene.drawables.size() == meshes_.size(), "a scene is loaded before it is drawn");
  context_->make_current();
  gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn_.frame);
  gl_.Viewport(0, 0, options_.width, options_.height);
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
  gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  for (const Shot& shot : shots) {
    const Viewport& view = shot.viewport;
    gl_.Viewport(view.x, options_.height - view.y - view.height, view.width, view.height);
    X_camera_world_ = shot.camera.X_world_camera.inverse();
    draw_background(scene.background);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.UseProgram(surface_program_);
    set_lights(scene.lighting, shot.camera);
    draw_opaque(scene);
    draw_translucent(scene);
  }
}

const Image& GlRenderer::draw(const Scene& scene, std::span<const Shot> shots, const Overlay* /*overlay*/)
{
  draw_shots(scene, shots);
  read_pixels();
  check(gl_.GetError() == GL_NO_ERROR, "a frame is drawn without an OpenGL error");
  return image_;
}

void GlRenderer::present(const Scene& scene, std::span<const Shot> shots, const Overlay* /*overlay*/)
{
  draw_shots(scene, shots);
}

void GlRenderer::load(const OverlayFont& /*font*/) {}

void GlRenderer::resize(int width, int height)
{
  options_.width = width;
  options_.height = height;
}

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

}  // namespace vrda
