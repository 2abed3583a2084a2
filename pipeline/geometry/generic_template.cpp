// The knee that is registered where no other template is given.
#include "geometry/knee_surfaces.hpp"

#include "geometry/knee.hpp"

namespace vrda::geometry {
namespace {

BoneSurfaces divided(const Mesh& mesh, bool (*is_articular)(const Eigen::Vector3d&, const Eigen::Vector3d&))
{
  std::vector<Eigen::Index> bone, cartilage;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    (is_articular((a + b + c) / 3.0, face_normal(mesh, t)) ? cartilage : bone).push_back(t);
  }
  return {select_triangles(mesh, bone), select_triangles(mesh, cartilage)};
}

}  // namespace

TemplateKnee generic_template()
{
  const geometry::Shape knee = geometry::right_template_knee();
  return {{divided(knee.reference.front().mesh, geometry::is_articular_femur),
           divided(knee.moving.front().mesh, geometry::is_articular_tibia)},
          Eigen::Vector3d::Zero()};
}

}  // namespace vrda::geometry
