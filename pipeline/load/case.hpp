/// What a job means once read: two bodies in canonical axes and every setting in internal units.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/frames.hpp"
#include "core/mesh.hpp"
#include "core/scaling.hpp"
#include "core/solver_options.hpp"
#include "ligament/ligaments.hpp"

namespace vrda {

/// The moving object before the first step: shift from where the meshes put it (canonical axes, own
/// side; DESIGN.md 5.6 `initial`) and turn about Delta (right-knee sign).
struct InitialPose {
  Eigen::Vector3d translation_mm{0.0, -20.0, 0.0};
  double theta_rad = 0.0;
};

/// One axis of the grid, as the job writes it: degrees, in order.
struct GridAxes {
  std::vector<double> flexion_deg;  ///< [n_flexion], at least one
  std::vector<double> varus_deg;    ///< [n_varus], at least one
};

/// What pushes at one flexion: canonical axes of the joint's own side.
struct Push {
  Eigen::Vector3d delta = Eigen::Vector3d::UnitY();  ///< unit
  Eigen::Vector3d force_n{0.0, 20.0, 0.0};           ///< along Delta and across it
  double moment_nmm = 0.0;                           ///< about Delta, right-knee sign of theta
  double varus_moment_nmm = 0.0;                     ///< adduction positive
};

struct LoadedInput {
  std::string name;           ///< path as the job writes it, or the generator's name and parameters
  std::string sha256;         ///< of the file's bytes, or of the generated mesh
  bool decides_steps = true;  ///< false: only how their results are scaled
};

/// What happened to one component on its way in; `vrda check` prints it.
struct ComponentSurvey {
  std::string body;
  std::string name;
  std::string source;
  bool has_contact = true;
  Eigen::Index n_vertices = 0;
  Eigen::Index n_triangles = 0;
  Eigen::Index n_welded = 0;      ///< vertices merged
  Eigen::Index n_degenerate = 0;  ///< faces dropped
  Eigen::Index n_boundary_edges = 0;
  Eigen::Index n_non_manifold_edges = 0;
  bool was_flipped = false;  ///< winding reversed to point outward
  Box box;                   ///< canonical
  double mean_edge_mm = 0.0;
  double area_mm2 = 0.0;
  double volume_mm3 = 0.0;  ///< meaningful when closed
};

/// The joint as it is solved. Where scaling keeps the steps that is at factor 1, and of_subject() has the
/// subject's.
struct Case {
  std::string title;
  std::string joint = "knee";  ///< "knee" or "other"
  SolverFrame frame;           ///< side, rotation centre (canonical), Delta of the first flexion
  Body reference;              ///< canonical, own side
  Body moving;
  Ligaments ligaments;  ///< canonical, own side; no fibre when the job has none
  InitialPose initial;
  GridAxes grid;
  bool is_varus_free = false;                               ///< the grid's one varus is then 0
  std::vector<Push> push;                                   ///< [n_flexion]
  Eigen::Vector3d push_point_mm = Eigen::Vector3d::Zero();  ///< from the rotation centre, canonical axes
  std::string method;                                       ///< "stability-search" or "equilibrium"
  SearchOptions search;
  EquilibriumOptions equilibrium;
  SpineOptions spine;
  /// [n_triangles of moving.contact] of which compartment each moving triangle is; empty when the
  /// joint has no compartments.
  std::vector<Compartment> compartment_of_triangle;
  std::vector<std::int32_t> smooth_degrees;
  bool smooth_recontact = true;  ///< with travel into contact at every attitude
  bool smooth_robust = false;    ///< fitted with Huber's weights
  double unsolved_fraction = 0.0;

  std::optional<Scaling> scaling;   ///< where the job has [scaling]
  double steps_scale = 1.0;         ///< the subject's size over the one this case is solved at
  std::string solved_anew_because;  ///< of a scaling that does not keep the steps
  std::string steps_job;            ///< of `resolved_job` what decides the steps

  std::string job_text;      ///< the job file's bytes as given
  std::string resolved_job;  ///< canonical TOML of every key with its value; equal jobs, equal text
  std::vector<LoadedInput> inputs;
  std::vector<ComponentSurvey> survey;
  std::vector<std::string> warnings;  ///< what loading noticed; one sentence each
};

struct LoadOptions {
  std::string data_directory;          ///< meshes are looked for here first when not empty
  std::vector<std::string> overrides;  ///< "key.path=value" in TOML syntax (`--set`)
};

/// Reads, checks and resolves a job and its meshes.
/// Throws InputError naming file, key, found and wanted. Cost: seconds for a million triangles.
Case load_case(const std::string& job_file, const LoadOptions& options = {});

/// The case at its subject's size: every length times `steps_scale`, which is 1 then. The lengths among the
/// settings of both methods too, since they held at factor 1.
Case of_subject(const Case& solved);

}  // namespace vrda
