/// What the panels say of a set of the motion model: its name, its gaps, its rotation.
#pragma once

#include <string>
#include <vector>

#include "model/frames.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::view {

enum class GapSource {
  none,         ///< no data for this set; an audit would provide it
  two_sided,    ///< gaps stored with the two-sided motion, interpolated linearly
  cells,        ///< solver gaps at the cells, interpolated linearly; set "raw" only
  audit,        ///< the nearest audited attitude of the set
  travel,       ///< travel into contact at the cells, interpolated linearly; for a set that was recontacted
  recontacted,  ///< zero at the cells by construction
};

/// mm; NaN if unknown.
struct GapReading {
  GapSource source = GapSource::none;
  OfCompartments<double> compartment_mm{nan, nan};  ///< for sources `cells`, `two_sided`
  double gap_mm = nan, penetration_mm = nan;        ///< for other sources: one is 0, or both are NaN
};

/// Reads the gaps of one set. `model` must outlive it.
class GapReader {
 public:
  GapReader(const store::MotionModel& model, const std::string& set);
  /// The pose must be of the set. Allocates nothing.
  GapReading at(const store::JointPose& pose) const;
  /// Of a grid; `attitude` must be within its range. Allocates nothing.
  GapReading at(const Attitude& attitude) const;

 private:
  GapReading at_frame(double key) const;

  bool has_cells_ = false;
  const store::TwoSided* two_sided_ = nullptr;
  const store::AuditSet* audit_ = nullptr;
  const store::GridD* travel_mm_ = nullptr;
  bool is_recontacted_ = false;
  const store::MotionModel& model_;
};

/// A curve at evenly spaced positions of the timeline; NaN: none there.
struct CurveLine {
  std::string name;
  std::vector<float> values, low = {}, high = {};  ///< without a band the last two are empty
  float width_px = 1.5F;
};

/// Internal rotation of the shown motion and, thin, of the bones alone, degrees.
struct RotationPlots {
  std::vector<std::vector<CurveLine>> of_sets;  ///< empty for a model without a prior
  double first_flexion_rad = 0.0, last_flexion_rad = 0.0;
};

/// At the balanced varus of each of `sets`.
RotationPlots rotation_plots(const store::MotionModel& model, const std::vector<std::string>& sets);

/// Display name of a set: "degree_6_recontacted" gives "degree 6, recontacted".
std::string set_label(const std::string& set);

}  // namespace vrda::view
