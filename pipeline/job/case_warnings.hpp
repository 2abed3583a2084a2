/// Warnings about valid jobs that are probably not intended.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "job/case.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"

namespace vrda::job {

/// One sentence each, in a fixed order: settings, then components.
std::vector<std::string> case_warnings(const Job& job, const Case& loaded);

/// Implausible ligament fibres at the pose of the meshes: one sentence for each kind, naming the first such
/// fibre: attachments far from their object or from the rest of their bundle, strains outside the
/// physiological range, stiffnesses outside the bounds of schemas/ligaments.md; of a knee also ligaments that
/// are missing or slack. Uses the bodies of `job_case`.
std::vector<std::string> fibre_warnings(const LoadedLigaments& loaded, const Case& job_case);

/// Fibres that are more than 2 mm inside bone at the pose of the meshes: one sentence, naming the deepest.
/// Not a part of a case's warnings, which are kept in motion models: `vrda check` says it with the ligaments.
std::vector<std::string> bone_crossing_warnings(const Case& job_case);

/// The side of the knee whose collateral ligaments are where those of the case are, by the names of bundles
/// (model::ligament_of). Empty for other joints, without collaterals, and for less than 15 mm of distance.
std::optional<Side> collateral_side(const Case& job_case);

/// "MCL" or "LCL" if both are on one side of a knee, at least 15 mm from its middle: the one that is not on
/// its own side. Else empty.
std::string misplaced_collateral(const Case& job_case, Side side);

/// Components of a joint's mesh files that are too coarse, too noisy or too full of holes in the joint space
/// for a pose (schemas/frames.md): one sentence each, with the number and its effect. None of joint "other".
std::vector<std::string> mesh_warnings(const Job& job, const Case& loaded);

/// Whether single precision at the distance of a file's vertices (`native`, in its unit) from its origin
/// makes steps that change a pose; empty if not, or if its numbers are more precise.
std::string coordinate_warning(const ComponentSurvey& survey, const Points& native, double unit_mm);

/// The axes, the side and the rotation centre of a joint, judged from its geometry: one sentence each, with
/// the value to write into the job: axes, side, then rotation centre. `loaded` must be unscaled (factor 1),
/// so that positions agree with the mesh files.
std::vector<std::string> anatomy_warnings(const Job& job, const Case& loaded);

// Surfaces that probably do not belong: left-overs of a segmentation in the joint space, cartilage of one
// compartment, a surface given twice. `vrda prepare` uses the same functions.

/// A body of which some shells are small beside the largest one of their component (CleanMesh).
struct ShellsOfBody {
  const Mesh& mesh;                                     ///< canonical axes, mm
  std::vector<std::vector<Eigen::Index>> small_shells;  ///< lists of its triangles
};

/// A small shell in the joint space.
struct Speck {
  std::size_t shell = 0;  ///< row of small_shells
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double size_mm = 0.0;      ///< longest edge of its box
  double distance_mm = 0.0;  ///< from the other body, at the pose of the meshes
};

/// Small shells of at most 15 mm that are in the joint space: within 8 mm of the other body at the pose of
/// the meshes, or within 8 mm of the body's own surface where that comes so near to the other body at one of
/// `X_other_body` (poses of the body in the other's frame).
std::vector<Speck> specks_of(const ShellsOfBody& body, const ShellsOfBody& other,
                             const std::vector<Pose>& X_other_body);

/// The reference (`sign` 1) or the moving object (-1) turned about the flexion axis, in the other's frame.
std::vector<Pose> flexed_poses(const Eigen::Vector3d& centre_mm, const std::vector<double>& flexion_deg,
                               double sign);

/// "N triangles, S mm across, at [x, y, z] mm in the axes of the file", at a point in these axes.
std::string speck_text(const Speck& speck, std::size_t n_triangles, const Eigen::Vector3d& file_mm);

/// "at [x, y, z], [x, y, z] mm in the axes of the file": up to three places at least 5 mm apart, and how many
/// others; empty without points.
std::string places_text(const std::vector<Eigen::Vector3d>& points_mm);

/// Share of the smaller of the two sides of z = `centre_z_mm` in the area that faces along `sign` times Y,
/// the part that bears load: 0.5 where both compartments are covered alike, 0 for one compartment only.
double lesser_side_share(const Mesh& mesh, double sign, double centre_z_mm);
/// Below this share of the area, cartilage is that of one compartment. Four real knees: at least 0.4.
inline constexpr double least_side_share = 0.15;

/// The shells of both bodies for `surface_warnings`.
struct SmallShells {
  std::vector<std::vector<Eigen::Index>> reference, moving;
};

/// One sentence each: specks, cartilage of one compartment, and contact surfaces that a body has twice.
/// `loaded` must be unscaled (factor 1).
std::vector<std::string> surface_warnings(const Job& job, const Case& loaded, const SmallShells& small);

// Plausibility of frame.unit: the mesh files must have the size of a joint.

/// Range of component sizes (diagonals of bounding boxes) without a warning.
struct SizeRange {
  double least_mm = 0.0, most_mm = 0.0;
};

SizeRange usual_size_range(const Job& job);

/// The unit in which a component of `size_mm` in `unit` would be within these sizes; empty if none.
std::string suggested_unit(const std::string& unit, double size_mm, const SizeRange& sizes);

double diagonal_mm(const Box& box);

/// The component's body, name and source, as the begin of a message.
std::string named(const ComponentSurvey& component);

/// Throws InputError if the largest mesh file of an object is implausible in the unit of its frame: below 1
/// mm (a knee: 3 mm) or above 3 m. `survey` has the components in the order of the job.
void check_unit(const Job& job, const std::vector<ComponentSurvey>& survey);

}  // namespace vrda::job
