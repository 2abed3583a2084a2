/// The motion model as plain data. schemas/motion-model.md specifies its file.
/// Units here are those of the file: mm and degrees.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/frames.hpp"
#include "model/mesh.hpp"
#include "model/plausibility.hpp"
#include "model/scaling.hpp"
#include "model/step_record.hpp"
#include "store/derived.hpp"
#include "store/uncertain_motion.hpp"

namespace vrda::store {

/// Grood-Suntay numbers over the grid (core/clinical.hpp).
struct ClinicalSurfaces {
  GridD flexion_deg, varus_deg, internal_rotation_deg;
  GridD anterior_mm, proximal_mm, lateral_mm;
};

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
  std::vector<std::int8_t> frame;  ///< [n_loads] LoadFrame: the axes in which a load keeps its direction
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

/// Centre of contact of each cell and compartment: mean of its contacts, weighted by force if the model has
/// an equilibrium. NaN where the compartment is not in contact.
struct ContactPaths {
  std::vector<double> medial_reference_mm;  ///< [n_cells, 3] canonical axes of the reference body
  std::vector<double> medial_moving_mm;     ///< [n_cells, 3] canonical axes of the moving body
  std::vector<double> lateral_reference_mm;
  std::vector<double> lateral_moving_mm;
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
struct SpineBranches {
  std::vector<std::int64_t> row_start;  ///< [n_flexion + 1]
  std::vector<double> varus_deg, tx_mm, ty_mm, tz_mm, theta_deg;
  std::vector<double> energy_nmm;
  std::vector<std::int8_t> is_chosen;  ///< 1 for that of the spine
};

/// The spine, the continuation path along flexion from which each row starts, solved with free varus.
struct FreeSpine {
  std::vector<std::int8_t> status;                     ///< [n_flexion] StepStatus
  std::vector<double> varus_deg;                       ///< [n_flexion] NaN where not stable, as all below
  std::vector<double> tx_mm, ty_mm, tz_mm, theta_deg;  ///< as the surfaces of those names
  std::vector<double> energy_nmm;
  /// Theta under an additional moment of -band and +band about Delta; NaN without a band or if unstable.
  std::vector<double> theta_low_deg, theta_high_deg;
  std::vector<std::int32_t> n_optima;            ///< distinct equilibria found from the different starts
  std::vector<double> optima_theta_spread_deg;   ///< largest minus smallest theta of them
  std::vector<double> optima_energy_spread_nmm;  ///< largest minus smallest energy of them
  SpineBranches branches;
};

/// Results of method "equilibrium" (core/step_record.hpp, Balance). Surfaces over (flexion, varus).
struct EquilibriumSurfaces {
  double band_moment_nmm = 0.0;  ///< 0: no band
  GridD energy_nmm, balance_residual_n, complementarity_mm, worst_gap_mm;
  GridD flexion_moment_nmm, varus_moment_nmm;
  std::vector<double> force_medial_n;   ///< [n_cells, 3] sum of the contact forces on the moving object, W;
  std::vector<double> force_lateral_n;  ///< only with compartments; NaN where not stable
  ForceRows forces;
  FreeSpine spine;
};

/// Roles of the joint's six coordinates (core/joint_coordinates.hpp), and what holds or determines them.
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
  std::vector<std::int8_t> wrap_body;   ///< [n_wraps] 0 reference, 1 moving
  std::vector<double> X_body_wrap;      ///< [n_wraps, 4, 4] canonical axes of its body
  Points wrap_radii_mm;                 ///< [n_wraps, 3] ellipsoid: half-axes; cylinder: r, r, half length
  std::vector<double> length_mm, strain, tension_n, energy_nmm;  ///< [n_cells, n_fibres] NaN where not stable
  std::vector<std::int8_t> is_wrapped;                           ///< [n_cells, n_fibres] -1 where not stable
};

/// The key of each frame of a model that is a sequence of frames: time, percentage of gait, number.
struct FrameSequence {
  std::string key_name;     ///< "time_s": see is_key_name
  std::vector<double> key;  ///< [n_flexion] strictly ascending, at least min_key_step apart
};

/// At least this far apart, so that rates over neighbouring keys cannot overflow.
inline constexpr double min_key_step = 1e-9;

/// A lower-case letter, then at most 39 lower-case letters, digits and underscores.
bool is_key_name(const std::string& name);

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
  GridD residual_mm;                    ///< last translation predicted by the solver
  GridD gap_medial_mm, gap_lateral_mm;  ///< remaining directional gap; NaN where nothing faces
  GridB contact_medial, contact_lateral, theta_determined;
  GridB is_spine;  ///< 1 on the spine cell of each flexion

  GridD varus_solved_deg;  ///< of each cell; differs from the axis where varus was free

  PushRows push;                                   ///< of a file of version 1.0: constant_push(delta)
  std::optional<EquilibriumSurfaces> equilibrium;  ///< if and only if method is "equilibrium"
  std::optional<CoordinateSurfaces> coordinates;   ///< if the job has roles that a grid cannot express
  std::optional<LigamentRows> ligaments;           ///< if the job has fibres
  std::optional<ContactPaths> contact_paths;       ///< if the joint has compartments

  ClinicalSurfaces clinical;
  ContactRows contacts;
  Body reference, moving;                       ///< canonical, own side
  std::vector<SmoothedSet> smoothed;            ///< by increasing degree
  std::optional<TwoSided> two_sided;            ///< only with compartments
  std::optional<DefaultMotion> default_motion;  ///< as `run` decided it; files before 1.10 have none
  std::optional<UncertainMotion> uncertainty;   ///< if the job has [uncertainty], once it is solved
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

}  // namespace vrda::store
