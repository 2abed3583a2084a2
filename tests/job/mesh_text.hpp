/// Mesh files as bytes and small jobs as text.
#pragma once

#include <string>
#include <vector>

#include "job/case.hpp"
#include "job/mesh_file.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

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

/// The triangles of a mesh as polygons of a file; `soup_of`: with unshared vertices, as in an STL file.
job::RawMesh raw_of(const Mesh& mesh);
job::RawMesh soup_of(const Mesh& mesh);

/// A folder with "job.toml" and the meshes of small_job(): by default two boxes 20 mm apart.
struct JobFolder {
  Scratch scratch;
  std::string job;

  explicit JobFolder(const std::string& text = small_job("joint = \"other\"\n"),
                     const Mesh& reference = box({0, 40, 0}, {60, 20, 80}),
                     const Mesh& moving = box({0, 0, 0}, {50, 20, 70}));
  job::Case load(const std::vector<std::string>& overrides = {}) const;
  InputError::Facts refused(const std::vector<std::string>& overrides = {}) const;
};

}  // namespace vrda::test
