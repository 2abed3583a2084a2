#include "view/gl_mesh.hpp"

#include <GL/glcorearb.h>
#include <meshoptimizer.h>
#include <Eigen/Geometry>

#include <algorithm>
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

namespace {

/// The part of the edges that have not as many triangles in one direction as in the other.
double open_part(const RenderMesh& mesh)
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
  double n_edges = 0.0, n_open = 0.0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    balance += edges[i].sign;
    const bool is_last =
        i + 1 == edges.size() || edges[i + 1].low != edges[i].low || edges[i + 1].high != edges[i].high;
    if (!is_last) continue;
    n_edges += 1.0;
    n_open += balance != 0 ? 1.0 : 0.0;
    balance = 0;
  }
  return n_open / n_edges;
}

}  // namespace

bool is_closed(const RenderMesh& mesh)
{
  return open_part(mesh) == 0.0 && volume_mm3(mesh) > 0.0;
}

bool is_solid(const RenderMesh& mesh)
{
  // As on the page. The border of a sheet of a million triangles has more.
  return open_part(mesh) < 1e-3 && volume_mm3(mesh) > 0.0;
}

namespace {

constexpr double parallel_determinant = 1e-9;  // mm^2: triangles seen edge-on are skipped

/// Distance along the ray to a triangle, in units of |direction|; infinite without a hit.
double hit(const Eigen::Vector3d& from, const Eigen::Vector3d& direction,
           const std::array<Eigen::Vector3d, 3>& corners)
{
  constexpr double none = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d a = corners[1] - corners[0], b = corners[2] - corners[0];
  const Eigen::Vector3d p = direction.cross(b);
  const double determinant = a.dot(p);
  if (std::abs(determinant) < parallel_determinant) return none;
  const Eigen::Vector3d s = from - corners[0];
  const double u = s.dot(p) / determinant;
  const Eigen::Vector3d q = s.cross(a);
  const double v = direction.dot(q) / determinant;
  if (u < 0.0 || v < 0.0 || u + v > 1.0) return none;
  const double along = b.dot(q) / determinant;
  return along > 0.0 ? along : none;
}

}  // namespace

double nearest_hit(const RenderMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& direction)
{
  double nearest = std::numeric_limits<double>::infinity();
  const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
    const std::array<float, 3>& p = mesh.vertices[mesh.triangles[i]].position_mm;
    return Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
  };
  for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3)
    nearest = std::min(nearest, hit(from, direction, {corner(i), corner(i + 1), corner(i + 2)}));
  return nearest;
}

namespace {

template <class T>
GLsizeiptr bytes_of(const std::vector<T>& items)
{
  return static_cast<GLsizeiptr>(items.size() * sizeof(T));
}

void upload_colours(const GlTable& gl, const Drawable& drawable, GpuMesh& mesh)
{
  const std::vector<VertexColour>& colours = drawable.colours;
  check(colours.empty() || colours.size() == drawable.mesh.vertices.size(), "there is one colour per vertex");
  mesh.has_colours = !colours.empty();
  mesh.has_translucent_colours =
      std::ranges::any_of(colours, [](const VertexColour& colour) { return colour[3] < 255; });
  if (colours.empty()) return;
  gl.BindBuffer(GL_ARRAY_BUFFER, mesh.colours);
  gl.BufferData(GL_ARRAY_BUFFER, bytes_of(colours), colours.data(), GL_DYNAMIC_DRAW);
  gl.EnableVertexAttribArray(2);
  gl.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(VertexColour), nullptr);
}

/// Of runs of triangles, which are near each other in most meshes: closer than one box of them all.
void find_boxes(const RenderMesh& mesh, std::vector<Eigen::AlignedBox3d>& boxes_mm)
{
  constexpr std::size_t run = 3 * 256;
  boxes_mm.clear();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i % run == 0) boxes_mm.emplace_back();
    const std::array<float, 3>& p_mm = mesh.vertices[mesh.triangles[i]].position_mm;
    boxes_mm.back().extend(Eigen::Vector3d(p_mm[0], p_mm[1], p_mm[2]));
  }
}

GpuMesh upload_mesh(const GlTable& gl, const Drawable& drawable)
{
  const RenderMesh& mesh = drawable.mesh;
  GpuMesh gpu;
  gpu.geometry = create_geometry(gl, sizeof(RenderVertex), {{3, 0}, {3, offsetof(RenderVertex, normal)}});
  gpu.colours = GlObject(gl.GenBuffers, gl.DeleteBuffers);
  gl.BufferData(GL_ARRAY_BUFFER, bytes_of(mesh.vertices), mesh.vertices.data(), GL_STATIC_DRAW);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, bytes_of(mesh.triangles), mesh.triangles.data(), GL_STATIC_DRAW);
  gpu.levels.push_back({0, static_cast<int>(mesh.triangles.size()), 0.0});
  upload_colours(gl, drawable, gpu);
  gpu.n_vertices = mesh.vertices.size();
  gpu.n_indices = mesh.triangles.size();
  gpu.revision = drawable.revision;
  gpu.is_closed = is_closed(mesh);
  find_boxes(mesh, gpu.boxes_mm);
  return gpu;
}

/// Uploads the coarser levels, if there are any and the mesh is unchanged since its upload.
void add_levels(const GlTable& gl, const MeshLevels& levels, GpuMesh& mesh)
{
  if (mesh.is_changed || levels.size() < 2) return;
  mesh.levels.clear();
  std::vector<std::uint32_t> indices;
  for (const DetailLevel& level : levels) {
    mesh.levels.push_back({indices.size(), static_cast<int>(level.triangles.size()), level.error_mm});
    indices.insert(indices.end(), level.triangles.begin(), level.triangles.end());
  }
  gl.BindVertexArray(mesh.geometry.array);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, bytes_of(indices), indices.data(), GL_STATIC_DRAW);
}

/// Uploads a new revision.
void upload_revision(const GlTable& gl, const Drawable& drawable, GpuMesh& mesh)
{
  if (drawable.revision == mesh.revision) return;
  const RenderMesh& changed = drawable.mesh;
  gl.BindVertexArray(mesh.geometry.array);
  gl.BindBuffer(GL_ARRAY_BUFFER, mesh.geometry.vertices);
  const auto fill = [&](GLenum kind, std::size_t& room, const auto& items) {
    if (items.size() <= room) return gl.BufferSubData(kind, 0, bytes_of(items), items.data());
    room = items.size();
    gl.BufferData(kind, bytes_of(items), items.data(), GL_DYNAMIC_DRAW);
  };
  fill(GL_ARRAY_BUFFER, mesh.n_vertices, changed.vertices);
  fill(GL_ELEMENT_ARRAY_BUFFER, mesh.n_indices, changed.triangles);
  upload_colours(gl, drawable, mesh);
  // Only the full level is overwritten; the coarser ones are invalid now.
  mesh.is_changed = true;
  mesh.is_closed = false;
  mesh.boxes_mm.assign(1, drawable.box_mm);
  mesh.levels.resize(1);
  mesh.levels[0].n = static_cast<int>(changed.triangles.size());
  mesh.revision = drawable.revision;
}

/// Draws the coarsest level within the allowed error.
void draw_level(const GlTable& gl, const GpuMesh& mesh, double allowed_error_mm)
{
  const IndexRun* chosen = mesh.levels.data();
  for (const IndexRun& level : mesh.levels) {
    if (level.error_mm <= allowed_error_mm) chosen = &level;
  }
  gl.BindVertexArray(mesh.geometry.array);
  gl.DrawElements(GL_TRIANGLES, chosen->n, GL_UNSIGNED_INT,
                  buffer_offset(chosen->first * sizeof(std::uint32_t)));
}

/// Separates bone (stronger mottling), which gets the texture, from soft tissue.
constexpr float texture_mottling = 0.1F;

/// Texture units.
constexpr int behind_unit = 0, image_unit = 1;

bool is_line_mode(DrawMode mode)
{
  return mode == DrawMode::wire || mode == DrawMode::hidden_line;
}

/// Lines are darkened on a light background for contrast.
Eigen::Vector3f line_shade(const Background& background)
{
  constexpr float light_backdrop = 0.1F, darkened = 0.2F;  // linear; chosen visually
  const float brightness = 0.5F * (background.top + background.bottom).mean();
  return Eigen::Vector3f::Constant(brightness > light_backdrop ? darkened : 1.0F);
}

}  // namespace

void SurfacePainter::load(const Scene& scene)
{
  meshes_.clear();
  for (const Scene* part = &scene; part != nullptr; part = part->other)
    for (const Drawable& drawable : part->drawables) meshes_.push_back(upload_mesh(gl_, drawable));
  group_.clear();
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const std::string& structure = drawable_of(scene, i).structure;
    std::size_t first = i < scene.drawables.size() ? 0 : scene.drawables.size();
    while (first < i && (structure.empty() || drawable_of(scene, first).structure != structure)) ++first;
    group_.push_back(first);
  }
  load_texture(scene.texture);
  levels_ = {};
  if (options_.coarseness_px <= 0.0) return;
  find_levels(scene);
  if (!options_.has_deferred_levels) take_levels();
}

/// Meshes with vertex colours get no levels: simplification would lose the pattern.
void SurfacePainter::find_levels(const Scene& scene)
{
  std::vector<RenderMesh> wanted;
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const Drawable& drawable = drawable_of(scene, i);
    wanted.push_back(drawable.colours.empty() ? drawable.mesh : RenderMesh{});
  }
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

void SurfacePainter::load_texture(const Texture& texture)
{
  texture_ = {};
  repeats_by_mm_ = 0.0F;
  if (texture.is_empty()) return;
  const std::size_t n_bytes =
      3 * static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height);
  check(texture.rgb.size() == n_bytes && texture.scale_mm > 0.0,
        "a texture has three bytes per pixel and a positive scale");
  gl_.ActiveTexture(GL_TEXTURE0 + image_unit);
  texture_ =
      create_texture(gl_, {texture.width, texture.height, GL_SRGB8, GL_RGB, GL_UNSIGNED_BYTE, GL_LINEAR},
                     texture.rgb.data());
  gl_.GenerateMipmap(GL_TEXTURE_2D);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl_.ActiveTexture(GL_TEXTURE0);
  repeats_by_mm_ = static_cast<float>(1.0 / texture.scale_mm);
}

void SurfacePainter::refresh(const Scene& scene)
{
  check(scene.drawables.size() + (scene.other ? scene.other->drawables.size() : 0) == meshes_.size(),
        "a scene is loaded before it is drawn");
  if (levels_.valid() && levels_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
    take_levels();
  for (std::size_t i = 0; i < meshes_.size(); ++i) upload_revision(gl_, drawable_of(scene, i), meshes_[i]);
}

const Drawable& SurfacePainter::drawable_of(const Scene& scene, std::size_t i)
{
  const std::size_t n = scene.drawables.size();
  return i < n ? scene.drawables[i] : scene.other->drawables[i - n];
}

bool SurfacePainter::is_shown(const Scene& scene, std::size_t i) const
{
  return drawable_of(scene, i).is_shown && (i < scene.drawables.size() ? has_own_ : has_other_);
}

void SurfacePainter::begin(const Scene& scene, const Shot& shot, const PixelBox& view, bool is_multisampled)
{
  const Camera& camera = shot.camera;
  has_own_ = shot.has_own;
  has_other_ = shot.has_other;
  check(scene.lighting.lights.size() <= most_lights, "a scene has at most four lights");
  ++n_begun_;
  mode_ = scene.mode;
  is_multisampled_ = is_multisampled;
  lighting_ = &scene.lighting;
  line_shade_ = line_shade(scene.background);
  X_camera_world_ = camera.X_world_camera.inverse();
  projection_ = projection(camera).cast<float>();
  px_mm_at_1_mm_ = view.height / (2.0 * camera.half_height_tangent);
  near_mm_ = camera.near_mm;
  has_section_ = scene.section.has_value();
  section_normal_.setZero();
  section_at_mm_ = 1.0F;
  if (has_section_) {
    const Eigen::Vector3d eye_mm = camera.X_world_camera.translation();
    const double side = scene.section->normal.dot(eye_mm) > scene.section->at_mm ? 1.0 : -1.0;
    section_normal_ = (side * X_camera_world_.linear() * scene.section->normal).cast<float>();
    section_at_mm_ = static_cast<float>(side * (scene.section->at_mm - scene.section->normal.dot(eye_mm)));
  }
  translucent_box_ = bounds(scene, view, true);
  find_groups(scene, view);
  content_box_ = is_line_mode(mode_) ? view : bounds(scene, view, false);
}

void SurfacePainter::find_groups(const Scene& scene, const PixelBox& view)
{
  translucent_groups_.clear();
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const Drawable& drawable = drawable_of(scene, i);
    if (!is_shown(scene, i) || !is_translucent(drawable, meshes_[i])) continue;
    if (std::ranges::find(translucent_groups_, group_[i], &Group::row) != translucent_groups_.end()) continue;
    const PixelBox box = bounds(scene, view, true, group_[i]);
    if (!box.is_empty()) translucent_groups_.push_back({group_[i], !drawable.structure.empty(), box});
  }
}

bool SurfacePainter::is_translucent(const Drawable& drawable, const GpuMesh& mesh) const
{
  if (drawable.layer == Layer::bodies && is_line_mode(mode_)) return false;
  return drawable.material.opacity < 1.0F || mesh.has_translucent_colours;
}

/// The bounds of the projected boxes of the drawables; the whole viewport if a corner is behind the camera.
PixelBox SurfacePainter::bounds(const Scene& scene, const PixelBox& view, bool is_only_translucent,
                                std::size_t group) const
{
  Eigen::Array2d low = Eigen::Array2d::Ones(), high = -low;  // normalised device coordinates
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const Drawable& drawable = drawable_of(scene, i);
    if (!is_shown(scene, i) || (is_only_translucent && !is_translucent(drawable, meshes_[i]))) continue;
    if (group != all_groups && group_[i] != group) continue;
    const Eigen::Matrix4d X_clip_mesh =
        projection_.cast<double>() * (X_camera_world_ * drawable.X_world_mesh).matrix();
    for (const Eigen::AlignedBox3d& box_mm : meshes_[i].boxes_mm) {
      Eigen::AlignedBox2d box;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector4d p_clip =
            X_clip_mesh * box_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)).homogeneous();
        if (!(p_clip.w() > 0.0)) return view;
        box.extend(Eigen::Vector2d(p_clip.head<2>() / p_clip.w()));
      }
      if ((box.min().array() > 1.0).any() || (box.max().array() < -1.0).any()) continue;
      low = low.min(box.min().array());
      high = high.max(box.max().array());
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

SurfacePainter::Shading SurfacePainter::shading_of(const Drawable& drawable) const
{
  if (drawable.layer != Layer::bodies) return Shading::smooth;
  switch (mode_) {
    case DrawMode::wire:
    case DrawMode::hidden_line:
      return Shading::lines;
    case DrawMode::flat:
      return Shading::flat;
    case DrawMode::smooth:
      return Shading::smooth;
    case DrawMode::textured:
      if (repeats_by_mm_ > 0.0F && drawable.material.mottling >= texture_mottling) return Shading::textured;
      return drawable.material.mottling > 0.0F ? Shading::mottled : Shading::smooth;
  }
  throw InternalError("unknown draw mode");
}

/// The allowed error at the nearest depth of the drawable; 0 in modes that show single triangles.
double SurfacePainter::allowed_error_mm(const Drawable& drawable) const
{
  if (drawable.layer == Layer::bodies && (is_line_mode(mode_) || mode_ == DrawMode::flat)) return 0.0;
  const Eigen::Vector3d middle_mm = drawable.box_mm.center();
  const double radius_mm = 0.5 * drawable.box_mm.sizes().norm();
  const double depth_mm = -(X_camera_world_ * (drawable.X_world_mesh * middle_mm)).z() - radius_mm;
  return options_.coarseness_px * std::max(depth_mm, near_mm_) / px_mm_at_1_mm_;
}

SurfacePainter::Program& SurfacePainter::compiled(const Variant& variant)
{
  const bool is_front = variant.shading == Shading::front;
  const bool is_depth = variant.shading == Shading::depth || is_front;
  const std::size_t n_lights = is_depth ? 0 : lighting_->lights.size();
  const std::size_t kind = 16 * static_cast<std::size_t>(variant.shading) + (variant.is_coloured ? 8 : 0) +
                           (variant.is_stored ? 4 : 0) + (variant.is_vertex_lit ? 2 : 0) +
                           (variant.is_multisampled ? 1 : 0);
  Program& program = programs_[(most_lights + 1) * kind + n_lights];
  if (program.linked.is_linked()) return program;
  constexpr std::array<const char*, n_shadings> names{
      "", "#define MOTTLED\n", "#define TEXTURED\n", "#define FLAT\n", "#define LINES\n",
      "", "#define FRONT\n"};
  std::string first = variant.is_stored ? "#version 430 core\n#define STORED\n" : "#version 330 core\n";
  first += "#define N_LIGHTS " + std::to_string(n_lights) + "\n";
  first += names[static_cast<std::size_t>(variant.shading)];
  if (variant.is_vertex_lit) first += "#define VERTEX_LIT\n";
  if (variant.is_coloured) first += "#define COLOURED\n";
  if (variant.is_multisampled) first += "#define MULTISAMPLED\n";
  if (!is_depth) first += lighting_functions;
  program.linked =
      GlProgram(gl_, first, surface_vertex_shader, is_depth ? peel_fragment_shader : surface_fragment_shader);
  return program;
}

void SurfacePainter::set_shot(Program& program)
{
  if (program.n_begun == n_begun_) return;
  program.n_begun = n_begun_;
  std::array<float, 3 * most_lights> direction{}, colour{};
  const std::vector<Light>& lights = lighting_->lights;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      direction[3 * i + k] = lights[i].towards_camera[static_cast<Eigen::Index>(k)];
      colour[3 * i + k] = lights[i].colour[static_cast<Eigen::Index>(k)];
    }
  }
  // The world's Y in camera axes.
  const Eigen::Vector3f up_camera = X_camera_world_.linear().col(1).cast<float>();
  const auto n_lights = static_cast<int>(lights.size());
  const GlProgram& linked = program.linked;
  linked.set("projection", projection_);
  linked.set("section_normal", section_normal_.data());
  linked.set("up_camera", up_camera.data());
  linked.set("sky", lighting_->sky.data());
  linked.set("ground", lighting_->ground.data());
  if (n_lights > 0) linked.set("light_direction", direction.data(), n_lights);
  if (n_lights > 0) linked.set("light_colour", colour.data(), n_lights);
  linked.set("behind", behind_unit);
  linked.set("front", front_unit);
  linked.set("image", image_unit);
  linked.set("repeats_by_mm", repeats_by_mm_);
}

void SurfacePainter::set_material(const GlProgram& program, const Drawable& drawable, Shading shading)
{
  const Material& material = drawable.material;
  const Eigen::Vector3f shade = shading == Shading::lines ? line_shade_ : Eigen::Vector3f::Ones();
  const Eigen::Vector3f colour = material.colour.cwiseProduct(shade);
  program.set("colour", colour.data());
  program.set("opacity", material.opacity);
  program.set("specular", material.specular);
  program.set("shininess", material.shininess);
  program.set("mottling", material.mottling);
  program.set("highlight", drawable.highlight);
  program.set("unlit", drawable.layer == Layer::caps ? 1.0F : 0.0F);  // as on the page
}

void SurfacePainter::draw_one(const Drawable& drawable, const GpuMesh& mesh, Variant variant)
{
  const bool is_depth = variant.shading == Shading::depth || variant.shading == Shading::front;
  variant.is_coloured = mesh.has_colours && !is_depth;
  variant.is_multisampled = is_multisampled_ && is_depth;
  Program& program = compiled(variant);
  program.linked.use();
  set_shot(program);
  const Eigen::Matrix4f X_camera_mesh = (X_camera_world_ * drawable.X_world_mesh).matrix().cast<float>();
  program.linked.set("X_camera_mesh", X_camera_mesh);
  program.linked.set("depth_offset_mm", static_cast<float>(drawable.depth_offset_mm));
  // As a part of the range of depths 0.01 mm: below the thickness of anything drawn; 2: of all depths.
  program.linked.set("behind_front", drawable.structure.empty() ? 2.0F : 1e-6F);
  if (!is_depth) set_material(program.linked, drawable, variant.shading);
  // Caps lie in the plane. Software rendering clips by the distances whether or not that is enabled.
  constexpr float never_mm = 1e9F;
  program.linked.set("section_at_mm", drawable.layer == Layer::caps ? never_mm : section_at_mm_);
  if (has_section_) gl_.Enable(GL_CLIP_DISTANCE0);
  draw_level(gl_, mesh, allowed_error_mm(drawable));
  if (has_section_) gl_.Disable(GL_CLIP_DISTANCE0);
}

void SurfacePainter::draw_lines(const Scene& scene)
{
  const auto draw_bodies = [&] {
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      const Drawable& drawable = drawable_of(scene, i);
      if (is_shown(scene, i) && drawable.layer == Layer::bodies)
        draw_one(drawable, meshes_[i], {Shading::lines});
    }
  };
  if (mode_ == DrawMode::hidden_line) {
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

void SurfacePainter::draw(const Scene& scene, SurfacePass pass, std::size_t group)
{
  const bool is_line_drawing = is_line_mode(mode_);
  if (pass == SurfacePass::opaque && is_line_drawing) draw_lines(scene);
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const Drawable& drawable = drawable_of(scene, i);
    if (!is_shown(scene, i) || (is_line_drawing && drawable.layer == Layer::bodies)) continue;
    if (is_translucent(drawable, meshes_[i]) == (pass == SurfacePass::opaque)) continue;
    if (group != all_groups && group_[i] != group) continue;
    const bool is_solid = drawable.is_solid && (scene.has_vertex_lighting || !has_section_);
    const bool is_closed = meshes_[i].is_closed || is_solid;
    const bool is_culled = pass == SurfacePass::opaque && is_closed;
    if (is_culled) gl_.Enable(GL_CULL_FACE);
    const Shading shading = pass == SurfacePass::translucent_depth ? Shading::depth
                            : pass == SurfacePass::front_depth     ? Shading::front
                                                                   : shading_of(drawable);
    const bool is_vertex_lit = is_culled && scene.has_vertex_lighting && shading != Shading::flat;
    draw_one(drawable, meshes_[i], {shading, false, pass == SurfacePass::translucent_store, is_vertex_lit});
    if (is_culled) gl_.Disable(GL_CULL_FACE);
  }
}

}  // namespace vrda::view
