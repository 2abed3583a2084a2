/// Behaviour of assimp without our checks: the reason for the checks and for our PLY parser. If a row fails
/// after an update of assimp, the corresponding check may be removed.
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <assimp/Importer.hpp>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "job/mesh_file.hpp"
#include "job/mesh_text.hpp"
#include "support/meshes.hpp"

namespace vrda::assimp_alone_test {

struct MeshText {
  const char* what;
  const char* extension;
  std::string bytes;
};

/// Number of face corners; nothing if assimp rejects the file.
std::optional<unsigned> corners_read_by_assimp(const MeshText& text)
{
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(text.bytes.data(), text.bytes.size(), 0, text.extension);
  if (scene == nullptr) return std::nullopt;
  unsigned n_corners = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) n_corners += mesh.mFaces[f].mNumIndices;
  }
  return n_corners;
}

job::RawMesh read(const MeshText& text)
{
  return job::read_mesh(std::string("a.") + text.extension, text.bytes);
}

const std::string facet_begin = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n";
const std::string facet = facet_begin + "endloop\nendfacet\n";
const std::string obj_vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const std::string ply_vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string ply_faces = "element face 1\nproperty list uchar int vertex_indices\n";

std::string ascii_ply(const std::string& header, const std::string& body)
{
  return "ply\nformat ascii 1.0\n" + header + "end_header\n" + body;
}

TEST(AssimpAlone, TakesDamagedFiles)
{
  std::string solid_header = test::binary_stl(test::box({0, 0, 0}, {1, 1, 1}));
  solid_header.replace(0, 5, "solid");
  solid_header.pop_back();
  const std::string xyz = "0 0 0\n1 0 0\n0 1 0\n";
  const std::vector<MeshText> rows{
      {"cut between facets", "stl", "solid a\n" + facet},
      {"four vertices in a facet", "stl",
       "solid a\n" + facet_begin + "vertex 1 1 0\nendloop\nendfacet\n" + facet + "endsolid a\n"},
      {"a decimal comma", "stl",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 1,5 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
       "endfacet\nendsolid a\n"},
      {"a cut binary file whose header begins with solid", "stl", solid_header},
      {"no number", "obj", "v a b c\n" + obj_vertices + "f 1 2 3\n"},
      {"a decimal comma", "obj", "v 1,5 0 0\n" + obj_vertices + "f 1 2 3\n"},
      {"cut within a face", "obj", obj_vertices + "f 1 2 3\nf 1 2"},
      {"an unknown keyword", "obj", obj_vertices + "vv 1 2 3\nf 1 2 3\n"},
      {"a normal that is not there", "obj", obj_vertices + "vn 0 0 1\nf 1//7 2//7 3//7\n"},
      {"cut within the vertices", "ply", ascii_ply(ply_vertices + ply_faces, "0 0 0\n1 0 0\n")},
      {"cut within a face", "ply", ascii_ply(ply_vertices + ply_faces, xyz + "3 0 1")},
      {"an index that is not there", "ply", ascii_ply(ply_vertices + ply_faces, xyz + "3 0 1 7\n")},
  };
  for (const MeshText& row : rows) {
    SCOPED_TRACE(std::string(row.extension) + ": " + row.what);
    EXPECT_TRUE(corners_read_by_assimp(row).has_value());
    EXPECT_THROW(read(row), InputError);
  }
}

TEST(AssimpAlone, RefusesValidFiles)
{
  const std::string xyz = "0 0 0\n1 0 0\n0 1 0\n";
  const std::vector<MeshText> rows{
      {"keywords in capitals", "stl",
       "SOLID A\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 0\nENDLOOP\n"
       "ENDFACET\nENDSOLID A\n"},
      {"a comment after a face", "obj", obj_vertices + "f 1 2 3 # first\n"},
      {"a comment before the format", "ply",
       "ply\ncomment knee\nformat ascii 1.0\n" + ply_vertices + ply_faces + "end_header\n" + xyz +
           "3 0 1 2\n"},
      {"faces before vertices", "ply", ascii_ply(ply_faces + ply_vertices, "3 0 1 2\n" + xyz)},
  };
  for (const MeshText& row : rows) {
    SCOPED_TRACE(std::string(row.extension) + ": " + row.what);
    EXPECT_FALSE(corners_read_by_assimp(row).has_value());
    EXPECT_EQ(read(row).corner, (std::vector<std::int32_t>{0, 1, 2}));
  }
}

}  // namespace vrda::assimp_alone_test
