/// Where eyes roughly are: where a fit can begin, whatever way a tracked body is turned.
#pragma once

#include <span>

#include "calibration/eyes_fit.hpp"

namespace vrda {

/// X_carrier_eyes of eyes that are taken as known, from any attitude: orthogonal iteration from the 24
/// attitudes of a cube; the answer of the least distance of the marks from their sights, with all marks in
/// front of the eyes where there is one. Identity for fewer than three marks.
/// Source: Lu, Hager, Mjolsness (2000) IEEE PAMI 22:610-622. Differs: two eyes, so that depth is told, too.
Pose eyes_start(std::span<const BullseyeMark> marks, const EyePair& eyes);

}  // namespace vrda
