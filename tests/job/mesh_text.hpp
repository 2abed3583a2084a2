/// Mesh files as bytes and small jobs as text.
#pragma once

#include <string>

#include "model/mesh.hpp"

namespace vrda::test {

std::string binary_stl(const Mesh& mesh);
std::string ascii_stl(const Mesh& mesh);
std::string ascii_ply(const Mesh& mesh, bool with_normals = false);
std::string binary_ply(const Mesh& mesh);
std::string wavefront(const Mesh& mesh);
/// Vertices-Faces, indices counted from `first_index`.
std::string vertices_faces(const Mesh& mesh, int first_index);

/// A job with the meshes "reference.stl" and "moving.stl"; `head` is before the tables of the objects, `tail`
/// after them.
std::string small_job(const std::string& head = "", const std::string& tail = "");

}  // namespace vrda::test
