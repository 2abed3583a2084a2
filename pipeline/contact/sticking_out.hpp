/// Which vertices of a mesh can be the first to touch a face.
#pragma once

#include <vector>

#include "contact/features.hpp"

namespace vrda {

/// [n_vertices] whether an edge that sticks out, bounds the sheet or is not shared by two consistently wound
/// faces ends there. Around any other vertex the surface is flat or hollow: another place touches a face no
/// later, and the vertex only seems to bear load.
std::vector<bool> sticking_out(const Mesh& mesh, const SurfaceFeatures& features);

}  // namespace vrda
