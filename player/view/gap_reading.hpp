/// How far the objects are apart at an attitude, as far as the motion model says it.
#pragma once

#include <string>

#include "core/frames.hpp"
#include "store/motion_model.hpp"

namespace vrda {

enum class GapSource {
  none,         ///< the file says nothing of this set: audit it
  cells,        ///< what the solver left at the cells, linear between them; of the set "raw"
  audit,        ///< of the nearest attitude that an audit of the set measured
  travel,       ///< the way into contact at the cells, linear between them; of a set that was recontacted
  recontacted,  ///< none at the cells, by construction
};

/// mm; NaN where there is no number.
struct GapReading {
  GapSource source = GapSource::none;
  double medial_mm = 0.0, lateral_mm = 0.0;   ///< of cells
  double gap_mm = 0.0, penetration_mm = 0.0;  ///< of all other sources: one is 0, or both are NaN
};

/// One set's readings. `model` must outlive it.
class GapReader {
 public:
  GapReader(const MotionModel& model, const std::string& set);
  /// `attitude` within the measured range. Allocates nothing.
  GapReading at(const Attitude& attitude) const;

 private:
  bool has_cells_ = false;
  const AuditSet* audit_ = nullptr;
  const GridD* travel_mm_ = nullptr;
  bool is_recontacted_ = false;
  const MotionModel& model_;
};

}  // namespace vrda
