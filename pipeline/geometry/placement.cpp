#include "geometry/placement.hpp"

#include <utility>

namespace vrda::geometry {

TreeMesh make_tree_mesh(Mesh mesh)
{
  TreeMesh result{std::move(mesh), {}};
  result.tree = BoxTree(result.mesh);
  return result;
}

TreeMesh rotated_reference(const TreeMesh& reference, const Attitude& attitude)
{
  Pose X = Pose::Identity();
  X.linear() = reference_rotation(attitude);
  TreeMesh result{transformed(reference.mesh, X), reference.tree};
  result.tree.refit(result.mesh);
  return result;
}

}  // namespace vrda::geometry
