#include "geometry/gap_tree.hpp"

#include <numeric>
#include <utility>

#include "geometry/gap_kernel.hpp"

namespace vrda::geometry {
namespace {

std::vector<std::int32_t> all_rows(const Mesh& mesh)
{
  std::vector<std::int32_t> rows(static_cast<std::size_t>(mesh.triangles.rows()));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

std::vector<ExactFace> exact_faces(const Mesh& mesh)
{
  std::vector<ExactFace> faces(static_cast<std::size_t>(mesh.triangles.rows()));
  for (std::size_t t = 0; t < faces.size(); ++t) {
    const Corners c = corners(mesh, static_cast<Eigen::Index>(t));
    faces[t] = {c, doubled_area(c), least_screened_area(c), offset_mm(mesh, static_cast<Eigen::Index>(t))};
  }
  return faces;
}

}  // namespace

GapTree::GapTree(const Mesh& mesh) : GapTree(mesh, all_rows(mesh)) {}

GapTree::GapTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles)
{
  auto data = std::make_shared<Data>();
  data->surface = gap_surface(mesh, triangles);
  data->faces = exact_faces(mesh);
  std::vector<bool> looks_up(data->faces.size());
  for (const std::int32_t t : data->surface.triangles) {
    const ExactFace& face = data->faces[static_cast<std::size_t>(t)];
    if (!gap_face(face.corner, face.doubled_area).faces_up()) continue;
    looks_up[static_cast<std::size_t>(t)] = true;
    data->up.push_back(t);
  }
  data->up_edges.assign(data->faces.size(), 0);
  for (const std::int32_t t : data->up) {
    data->up_edges[static_cast<std::size_t>(t)] = first_contact_edges(data->surface, t, looks_up);
  }
  if (mesh.vertices_mm.rows() > 0) data->radius_mm = mesh.vertices_mm.rowwise().norm().maxCoeff();
  data->offset_mm = largest_offset_mm(mesh);
  data_ = std::move(data);
}

bool GapTree::is_empty() const
{
  return data_ == nullptr || data_->surface.triangles.empty();
}

}  // namespace vrda::geometry
