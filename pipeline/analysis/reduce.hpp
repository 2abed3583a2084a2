/// Reduces a motion over flexion and varus to flexion only, with both condyles in contact.
/// schemas/clinical.md contains every rule and formula.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "analysis/audit.hpp"
#include "model/mesh.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// The zero varus of one flexion. Both columns are solved ones, and equal if the varus is that of a column.
struct VarusChoice {
  store::ZeroVarusSource source = store::ZeroVarusSource::none;
  double varus_deg = std::numeric_limits<double>::quiet_NaN();
  double first_deg = std::numeric_limits<double>::quiet_NaN();  ///< only for both_touch, like last_deg
  double last_deg = std::numeric_limits<double>::quiet_NaN();
  bool is_cut_off = false;             ///< the run of columns reaches the first or last varus of the grid
  Eigen::Index before = 0, after = 0;  ///< columns around it
  double weight_after = 0.0;           ///< weight of `after` in a linear interpolation
};

/// [n_flexion]. If varus was free: the solved varus. Else the mean of the first and last solved column in
/// contact in both compartments; other solved columns between them split them into runs, of which the one
/// nearest to the spine counts. Without such columns: the root nearest to the spine of medial -
/// gap_lateral, linear between neighbouring solved columns. Else none. `raw` is the motion of the model's raw
/// surfaces. Source: thesis 5.4, which has a single run.
std::vector<VarusChoice> varus_choices(const store::MotionModel& model, const store::Motion& raw);

/// Contact of a compartment at one pose. Both points are the same contact.
struct CompartmentContact {
  Pose X_reference_moving = Pose::Identity();
  Eigen::Vector3d p_reference_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_moving_mm = Eigen::Vector3d::Zero();
};

/// Travels are signed lengths in the sagittal plane (X anterior, Y proximal) of the moving body, anterior
/// positive.
struct Rolling {
  double reference_mm = 0.0;  ///< travel of the contact on the reference body
  double moving_mm = 0.0;     ///< travel of the contact on the moving body
  double rolling_mm = 0.0;    ///< common part: the shorter of two travels in the same direction, else 0
  double sliding_mm = 0.0;    ///< moving_mm - reference_mm: forward slip of the reference surface
};

/// Rolling between two contacts. The travel on the reference is rotated into the moving body's axes midway
/// between both poses. Chords approximate arcs: relative error a^2 / 24 for a rotation a.
/// Source: rolling of two bodies on each other; formulas in schemas/clinical.md.
Rolling rolling_between(const CompartmentContact& start, const CompartmentContact& end);

/// True if the joint has compartments or varus was free.
bool is_reducible(const store::MotionModel& model);

/// The flexion-only motion: varus from the raw cells, poses from `set`, one of set_names(model). Poses of
/// "raw" are linear between the two adjacent columns, or those of the cell; contact points always come from
/// the raw cells. The model must be reducible. Flexions without a pose, possibly all, have source none.
store::ZeroVarus reduce(const store::MotionModel& model, const std::string& set);

/// "zero varus at 12 of 91 flexions: ..." if the grid cuts off bands of contact; else empty.
std::string cut_off_warning(const store::ZeroVarus& zero_varus);

/// Number of flexions with a pose.
int n_reduced_flexions(const store::ZeroVarus& zero_varus);

// The motion over flexion alone in which both compartments are in contact (thesis 5.4, 6.2.2).

struct TwoSidedOptions {
  int degree = 6;          ///< of the polynomials of x, z and theta; lowered to what the raw poses determine
  bool is_robust = false;  ///< Huber weights
  double spacing_deg = 0.25;  ///< largest step of the flexion axis, which contains the model's flexions
};

/// Smooths x, z, theta and varus of the raw course over flexion, then finds at each flexion the varus at
/// which the gaps of both compartments are equal, and the position along Delta at which the nearer one is
/// closed, up to contact_margin_mm (analysis/audit.hpp).
///  - Raw course: with the equilibrium the spine with free varus, which does not depend on the varus axis;
///  with the
///    stability search the zero-varus poses of the raw cells.
///  - Where the raw equilibrium lifts a compartment off by more than the contact resolution, the difference
///  of the
///    gaps is kept, linear between the raw flexions.
///  - A flexion has no pose beyond the raw course, and where no varus within 8 degrees of the smooth one
///  closes both
///    gaps.
/// Empty for a sequence of frames, if the joint has no compartments or the raw course has no pose. Bitwise
/// equal for any number of threads.
std::optional<store::TwoSided> two_sided(const store::MotionModel& model, const TwoSidedOptions& options,
                                         const Measuring& with);

}  // namespace vrda::analysis
