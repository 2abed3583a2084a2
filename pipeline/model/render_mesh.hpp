/// Render meshes (single precision, split vertices) and surface materials.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "model/mesh.hpp"
#include "core/units.hpp"

namespace vrda::inline model {

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
