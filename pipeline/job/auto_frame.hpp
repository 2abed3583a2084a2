/// `origin = "auto"` and `align = "auto"` of a knee's bodies: the generic template registered onto their
/// bones.
#pragma once

#include <optional>

#include "job/case.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "model/mesh.hpp"

namespace vrda::job {

struct AutoFrames {
  FoundFrames frames;
  std::vector<std::string> warnings;  ///< a side that the bones contradict, short bones
};

/// Absent if no frame of the job is "auto". The mesh files of both bodies must show the bones in one pose.
/// Numbers are rounded to 1e-7 degrees and 1e-6 mm, so that a job with these numbers is the same job.
/// Throws InputError naming the key for bones that are not those of one knee.
std::optional<AutoFrames> auto_frames(const Job& job, ComponentLoader& source);

/// The frame of the joint or of a body (schemas/frames.md) at a key of a validated job.
FrameJob frame_at(const core::DocumentValue& root, const std::string& key);

/// The frame of "reference" or "moving"; absent if the body has none. Throws InputError for "auto" in another
/// joint than a knee, and for axes next to `align = "auto"`.
std::optional<FrameJob> body_frame_at(const core::Document& document, const std::string& body);

/// Replaces "auto" in the document and in the body by what was found.
void set_found_frame(core::Document& document, BodyJob& body, const FoundFrame& found);

// Sphere fits to the femoral condyles: an estimate of a knee's flexion axis.

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

// Whether the surfaces that face each other are those of a ball in a socket.

struct BallFit {
  Sphere sphere;        ///< least squares through the facing vertices of the moving object
  double rms_mm = 0.0;  ///< distance of these vertices from it
  bool is_ball = false;
};

/// At the pose of the meshes: the vertices of the moving object whose distance from the reference is at most
/// 4 mm above the smallest. A ball: they are within 4 % of the radius of one sphere (RMS), cover a good part
/// of it, and its radius is 5 to 60 mm. Nothing if fewer than 20 vertices.
std::optional<BallFit> ball_fit(const Case& loaded);

/// The sphere of the head that either object has in the other's socket: from ball_fit() on by iterated least
/// squares of the faces on the sphere, without fovea and neck. Nothing if there is no head.
std::optional<Sphere> head_sphere(const Case& loaded);

/// One sentence if the kind of the joint contradicts the shape, else empty.
std::string joint_shape_warning(const std::string& joint, const Case& loaded);

}  // namespace vrda::job
