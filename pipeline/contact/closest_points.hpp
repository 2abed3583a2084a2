/// Closest points of two triangles in closed form: which pairs of features are close, before the narrow
/// phase.
#pragma once

#include <optional>

#include "contact/narrow_phase.hpp"

namespace vrda::contact {

/// Distance and closest points of the bare triangles, by the pairs of their features. Empty where the line
/// between the points does not prove the triangles apart by more than rounding: they overlap, are nearer than
/// about 1e-8 mm or degenerate, and only the narrow phase decides.
std::optional<TriangleDistance> closest_points(const proximity::Corners& reference,
                                               const proximity::Corners& moving);

}  // namespace vrda::contact
