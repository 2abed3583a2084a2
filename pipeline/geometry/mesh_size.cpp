#include "geometry/mesh_size.hpp"

#include <cstdio>

#include "core/error.hpp"

namespace vrda::geometry {

void require_moderate_size(double n_triangles, const std::string& parameter)
{
  constexpr double most_millions = 2.0;
  if (n_triangles <= 1e6 * most_millions) return;
  char found[64];
  std::snprintf(found, sizeof found, "a mesh of up to %.3g million triangles", 1e-6 * n_triangles);
  throw InputError({"shape", parameter, found, "a value for at most 2 million"});
}

}  // namespace vrda::geometry
