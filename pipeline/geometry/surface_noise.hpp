/// Noise of a surface's vertices, and smoothing that removes it without shrinking the surface.
#pragma once

#include <vector>

#include "model/mesh.hpp"

namespace vrda::geometry {

struct SurfaceNoise {
  /// Standard deviation of the vertices across the surface; NaN: not judged, with too few
  /// vertices away from borders, or a thin body with edges above 1.5 mm.
  double noise_mm = 0.0;
  double edge_mm = 0.0;  ///< mean length of an edge, without the noise
  double limit_mm =
      0.0;  ///< the most that clean meshes with such edges have, since curvature looks like noise

  bool is_noisy() const { return noise_mm > limit_mm; }
};

/// By what the Laplacian of the mesh, applied twice, leaves across the surface, each vertex divided by its
/// own gain; the median, which edges of bones do not change. Cost: some sorts of the edges.
SurfaceNoise surface_noise(const Mesh& mesh);

struct SmoothedSurface {
  Mesh mesh;                     ///< with normals computed again
  std::vector<double> moved_mm;  ///< [n_vertices] distance to the vertex before
  int n_passes = 0;
};

/// The mesh smoothed by Taubin's passes, as many as its noise relative to the edges takes; expects a noisy
/// one. Vertices of open borders and of sharp edges (where the noise lets them be found) move along these
/// only, their corners not at all. Does not depend on the order of vertices but by rounding; the mirrored
/// mesh gives the mirrored one. Source: Taubin (1995), Proc. SIGGRAPH, 351-358.
SmoothedSurface smoothed_surface(const Mesh& mesh, const SurfaceNoise& noise);

}  // namespace vrda::geometry
