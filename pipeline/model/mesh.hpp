/// Triangle meshes, their measures and maps, and the two bodies of a joint made of them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/fields.hpp"
#include "core/units.hpp"

namespace vrda::inline model {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Pose = Eigen::Isometry3d;

/// An indexed triangle mesh. Counter-clockwise seen from outside.
struct Mesh {
  Points vertices_mm;   ///< [n_vertices, 3]
  Triangles triangles;  ///< [n_triangles, 3] row indices of vertices_mm
  Points normals;       ///< [n_vertices, 3] unit, outward; may be empty
  /// [n_triangles] radius by which the surface is rounded outward (spheres at vertices, cylinders at edges,
  /// shifted faces) wherever gaps, contacts and overlaps are measured; empty: none.
  std::vector<double> offset_mm;
  /// [n_triangles] depth to which another object may be inside the surface (inward_limit()); empty: none.
  std::vector<double> overlap_mm;
};

/// Offset of triangle `t`, and the largest one.
inline double offset_mm(const Mesh& mesh, Eigen::Index t)
{
  return mesh.offset_mm.empty() ? 0.0 : mesh.offset_mm[static_cast<std::size_t>(t)];
}
double largest_offset_mm(const Mesh& mesh);

/// Allowed overlap of triangle `t`.
inline double overlap_mm(const Mesh& mesh, Eigen::Index t)
{
  return mesh.overlap_mm.empty() ? 0.0 : mesh.overlap_mm[static_cast<std::size_t>(t)];
}

struct Box {
  Eigen::Vector3d min_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d max_mm = Eigen::Vector3d::Zero();
};

/// The corners of triangle `t`, in order.
std::array<Eigen::Vector3d, 3> corners(const Mesh& mesh, Eigen::Index t);

/// Unit outward normal of triangle `t`; zero for a degenerate one.
Eigen::Vector3d face_normal(const Mesh& mesh, Eigen::Index t);

/// Vertex normals: mean of the incident face normals weighted by face area, unit length
/// (zero where the faces cancel out).
Points vertex_normals(const Mesh& mesh);

/// Volume enclosed, by the divergence theorem; positive when normals point outward.
/// Undefined for an open mesh.
double signed_volume_mm3(const Mesh& mesh);

double area_mm2(const Mesh& mesh);
double mean_edge_length_mm(const Mesh& mesh);

/// Number of edges with one face (boundary) and with more than two or inconsistently wound
/// faces (non-manifold).
struct EdgeCounts {
  Eigen::Index boundary = 0;
  Eigen::Index non_manifold = 0;
  std::vector<std::int32_t> boundary_vertex, non_manifold_vertex;  ///< one of each edge
};
EdgeCounts edge_counts(const Mesh& mesh);

/// Bounding box; zero for an empty mesh.
Box bounding_box(const Mesh& mesh);

/// Every vertex and normal mapped by `X_to_from`.
Mesh transformed(const Mesh& mesh, const Pose& X_to_from);

/// Reflected in the plane Z = 0, winding reversed so that normals stay outward. Applied twice it gives
/// bitwise the same mesh.
Mesh mirrored_z(const Mesh& mesh);

/// Appends `extra` to `mesh`.
void append(Mesh& mesh, const Mesh& extra);

/// The mesh with only the listed triangles; all vertices are kept.
Mesh select_triangles(const Mesh& mesh, const std::vector<Eigen::Index>& kept);

/// The surface that limits other objects: that of `mesh`, each triangle with an allowed overlap displaced
/// inward by it along its normal. Vertices move so that their faces' planes do (least squares, at most twice
/// the overlap). A triangle that turns over, at a rim sharper than the overlap, limits nothing: it becomes a
/// point. The other rows, normals and overlap_mm stay.
Mesh inward_limit(const Mesh& mesh);

/// A named component of one of the two bodies of a joint.
struct Component {
  std::string name;      ///< unique within its body
  std::string material;  ///< "bone", "cartilage", "meniscus", ...
};

/// Triangles of several components in one mesh.
struct Part {
  Mesh mesh;                            ///< canonical axes, mm, not recentred
  std::vector<std::int32_t> component;  ///< [n_triangles] index into Body::components
};

struct Body {
  std::string name;
  std::vector<Component> components;
  Part contact;  ///< takes part in contact
  Part visual;   ///< drawn only
};

/// Rows of part.mesh.triangles by component, in order: one list a component of `body`.
std::vector<std::vector<Eigen::Index>> triangles_by_component(const Body& body, const Part& part);

/// Both parts of `body` reflected in Z = 0.
Body mirrored_z(const Body& body);

/// The sides of a joint that are evaluated separately, by their codes in files.
enum class Compartment : std::int8_t { none = 0, medial = 1, lateral = 2 };
inline constexpr Named<Compartment> compartment_names[] = {{Compartment::medial, "medial"},
                                                           {Compartment::lateral, "lateral"}};
constexpr const auto& names_of(Compartment)
{
  return compartment_names;
}
inline constexpr auto all_compartments = values_in(compartment_names);

/// An entry for each of `all_compartments`, by the compartment or its row.
template <typename Entry>
struct OfCompartments : std::array<Entry, all_compartments.size()> {
  using std::array<Entry, all_compartments.size()>::operator[];
  Entry& operator[](Compartment side) { return this->at(static_cast<std::size_t>(side) - 1); }
  const Entry& operator[](Compartment side) const { return this->at(static_cast<std::size_t>(side) - 1); }
};

/// Rows of the triangles in compartment `wanted`; `Code` is Compartment or its stored code.
template <typename Code>
std::vector<std::int32_t> triangles_of(const std::vector<Code>& compartment_of_triangle, Compartment wanted)
{
  std::vector<std::int32_t> rows;
  for (std::size_t t = 0; t < compartment_of_triangle.size(); ++t) {
    if (static_cast<Compartment>(compartment_of_triangle[t]) == wanted)
      rows.push_back(static_cast<std::int32_t>(t));
  }
  return rows;
}

// Render meshes (single precision, split vertices) and surface materials.

struct RenderVertex {
  std::array<float, 3> position_mm{};
  std::array<float, 3> normal{};  ///< unit, outward
};

struct RenderMesh {
  std::vector<RenderVertex> vertices;
  std::vector<std::uint32_t> triangles;  ///< three indices of `vertices` each
};

/// Edges with a larger dihedral angle stay sharp: those of cut shafts, near 90 degrees, but not the rims of
/// plateaus, which on a coarse mesh vary between less than 60 and 75 degrees from edge to edge.
inline constexpr double default_crease_rad = rad_from_deg(80.0);

/// Render mesh of the listed triangles of `mesh`. The normal at each corner is the area-weighted mean of the
/// faces around the vertex whose normals are within `crease_rad` of the corner's own face; vertices with
/// different normals are split. Positions are relative to `origin_mm`, so that single precision suffices for
/// a mesh far from its origin. Degenerate triangles are omitted.
RenderMesh make_render_mesh(const Mesh& mesh, const std::vector<Eigen::Index>& triangles,
                            const Eigen::Vector3d& origin_mm, double crease_rad = default_crease_rad);

/// Appearance of a surface, by the material name in a motion model. Colours are linear RGB on [0, 1].
struct Material {
  Eigen::Vector3f colour{0.5F, 0.5F, 0.5F};
  float opacity = 1.0F;     ///< below 1: drawn after all opaque surfaces
  float specular = 0.1F;    ///< specular coefficient
  float shininess = 30.0F;  ///< Blinn-Phong exponent
  float mottling = 0.0F;    ///< relative amplitude of the colour variation over the surface
};

/// The crease angle of a material's parts: a meniscus is soft tissue without sharp edges.
double crease_rad_of(const std::string& material);

/// Known names: "bone", "cartilage", "meniscus"; any other gives a neutral material.
Material material_of(const std::string& name);

}  // namespace vrda::inline model
