/// The motion model as plain data. schemas/motion-model.md is the specification of its file.
/// Units here are those of the file: mm and degrees.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/frames.hpp"
#include "core/mesh.hpp"
#include "core/plausibility.hpp"
#include "core/scaling.hpp"
#include "core/step_record.hpp"
#include "store/derived.hpp"
#include "store/grid.hpp"

namespace vrda {

/// Grood-Suntay numbers over the grid (core/clinical.hpp).
struct ClinicalSurfaces {
  GridD flexion_deg, varus_deg, internal_rotation_deg;
  GridD anterior_mm, proximal_mm, lateral_mm;
};

/// Contacts of all cells in compressed rows: those of cell c = i * n_varus + j are
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
  std::string name;    ///< as the job writes it
  std::string sha256;  ///< of the file's bytes, or of the generated mesh
};

struct JobRecord {
  std::string text;      ///< the job file as given
  std::string resolved;  ///< every key with its value
  std::vector<InputFile> inputs;
  std::optional<Scaling> scaling = std::nullopt;  ///< where the job scales
};

/// What pushes the moving object at each flexion.
struct PushRows {
  Points delta;                                        ///< [n_flexion, 3] unit vectors, world W
  Points force_n;                                      ///< [n_flexion, 3] along Delta and across it, W
  std::vector<double> moment_nmm;                      ///< [n_flexion] about Delta, right-knee sign of theta
  std::vector<double> varus_moment_nmm;                ///< [n_flexion]
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< where the force acts, world W
};

/// Points of each cell where a compartment bears its load: mean of its contacts, weighted by force where the
/// equilibrium knows it. NaN where the compartment does not touch.
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

/// The pose of each flexion with varus left free, which the rows of the grid start from.
struct FreeSpine {
  std::vector<std::int8_t> status;                     ///< [n_flexion] StepStatus
  std::vector<double> varus_deg;                       ///< [n_flexion] NaN where not stable, like all below
  std::vector<double> tx_mm, ty_mm, tz_mm, theta_deg;  ///< as the surfaces of those names
  std::vector<double> energy_nmm;
  /// Theta under an extra moment of -band and +band about Delta; NaN without a band or not stable there.
  std::vector<double> theta_low_deg, theta_high_deg;
  std::vector<std::int32_t> n_optima;            ///< different places of rest that the starts led to
  std::vector<double> optima_theta_spread_deg;   ///< largest less smallest theta among them
  std::vector<double> optima_energy_spread_nmm;  ///< largest less smallest energy among them
};

/// What only the equilibrium knows (core/step_record.hpp, Balance). Surfaces over (flexion, varus).
struct EquilibriumSurfaces {
  double band_moment_nmm = 0.0;  ///< 0: no band
  GridD energy_nmm, balance_residual_n, complementarity_mm, worst_gap_mm;
  GridD flexion_moment_nmm, varus_moment_nmm;
  std::vector<double> force_medial_n;   ///< [n_cells, 3] sum of the contact forces on the moving object, W;
  std::vector<double> force_lateral_n;  ///< only with compartments; NaN where not stable
  ForceRows forces;
  FreeSpine spine;
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

struct MotionModel {
  std::string title;
  std::string joint;                                             ///< "knee" or "other"
  std::string side;                                              ///< "right" or "left"
  std::string method;                                            ///< "stability-search" or "equilibrium"
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();  ///< canonical
  Eigen::Vector3d delta = Eigen::Vector3d::UnitY();              ///< world W; of the first flexion
  double contact_resolution_mm = 0.1;
  bool has_compartments = true;
  std::vector<std::int8_t>
      compartment_of_triangle;  ///< [n triangles of moving.contact] Compartment; only with them

  std::vector<double> flexion_deg;  ///< [n_flexion]
  std::vector<double> varus_deg;    ///< [n_varus]

  GridD tx_mm, ty_mm, tz_mm, theta_deg;
  std::vector<double> X_reference_moving;  ///< [n_flexion, n_varus, 4, 4] row-major
  GridB status;                            ///< StepStatus
  GridB plausibility;                      ///< Plausibility
  GridI iterations, queries;
  GridD residual_mm;                    ///< last translation predicted by the solver
  GridD gap_medial_mm, gap_lateral_mm;  ///< directional gap left; NaN where nothing faces
  GridB contact_medial, contact_lateral, theta_determined;
  GridB is_spine;  ///< 1 on the spine cell of each flexion

  GridD varus_solved_deg;  ///< of each cell; differs from the axis where varus was free

  PushRows push;                                   ///< of a file of version 1.0: constant_push(delta)
  std::optional<EquilibriumSurfaces> equilibrium;  ///< of method "equilibrium" only, and exactly there
  std::optional<LigamentRows> ligaments;           ///< where the job has fibres
  std::optional<ContactPaths> contact_paths;       ///< where the joint has compartments

  ClinicalSurfaces clinical;
  ContactRows contacts;
  Body reference, moving;               ///< canonical, own side
  std::vector<SmoothedSet> smoothed;    ///< by rising degree
  std::optional<ZeroVarus> zero_varus;  ///< once reduced
  std::vector<AuditSet> audits;         ///< by name
  JobRecord job;
};

/// Row `k` of [n, 4, 4] row-major, as X_reference_moving holds them. Of a cell that is not solved all NaN.
Pose pose_in(const std::vector<double>& poses, std::size_t k);

/// Along `delta` at each flexion, with a force and moments of 0.
PushRows constant_push(const Eigen::Vector3d& delta, std::size_t n_flexion);

/// Gives the gaps and contact flags of the compartments what they are without any: NaN and -1.
void set_no_compartments(MotionModel& model);

/// `model` with every cell of its grid (flexion_deg x varus_deg) pending: no poses, contacts, forces and
/// nothing that is made of them. The content of a start file; a run then fills the cells in. Keeps the push,
/// or makes it that of `delta` where it has not a row a flexion, what is no cell's of the fibres, and the
/// compartments of triangles, `none` where they are missing. Contact paths and equilibrium exist after it as
/// has_compartments and method ask.
MotionModel with_pending_cells(MotionModel model);

/// `model` with `set` in place of the one of its degree. Audits of that one and a zero-varus motion made from
/// it go with it where the motion becomes another; the same set once more changes nothing.
MotionModel with_smoothed(MotionModel model, SmoothedSet set);

}  // namespace vrda
