/// Meshes as the bytes of files. Texts have the fewest digits that read back as the same double.
#pragma once

#include <string>

#include "load/raw_mesh.hpp"

namespace vrda {

/// Vertices-Faces (thesis 4.1), indices from 0. Keeps no normals.
std::string vertices_faces_bytes(const RawMesh& mesh);

/// The normals that belong to a Vertices-Faces file: their number, then one a line in the vertices' order.
std::string vertex_normals_bytes(const RawMesh& mesh);

/// Wavefront OBJ and ASCII PLY, with normals where the mesh has them.
std::string wavefront_bytes(const RawMesh& mesh);
std::string ply_bytes(const RawMesh& mesh);

/// Binary STL: single precision. `header` comes first, cut at 80 bytes.
std::string stl_bytes(const Mesh& mesh, const std::string& header);

/// The format that the extension of `file` names: .vf, .obj (Wavefront), .ply, or .stl, for which polygons
/// are cut into triangles as load does. Throws InputError naming `file` for another extension, or for a
/// coordinate that an STL cannot hold.
std::string mesh_bytes(const std::string& file, const RawMesh& mesh);

/// Vertices of equal coordinates merged: a reader of STL or Wavefront gives each face its own. Their normals
/// become the mean, of unit length; none at all where one has no direction.
RawMesh with_shared_vertices(const RawMesh& mesh);

}  // namespace vrda
