/// Thickness of cartilage where a scan shows bones only.
#pragma once

#include "registration/knee_fit.hpp"

namespace vrda::prepare {

/// Mean over both compartments of the gap between the bones along the tibia's axis in the pose of the scan.
/// NaN where a compartment has no bone above it.
double scanned_gap_mm(const registration::KneeFit& fit, const registration::KneeSurfaces& subject);

/// The part of that gap that is cartilage: both layers together are 1.5 to 5 mm thick.
double cartilage_in_gap_mm(double gap_mm);

}  // namespace vrda::prepare
