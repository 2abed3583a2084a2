// Bytes of a mesh file to vertices and triangles, by assimp; checks of what assimp accepts silently.
#include <assimp/BaseImporter.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/document.hpp"
#include "job/raw_mesh.hpp"
#include "job/vf_file.hpp"

namespace vrda::job {
namespace {

// Prevents importers from opening other files.
class NoOtherFiles : public Assimp::IOSystem {
 public:
  bool Exists(const char* /*name*/) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* /*name*/, const char* /*mode*/) override { return nullptr; }
  void Close(Assimp::IOStream* /*stream*/) override {}
};

// assimp registers about fifty importers: removes all except the one for this extension.
void keep_only(Assimp::Importer& importer, const std::string& extension)
{
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    Assimp::BaseImporter* loader = importer.GetImporter(i);
    if (loader->GetInfo()->mFileExtensions == extension) continue;
    importer.UnregisterLoader(loader);
    delete loader;  // unregistering transfers ownership
  }
  check(importer.GetImporterCount() == 1, "assimp must have exactly one importer for this extension");
}

void append_mesh(RawMesh& mesh, const aiMesh& part, bool& has_normals)
{
  const Eigen::Index first = mesh.vertices.rows();
  const auto n = static_cast<Eigen::Index>(part.mNumVertices);
  mesh.vertices.conservativeResize(first + n, 3);
  mesh.normals.conservativeResize(first + n, 3);
  has_normals = has_normals && part.mNormals != nullptr;
  for (Eigen::Index v = 0; v < n; ++v) {
    const aiVector3D& p = part.mVertices[v];
    const aiVector3D normal = part.mNormals == nullptr ? aiVector3D() : part.mNormals[v];
    mesh.vertices.row(first + v) << static_cast<double>(p.x), static_cast<double>(p.y),
        static_cast<double>(p.z);
    mesh.normals.row(first + v) << static_cast<double>(normal.x), static_cast<double>(normal.y),
        static_cast<double>(normal.z);
  }
  for (unsigned int f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices < 3) continue;  // points and lines
    mesh.size.push_back(static_cast<std::int32_t>(face.mNumIndices));
    for (unsigned int k = 0; k < face.mNumIndices; ++k) {
      mesh.corner.push_back(static_cast<std::int32_t>(first) + static_cast<std::int32_t>(face.mIndices[k]));
    }
  }
}

RawMesh read_with_assimp(const std::string& file, const std::string& bytes, const std::string& extension)
{
  Assimp::Importer importer;
  importer.SetIOHandler(new NoOtherFiles);  // the importer owns it
  keep_only(importer, extension);
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, extension.c_str());
  if (scene == nullptr) {
    throw InputError({file, "",
                      "a file that cannot be parsed (" + std::string(importer.GetErrorString()) + ")",
                      "a complete " + extension + " file"});
  }
  RawMesh mesh;
  bool has_normals = extension != "stl";  // STL normals belong to facets, not to vertices
  for (unsigned int m = 0; m < scene->mNumMeshes; ++m) append_mesh(mesh, *scene->mMeshes[m], has_normals);
  if (!has_normals) mesh.normals.resize(0, 3);
  return mesh;
}

void check_mesh(const std::string& file, const RawMesh& mesh)
{
  if (mesh.size.empty()) {
    throw InputError({file, "",
                      "an empty mesh: " + std::to_string(mesh.vertices.rows()) + " vertices and no face",
                      "a mesh with faces"});
  }
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const bool is_far = !(mesh.vertices.row(v).cwiseAbs().maxCoeff() <= largest_coordinate);
    if (mesh.vertices.row(v).allFinite() && !is_far) continue;
    const auto p = mesh.vertices.row(v);
    throw InputError({file, "vertex " + std::to_string(v),
                      "(" + shortest_decimal(p.x()) + ", " + shortest_decimal(p.y()) + ", " +
                          shortest_decimal(p.z()) + ")",
                      "three finite numbers of at most 1e9 in size"});
  }
  std::size_t corner = 0;
  for (std::size_t f = 0; f < mesh.size.size(); ++f) {
    if (mesh.size[f] > static_cast<std::int32_t>(largest_face_size)) {
      throw InputError({file, "face " + std::to_string(f), std::to_string(mesh.size[f]) + " corners",
                        "at most " + std::to_string(largest_face_size)});
    }
    for (std::int32_t k = 0; k < mesh.size[f]; ++k, ++corner) {
      if (mesh.corner[corner] >= 0 && mesh.corner[corner] < mesh.vertices.rows()) continue;
      throw InputError({file, "face " + std::to_string(f),
                        "vertex index " + std::to_string(mesh.corner[corner]),
                        "an index of " + std::to_string(mesh.vertices.rows()) + " vertices"});
    }
  }
}

std::string lower_extension(const std::string& file)
{
  return lower_case(std::filesystem::path(file).extension().string());
}

RawMesh read_by_extension(const std::string& file, std::string bytes)
{
  const std::string extension = lower_extension(file);
  if (extension == ".stl") return read_with_assimp(file, checked_stl(file, std::move(bytes)), "stl");
  if (extension == ".ply") return read_ply(file, bytes);
  if (extension == ".vf" || (extension == ".obj" && is_vertices_faces(bytes)))
    return read_vertices_faces(file, bytes);
  if (extension == ".obj") return read_with_assimp(file, checked_wavefront(file, bytes), "obj");
  throw InputError({file, "", "the extension \"" + extension + "\"", "a mesh file: .stl, .ply, .obj or .vf"});
}

}  // namespace

RawMesh read_mesh(const std::string& file, std::string bytes)
{
  if (bytes.empty()) throw InputError({file, "", "an empty file", "a mesh"});
  RawMesh mesh = read_by_extension(file, std::move(bytes));
  check_mesh(file, mesh);
  return mesh;
}

}  // namespace vrda::job
