/// The bound on the size of a generated mesh.
#pragma once

#include <string>

namespace vrda::geometry {

/// Throws InputError with the shape's `parameter` as its field if a mesh of up to `n_triangles`, estimated
/// before it is made, has more than two million: some seconds and a gigabyte.
void require_moderate_size(double n_triangles, const std::string& parameter);

}  // namespace vrda::geometry
