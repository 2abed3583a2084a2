/// Two triangles in closed form: whether they share a point, and where they are closest.
#pragma once

#include "contact/narrow_phase.hpp"

namespace vrda {

/// How far the best of the directions that can part two triangles (both normals, cross products of edges,
/// normals of edges within their planes) keeps them apart: positive when they share no point, negative when
/// each direction finds them overlapping by as much at least. Good to rounding.
double separation_mm(const Corners& a, const Corners& b);

/// The nearest of all corners, edges and faces of two triangles that share no point; good to rounding. Where
/// closest points are not unique (parallel edges or faces) it is the end of a common stretch.
TriangleDistance closest_points(const Corners& reference, const Corners& moving);

}  // namespace vrda
