/// Whether the surfaces that face each other are those of a ball in a socket.
#pragma once

#include "job/case.hpp"
#include "job/condyles.hpp"

namespace vrda::job {

struct BallFit {
  Sphere sphere;        ///< least squares through the facing vertices of the moving object
  double rms_mm = 0.0;  ///< distance of these vertices from it
  bool is_ball = false;
};

/// At the pose of the meshes: the vertices of the moving object whose distance from the reference is at most
/// 4 mm above the smallest. A ball: they are within 4 % of the radius of one sphere (RMS), cover a good part
/// of it, and its radius is 5 to 60 mm. Nothing if fewer than 20 vertices.
std::optional<BallFit> ball_fit(const Case& loaded);

/// One sentence if the kind of the joint contradicts the shape, else empty.
std::string joint_shape_warning(const std::string& joint, const Case& loaded);

}  // namespace vrda::job
