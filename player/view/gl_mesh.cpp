#include "view/gl_mesh.hpp"

#include <GL/glcorearb.h>
#include <meshoptimizer.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <numeric>
#include <utility>

#include "core/text.hpp"
#include "view/shaders.hpp"

namespace vrda::view {
namespace {

/// From half a pixel in a close-up (20 pixels per mm) to half a pixel of a whole leg, in steps of sqrt(2).
constexpr std::array<double, 9> target_error_mm{0.03, 0.042, 0.06, 0.085, 0.12, 0.17, 0.25, 0.35, 0.5};

/// Smaller meshes have negligible cost and get no levels.
constexpr std::size_t least_triangles = 500;

/// A level is kept if it has at most this fraction of the previous level's triangles.
constexpr double largest_fraction = 0.8;

std::vector<std::uint32_t> cache_ordered(const std::vector<std::uint32_t>& triangles, std::size_t n_vertices)
{
  std::vector<std::uint32_t> ordered(triangles.size());
  meshopt_optimizeVertexCache(ordered.data(), triangles.data(), triangles.size(), n_vertices);
  return ordered;
}

/// For each vertex, the lowest-numbered vertex with the same position.
std::vector<std::uint32_t> merged_vertices(const RenderMesh& mesh)
{
  std::vector<std::uint32_t> order(mesh.vertices.size()), merged(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto position = [&](std::uint32_t i) { return mesh.vertices[i].position_mm; };
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return position(a) != position(b) ? position(a) < position(b) : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_new = i == 0 || position(order[i]) != position(order[i - 1]);
    merged[order[i]] = is_new ? order[i] : merged[order[i - 1]];
  }
  return merged;
}

double volume_mm3(const RenderMesh& mesh)
{
  double six_volumes_mm3 = 0.0;
  const auto corner_mm = [&](std::size_t i) {
    return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[mesh.triangles[i]].position_mm.data())
        .cast<double>()
        .eval();
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
    six_volumes_mm3 += corner_mm(i).dot(corner_mm(i + 1).cross(corner_mm(i + 2)));
  return six_volumes_mm3 / 6.0;
}

}  // namespace

MeshLevels levels_of(const RenderMesh& mesh)
{
  MeshLevels levels;
  const std::size_t n_vertices = mesh.vertices.size();
  levels.push_back({cache_ordered(mesh.triangles, n_vertices), 0.0});
  if (mesh.triangles.size() < 3 * least_triangles) return levels;
  const float* const positions = mesh.vertices.front().position_mm.data();
  // meshoptimizer's errors are relative to the mesh's extent.
  const double extent_mm = meshopt_simplifyScale(positions, n_vertices, sizeof(RenderVertex));
  for (const double wanted_mm : target_error_mm) {
    // Simplify the full mesh each time: errors of successive simplification add up, and a level within 0.085
    // mm would have three times the triangles.
    std::vector<std::uint32_t> fewer(mesh.triangles.size());
    float error = 0.0F;
    fewer.resize(meshopt_simplify(fewer.data(), mesh.triangles.data(), mesh.triangles.size(), positions,
                                  n_vertices, sizeof(RenderVertex), 0,
                                  static_cast<float>(wanted_mm / extent_mm), 0, &error));
    const auto n_before = static_cast<double>(levels.back().triangles.size());
    if (static_cast<double>(fewer.size()) > largest_fraction * n_before) continue;
    levels.push_back({cache_ordered(fewer, n_vertices), static_cast<double>(error) * extent_mm});
  }
  return levels;
}

bool is_closed(const RenderMesh& mesh)
{
  const std::vector<std::uint32_t> merged = merged_vertices(mesh);
  // Edges with the smaller vertex first; the sign is the original direction.
  struct Edge {
    std::uint32_t low, high;
    int sign;
  };
  std::vector<Edge> edges;
  edges.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
    const std::uint32_t a = merged[mesh.triangles[i]], b = merged[mesh.triangles[next]];
    edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
  }
  std::ranges::sort(
      edges, [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
  int balance = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    balance += edges[i].sign;
    const bool is_last =
        i + 1 == edges.size() || edges[i + 1].low != edges[i].low || edges[i + 1].high != edges[i].high;
    if (is_last && balance != 0) return false;
  }
  return volume_mm3(mesh) > 0.0;
}

namespace {

template <class T>
GLsizeiptr bytes_of(const std::vector<T>& items)
{
  return static_cast<GLsizeiptr>(items.size() * sizeof(T));
}

void upload_colours(const GlTable& gl, const view::Drawable& drawable, GpuMesh& mesh)
{
  const std::vector<view::VertexColour>& colours = drawable.colours;
  check(colours.empty() || colours.size() == drawable.mesh.vertices.size(), "there is one colour per vertex");
  mesh.has_colours = !colours.empty();
  mesh.has_translucent_colours =
      std::ranges::any_of(colours, [](const view::VertexColour& colour) { return colour[3] < 255; });
  if (colours.empty()) return;
  gl.BindBuffer(GL_ARRAY_BUFFER, mesh.buffers[2]);
  gl.BufferData(GL_ARRAY_BUFFER, bytes_of(colours), colours.data(), GL_DYNAMIC_DRAW);
  gl.EnableVertexAttribArray(2);
  gl.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(view::VertexColour), nullptr);
}

}  // namespace

GpuMesh upload_mesh(const GlTable& gl, const view::Drawable& drawable)
{
  const RenderMesh& mesh = drawable.mesh;
  GpuMesh gpu;
  gl.GenVertexArrays(1, &gpu.vertex_array);
  gl.GenBuffers(static_cast<GLsizei>(gpu.buffers.size()), gpu.buffers.data());
  gl.BindVertexArray(gpu.vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, gpu.buffers[0]);
  gl.BufferData(GL_ARRAY_BUFFER, bytes_of(mesh.vertices), mesh.vertices.data(), GL_STATIC_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, gpu.buffers[1]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, bytes_of(mesh.triangles), mesh.triangles.data(), GL_STATIC_DRAW);
  gpu.levels.push_back({0, static_cast<int>(mesh.triangles.size()), 0.0});
  gl.EnableVertexAttribArray(0);
  gl.EnableVertexAttribArray(1);
  constexpr GLsizei stride = sizeof(RenderVertex);
  gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, nullptr);
  gl.VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(RenderVertex, normal)));
  upload_colours(gl, drawable, gpu);
  gpu.n_vertices = mesh.vertices.size();
  gpu.n_indices = mesh.triangles.size();
  gpu.revision = drawable.revision;
  gpu.is_closed = is_closed(mesh);
  return gpu;
}

void add_levels(const GlTable& gl, const MeshLevels& levels, GpuMesh& mesh)
{
  if (mesh.is_changed || levels.size() < 2) return;
  mesh.levels.clear();
  std::vector<std::uint32_t> indices;
  for (const DetailLevel& level : levels) {
    mesh.levels.push_back({indices.size(), static_cast<int>(level.triangles.size()), level.error_mm});
    indices.insert(indices.end(), level.triangles.begin(), level.triangles.end());
  }
  gl.BindVertexArray(mesh.vertex_array);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, bytes_of(indices), indices.data(), GL_STATIC_DRAW);
}

void refresh(const GlTable& gl, const view::Drawable& drawable, GpuMesh& mesh)
{
  if (drawable.revision == mesh.revision) return;
  const RenderMesh& changed = drawable.mesh;
  check(changed.vertices.size() <= mesh.n_vertices && changed.triangles.size() <= mesh.n_indices,
        "a new revision of a mesh is not larger than at its upload");
  gl.BindVertexArray(mesh.vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, mesh.buffers[0]);
  gl.BufferSubData(GL_ARRAY_BUFFER, 0, bytes_of(changed.vertices), changed.vertices.data());
  gl.BufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, bytes_of(changed.triangles), changed.triangles.data());
  upload_colours(gl, drawable, mesh);
  // Only the full level is overwritten; the coarser ones are invalid now.
  mesh.is_changed = true;
  mesh.is_closed = false;
  mesh.levels.resize(1);
  mesh.levels[0].n = static_cast<int>(changed.triangles.size());
  mesh.revision = drawable.revision;
}

void release_mesh(const GlTable& gl, GpuMesh& mesh)
{
  gl.DeleteVertexArrays(1, &mesh.vertex_array);
  gl.DeleteBuffers(static_cast<GLsizei>(mesh.buffers.size()), mesh.buffers.data());
  mesh = {};
}

void draw(const GlTable& gl, const GpuMesh& mesh, double allowed_error_mm)
{
  const IndexRun* chosen = mesh.levels.data();
  for (const IndexRun& level : mesh.levels) {
    if (level.error_mm <= allowed_error_mm) chosen = &level;
  }
  gl.BindVertexArray(mesh.vertex_array);
  gl.DrawElements(GL_TRIANGLES, chosen->n, GL_UNSIGNED_INT,
                  buffer_offset(chosen->first * sizeof(std::uint32_t)));
}

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
