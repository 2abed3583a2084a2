/// Serialises meshes to file formats. Text uses the fewest digits that restore the same double.
#pragma once

#include <string>

#include "job/raw_mesh.hpp"

namespace vrda::job {

/// Vertices-Faces (thesis 4.1), indices from 0, without normals.
std::string vertices_faces_bytes(const job::RawMesh& mesh);

/// The normals file of a Vertices-Faces file: their number, then one normal for each vertex and line.
std::string vertex_normals_bytes(const job::RawMesh& mesh);

/// Wavefront OBJ and ASCII PLY, with normals if the mesh has them.
std::string wavefront_bytes(const job::RawMesh& mesh);
std::string ply_bytes(const job::RawMesh& mesh);

/// Binary STL, single precision. `header`: at most 80 bytes are written.
std::string stl_bytes(const Mesh& mesh, const std::string& header);

/// Selects the format by the extension of `file`: .vf, .obj (Wavefront), .ply, or .stl (polygons are
/// triangulated as in load). Throws InputError naming `file` for another extension and for a coordinate
/// outside the range of an STL.
std::string mesh_bytes(const std::string& file, const job::RawMesh& mesh);

/// Merges vertices with equal coordinates, since the readers of STL and Wavefront give each face its own
/// vertices. Normals are averaged and normalised; if one has no direction, all are removed.
job::RawMesh merge_equal_vertices(const job::RawMesh& mesh);

}  // namespace vrda::job
