/// The Vertices-Faces format of thesis 4.1: two counts, the vertices, then each face as its number of
/// corners and their indices. Words are separated by white space; # starts a comment.
#pragma once

#include <string>

#include "load/raw_mesh.hpp"

namespace vrda {

/// Whether the first word is a number, as no Wavefront file's is.
bool is_vertices_faces(const std::string& bytes);

/// Indices count from 0 where index 0 occurs, from 1 where the vertex count occurs as an index, and from
/// 0 where neither does. Throws InputError naming file and line.
RawMesh read_vertices_faces(const std::string& file, const std::string& bytes);

}  // namespace vrda
