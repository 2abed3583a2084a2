/// Where a knee's flexion axis should lie, judged from the shape of its reference object.
#pragma once

#include <optional>

#include "core/mesh.hpp"

namespace vrda {

struct Sphere {
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
};

struct CondyleSpheres {
  Sphere left;  ///< of the half with the smaller canonical z
  Sphere right;
};

/// Spheres through the posterior-distal faces of both halves of a femoral surface (canonical axes, near
/// extension; of a whole bone its lower end), by least squares weighted with face area, faces off the sphere
/// left out in turn. On the four real knees their middle lies within 5 mm of an independent fit. Nothing when
/// a half has too few such faces or they do not settle on a sphere of a condyle's size (5 to 60 mm).
std::optional<CondyleSpheres> condyle_spheres(const Mesh& femur);

}  // namespace vrda
