/// The stability search of the thesis (3.2 to 3.7; DESIGN.md 5.1): the pose at which the moving object,
/// pushed along Delta against the reference, neither turns nor slides any more.
#pragma once

#include <functional>

#include "core/search_move.hpp"
#include "core/search_options.hpp"
#include "core/step_record.hpp"
#include "solve/joint.hpp"

namespace vrda {

/// Told of every move, in order.
using Watch = std::function<void(const SearchMove&)>;

/// Solves one motion step from `seed`. The key of the result is left as it is by default; a pose that is
/// `stable` never overlaps, and touches within the translation resolution. Pure: same input, same bits.
/// Source: thesis 3.2 to 3.7. Differs: travel along Delta is measured exactly instead of stepped, normals
/// come from the side of least curvature, and a step is restored only by a motion that led somewhere new.
StepRecord find_stable_pose(const Joint& joint, const Attitude& attitude, const MovingPose& seed,
                            const SearchOptions& options, const Watch& watch = {});

}  // namespace vrda
