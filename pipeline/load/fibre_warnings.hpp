/// What looks unintended about ligament fibres on the pose of the meshes.
#pragma once

#include "load/case_ligaments.hpp"

namespace vrda {

/// One sentence a kind, naming the first fibre it holds for: attachments far from their object or from the
/// rest of their bundle, strains no ligament has, stiffnesses that look like N/mm.
std::vector<std::string> fibre_warnings(const LoadedLigaments& loaded, const Body& reference,
                                        const Body& moving);

}  // namespace vrda
