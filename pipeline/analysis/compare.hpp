/// Properties of the raw motion that bound what a polynomial can reach: steps between neighbouring flexions,
/// variance, correlation of residuals. Lengths count in perceptible errors of 0.145 mm, angles in those of
/// 0.27 degrees.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/smooth.hpp"
#include "core/fields.hpp"
#include "core/units.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// Of surface 0 to 2 (tx, ty, tz) in mm, of the angles after them in degrees, as the surfaces are stored.
inline double perceptible_unit(std::size_t surface)
{
  return surface < 3 ? perceptible_mm : deg_from_rad(perceptible_rad);
}

/// Squared errors below this, of a millionth of a perceptible error, are rounding: 0.1 nanometres.
inline constexpr double rounding_sq = 1e-12;

/// A step between neighbouring flexions that exceeds the steps before and after it.
struct RawJump {
  double size = 0.0;  ///< excess over the longer of both steps, in perceptible errors; 0 without any
  double from_deg = 0.0, to_deg = 0.0;
};

/// A polynomial passes halfway through a step, so every degree is off by half of it on both sides. Facets of
/// the generic knee cause steps of 6 perceptible errors in half of the varus columns, a single outlier none.
inline constexpr double largest_raw_jump = 10.0;

/// Poses as in left_out_errors() (analysis/compare.hpp), in perceptible errors. The excess of a flexion is
/// the median over the varus columns solved at its four neighbouring flexions, so that steps of single cells
/// do not count. `fit` gives the raw values.
RawJump largest_jump(const std::vector<double>& flexion_deg, const SmoothFit& fit);

/// That of the model's raw poses; 0 for a sequence of frames or without solved cells.
RawJump raw_jump(const store::MotionModel& model);

/// "the raw motion jumps by 34 times the perceptible error between flexion 40 and 45 degrees".
std::string jump_text(const RawJump& jump);

/// Mean square of the raw pose about its mean, in squared perceptible errors, over the cells that are fitted.
double raw_variance(const SmoothFit& fit);

/// Blocks whose central cell is farther from all others than the residuals are correlated: 2 L - 1 cells
/// along an axis, where L is the smallest lag at which the autocorrelation of the residuals is below two
/// standard errors of white noise (Bartlett), 2 / sqrt(number of pairs of cells). At most a quarter of the
/// axis: polynomials do not extrapolate far. White noise and rounding give single cells.
BlockSize correlated_block(const SmoothFit& fit);

// Recommends the lowest degree that predicts left-out attitudes as well as the best one, stays in contact
// and is smooth; or none, with the reason.

/// Why a degree, or every degree, does not meet the criteria. Lengths are visible above perceptible_mm.
enum class Fault {
  none,
  not_measurable,  ///< a block of attitudes cannot be left out
  unpredicted,     ///< predicts less than half of the raw motion's variance, with a visible error
  jump,            ///< the raw motion jumps (raw_motion.hpp), so no polynomial follows it
  no_contact,      ///< no pose in contact at some flexion or attitude that another degree has
  overlap,         ///< visible after it was moved into contact, of any side
  gap,             ///< the same
  rough,           ///< a second difference over one degree of flexion is visible
};
inline constexpr Named<Fault> fault_names[] = {{Fault::none, "none"},
                                               {Fault::not_measurable, "not_measurable"},
                                               {Fault::unpredicted, "unpredicted"},
                                               {Fault::jump, "jump"},
                                               {Fault::no_contact, "no_contact"},
                                               {Fault::overlap, "overlap"},
                                               {Fault::gap, "gap"},
                                               {Fault::rough, "rough"}};
constexpr const auto& names_of(Fault)
{
  return fault_names;
}

/// A degree's motion after it was moved into contact: two-sided, or along Delta without compartments.
struct ContactFigures {
  int n_poses = 0;
  int n_lifted_off = 0;  ///< flexions at which a side is lifted off as in the raw motion; its gap is omitted
  double largest_gap_mm = 0.0, largest_overlap_mm = 0.0;  ///< of any side
  std::optional<store::TwoSidedFigures> sides;            ///< only with compartments
};

/// What is known of one degree; errors in units of the perceptible error.
struct DegreeEvidence {
  int degree = 0;
  /// [n_cells] squared errors of fits without the cell's block, the same cells in the same order for every
  /// degree; empty if a block cannot be omitted.
  std::vector<double> left_out_sq;
  double second_difference = 0.0;                        ///< RMS over one degree of flexion
  std::optional<ContactFigures> contact = std::nullopt;  ///< if measured
};

/// What is known of the raw motion.
struct RawEvidence {
  std::vector<std::int32_t> block;  ///< [n_cells] number of each cell's block
  BlockSize block_size;
  double variance = 0.0;  ///< raw_variance()
  RawJump jump;
};

/// One degree compared with the best.
struct RankedDegree {
  int degree = 0;
  double error = 0.0;           ///< root mean square; NaN if not measurable, like the next two
  double excess_sq = 0.0;       ///< mean over the cells of squared error minus that of the best
  double standard_error = 0.0;  ///< of excess_sq, paired: from the spread of the differences per block
  bool is_within = false;       ///< excess_sq <= 2 standard_error
  Fault fault = Fault::none;
  std::string fault_reason;  ///< the fault with its figures, a part of a sentence; empty without a fault
};

struct Recommendation {
  int degree = -1;            ///< -1: none meets the criteria
  Fault fault = Fault::none;  ///< why none meets the criteria: that of the best degree, or `jump`
  int best_degree = -1;       ///< smallest error, of the degrees without a fault if there is one
  std::string reason;         ///< one sentence
  BlockSize block_size;       ///< attitudes left out together
  std::vector<RankedDegree> ranked;
};

/// Recommends the lowest degree without a fault within two paired standard errors of the best of them. Errors
/// of a cell below 1e-6 count as 1e-6: they are rounding, and their order is chance. Expects ascending
/// degrees.
Recommendation recommend(const std::vector<DegreeEvidence>& degrees, const RawEvidence& raw);

/// [n_fits] The error of each cell's pose, for DegreeEvidence; analysis/compare.hpp has the rules. `left_out`
/// are the errors of each fit's surfaces (leave_one_out, or leave_blocks_out). Cells are those fitted in
/// translation, in grid order. Robust if the fits are. `fits` are of one model by ascending degree.
std::vector<std::vector<double>> left_out_errors(const std::vector<SmoothFit>& fits,
                                                 const std::vector<std::vector<store::GridD>>& left_out);

// Compares smoothing degrees: residual, prediction error, roughness, and gap and penetration of the motion.

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

/// A follower's part of a degree.
struct FollowerRow {
  std::string name;
  std::vector<SurfaceRow> surfaces;               ///< by store::follower_surface_names
  std::optional<MotionAuditTotals> audit_totals;  ///< against what it touches, if an audit was requested
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
  std::vector<FollowerRow> followers;             ///< whose cells determine the degree; by name
  double second_difference = 0.0;  ///< RMS over one degree of flexion, of the pose in perceptible errors
  std::optional<ContactFigures> contact;  ///< if requested
};

/// Audits the set "degree_N" or "degree_N_recontacted" of `model`; implemented by the `audit` room.
using AuditMotion = std::function<store::AuditSet(const store::MotionModel& model, const std::string& set)>;
/// Sets the travels into contact of a set and of its followers: add_recontact() of analysis/audit.hpp.
using Recontact = std::function<void(const store::MotionModel& model, store::SmoothedSet& set)>;

/// Moves the motion of `set` into contact, two-sided or along Delta without compartments, and measures it;
/// implemented by the `app` room.
using MeasureContact =
    std::function<ContactFigures(const store::MotionModel& model, const store::SmoothedSet& set)>;

struct CompareOptions {
  std::string name;                                                 ///< model name for messages
  std::vector<int> degrees{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};  ///< ascending, each at most 20
  SmoothOptions smooth;
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
