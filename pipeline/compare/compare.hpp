/// Smoothing degrees side by side: what each leaves, predicts, bends, and does to the surfaces in contact.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compare/recommend.hpp"
#include "smooth/smooth.hpp"
#include "store/evaluate_smoothed.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// NaN where no attitude counts.
struct Faults {
  int n_attitudes = 0;      ///< that count: all cells of the model around them are solved
  int n_overlapping = 0;    ///< of them
  int n_nothing_ahead = 0;  ///< of them: free, and no touch anywhere along Delta
  double largest_penetration_mm = 0.0;
  double largest_gap_mm = 0.0;  ///< of those free with a touch ahead
};

struct MotionFaults {
  Faults at_grid;  ///< attitudes of the model's grid
  Faults between;  ///< the others
};

/// Where a cell failed a smoothed motion has a pose without data: such attitudes do not count.
MotionFaults faults_of(const MotionModel& model, const AuditSet& audit);

/// Root mean square of the second derivatives over the measured range: the square root of the mean over
/// flexion f and varus w of s_ff^2 + 2 s_fw^2 + s_ww^2 (a thin plate's energy, the same whichever way the two
/// axes are turned). 0 of a plane. An axis with one value adds nothing. Unit: that of the surface over a
/// degree squared, mm/degree^2. Exact: a derivative of a Legendre series is one, and these are orthogonal.
/// Source: Green, Silverman (1994), Nonparametric Regression and Generalized Linear Models, 7.4.
double roughness(const SmoothedSet& set, const SmoothedSurface& surface, const AxisRanges& ranges);

/// What a smoothed surface does to the raw one, in mm or degrees.
struct ErrorMeasures {
  double rms = 0.0;            ///< residual, root mean square
  double largest = 0.0;        ///< residual, absolute
  double leave_one_out = 0.0;  ///< root mean square; NaN where some cell cannot be left out
  double roughness = 0.0;      ///< roughness(); mm or degrees, over a degree squared
};

struct SurfaceRow {
  std::string name;  ///< "tx", "ty", "tz", "theta", where varus was free "varus"
  std::int32_t n_cells = 0;
  double condition_number = 0.0;
  ErrorMeasures errors;
};

/// One degree.
struct DegreeRow {
  SmoothedSet set;                   ///< with recontact_mm where that was asked for
  std::vector<SurfaceRow> surfaces;  ///< in the order of set.surfaces
  ErrorMeasures translation;         ///< of the vector (tx, ty, tz): its length, roughness as one vector
  bool is_converged = true;          ///< false where the steps to Huber's weights met their limit
  /// Share of the solved attitudes where the motion is off by more than perceptible_mm, or by more than
  /// perceptible_deg in an angle that is fitted there. With recontact that of the recontacted motion.
  double perceptible_share = 0.0;
  std::optional<MotionFaults> faults;  ///< where an audit was asked for
};

/// Gap and penetration of the set "degree_N" or "degree_N_recontacted" of `model`: the `audit` room.
using AuditMotion = std::function<AuditSet(const MotionModel& model, const std::string& set)>;
/// Travel along Delta into contact at the attitudes of the grid, mm: the `audit` room.
using Recontact = std::function<GridD(const MotionModel& model, const SmoothedSet& set)>;

struct CompareOptions {
  std::string name;                                                 ///< of the model, for messages
  std::vector<int> degrees{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};  ///< rising, each at most 20
  SmoothOptions smooth;
  AuditMotion audit;    ///< empty: no faults
  Recontact recontact;  ///< empty: the smoothed motion itself
};

struct Comparison {
  std::vector<DegreeRow> rows;           ///< by rising degree
  std::vector<int> degrees_not_carried;  ///< asked for, and too high for the solved cells
  Recommendation recommendation;
};

/// Smooths `model`, whose own smoothed sets play no part, by each degree that its cells can carry.
/// The error of a left-out cell is that of its pose: square of (translation / perceptible_mm) plus those of
/// (angle / perceptible_deg), where the angle is fitted under every degree. With robust smoothing errors far
/// off count with their Huber loss: from 1.345 scales on they grow linearly, the scale being the smallest
/// that any degree has.
/// Throws InputError when the cells cannot carry even the lowest degree.
Comparison compare(const MotionModel& model, const CompareOptions& options);

}  // namespace vrda
