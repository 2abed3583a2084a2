/// Warnings about valid jobs that are probably not intended.
#pragma once

#include <optional>

#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"

namespace vrda::job {

/// The value in steps of 1 / steps_per_unit, without a negative zero.
std::string rounded_text(double value, double steps_per_unit);

/// One sentence each, in a fixed order: settings, then components.
std::vector<std::string> case_warnings(const Job& job, const Case& loaded);

/// Implausible ligament fibres at the pose of the meshes: one sentence for each kind, naming the first such
/// fibre: attachments far from their object or from the rest of their bundle, strains outside the
/// physiological range, stiffnesses outside the bounds of schemas/ligaments.md; of a knee also ligaments that
/// are missing or slack. Uses the bodies of `job_case`.
std::vector<std::string> fibre_warnings(const LoadedLigaments& loaded, const Case& job_case);

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

}  // namespace vrda::job
