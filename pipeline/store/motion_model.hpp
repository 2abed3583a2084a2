/// Data derived from a motion model's raw surfaces: smoothed sets, audits, the zero-varus motion.
/// Units here are those of the file: mm and degrees.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/frames.hpp"
#include "model/mesh.hpp"
#include "model/step_record.hpp"
#include "store/dataset.hpp"

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

/// What belongs to a body that follows the joint, by its name, which is that of its group.
struct OfFollower {
  std::string name;
};
std::string group_name(const OfFollower& follower);
bool set_group_name(OfFollower& follower, const std::string& name);
inline const char* allowed_group_names(const OfFollower&)
{
  return "a letter, then letters, digits, - and _";
}

/// Its coordinates as polynomials with the exponents of their set.
struct SmoothedFollower : OfFollower {
  std::vector<SmoothedSurface> surfaces;  ///< by follower_surface_names
  std::optional<GridD> recontact_mm;      ///< as that of the set, along the follower's Delta
};
/// In the order of follower_coordinates() of model/coordinates.hpp, degrees and mm.
inline constexpr const char* follower_surface_names[] = {"flexion_angle", "rotation_angle", "tilt",
                                                         "anterior",      "proximal",       "lateral"};

struct SmoothedSet {
  std::int32_t degree = 0;
  bool is_robust = false;                 ///< fitted with Huber's weights
  Exponents exponents;                    ///< [n_terms, 2]
  std::vector<SmoothedSurface> surfaces;  ///< tx, ty, tz, theta; also varus where it was free
  /// Travel along Delta from the smoothed pose into contact, mm, added by the set "degree_N_recontacted". NaN
  /// where there is no contact along Delta.
  std::optional<GridD> recontact_mm;
  std::vector<SmoothedFollower> followers;  ///< by name; those whose solved cells determine the degree
};

/// Names of a set's surfaces in order; the last only where varus was free.
inline constexpr const char* smoothed_names[] = {"tx", "ty", "tz", "theta", "varus"};

/// "/smoothed/degree_6".
std::string smoothed_group(std::int32_t degree);
/// "/smoothed/degree_6/tx" of surface "tx"; that of "varus" is `varus_solved`.
std::string smoothed_path(std::int32_t degree, const std::string& name);

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

/// The same of a follower against what it touches, along its own Delta.
struct FollowerAudit : OfFollower {
  GridB state;  ///< AuditState
  GridD gap_mm, penetration_mm;
};

/// Gap and penetration of one motion on the audit's own grid.
struct AuditSet {
  std::string name;                            ///< "raw", "degree_6", "degree_6_recontacted", "zero_varus"
  std::int32_t refine = 1;                     ///< subdivisions of each cell of the model, along each axis
  std::vector<double> flexion_deg, varus_deg;  ///< axes; varus is {0} for zero_varus and where varus was free
  std::vector<double> frame_key;  ///< [n_flexion] in a sequence of frames, and flexion then in any order
  GridB state;                    ///< AuditState
  GridD gap_mm;                   ///< travel along Delta to the next contact; NaN unless free
  OfCompartments<GridD> compartment_gap_mm;  ///< signed; sized only with compartments
  GridD penetration_mm;  ///< travel opposite to Delta out of the overlap; 0 when free, NaN without a pose
  std::vector<FollowerAudit> followers;  ///< by name
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
  int n_poses = 0;                                                ///< 0 without compartments
  int n_both_in_contact = 0;                                      ///< both gaps within perceptible_mm
  OfCompartments<double> largest_gap_mm{}, largest_overlap_mm{};  ///< at least 0

  void include(const OfCompartments<double>& gap_mm);
};
TwoSidedFigures two_sided_figures(const AuditSet& audit);

/// Returns `audits`, sorted by name, with `audit` inserted or replacing the one of the same name.
std::vector<AuditSet> with_audit(std::vector<AuditSet> audits, AuditSet audit);

/// The motion that is shown, exported and reported if none is named (store::default_motion).
struct DefaultMotion {
  std::string set;     ///< "two_sided", "raw", "degree_6_recontacted", ...
  std::string reason;  ///< why it is not the smoothed motion, one sentence; empty if that meets the criteria
  std::string statement = {};  ///< of a model with a prior: PriorRows::statement
};

/// One spring of a job with a prior, at the equilibria of the spine. NaN where that is not stable. Degrees or
/// mm, N mm per rad or N per mm, N mm or N, by the coordinate.
struct PriorTermRows {
  std::int8_t coordinate = 0;                               ///< PriorCoordinate; the name of its group
  std::string shape;                                        ///< "walker-1988" or "table"
  double level = 0.0;                                       ///< added to the curve
  bool is_level_free = false;                               ///< estimated from the motion
  std::vector<double> curve;                                ///< [n_flexion] with the level
  std::vector<double> value, stiffness, force, energy_nmm;  ///< [n_flexion]; force: on the coordinate
};
std::string group_name(const PriorTermRows& term);
bool set_group_name(PriorTermRows& term, const std::string& name);
inline const char* allowed_group_names(const PriorTermRows&)
{
  return "varus, internal, anterior, proximal, lateral or centre_anterior";
}

/// Poses in rows, as the surfaces of those names; NaN in a row without a pose.
struct PoseRows {
  std::vector<double> tx_mm, ty_mm, tz_mm, theta_deg, varus_deg;

  template <typename Rows>
  static auto columns_of(Rows& rows)
  {
    return std::array{&rows.tx_mm, &rows.ty_mm, &rows.tz_mm, &rows.theta_deg, &rows.varus_deg};
  }
  void resize(std::size_t n)
  {
    for (std::vector<double>* column : columns_of(*this)) column->resize(n, nan);
  }
  void set(std::size_t row, const Eigen::Vector3d& t_mm, double of_theta_deg, double of_varus_deg);
};

/// The motion of the spine without the prior; NaN where it is not stable.
struct BonesAlone : PoseRows {
  std::vector<std::int8_t> status;  ///< [n_flexion] StepStatus
  std::vector<double> energy_nmm;
  std::vector<std::int32_t> n_optima;  ///< distinct equilibria
};
/// Its name as a motion, after those of set_names().
inline constexpr const char* bones_alone_name = "bones_alone";

/// A prior (schemas/prior.md), its part in the motion, and the motion without it.
struct PriorRows {
  std::string statement;  ///< on the default motion, for whoever sees it: prior_statement() of verdict.hpp
  std::vector<PriorTermRows> terms;
  std::vector<double> own_stiffness;  ///< [n_flexion] N mm per rad about Delta without it; NaN: not measured
  /// [n_flexion] Shares of the prior: of the stiffness about Delta, which is the share of the rotation that
  /// it decides; of the moments about Delta; of the energy. NaN where the spine is not stable.
  std::vector<double> rotation_share, moment_share, energy_share;
  BonesAlone bones_alone;
};
/// Mean share of the rotation over the flexions, NaN without one.
double rotation_share_of(const PriorRows& prior);

/// Which compartments are in contact in a two-sided pose.
enum class TwoSidedContact : std::int8_t {
  no_pose = -1,
  both = 0,
  medial = 1,   ///< the lateral one is lifted off, as in the raw motion
  lateral = 2,  ///< the medial one is lifted off
};

/// The motion over flexion alone in which both compartments are in contact (thesis 5.4): x, z and theta are
/// polynomials of flexion, the position along Delta and varus follow from the gaps of both compartments.
struct TwoSided : PoseRows {
  std::int32_t degree = 0;                     ///< of the polynomials
  std::vector<double> flexion_deg;             ///< own axis, finer than the model's
  std::vector<std::int8_t> contact;            ///< TwoSidedContact
  OfCompartments<std::vector<double>> gap_mm;  ///< measured
};

/// How the repair of a frame ended (analysis/repair.hpp).
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
  interpolated = 1,  ///< root of medial - lateral gap between two columns
  free = 2,          ///< varus was free
};

/// Centre of contact of each cell and compartment: mean of its contacts, weighted by force if the model has
/// an equilibrium. NaN where the compartment is not in contact.
struct ContactPath {
  std::vector<double> reference_mm;  ///< [n_cells, 3] canonical axes of the reference body
  std::vector<double> moving_mm;     ///< [n_cells, 3] canonical axes of the moving body
};
using ContactPaths = OfCompartments<ContactPath>;

/// The flexion-only motion with both condyles in contact. NaN where `source` is `none`.
struct ZeroVarus : PoseRows {
  std::string set = "raw";          ///< motion of these poses: a name as in AuditSet, except "zero_varus"
  std::vector<std::int8_t> source;  ///< [n_flexion] ZeroVarusSource
  std::vector<double> varus_first_deg, varus_last_deg;  ///< [n_flexion] of both_touch only
  /// [n_flexion] 1 if the band from varus_first to varus_last reaches the border of the grid, which cuts it
  /// off: the mean is then not that of the whole band.
  std::vector<std::int8_t> is_cut_off;
  std::vector<double> X_reference_moving;       ///< [n_flexion, 4, 4] row-major
  OfCoordinates<std::vector<double>> clinical;  ///< [n_flexion]
  ContactPaths centres;                         ///< [n_flexion, 3] of contact; only with compartments
  /// [n_flexion - 1] Finite helical axis of the moving body between flexion k and k + 1, in canonical axes of
  /// the reference body. NaN where an end has no pose or the rotation is too small for an axis.
  std::vector<double> helical_rotation_deg, helical_translation_mm;
  std::vector<double> helical_direction, helical_point_mm;  ///< [n_flexion - 1, 3]
  std::vector<double> instant_centre_mm;  ///< [n_flexion - 1, 2] anterior, proximal in the sagittal plane
  /// [n_flexion - 1] Of the centre of contact; only with compartments. Formulas: schemas/clinical.md.
  struct RollingRows {
    std::vector<double> rolling_mm, sliding_mm;
  };
  OfCompartments<RollingRows> rolling;
};

// Motion over flexion of the samples of an uncertain job, their bands, and the inputs that the spread comes
// from. Units here are those of the file: mm, degrees, N.

/// Probabilities of the bands.
inline constexpr std::array<double, 5> band_probabilities{0.0, 0.05, 0.5, 0.95, 1.0};

/// Rows of the tables of correlation and index: three rotations, three translations, three contact forces.
inline constexpr std::array<const char*, 9> uncertain_quantities{"flexion",
                                                                 "varus",
                                                                 "internal",
                                                                 "anterior",
                                                                 "proximal",
                                                                 "lateral",
                                                                 "contact_force",
                                                                 "contact_force_medial",
                                                                 "contact_force_lateral"};

/// Six coordinates of the joint, or of a follower, in the samples. Samples whose pose is not stable at a
/// flexion have NaN there and are left out of the statistics.
struct UncertainPose {
  std::vector<std::int8_t> status;          ///< [n_samples, n_flexion] StepStatus
  std::vector<double> rotation_deg;         ///< [n_samples, n_flexion, 3] flexion, varus, internal
  std::vector<double> translation_mm;       ///< [n_samples, n_flexion, 3] anterior, proximal, lateral
  std::vector<std::int32_t> n_solved;       ///< [n_flexion] stable samples
  std::vector<double> rotation_band_deg;    ///< [5, n_flexion, 3] quantiles
  std::vector<double> translation_band_mm;  ///< [5, n_flexion, 3]
  /// [n_flexion, n_quantities, n_draws] Spearman's rank correlation, and first-order Sobol index with its 90
  /// % interval; NaN where the quantity has no spread.
  std::vector<double> rank_correlation, first_order, first_order_low, first_order_high;

  std::size_t n_samples() const { return n_solved.empty() ? 0 : status.size() / n_solved.size(); }
};

/// Its quantities are its coordinates: flexion, rotation, tilt; anterior, proximal, lateral.
struct UncertainFollower : OfFollower, UncertainPose {};

/// Its quantities are `uncertain_quantities`.
struct UncertainMotion : UncertainPose, PoseRows {
  std::string sequence;  ///< "sobol" or "latin-hypercube"
  std::int32_t seed = 0;
  std::vector<std::string> draw;  ///< [n_draws] names of the independent draws
  std::vector<double> value;      ///< [n_samples, n_draws] factors, changes or scores
  std::vector<double>
      contact_force_n;              ///< [n_samples, n_flexion, 3] all, medial, lateral; NaN: no compartments
  std::vector<double> probability;  ///< [5] band_probabilities
  std::vector<double> contact_force_band_n;  ///< [5, n_flexion, 3]
  std::vector<double> tension_band_n;        ///< [5, n_flexion, n_fibres]
  /// [5] At each of the probabilities a sample: when the samples that are solved at most flexions are ordered
  /// by internal rotation, as mean over flexion. The pose rows are its motion, [5, n_flexion].
  std::vector<std::int32_t> quantile_sample;
  std::vector<std::int8_t> quantile_status;  ///< StepStatus
  std::vector<std::string> quantity;         ///< [9] uncertain_quantities
  std::vector<UncertainFollower> followers;  ///< by name
};

// The motion model as plain data. schemas/motion-model.md specifies its file.
// Units here are those of the file: mm and degrees.

/// Grood-Suntay numbers over the grid (model/coordinates.hpp).
using ClinicalSurfaces = OfCoordinates<GridD>;

/// Contacts of all cells in compressed rows: cell c = i * n_varus + j has rows
/// [row_start[c], row_start[c + 1]).
struct ContactRows {
  std::vector<std::int64_t> row_start;           ///< [n_cells + 1]
  Points point_world_mm;                         ///< [n, 3] on the reference's surface, world W
  Points normal_world;                           ///< [n, 3] direction of the reaction on the moving object
  std::vector<double> distance_mm;               ///< [n]
  std::vector<std::int32_t> triangle_reference;  ///< [n] row of /bodies/reference/triangles
  std::vector<std::int32_t> triangle_moving;     ///< [n]
  std::vector<std::int8_t> compartment;          ///< [n] 0 none, 1 medial, 2 lateral
};

struct InputFile {
  std::string name;    ///< as written in the job
  std::string sha256;  ///< of the file's bytes, or of the generated mesh
};

struct JobRecord {
  std::string text;      ///< content of the job file
  std::string resolved;  ///< every key with its value
  std::vector<InputFile> inputs;
  std::optional<Scaling> scaling = std::nullopt;  ///< if the job scales
  std::vector<std::string> warnings = {};  ///< of `vrda check`, one sentence each; none before version 1.10
};

/// Forces at material points of the moving object, and moments. Their opposites act on the reference.
struct LoadRows {
  std::vector<std::string> name;   ///< [n_loads]
  std::vector<std::int8_t> frame;  ///< [n_loads] BodyIndex + 1: the axes in which a load keeps its direction
  Points point_mm;                 ///< [n_loads, 3] at the pose of the meshes, W
  std::vector<double> force_n;     ///< [n_flexion, n_loads, 3] axes of the frame
  std::vector<double> moment_nmm;  ///< [n_flexion, n_loads, 3] right-handed, axes of the frame
};

/// Lines of constant tension, with the points of all lines one after the other.
struct LineRows {
  std::vector<std::string> name;         ///< [n_lines]
  std::vector<double> tension_n;         ///< [n_flexion, n_lines]
  Points point_mm;                       ///< [n_points, 3] from the origin, at the pose of the meshes, W
  std::vector<std::int32_t> point_line;  ///< [n_points] row of `name`
  std::vector<std::int8_t> point_body;   ///< [n_points] 0 reference, 1 moving
};

/// Loads on the moving object at each flexion.
struct PushRows {
  Points delta;                                        ///< [n_flexion, 3] unit vectors, world W
  Points force_n;                                      ///< [n_flexion, 3] along and across Delta, W
  std::vector<double> moment_nmm;                      ///< [n_flexion] about Delta, right-knee sign of theta
  std::vector<double> varus_moment_nmm;                ///< [n_flexion]
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< point of application of the force, world W
  std::optional<LoadRows> loads = std::nullopt;
  std::optional<LineRows> lines = std::nullopt;
};

/// The contact forces of all cells in compressed rows, like ContactRows. A force on the moving object is
/// along_delta_n * normal / -(normal . Delta).
struct ForceRows {
  std::vector<std::int64_t> row_start;           ///< [n_cells + 1]
  Points point_world_mm;                         ///< [n, 3] W
  Points normal_world;                           ///< [n, 3] unit, W
  std::vector<double> along_delta_n;             ///< [n] above 0
  std::vector<std::int32_t> triangle_reference;  ///< [n]
  std::vector<std::int32_t> triangle_moving;     ///< [n]
  std::vector<std::int8_t> compartment;          ///< [n] 0 none, 1 medial, 2 lateral
};

/// The distinct equilibria found at each flexion in compressed rows, like ContactRows.
struct SpineBranches : PoseRows {
  std::vector<std::int64_t> row_start;  ///< [n_flexion + 1]
  std::vector<double> energy_nmm;
  std::vector<std::int8_t> is_chosen;  ///< 1 for that of the spine
};

/// The spine, the continuation path along flexion from which each row starts, solved with free varus.
struct FreeSpine : PoseRows {
  std::vector<std::int8_t> status;  ///< [n_flexion] StepStatus
  std::vector<double> energy_nmm;   ///< NaN where not stable, as all below
  /// Theta under an additional moment of -band and +band about Delta; NaN without a band or if unstable.
  std::vector<double> theta_low_deg, theta_high_deg;
  std::vector<std::int32_t> n_optima;            ///< distinct equilibria found from the different starts
  std::vector<double> optima_theta_spread_deg;   ///< largest minus smallest theta of them
  std::vector<double> optima_energy_spread_nmm;  ///< largest minus smallest energy of them
  SpineBranches branches;
};

/// Results of method "equilibrium" (model/step_record.hpp, Balance). Surfaces over (flexion, varus).
struct EquilibriumSurfaces {
  double band_moment_nmm = 0.0;  ///< 0: no band
  GridD energy_nmm, balance_residual_n, complementarity_mm, worst_gap_mm;
  GridD flexion_moment_nmm, varus_moment_nmm;
  /// [n_cells, 3] Sum of the contact forces on the moving object, W; only with compartments; NaN where not
  /// stable.
  OfCompartments<std::vector<double>> force_n;
  ForceRows forces;
  FreeSpine spine;
};

/// Roles of the joint's six coordinates (model/coordinates.hpp), and what holds or determines them.
struct CoordinateSurfaces {
  std::vector<std::int8_t> role;           ///< [6] CoordinateRole
  std::vector<std::int8_t> determined;     ///< [n_cells, 6] of free coordinates; else -1
  std::vector<double> holding_moment_nmm;  ///< [n_cells, 3] of held rotations, NaN where free
  std::vector<double> holding_force_n;     ///< [n_cells, 3] of held translations
};

struct LigamentRows {
  std::vector<std::string> name, bundle;  ///< [n_fibres]
  Points reference_mm;                    ///< [n_fibres, 3] attachment, canonical axes of its body
  Points moving_mm;                       ///< [n_fibres, 3]
  std::vector<double> stiffness_n;        ///< [n_fibres] per unit strain
  std::vector<double> slack_length_mm;    ///< [n_fibres]
  std::vector<std::int32_t> wrap;         ///< [n_fibres] row of the wraps, or -1
  double transition_strain = 0.06;
  std::vector<std::string> wrap_name;   ///< [n_wraps]
  std::vector<std::int8_t> wrap_shape;  ///< [n_wraps] 0 cylinder, 1 ellipsoid
  std::vector<std::int8_t> wrap_body;   ///< [n_wraps] 0 reference, 1 moving; of a follower BodyIndex
  std::vector<double> X_body_wrap;      ///< [n_wraps, 4, 4] canonical axes of its body
  Points wrap_radii_mm;                 ///< [n_wraps, 3] ellipsoid: half-axes; cylinder: r, r, half length
  std::vector<double> length_mm, strain, tension_n, energy_nmm;  ///< [n_cells, n_fibres] NaN where not stable
  std::vector<std::int8_t> is_wrapped;                           ///< [n_cells, n_fibres] -1 where not stable
  // Of a follower only, else empty.
  std::vector<std::int8_t> from_body, to_body;  ///< [n_fibres] BodyIndex of both ends
  std::vector<double> constant_tension_n;       ///< [n_fibres] above 0: instead of stiffness and slack length
};

/// A body that follows the joint (schemas/followers.md), over the cells of the joint.
struct FollowerRows : OfFollower {
  std::int32_t body_index = 2;       ///< BodyIndex; bodies of smaller ones are solved before it
  std::int32_t of = 0;               ///< BodyIndex of the body whose frame its coordinates use
  std::vector<std::int8_t> touches;  ///< BodyIndex of what it may touch
  /// [n touches] whether also the drawn parts of that body; empty: of none.
  std::vector<std::int8_t> touches_drawn;
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< origin of its coordinates, canonical
  Eigen::Vector3d delta = -Eigen::Vector3d::UnitX();    ///< unit, canonical axes, fixed to it
  double push_n = 0.0;                                  ///< along Delta
  bool has_reaction = false;                            ///< its fibres pull on the moving object
  Body body;                                            ///< canonical, where its files are
  GridB status;                                         ///< StepStatus
  GridB plausibility;                                   ///< Plausibility; empty in files before 1.14
  /// follower_coordinates() of model/coordinates.hpp; NaN where not stable, as all below.
  OfCoordinates<GridD> coordinates;
  std::vector<double> X_of_follower;  ///< [n_cells, 4, 4] stored vertices to those of the body `of`
  GridI iterations, queries;
  GridD energy_nmm, balance_residual_n, complementarity_mm, worst_gap_mm;
  ForceRows forces;  ///< points and normals in canonical axes of the body `of`
  std::optional<LigamentRows> ligaments;
};

/// The key of each frame of a model that is a sequence of frames: time, percentage of gait, number.
struct FrameSequence {
  std::string key_name;     ///< "time_s": see is_key_name
  std::vector<double> key;  ///< [n_flexion] strictly ascending, at least min_key_step apart
};

/// At least this far apart, so that rates over neighbouring keys cannot overflow.
inline constexpr double min_key_step = 1e-9;

struct MotionModel {
  std::string title;
  std::string joint;   ///< one of joint_kind_names
  std::string side;    ///< "right" or "left"
  std::string method;  ///< "stability-search", "equilibrium" or "import"
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();  ///< canonical
  Eigen::Vector3d delta = Eigen::Vector3d::UnitY();              ///< world W; of the first flexion
  double contact_resolution_mm = 0.1;
  bool has_compartments = true;
  std::vector<std::int8_t>
      compartment_of_triangle;  ///< [n triangles of moving.contact] Compartment; empty without compartments

  /// If set, the model is a sequence of frames: row i of every table over flexion is frame i.
  std::optional<FrameSequence> frames;
  std::vector<double>
      flexion_deg;  ///< [n_flexion] ascending; of each frame's attitude, in any order, with frames
  std::vector<double> varus_deg;  ///< [n_varus]; {0} with frames

  GridD tx_mm, ty_mm, tz_mm, theta_deg;
  std::vector<double> X_reference_moving;  ///< [n_flexion, n_varus, 4, 4] row-major
  GridB status;                            ///< StepStatus
  GridB plausibility;                      ///< Plausibility
  GridI iterations, queries;
  GridD residual_mm;             ///< last translation predicted by the solver
  OfCompartments<GridD> gap_mm;  ///< remaining directional gap; NaN where nothing faces
  OfCompartments<GridB> is_in_contact;
  GridB theta_determined;
  GridB is_spine;  ///< 1 on the spine cell of each flexion

  GridD varus_solved_deg;  ///< of each cell; differs from the axis where varus was free

  PushRows push;                                   ///< of a file of version 1.0: constant_push(delta)
  std::optional<EquilibriumSurfaces> equilibrium;  ///< if and only if method is "equilibrium"
  std::optional<CoordinateSurfaces> coordinates;   ///< if the job has roles that a grid cannot express
  std::optional<LigamentRows> ligaments;           ///< if the job has fibres
  std::vector<FollowerRows> followers;             ///< by name
  std::optional<ContactPaths> contact_paths;       ///< if the joint has compartments

  ClinicalSurfaces clinical;
  ContactRows contacts;
  Body reference, moving;                       ///< canonical, own side
  std::vector<SmoothedSet> smoothed;            ///< by increasing degree
  std::optional<TwoSided> two_sided;            ///< only with compartments
  std::optional<DefaultMotion> default_motion;  ///< as `run` decided it; files before 1.10 have none
  std::optional<UncertainMotion> uncertainty;   ///< if the job has [uncertainty], once it is solved
  std::optional<PriorRows> prior;               ///< if the job has [[prior]], once it is solved
  std::optional<RepairedFrames> repair;         ///< of a repaired measurement; only with frames
  std::optional<ZeroVarus> zero_varus;          ///< after `reduce`
  std::vector<AuditSet> audits;                 ///< by name
  JobRecord job;
};

/// Whether Delta differs from +Y at some flexion. Flexion and varus of the attitude and theta are then about
/// axes turned with Delta, and differ from the joint's own angles (/clinical).
bool has_turned_axes(const MotionModel& model);

/// Throws InputError naming `file` if the model is a sequence of frames: `what` ("smoothing") needs a grid of
/// attitudes.
void require_grid(const MotionModel& model, const std::string& file, const std::string& what);

/// Row `k` of [n, 4, 4] row-major, as X_reference_moving. All NaN for a cell that is not solved.
Pose pose_in(const std::vector<double>& poses, std::size_t k);

/// A push along `delta` at each flexion, with zero force and moments.
PushRows constant_push(const Eigen::Vector3d& delta, std::size_t n_flexion);

/// Sets the gaps and contact flags to their values for a joint without compartments: NaN and -1.
void set_no_compartments(MotionModel& model);

/// Returns `model` with every cell of its grid (flexion_deg x varus_deg) pending: no poses, contacts, forces
/// or derived data. This is the content of a start file; a run then fills the cells. Keeps the push (or sets
/// constant_push(delta) if its rows do not match flexion), the fibres' properties, and the compartments of
/// triangles (`none` where missing). has_compartments and method decide on contact paths and equilibrium.
MotionModel with_pending_cells(MotionModel model);

/// Returns `model` with `set` inserted or replacing the set of the same degree. If the motion changes, audits
/// of the old set and a zero-varus motion derived from it are removed; an equal set changes nothing.
MotionModel with_smoothed(MotionModel model, SmoothedSet set);

/// Centres of contact. For each stable cell and compartment: the mean of the points of its contact forces,
/// weighted by force magnitude; without an equilibrium the unweighted mean of its contacts. NaN without
/// contacts. `model` must have poses, varus_solved_deg, push.delta, contacts and equilibrium->forces.
ContactPaths contact_paths_of(const MotionModel& model);

/// The model at a subject's size, without a new run: multiplies every length, energy and moment by `factor`
/// (above 0) about the origin of the canonical axes. Angles, forces, strains, counts and the job record are
/// unchanged. Pure contact has no length scale (schemas/scaling.md): the result equals a run at that scale,
/// up to the position of the origin.
MotionModel scaled_model(MotionModel model, double factor);

// HDF5 file of the motion model (schemas/motion-model.md).

inline constexpr const char* format_name = "vrda motion model";
inline constexpr const char* format_version = "1.14";
inline constexpr int format_minor_version = 14;
/// Smallest minor version that readers accept; later ones add objects, which are ignored.
inline constexpr int least_minor_version = 7;

/// Writes `model` to `path`: under a temporary name in the same folder, flushed to the disk, then renamed,
/// so `path` is always a complete old or new file. Equal models give equal bytes. A lock that was missing is
/// a warning in the file.
/// Every grid must have the shape of the axes, and row_start one entry more than there are cells. Values are
/// not checked here (see validate_hdf5). Throws InputError when the file cannot be written, InternalError
/// when the model's shapes are inconsistent.
void write_motion_model(const std::string& path, const MotionModel& model);

/// Reads a motion model in a separate process (store/read_separately.hpp). Throws InputError naming the file
/// and the first object that violates the specification, or how that process ended. No other thread may use
/// HDF5 meanwhile.
MotionModel read_motion_model(const std::string& path);

/// All violations of the specification by a motion model or trace; empty if it is valid. Reads as above;
/// throws InputError when the file is absent, not an HDF5 file, or too damaged to be listed.
std::vector<Finding> validate_hdf5(const std::string& path);

}  // namespace vrda::store
