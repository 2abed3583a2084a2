/// Warnings about valid jobs that are probably not intended.
#pragma once

#include "load/axis_map.hpp"
#include "load/case_ligaments.hpp"
#include "load/job.hpp"

namespace vrda::load {

/// One sentence each, in a fixed order: settings, then components.
std::vector<std::string> case_warnings(const Job& job, const Case& loaded);

/// Implausible ligament fibres at the pose of the meshes: one sentence for each kind, naming the first such
/// fibre: attachments far from their object or from the rest of their bundle, strains outside the
/// physiological range, stiffnesses that are probably in N/mm.
std::vector<std::string> fibre_warnings(const LoadedLigaments& loaded, const Body& reference,
                                        const Body& moving);

/// The axes, the side and the rotation centre of a joint, judged from its geometry: one sentence each, with
/// the value to write into the job: axes, side, then rotation centre. `loaded` must be unscaled (factor 1),
/// so that positions agree with the mesh files.
std::vector<std::string> anatomy_warnings(const Job& job, const Case& loaded);

}  // namespace vrda::load
