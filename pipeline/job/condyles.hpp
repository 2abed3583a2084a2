/// Sphere fits to the femoral condyles: an estimate of a knee's flexion axis.
#pragma once

#include <optional>

#include "model/mesh.hpp"

namespace vrda::job {

struct Sphere {
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
};

struct CondyleSpheres {
  Sphere left;  ///< the half with the smaller canonical z
  Sphere right;
};

/// Spheres through the posterior-distal faces of both halves of a femoral surface (canonical axes, near
/// extension; the lower end of a whole bone). Iterated least squares weighted by face area, without faces off
/// the sphere. On four real knees the midpoint is within 5 mm of an independent fit. Returns nothing if a
/// half has too few faces or the radius is outside 5 to 60 mm.
std::optional<CondyleSpheres> condyle_spheres(const Mesh& femur);

}  // namespace vrda::job
