/// Warnings about implausible ligament fibres at the pose of the meshes.
#pragma once

#include "load/case_ligaments.hpp"

namespace vrda::load {

/// One sentence for each kind, naming the first such fibre: attachments far from their object or from the
/// rest of their bundle, strains outside the physiological range, stiffnesses that are probably in N/mm.
std::vector<std::string> fibre_warnings(const LoadedLigaments& loaded, const Body& reference,
                                        const Body& moving);

}  // namespace vrda::load
