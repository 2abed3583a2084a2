/// The job file (DESIGN.md 5.6) as settings in internal units: mm, rad, N. Degrees and other length
/// units end here, except for the grid, whose axes are written out as the job gives them.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/frames.hpp"
#include "core/solver_options.hpp"
#include "documents/document.hpp"
#include "load/case.hpp"

namespace vrda {

/// Where the triangles of an open sheet point, as its file winds them.
enum class Winding { outward, inward };

/// A part made by code instead of read from a file.
struct GenerateJob {
  std::string shape;
  std::string part;
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> words;
};

/// Exactly one of `file` and `generate` is given.
struct ComponentJob {
  std::string key;  ///< "reference.component.0", for messages
  std::string name;
  std::string file;  ///< as the job writes it; empty for a generated part
  std::optional<GenerateJob> generate;
  std::string material;
  bool has_contact = true;
  Winding winding = Winding::outward;
  double inset_mm = 0.0;  ///< each vertex goes inward along its normal: a thinner part, or a contact offset
  Eigen::Vector3d shift_mm{0.0, 0.0, 0.0};  ///< canonical, of the whole component
};

struct BodyJob {
  std::string name;
  std::vector<ComponentJob> components;
};

/// From the mesh files' coordinates to canonical axes (load/axis_map.hpp).
struct FrameJob {
  std::string unit;
  std::string anterior;
  std::string proximal;
  std::string right;
  Eigen::Vector3d origin_native{0.0, 0.0, 0.0};  ///< rotation centre, native unit
  Eigen::Vector3d align_rotation_rad{0.0, 0.0, 0.0};
  Eigen::Vector3d align_translation_mm{0.0, 0.0, 0.0};
};

/// How much larger the subject's joint is: a factor, or a table that one is fitted to.
struct ScalingJob {
  Eigen::Vector3d factor{1.0, 1.0, 1.0};  ///< anterior, proximal, right; of no meaning with landmarks
  std::string landmarks_file;             ///< empty: the factor is given
};

/// A setting that may follow flexion: linear between rows, held beyond the ends. A constant has one row.
struct OverFlexion {
  std::vector<double> flexion_rad;  ///< [n] rising
  Eigen::MatrixXd value;            ///< [n, components]
};

/// The row of values that holds at a flexion.
Eigen::VectorXd at_flexion(const OverFlexion& setting, double flexion_rad);

struct PushJob {
  OverFlexion delta;             ///< [n, 3] unit vectors, canonical
  OverFlexion force_n;           ///< [n, 1]
  OverFlexion lateral_force_n;   ///< [n, 2] anterior, right
  OverFlexion moment_nmm;        ///< [n, 1] about Delta
  OverFlexion varus_moment_nmm;  ///< [n, 1] on varus, adduction positive
  Eigen::Vector3d point_mm{0.0, 0.0, 0.0};
};

enum class SolverMethod { stability_search, equilibrium };

/// One fibre, from the job or a table. Exactly one of slack length and reference strain is given.
struct FibreJob {
  std::string name;
  std::string bundle;  ///< empty: from the name
  /// Attachments at the pose of the meshes, along the mesh files' axes, mm: mapped like the meshes.
  Eigen::Vector3d reference_native_mm{0.0, 0.0, 0.0};
  Eigen::Vector3d moving_native_mm{0.0, 0.0, 0.0};
  double stiffness_n = 0.0;  ///< per unit strain, above 0
  std::optional<double> slack_length_mm;
  std::optional<double> reference_strain;  ///< at the pose of the meshes
  std::string wrap;
  std::string source;  ///< file, for messages
  std::string field;   ///< "ligaments.fibre.3" or "line 7"
};

/// Exactly one of `fibres_file`, `fibres` and `generate` is given.
struct LigamentsJob {
  std::string fibres_file;
  std::vector<FibreJob> fibres;
  std::optional<GenerateJob> generate;  ///< its part is empty
  std::string wraps_file;
  double transition_strain = 0.06;
};

/// Either a half-space by the rotation centre or moving components by name.
struct CompartmentJob {
  std::string half_space;  ///< "left", "right" or empty
  std::vector<std::string> components;
};

struct Job {
  std::string file;
  std::string text;           ///< the file's bytes
  std::string resolved_text;  ///< canonical TOML: every key with its value
  std::string unscaled_text;  ///< the same without [scaling]
  Document document;          ///< for messages that name a key
  bool has_campaign = false;  ///< left out of the resolved job

  std::string title;
  std::string joint;
  Side side = Side::right;
  FrameJob frame;
  std::optional<ScalingJob> scaling;
  BodyJob reference;
  BodyJob moving;
  InitialPose initial;
  PushJob push;
  GridAxes grid;
  bool is_varus_free = false;  ///< grid.varus_deg is then {0}
  SolverMethod method = SolverMethod::stability_search;
  SearchOptions search;
  EquilibriumOptions equilibrium;
  SpineOptions spine;
  std::optional<LigamentsJob> ligaments;
  std::optional<CompartmentJob> medial;  ///< with `lateral`, or neither
  std::optional<CompartmentJob> lateral;
  std::vector<std::int32_t> smooth_degrees;
  bool smooth_recontact = true;
  bool smooth_robust = false;
  double unsolved_fraction = 0.0;
};

/// The job that `text` says, with `overrides` ("key.path=value") applied; `file` is its name in messages.
/// Throws InputError naming file, key, found and wanted. Opens no file.
Job parse_job(const std::string& file, std::string text, const std::vector<std::string>& overrides = {});

/// parse_job() of a file's bytes. Opens no mesh.
Job read_job(const std::string& file, const std::vector<std::string>& overrides = {});

/// The Case of a job whose meshes, ligaments and compartments `joint` has, a case loaded at factor 1 whose
/// bodies may be left out: they, survey and warnings are not taken over. Reads landmarks only. Throws
/// InputError where a valid job asks what no method solves, and for what is wrong with its scaling.
Case case_of_joint(const Job& job, const std::string& data_directory, const Case& joint);

}  // namespace vrda
