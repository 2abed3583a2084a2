/// A mesh as graphics hardware wants it, and how surfaces look.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.hpp"
#include "core/units.hpp"

namespace vrda {

struct DrawVertex {
  std::array<float, 3> position_mm{};
  std::array<float, 3> normal{};  ///< unit, outward
};

struct DrawMesh {
  std::vector<DrawVertex> vertices;
  std::vector<std::uint32_t> triangles;  ///< three indices of `vertices` each
};

/// Edges bent by more stay sharp: those of cut shafts, near a right angle, and not the rims of plateaus,
/// which on a coarse mesh are bent by up to 75 degrees at some edges and by less than 60 at the next.
inline constexpr double default_crease_rad = rad_from_deg(80.0);

/// The triangles listed of `mesh`. At each corner the normal is the mean, weighted by area, of the faces
/// around the vertex that are bent from the corner's own by at most `crease_rad`; vertices are split where
/// that gives different normals. Positions are taken relative to `origin_mm`, so that single precision
/// suffices for a mesh far from its origin. Degenerate triangles are left out.
DrawMesh draw_mesh(const Mesh& mesh, const std::vector<Eigen::Index>& triangles,
                   const Eigen::Vector3d& origin_mm, double crease_rad = default_crease_rad);

/// How surfaces look, by the material that a motion model names. Colours are linear RGB on [0, 1].
struct Material {
  Eigen::Vector3f colour{0.5F, 0.5F, 0.5F};
  float opacity = 1.0F;     ///< below 1 drawn after everything opaque
  float specular = 0.1F;    ///< strength of the highlight
  float shininess = 30.0F;  ///< Blinn-Phong exponent
  float mottling = 0.0F;    ///< amplitude of the colour's variation over the surface, as a part of it
};

/// "bone", "cartilage", "meniscus"; neutral otherwise.
Material material_of(const std::string& name);

}  // namespace vrda
