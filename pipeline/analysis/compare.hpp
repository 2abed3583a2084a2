/// Compares smoothing degrees: residual, prediction error, roughness, and gap and penetration of the motion.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/recommend.hpp"
#include "analysis/smooth.hpp"
#include "store/evaluate_smoothed.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// Audit figures of the attitudes that count; lengths are NaN without any.
struct AuditTotals {
  int n_attitudes = 0;      ///< with all surrounding cells of the model solved
  int n_overlapping = 0;    ///< of these
  int n_nothing_ahead = 0;  ///< of these: free, without a contact along Delta
  double largest_penetration_mm = 0.0;
  double largest_gap_mm = 0.0;  ///< of the free ones with a contact ahead
};

struct MotionAuditTotals {
  AuditTotals at_grid;  ///< attitudes of the model's grid
  AuditTotals between;  ///< attitudes between them
};

/// Ignores attitudes next to a failed cell, where a smoothed motion has a pose without data.
MotionAuditTotals motion_audit_totals(const store::MotionModel& model, const store::AuditSet& audit);

/// Root mean square of the second derivatives over the measured range: the square root of the mean over
/// flexion f and varus w of s_ff^2 + 2 s_fw^2 + s_ww^2 (a thin plate's energy, invariant to rotation of the
/// two axes). 0 for a plane. An axis with one value adds nothing. Unit: that of the surface per degree
/// squared. Exact: derivatives of a Legendre series are Legendre series, which are orthogonal. Source: Green,
/// Silverman (1994), Nonparametric Regression and Generalized Linear Models, 7.4.
double roughness(const store::SmoothedSet& set, const store::SmoothedSurface& surface,
                 const store::AxisRanges& ranges);

/// Root mean square of the second derivative by flexion over the measured range, per degree squared: the
/// second difference over one degree. Exact, as roughness().
double flexion_roughness(const store::SmoothedSet& set, const store::SmoothedSurface& surface,
                         const store::AxisRanges& ranges);

/// Errors of a smoothed surface against the raw one, in mm or degrees.
struct ErrorMeasures {
  double rms = 0.0;            ///< root mean square of the residual
  double largest = 0.0;        ///< largest absolute residual
  double leave_one_out = 0.0;  ///< root mean square; NaN if a cell cannot be omitted
  double roughness = 0.0;      ///< roughness(), mm or degrees per degree squared
};

struct SurfaceRow {
  std::string name;  ///< "tx", "ty", "tz", "theta"; "varus" if varus was free
  std::int32_t n_cells = 0;
  double condition_number = 0.0;
  ErrorMeasures errors;
};

/// The measures of one degree.
struct DegreeRow {
  store::SmoothedSet set;            ///< with recontact_mm if requested
  std::vector<SurfaceRow> surfaces;  ///< in the order of set.surfaces
  ErrorMeasures translation;         ///< of the vector (tx, ty, tz)
  bool is_converged = true;          ///< false if the Huber weights reached the iteration limit
  /// Share of the solved attitudes with an error of the motion above perceptible_mm, or above perceptible_rad
  /// in an angle that is fitted there. With recontact, the share of the recontacted motion.
  double perceptible_share = 0.0;
  std::optional<MotionAuditTotals> audit_totals;  ///< if an audit was requested
  double second_difference = 0.0;  ///< RMS over one degree of flexion, of the pose in perceptible errors
  std::optional<ContactFigures> contact;  ///< if requested
};

/// Audits the set "degree_N" or "degree_N_recontacted" of `model`; implemented by the `audit` room.
using AuditMotion = std::function<store::AuditSet(const store::MotionModel& model, const std::string& set)>;
/// Travel along Delta into contact at the attitudes of the grid, mm; implemented by the `audit` room.
using Recontact = std::function<store::GridD(const store::MotionModel& model, const store::SmoothedSet& set)>;

/// Moves the motion of `set` into contact, two-sided or along Delta without compartments, and measures it;
/// implemented by the `app` room.
using MeasureContact =
    std::function<ContactFigures(const store::MotionModel& model, const store::SmoothedSet& set)>;

struct CompareOptions {
  std::string name;                                                 ///< model name for messages
  std::vector<int> degrees{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};  ///< ascending, each at most 20
  analysis::SmoothOptions smooth;
  AuditMotion audit;       ///< empty: no audit
  Recontact recontact;     ///< empty: no recontact
  MeasureContact contact;  ///< empty: contact does not affect the recommendation
};

struct Comparison {
  std::vector<DegreeRow> rows;            ///< by ascending degree
  std::vector<int> undetermined_degrees;  ///< requested, but too high for the solved cells
  Recommendation recommendation;
};

/// Smooths `model` (ignoring its own smoothed sets) with each degree that its cells determine.
/// The recommendation leaves out blocks (correlated_block() of the degree with the smallest leave-one-out
/// error). The error of a cell is that of its pose: square of (translation / perceptible_mm) plus those
/// of (angle / perceptible_rad) for angles fitted under every degree. With robust smoothing large errors
/// count with Huber's loss: linear above 1.345 scales, with the smallest scale of all degrees. Throws
/// InputError if the cells do not determine the lowest degree.
Comparison compare(const store::MotionModel& model, const CompareOptions& options);

}  // namespace vrda::analysis
