/// Data derived from a motion model's raw surfaces: smoothed sets, audits, the zero-varus motion.
/// Units here are those of the file: mm and degrees.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vrda::store {

/// Values over (flexion, varus). NaN (or -1 for flags) where a cell has no value.
template <typename Scalar>
using Grid = Eigen::Array<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using GridD = Grid<double>;
using GridI = Grid<std::int32_t>;
using GridB = Grid<std::int8_t>;

/// The code stored in the file.
template <typename Code>
constexpr std::int8_t code_of(Code code)
{
  return static_cast<std::int8_t>(code);
}

/// One smoothed parameter: sum of coefficient[k] P_i(u) P_j(v), Legendre polynomials,
/// i = exponents(k, 0) of flexion, j = exponents(k, 1) of varus, u and v on [-1, 1].
struct SmoothedSurface {
  std::string name;                  ///< "tx", "ty", "tz" (mm), "theta" or "varus" (degrees)
  std::vector<double> coefficients;  ///< [n_terms]
  GridD values;                      ///< on the grid of the model
  std::int32_t n_cells = 0;          ///< cells fitted
  double rms = 0.0;                  ///< root mean square residual
  double largest_residual = 0.0;     ///< largest absolute residual
  double leave_one_out_rms = 0.0;    ///< from the hat matrix
  double condition_number = 0.0;     ///< of the design matrix
};

using Exponents = Eigen::Array<std::int32_t, Eigen::Dynamic, 2, Eigen::RowMajor>;

struct SmoothedSet {
  std::int32_t degree = 0;
  bool is_robust = false;                 ///< fitted with Huber's weights
  Exponents exponents;                    ///< [n_terms, 2]
  std::vector<SmoothedSurface> surfaces;  ///< tx, ty, tz, theta; also varus where it was free
  /// Travel along Delta from the smoothed pose into contact, mm, added by the set "degree_N_recontacted". NaN
  /// where there is no contact along Delta.
  std::optional<GridD> recontact_mm;
};

/// Names of a set's surfaces in order; the last only where varus was free.
inline constexpr const char* smoothed_names[] = {"tx", "ty", "tz", "theta", "varus"};

/// "/smoothed/degree_6".
std::string smoothed_group(std::int32_t degree);
/// "/smoothed/degree_6/tx" of surface "tx"; that of "varus" is `varus_solved`.
std::string smoothed_path(std::int32_t degree, const std::string& name);
/// "/smoothed/degree_6/coefficients_tx".
std::string coefficients_path(std::int32_t degree, const std::string& name);

/// Name of an element's group below /smoothed or /audit, and the inverse: false for an invalid name.
std::string group_name(const SmoothedSet& set);
bool set_group_name(SmoothedSet& set, const std::string& name);
/// Names that an element may have, for messages.
inline const char* allowed_group_names(const SmoothedSet&)
{
  return "\"degree_\" followed by an integer";
}

/// Result of the audit at one attitude.
enum class AuditState : std::int8_t {
  no_pose = -1,       ///< the motion has no pose there
  free = 0,           ///< a gap, possibly 0
  overlapping = 1,    ///< penetration
  nothing_ahead = 2,  ///< free, without any contact along Delta
};

/// Gap and penetration of one motion on the audit's own grid.
struct AuditSet {
  std::string name;                            ///< "raw", "degree_6", "degree_6_recontacted", "zero_varus"
  std::int32_t refine = 1;                     ///< subdivisions of each cell of the model, along each axis
  std::vector<double> flexion_deg, varus_deg;  ///< axes; varus is {0} for zero_varus and where varus was free
  std::vector<double> frame_key;  ///< [n_flexion] in a sequence of frames, and flexion then in any order
  GridB state;                    ///< AuditState
  GridD gap_mm;                   ///< travel along Delta to the next contact; NaN unless free
  GridD gap_medial_mm, gap_lateral_mm;  ///< signed, of each compartment; sized only with compartments
  GridD penetration_mm;  ///< travel opposite to Delta out of the overlap; 0 when free, NaN without a pose
};

/// Whether an audit may have this name: "raw", "two_sided", "zero_varus", "degree_6" or
/// "degree_6_recontacted".
bool is_audit_name(const std::string& name);
/// "/audit/raw".
std::string audit_group(const std::string& name);

std::string group_name(const AuditSet& audit);
bool set_group_name(AuditSet& audit, const std::string& name);
inline const char* allowed_group_names(const AuditSet&)
{
  return "raw, two_sided, zero_varus, degree_N or degree_N_recontacted";
}

/// Maxima over the grid; NaN if no attitude has a value.
struct AuditSummary {
  double largest_penetration_mm = 0.0;
  double largest_gap_mm = 0.0;
};
AuditSummary summary_of(const AuditSet& audit);

/// Contact of both compartments over some poses of a motion. Signed gaps; one of NaN faces nothing and is not
/// in contact.
struct TwoSidedFigures {
  int n_poses = 0;                                                      ///< 0 without compartments
  int n_both_in_contact = 0;                                            ///< both gaps within perceptible_mm
  double largest_gap_medial_mm = 0.0, largest_overlap_medial_mm = 0.0;  ///< at least 0
  double largest_gap_lateral_mm = 0.0, largest_overlap_lateral_mm = 0.0;

  void include(double medial_mm, double lateral_mm);
};
TwoSidedFigures two_sided_figures(const AuditSet& audit);

/// Returns `audits`, sorted by name, with `audit` inserted or replacing the one of the same name.
std::vector<AuditSet> with_audit(std::vector<AuditSet> audits, AuditSet audit);

/// The motion that is shown, exported and reported if none is named (store::default_motion).
struct DefaultMotion {
  std::string set;     ///< "two_sided", "raw", "degree_6_recontacted", ...
  std::string reason;  ///< why it is not the smoothed motion, one sentence; empty if that meets the criteria
};

/// Which compartments are in contact in a two-sided pose.
enum class TwoSidedContact : std::int8_t {
  no_pose = -1,
  both = 0,
  medial = 1,   ///< the lateral one is lifted off, as in the raw motion
  lateral = 2,  ///< the medial one is lifted off
};

/// The motion over flexion alone in which both compartments are in contact (thesis 5.4): x, z and theta are
/// polynomials of flexion, the position along Delta and varus follow from the gaps of both compartments.
struct TwoSided {
  std::int32_t degree = 0;                             ///< of the polynomials
  std::vector<double> flexion_deg;                     ///< own axis, finer than the model's
  std::vector<std::int8_t> contact;                    ///< TwoSidedContact
  std::vector<double> tx_mm, ty_mm, tz_mm, theta_deg;  ///< as the surfaces of those names; NaN without a pose
  std::vector<double> varus_deg;
  std::vector<double> gap_medial_mm, gap_lateral_mm;  ///< measured
};

/// How the repair of a frame ended (repair/repair.hpp).
enum class RepairStatus : std::int8_t { unchanged = 0, repaired = 1, not_converged = 2, nothing_ahead = 3 };

/// The measured motion of which a model's frames are the repair, and what the repair changed.
struct RepairedFrames {
  bool is_converged = false;              ///< else the limit of iterations ended the repair
  std::vector<double> X_measured;         ///< [n_flexion, 4, 4] row-major, as X_reference_moving
  std::vector<std::int8_t> status;        ///< [n_flexion] RepairStatus
  std::vector<double> distance;           ///< [n_flexion] Mahalanobis distance from the measured pose
  std::vector<double> rotation_shift;     ///< [n_flexion, 3] in standard deviations, about the canonical axes
  std::vector<double> translation_shift;  ///< [n_flexion, 3] likewise, along them
  /// [n_flexion] Travel along Delta to the next contact; NaN where the bodies overlap or nothing is ahead.
  std::vector<double> gap_before_mm, gap_after_mm;
  std::vector<double> penetration_before_mm, penetration_after_mm;  ///< [n_flexion] as AuditSet
  std::vector<double> noise_deg, noise_mm;  ///< [3] standard deviations, canonical axes
  /// [3] Period of half amplitude of the smoothing in mean spacings of the frames; 2: not smoothed.
  std::vector<double> rotation_period, translation_period;
  std::vector<double> gap_limit_mm;  ///< [1] of the pair or [2] of medial and lateral; NaN: none
};

/// Source of the varus of a zero-varus pose (schemas/clinical.md).
enum class ZeroVarusSource : std::int8_t {
  none = -1,         ///< no pose
  both_touch = 0,    ///< mean of the first and last varus with both compartments in contact
  interpolated = 1,  ///< root of gap_medial - gap_lateral between two columns
  free = 2,          ///< varus was free
};

/// The flexion-only motion with both condyles in contact. NaN where `source` is `none`.
struct ZeroVarus {
  std::string set = "raw";          ///< motion of these poses: a name as in AuditSet, except "zero_varus"
  std::vector<std::int8_t> source;  ///< [n_flexion] ZeroVarusSource
  std::vector<double> varus_deg;    ///< [n_flexion]
  std::vector<double> varus_first_deg, varus_last_deg;  ///< [n_flexion] of both_touch only
  /// [n_flexion] 1 if the band from varus_first to varus_last reaches the border of the grid, which cuts it
  /// off: the mean is then not that of the whole band.
  std::vector<std::int8_t> is_cut_off;
  std::vector<double> tx_mm, ty_mm, tz_mm, theta_deg;  ///< [n_flexion] as the surfaces of those names
  std::vector<double> X_reference_moving;              ///< [n_flexion, 4, 4] row-major
  std::vector<double> clinical_flexion_deg, clinical_varus_deg, internal_rotation_deg;  ///< [n_flexion]
  std::vector<double> anterior_mm, proximal_mm, lateral_mm;                             ///< [n_flexion]
  /// [n_flexion, 3] centres of contact; only with compartments (as ContactPaths).
  std::vector<double> medial_reference_mm, medial_moving_mm, lateral_reference_mm, lateral_moving_mm;
  /// [n_flexion - 1] Finite helical axis of the moving body between flexion k and k + 1, in canonical axes of
  /// the reference body. NaN where an end has no pose or the rotation is too small for an axis.
  std::vector<double> helical_rotation_deg, helical_translation_mm;
  std::vector<double> helical_direction, helical_point_mm;  ///< [n_flexion - 1, 3]
  std::vector<double> instant_centre_mm;  ///< [n_flexion - 1, 2] anterior, proximal in the sagittal plane
  /// [n_flexion - 1] Rolling and sliding of the centre of contact; only with compartments. Formulas:
  /// schemas/clinical.md.
  std::vector<double> medial_rolling_mm, medial_sliding_mm, lateral_rolling_mm, lateral_sliding_mm;
};

}  // namespace vrda::store
