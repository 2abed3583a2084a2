/// Reading of mesh bytes, up to the solver's mesh.
#pragma once

#include "fuzz/outcome.hpp"
#include "job/clean_mesh.hpp"

namespace vrda::test {

/// Reads, cleans and checks that every index is within its mesh and every number is finite.
inline void read_and_clean(const std::string& file, std::string bytes)
{
  read_or_refuse([&] {
    const job::RawMesh raw = job::read_mesh(file, std::move(bytes));
    std::size_t n_corners = 0;
    for (const std::int32_t size : raw.size) n_corners += static_cast<std::size_t>(size);
    require(n_corners == raw.corner.size(), "faces and corners do not match");
    for (const std::int32_t corner : raw.corner)
      require(corner >= 0 && corner < raw.vertices.rows(), "a corner outside the vertices");
    for (const Side side : {Side::right, Side::left}) {
      const job::CleanMesh clean = job::clean_mesh(raw, job::Winding::outward, side);
      const Mesh& mesh = clean.mesh;
      require(mesh.normals.rows() == mesh.vertices_mm.rows(), "not one normal per vertex");
      require(mesh.vertices_mm.allFinite() && mesh.normals.allFinite(), "a number that is not finite");
      require(mesh.triangles.size() == 0 ||
                  (mesh.triangles.minCoeff() >= 0 && mesh.triangles.maxCoeff() < mesh.vertices_mm.rows()),
              "a triangle outside the vertices");
      require(clean.n_welded >= 0 && clean.n_degenerate >= 0, "a negative count");
    }
  });
}

}  // namespace vrda::test
