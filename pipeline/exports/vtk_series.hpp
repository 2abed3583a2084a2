/// A flexion motion as ParaView opens it: one .vtp file a flexion, and a .pvd file that lists them.
#pragma once

#include <string>
#include <vector>

#include "exports/flexion_motion.hpp"

namespace vrda {

/// Both bodies as posed in world W (mm, single precision), VTK PolyData in XML with its arrays appended as
/// raw bytes. Cells carry `body` (0 reference, 1 moving), `component`, `material` and `has_contact`; field
/// data the names that `component` and `material` number, the attitude and the clinical numbers.
std::string posed_vtp(const MotionModel& model, const FlexionFrame& frame);

/// The contacts of the raw cell at this frame, as points in world W with `normal`, `distance_mm` and
/// `compartment`; empty where the frame is no cell's pose. Only for a motion of the set "raw".
std::string contacts_vtp(const MotionModel& model, const FlexionFrame& frame);

struct SeriesEntry {
  double flexion_deg = 0.0;
  int part = 0;      ///< 0 bodies, 1 contacts
  std::string file;  ///< relative to the .pvd file
};

/// The list, with the flexion in degrees as its time.
std::string series_pvd(const std::vector<SeriesEntry>& entries);

}  // namespace vrda
