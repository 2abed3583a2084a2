/// Parser for Vertices-Faces (thesis 4.1): two counts, the vertices, then each face as its number of corners
/// and their indices. Words are separated by white space; # starts a comment.
#pragma once

#include <string>

#include "job/raw_mesh.hpp"

namespace vrda::job {

/// Whether the first word is a number, which distinguishes the format from Wavefront.
bool is_vertices_faces(const std::string& bytes);

/// Indices start at 0 if index 0 occurs, at 1 if the vertex count occurs as an index, and at 0 if neither
/// occurs. Throws InputError naming file and line.
RawMesh read_vertices_faces(const std::string& file, const std::string& bytes);

/// The normals file of a Vertices-Faces file (schemas/legacy-formats.md): their number, then one normal for
/// each vertex. Throws InputError naming file and line.
Points read_vertex_normals(const std::string& file, const std::string& bytes, Eigen::Index n_vertices);

}  // namespace vrda::job
