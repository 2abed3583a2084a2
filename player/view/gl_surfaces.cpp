#include "view/gl_surfaces.hpp"

#include <GL/glcorearb.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/error.hpp"
#include "view/shaders.hpp"

namespace vrda::view {
namespace {

/// Separates bone (stronger mottling), which gets the texture, from soft tissue.
constexpr float texture_mottling = 0.1F;

/// Texture units.
constexpr GLint behind_unit = 0, image_unit = 1;

bool is_line_mode(view::DrawMode mode)
{
  return mode == view::DrawMode::wire || mode == view::DrawMode::hidden_line;
}

/// Lines are darkened on a light background for contrast.
Eigen::Vector3f line_shade(const view::Background& background)
{
  constexpr float light_backdrop = 0.1F, darkened = 0.2F;  // linear; chosen visually
  const float brightness = 0.5F * (background.top + background.bottom).mean();
  return Eigen::Vector3f::Constant(brightness > light_backdrop ? darkened : 1.0F);
}

}  // namespace

SurfacePainter::SurfacePainter(const GlTable& gl, const SurfaceOptions& options) : gl_(gl), options_(options)
{
}

SurfacePainter::~SurfacePainter()
{
  for (GpuMesh& mesh : meshes_) release_mesh(gl_, mesh);
  for (const Program& program : programs_) gl_.DeleteProgram(program.id);
  gl_.DeleteTextures(1, &texture_);
}

void SurfacePainter::load(const view::Scene& scene)
{
  for (GpuMesh& mesh : meshes_) release_mesh(gl_, mesh);
  meshes_.clear();
  for (const view::Drawable& drawable : scene.drawables) meshes_.push_back(upload_mesh(gl_, drawable));
  load_texture(scene.texture);
  levels_ = {};
  if (options_.coarseness_px <= 0.0) return;
  find_levels(scene);
  if (!options_.has_deferred_levels) take_levels();
}

/// Meshes with vertex colours get no levels: simplification would lose the pattern.
void SurfacePainter::find_levels(const view::Scene& scene)
{
  std::vector<RenderMesh> wanted;
  for (const view::Drawable& drawable : scene.drawables)
    wanted.push_back(drawable.colours.empty() ? drawable.mesh : RenderMesh{});
  levels_ = std::async(std::launch::async, [wanted = std::move(wanted)] {
    std::vector<MeshLevels> levels;
    levels.reserve(wanted.size());
    for (const RenderMesh& mesh : wanted) levels.push_back(levels_of(mesh));
    return levels;
  });
}

/// Waits for the levels and uploads them.
void SurfacePainter::take_levels()
{
  const std::vector<MeshLevels> levels = levels_.get();
  for (std::size_t i = 0; i < meshes_.size(); ++i) add_levels(gl_, levels[i], meshes_[i]);
}

void SurfacePainter::load_texture(const view::Texture& texture)
{
  gl_.DeleteTextures(1, &texture_);
  texture_ = 0;
  repeats_by_mm_ = 0.0F;
  if (texture.is_empty()) return;
  const std::size_t n_bytes =
      3 * static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height);
  check(texture.rgb.size() == n_bytes && texture.scale_mm > 0.0,
        "a texture has three bytes per pixel and a positive scale");
  gl_.GenTextures(1, &texture_);
  gl_.ActiveTexture(GL_TEXTURE0 + image_unit);
  gl_.BindTexture(GL_TEXTURE_2D, texture_);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8, texture.width, texture.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
                 texture.rgb.data());
  gl_.GenerateMipmap(GL_TEXTURE_2D);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl_.ActiveTexture(GL_TEXTURE0);
  repeats_by_mm_ = static_cast<float>(1.0 / texture.scale_mm);
}

void SurfacePainter::refresh(const view::Scene& scene)
{
  check(scene.drawables.size() == meshes_.size(), "a scene is loaded before it is drawn");
  if (levels_.valid() && levels_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
    take_levels();
  for (std::size_t i = 0; i < meshes_.size(); ++i) vrda::view::refresh(gl_, scene.drawables[i], meshes_[i]);
}

void SurfacePainter::begin(const view::Scene& scene, const view::Camera& camera, const PixelBox& view,
                           bool is_multisampled)
{
  check(scene.lighting.lights.size() <= view::most_lights, "a scene has at most four lights");
  ++n_begun_;
  mode_ = scene.mode;
  is_multisampled_ = is_multisampled;
  lighting_ = &scene.lighting;
  line_shade_ = line_shade(scene.background);
  X_camera_world_ = camera.X_world_camera.inverse();
  projection_ = view::projection(camera).cast<float>();
  px_mm_at_1_mm_ = view.height / (2.0 * camera.half_height_tangent);
  near_mm_ = camera.near_mm;
  translucent_box_ = bounds(scene, view, true);
  content_box_ = is_line_mode(mode_) ? view : bounds(scene, view, false);
}

bool SurfacePainter::is_translucent(const view::Drawable& drawable, const GpuMesh& mesh) const
{
  if (drawable.layer == view::Layer::bodies && is_line_mode(mode_)) return false;
  return drawable.material.opacity < 1.0F || mesh.has_translucent_colours;
}

PixelBox bounding_box(const PixelBox& a, const PixelBox& b)
{
  if (a.is_empty()) return b;
  if (b.is_empty()) return a;
  const int x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

/// The bounds of the projected boxes of the drawables; the whole viewport if a corner is behind the camera.
PixelBox SurfacePainter::bounds(const view::Scene& scene, const PixelBox& view,
                                bool is_only_translucent) const
{
  Eigen::Array2d low = Eigen::Array2d::Ones(), high = -low;  // normalised device coordinates
  const auto include = [&](const Eigen::Vector4d& p_clip) {
    const bool is_in_front = p_clip.w() > 0.0;
    const Eigen::Array2d p =
        is_in_front ? Eigen::Array2d(p_clip.head<2>() / p_clip.w()) : Eigen::Array2d(0, 0);
    low = low.min(is_in_front ? p : -Eigen::Array2d::Ones());
    high = high.max(is_in_front ? p : Eigen::Array2d::Ones());
  };
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const view::Drawable& drawable = scene.drawables[i];
    if (!drawable.is_shown || (is_only_translucent && !is_translucent(drawable, meshes_[i]))) continue;
    const Eigen::Matrix4d X_clip_mesh =
        projection_.cast<double>() * (X_camera_world_ * drawable.X_world_mesh).matrix();
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector4d p_mm =
          drawable.box_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)).homogeneous();
      include(X_clip_mesh * p_mm);
    }
  }
  if ((low >= high).any()) return {};
  // One pixel of margin for rounding to single precision.
  const Eigen::Array2d size(view.width, view.height);
  const Eigen::Array2d first = ((low.max(-1.0) * 0.5 + 0.5) * size - 1.0).max(0.0).floor();
  const Eigen::Array2d last = ((high.min(1.0) * 0.5 + 0.5) * size + 1.0).min(size).ceil();
  if ((first >= last).any()) return {};
  return {view.x + static_cast<int>(first.x()), view.y + static_cast<int>(first.y()),
          static_cast<int>(last.x() - first.x()), static_cast<int>(last.y() - first.y())};
}

SurfacePainter::Shading SurfacePainter::shading_of(const view::Drawable& drawable) const
{
  if (drawable.layer != view::Layer::bodies) return Shading::smooth;
  switch (mode_) {
    case view::DrawMode::wire:
    case view::DrawMode::hidden_line:
      return Shading::lines;
    case view::DrawMode::flat:
      return Shading::flat;
    case view::DrawMode::smooth:
      return Shading::smooth;
    case view::DrawMode::textured:
      if (repeats_by_mm_ > 0.0F && drawable.material.mottling >= texture_mottling) return Shading::textured;
      return drawable.material.mottling > 0.0F ? Shading::mottled : Shading::smooth;
  }
  throw InternalError("unknown draw mode");
}

/// The allowed error at the nearest depth of the drawable; 0 in modes that show single triangles.
double SurfacePainter::allowed_error_mm(const view::Drawable& drawable) const
{
  if (drawable.layer == view::Layer::bodies && (is_line_mode(mode_) || mode_ == view::DrawMode::flat))
    return 0.0;
  const Eigen::Vector3d middle_mm = drawable.box_mm.center();
  const double radius_mm = 0.5 * drawable.box_mm.sizes().norm();
  const double depth_mm = -(X_camera_world_ * (drawable.X_world_mesh * middle_mm)).z() - radius_mm;
  return options_.coarseness_px * std::max(depth_mm, near_mm_) / px_mm_at_1_mm_;
}

SurfacePainter::Program& SurfacePainter::compiled(const Variant& variant)
{
  const bool is_depth = variant.shading == Shading::depth;
  const std::size_t n_lights = is_depth ? 0 : lighting_->lights.size();
  const std::size_t kind = 16 * static_cast<std::size_t>(variant.shading) + (variant.is_coloured ? 8 : 0) +
                           (variant.is_stored ? 4 : 0) + (variant.is_vertex_lit ? 2 : 0) +
                           (variant.is_multisampled ? 1 : 0);
  Program& program = programs_[(view::most_lights + 1) * kind + n_lights];
  if (program.id != 0) return program;
  constexpr std::array<const char*, n_shadings> names{
      "", "#define MOTTLED\n", "#define TEXTURED\n", "#define FLAT\n", "#define LINES\n", ""};
  std::string first = variant.is_stored ? "#version 430 core\n#define STORED\n" : "#version 330 core\n";
  first += "#define N_LIGHTS " + std::to_string(n_lights) + "\n";
  first += names[static_cast<std::size_t>(variant.shading)];
  if (variant.is_vertex_lit) first += "#define VERTEX_LIT\n";
  if (variant.is_coloured) first += "#define COLOURED\n";
  if (variant.is_multisampled) first += "#define MULTISAMPLED\n";
  if (!is_depth) first += lighting_functions;
  program.id = linked_program(gl_, first.c_str(), surface_vertex_shader,
                              is_depth ? peel_fragment_shader : surface_fragment_shader);
  const auto at = [&](const char* name) { return gl_.GetUniformLocation(program.id, name); };
  program.at = {at("X_camera_mesh"), at("projection"), at("colour"),          at("opacity"),
                at("specular"),      at("shininess"),  at("mottling"),        at("up_camera"),
                at("sky"),           at("ground"),     at("light_direction"), at("light_colour"),
                at("behind"),        at("image"),      at("repeats_by_mm"),   at("depth_offset_mm")};
  return program;
}

void SurfacePainter::set_shot(Program& program)
{
  if (program.n_begun == n_begun_) return;
  program.n_begun = n_begun_;
  std::array<float, 3 * view::most_lights> direction{}, colour{};
  const std::vector<view::Light>& lights = lighting_->lights;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      direction[3 * i + k] = lights[i].towards_camera[static_cast<Eigen::Index>(k)];
      colour[3 * i + k] = lights[i].colour[static_cast<Eigen::Index>(k)];
    }
  }
  // The world's Y in camera axes.
  const Eigen::Vector3f up_camera = X_camera_world_.linear().col(1).cast<float>();
  const Uniforms& at = program.at;
  const auto n_lights = static_cast<GLsizei>(lights.size());
  gl_.UniformMatrix4fv(at.projection, 1, GL_FALSE, projection_.data());
  gl_.Uniform3fv(at.up_camera, 1, up_camera.data());
  gl_.Uniform3fv(at.sky, 1, lighting_->sky.data());
  gl_.Uniform3fv(at.ground, 1, lighting_->ground.data());
  // OpenGL ignores the location -1 of unused uniforms.
  gl_.Uniform3fv(n_lights > 0 ? at.light_direction : -1, n_lights, direction.data());
  gl_.Uniform3fv(n_lights > 0 ? at.light_colour : -1, n_lights, colour.data());
  gl_.Uniform1i(at.behind, behind_unit);
  gl_.Uniform1i(at.image, image_unit);
  gl_.Uniform1f(at.repeats_by_mm, repeats_by_mm_);
}

void SurfacePainter::set_material(const Program& program, const view::Drawable& drawable, Shading shading)
{
  const Material& material = drawable.material;
  const Eigen::Vector3f shade = shading == Shading::lines ? line_shade_ : Eigen::Vector3f::Ones();
  const Eigen::Vector3f colour = material.colour.cwiseProduct(shade);
  gl_.Uniform3fv(program.at.colour, 1, colour.data());
  gl_.Uniform1f(program.at.opacity, material.opacity);
  gl_.Uniform1f(program.at.specular, material.specular);
  gl_.Uniform1f(program.at.shininess, material.shininess);
  gl_.Uniform1f(program.at.mottling, material.mottling);
}

void SurfacePainter::draw_one(const view::Drawable& drawable, const GpuMesh& mesh, Variant variant)
{
  const bool is_depth = variant.shading == Shading::depth;
  variant.is_coloured = mesh.has_colours && !is_depth;
  variant.is_multisampled = is_multisampled_ && is_depth;
  Program& program = compiled(variant);
  gl_.UseProgram(program.id);
  set_shot(program);
  const Eigen::Matrix4f X_camera_mesh = (X_camera_world_ * drawable.X_world_mesh).matrix().cast<float>();
  gl_.UniformMatrix4fv(program.at.X_camera_mesh, 1, GL_FALSE, X_camera_mesh.data());
  gl_.Uniform1f(program.at.depth_offset_mm, static_cast<float>(drawable.depth_offset_mm));
  if (!is_depth) set_material(program, drawable, variant.shading);
  vrda::view::draw(gl_, mesh, allowed_error_mm(drawable));
}

void SurfacePainter::draw_lines(const view::Scene& scene)
{
  const auto draw_bodies = [&] {
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      const view::Drawable& drawable = scene.drawables[i];
      if (drawable.is_shown && drawable.layer == view::Layer::bodies)
        draw_one(drawable, meshes_[i], {Shading::lines});
    }
  };
  if (mode_ == view::DrawMode::hidden_line) {
    // Depth of the faces, offset slightly behind their edges.
    gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    gl_.Enable(GL_POLYGON_OFFSET_FILL);
    gl_.PolygonOffset(1.0F, 1.0F);
    draw_bodies();
    gl_.Disable(GL_POLYGON_OFFSET_FILL);
    gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  }
  gl_.PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  gl_.DepthFunc(GL_LEQUAL);
  draw_bodies();
  gl_.DepthFunc(GL_LESS);
  gl_.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

void SurfacePainter::draw(const view::Scene& scene, SurfacePass pass)
{
  const bool is_line_drawing = is_line_mode(mode_);
  if (pass == SurfacePass::opaque && is_line_drawing) draw_lines(scene);
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const view::Drawable& drawable = scene.drawables[i];
    if (!drawable.is_shown || (is_line_drawing && drawable.layer == view::Layer::bodies)) continue;
    if (is_translucent(drawable, meshes_[i]) == (pass == SurfacePass::opaque)) continue;
    const bool is_depth = pass == SurfacePass::translucent_depth;
    const bool is_closed = meshes_[i].is_closed || (drawable.is_solid && scene.has_vertex_lighting);
    const bool is_culled = pass == SurfacePass::opaque && is_closed;
    if (is_culled) gl_.Enable(GL_CULL_FACE);
    const Shading shading = is_depth ? Shading::depth : shading_of(drawable);
    const bool is_vertex_lit = is_culled && scene.has_vertex_lighting && shading != Shading::flat;
    draw_one(drawable, meshes_[i], {shading, false, pass == SurfacePass::translucent_store, is_vertex_lit});
    if (is_culled) gl_.Disable(GL_CULL_FACE);
  }
}

}  // namespace vrda::view
