/// The motion model as plain data. schemas/motion-model.md is the specification of its file.
/// Units here are those of the file: mm and degrees.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/body.hpp"
#include "core/step_status.hpp"

namespace vrda {

/// Values over (flexion, varus). NaN (or -1 for flags) where a cell has no answer.
template <typename Scalar>
using Grid = Eigen::Array<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using GridD = Grid<double>;
using GridI = Grid<std::int32_t>;
using GridB = Grid<std::int8_t>;

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

/// One smoothed parameter: sum of coefficient[k] P_i(u) P_j(v), Legendre polynomials,
/// i = exponents(k, 0) of flexion, j = exponents(k, 1) of varus, u and v on [-1, 1].
struct SmoothedSurface {
  std::string name;                  ///< "tx", "ty", "tz" (mm) or "theta" (degrees)
  std::vector<double> coefficients;  ///< [n_terms]
  GridD values;                      ///< on the grid of the model
  std::int32_t n_cells = 0;          ///< cells fitted
  double rms = 0.0;                  ///< root mean square residual
  double largest_residual = 0.0;     ///< largest absolute residual
  double leave_one_out_rms = 0.0;    ///< from the hat matrix
  double condition_number = 0.0;     ///< of the design matrix
};

struct SmoothedSet {
  std::int32_t degree = 0;
  Eigen::Array<std::int32_t, Eigen::Dynamic, 2, Eigen::RowMajor> exponents;  ///< [n_terms, 2]
  std::vector<SmoothedSurface> surfaces;                                     ///< tx, ty, tz, theta
};

struct InputFile {
  std::string name;    ///< as the job writes it
  std::string sha256;  ///< of the file's bytes, or of the generated mesh
};

struct JobRecord {
  std::string text;      ///< the job file as given
  std::string resolved;  ///< every key with its value
  std::vector<InputFile> inputs;
};

struct MotionModel {
  std::string title;
  std::string joint;                                             ///< "knee" or "other"
  std::string side;                                              ///< "right" or "left"
  std::string method;                                            ///< "stability-search"
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();  ///< canonical
  Eigen::Vector3d delta = Eigen::Vector3d::UnitY();              ///< world W
  double contact_resolution_mm = 0.1;
  bool has_compartments = true;

  std::vector<double> flexion_deg;  ///< [n_flexion]
  std::vector<double> varus_deg;    ///< [n_varus]

  GridD tx_mm, ty_mm, tz_mm, theta_deg;
  std::vector<double> X_reference_moving;  ///< [n_flexion, n_varus, 4, 4] row-major
  GridB status;                            ///< StepStatus
  GridI iterations, queries;
  GridD residual_mm;                    ///< last translation predicted by the solver
  GridD gap_medial_mm, gap_lateral_mm;  ///< directional gap left; NaN where nothing faces
  GridB contact_medial, contact_lateral, theta_determined;
  GridB is_spine;  ///< 1 on the spine cell of each flexion

  ClinicalSurfaces clinical;
  ContactRows contacts;
  Body reference, moving;  ///< canonical, own side
  std::vector<SmoothedSet> smoothed;
  JobRecord job;
};

/// `model` with every cell of its grid (flexion_deg x varus_deg) pending: no poses, no contacts, no smoothed
/// surfaces. The content of a start file; a run then fills the cells in.
MotionModel with_pending_cells(MotionModel model);

}  // namespace vrda
