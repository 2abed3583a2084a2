/// [uncertainty] of a job: which inputs are uncertain and how they are distributed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "model/mesh.hpp"
#include "model/step_record.hpp"

namespace vrda::job {

enum class DistributionKind { normal, lognormal, uniform, table };

/// Of one number: a factor or a change, in the unit of what it changes.
struct Distribution {
  DistributionKind kind = DistributionKind::normal;
  double mean = 0.0;                ///< normal: mean; lognormal: median, above 0
  double sd = 0.0;                  ///< normal: standard deviation; lognormal: that of the natural logarithm
  double from = 0.0, to = 0.0;      ///< uniform
  std::vector<double> values = {};  ///< table: ascending, equally likely, linear between neighbours
};

/// What may be uncertain; the first three may also be fitted.
enum class InputQuantity {
  reference_strain,
  attachment,
  load,
  stiffness,
  rotation_centre,
  offset,
  thickness,
  prior_shape,
  prior_level,
  direction  ///< of a follower's tendon
};
inline constexpr Named<InputQuantity> input_quantity_names[] = {
    {InputQuantity::reference_strain, "reference_strain"},
    {InputQuantity::attachment, "attachment"},
    {InputQuantity::load, "load"},
    {InputQuantity::stiffness, "stiffness"},
    {InputQuantity::rotation_centre, "rotation_centre"},
    {InputQuantity::offset, "offset"},
    {InputQuantity::thickness, "thickness"},
    {InputQuantity::prior_shape, "prior_shape"},
    {InputQuantity::prior_level, "prior_level"},
    {InputQuantity::direction, "direction"}};
constexpr const auto& names_of(InputQuantity)
{
  return input_quantity_names;
}

/// Which fibres share one draw or unknown.
enum class SharedBy { fibre, bundle, all };
inline constexpr Named<SharedBy> shared_by_names[] = {
    {SharedBy::fibre, "fibre"}, {SharedBy::bundle, "bundle"}, {SharedBy::all, "all"}};
constexpr const auto& names_of(SharedBy)
{
  return shared_by_names;
}

/// Those without a name have that of the job.
enum class InputLoad {
  force,
  anterior_force,
  right_force,
  moment,
  varus_moment,
  push,     ///< of a follower
  tension,  ///< of all lines of a follower together
  applied,
  line
};
inline constexpr Named<InputLoad> input_load_names[] = {{InputLoad::force, "force"},
                                                        {InputLoad::anterior_force, "anterior_force"},
                                                        {InputLoad::right_force, "right_force"},
                                                        {InputLoad::moment, "moment"},
                                                        {InputLoad::varus_moment, "varus_moment"},
                                                        {InputLoad::push, "push"},
                                                        {InputLoad::tension, "tension"}};
constexpr const auto& names_of(InputLoad)
{
  return input_load_names;
}

/// An input of a case that may change: the name, whose it is, and where it is in the case.
struct Parameter {
  std::string name;
  InputQuantity quantity = InputQuantity::reference_strain;
  std::optional<std::size_t> follower;  ///< row of the follower whose fibres, component or load it is
  /// Of stiffness, reference strain and attachment: rows of the case's fibres, or of the follower's.
  std::vector<std::size_t> fibres;
  BodyIndex body = BodyIndex::reference;  ///< of the attachment, offset or thickness
  InputLoad load = InputLoad::force;
};

/// One [[uncertainty.parameter]].
struct UncertainParameter : Parameter {
  Distribution distribution;
  bool is_factor = false;  ///< the distribution is that of a factor, else of a change
  SharedBy shared_by = SharedBy::bundle;
  double correlation = 0.0;    ///< of the fibres of one bundle, with SharedBy::fibre
  std::int32_t component = 0;  ///< of the offset or thickness, in its object; -1: all
  std::size_t term = 0;        ///< of the prior, or of the follower's directions
  std::size_t load_row = 0;    ///< of an applied load or a line
};

enum class SampleSequence { sobol, latin_hypercube };

struct Uncertainty {
  std::int32_t n_samples = 0;  ///< at least 2
  SampleSequence sequence = SampleSequence::sobol;
  std::uint32_t seed = 1;
  std::vector<UncertainParameter> parameters;  ///< at least one
  /// [n_fibres] Reference strain at the pose of the meshes if the fibre is given by it, NaN if by its slack
  /// length. The former keep their strain when attachments move.
  std::vector<double> reference_strain;
};

// A loaded job: two bodies in canonical axes and all settings in internal units.

/// Start pose of the moving object: translation from the pose of the meshes (canonical axes, the joint's own
/// side; key `moving.initial` of the job) and rotation about Delta (right-knee sign).
struct InitialPose {
  Eigen::Vector3d translation_mm{0.0, -20.0, 0.0};
  double theta_rad = 0.0;
};

/// Flexion and varus angles of the grid in degrees, in the order of the job.
struct GridAxes {
  std::vector<double> flexion_deg;  ///< [n_flexion], at least one
  std::vector<double> varus_deg;    ///< [n_varus], at least one
};

/// Angles that bound the degree of smoothing: a degree is below their number. An axis with one angle is not
/// fitted: only its constant term is used.
inline std::size_t n_fitted_angles(const GridAxes& grid)
{
  const std::size_t n_flexion = grid.flexion_deg.size(), n_varus = grid.varus_deg.size();
  return n_varus == 1 ? n_flexion : n_flexion == 1 ? n_varus : std::min(n_flexion, n_varus);
}

/// Roles of the joint's six coordinates, and their values where they are driven or given.
struct CoordinateRows {
  std::array<CoordinateRole, n_joint_coordinates> role{};
  /// [n_path] NaN where free, and in varus where a grid drives it.
  std::vector<JointCoordinates> rows;
  std::string key_name;     ///< of a sequence of frames ("time_s"); empty for a grid over flexion
  std::vector<double> key;  ///< [n_rows] of a sequence, ascending

  bool is_sequence() const { return !key_name.empty(); }
};

/// Point of application and axes of an applied load ([[push.load]]).
struct LoadPoint {
  std::string name;
  BodyIndex frame = BodyIndex::world;
  Eigen::Vector3d point_mm{0.0, 0.0,
                           0.0};  ///< of the moving object, from the rotation centre, canonical axes
};

/// A line of constant tension ([[push.line]]): points from its origin on the reference to its insertion on
/// the moving object, from the rotation centre at the pose of the meshes, canonical axes.
struct LinePath {
  std::string name;
  std::vector<Eigen::Vector3d> reference_mm;  ///< at least one
  std::vector<Eigen::Vector3d> moving_mm;     ///< at least one
};

/// The loads at one flexion, in canonical axes of the joint's own side.
struct Push {
  Eigen::Vector3d delta = Eigen::Vector3d::UnitY();  ///< unit
  Eigen::Vector3d force_n{0.0, 20.0, 0.0};           ///< along Delta and across it
  double moment_nmm = 0.0;                           ///< about Delta, right-knee sign of theta
  double varus_moment_nmm = 0.0;                     ///< adduction positive
  std::vector<Eigen::Vector3d> load_force_n;         ///< [n_loads]
  std::vector<Eigen::Vector3d> load_moment_nmm;      ///< [n_loads] by the right-hand rule on both sides
  std::vector<double> line_tension_n;                ///< [n_lines] at least 0
};

struct LoadedInput {
  std::string name;           ///< path as written in the job, or the generator's name and parameters
  std::string sha256;         ///< of the file's bytes, or of the generated mesh
  bool affects_steps = true;  ///< false: affects only the scaling of the results
};

/// Statistics of one component, printed by `vrda check`.
struct ComponentSurvey {
  std::string body;
  std::string name;
  std::string source;
  bool has_contact = true;
  Eigen::Index n_vertices = 0;
  Eigen::Index n_triangles = 0;
  Eigen::Index n_welded = 0;      ///< vertices merged
  Eigen::Index n_degenerate = 0;  ///< faces dropped
  Eigen::Index n_identical = 0;   ///< copies of triangles dropped
  Eigen::Index n_boundary_edges = 0;
  Eigen::Index n_non_manifold_edges = 0;
  /// Where such faces and edges are, mm in the axes of the file (places_text); empty without any.
  std::string degenerate_places, boundary_places, non_manifold_places;
  std::vector<std::string> notes;  ///< what of the file was ignored
  bool was_flipped = false;        ///< at least one shell was reversed to point outward
  bool has_sheet = false;          ///< at least one shell is an open sheet, whose winding defines its outside
  Box box;                         ///< canonical
  double mean_edge_mm = 0.0;
  double area_mm2 = 0.0;
  double volume_mm3 = 0.0;  ///< meaningful when closed
};

/// What registration found for `origin = "auto"` and `align = "auto"` of a body, as numbers of the job.
struct FoundFrame {
  Eigen::Vector3d origin_native = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_deg = Eigen::Vector3d::Zero();
};
struct FoundFrames {
  FoundFrame reference, moving;
};

/// What a job says and its case keeps as it is: a base of both, so that the fields are listed once and have
/// the same names in both.
struct CaseSettings {
  std::string title;
  std::string joint = "knee";  ///< one of joint_kind_names
  InitialPose initial;
  GridAxes grid;               ///< degrees
  bool is_varus_free = false;  ///< the grid then has the single varus 0
  SearchOptions search;
  EquilibriumOptions equilibrium;
  SpineOptions spine;
  std::vector<PriorTerm> prior;  ///< springs to published curves (schemas/prior.md)
  std::vector<std::int32_t> smooth_degrees;
  bool smooth_recontact = true;  ///< y from the directional gap at every attitude
  bool smooth_robust = false;    ///< fitted with Huber weights
  double unsolved_fraction = 0.0;
};

/// A spring on the direction of a bundle of fibres as the follower sees it ([[follower.direction]]): from the
/// means of the fibres' ends, about an axis of the follower; at rest as in the scan, turned by `rest_rad`.
struct TendonDirection {
  std::string bundle;
  double stiffness_nmm = 0.0;                       ///< per rad
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, canonical axes
  double rest_rad = 0.0;                            ///< about the axis
};

/// A body that follows the joint ([[follower]]; schemas/followers.md): solved at each attitude after it, with
/// six free coordinates, against bodies already placed. Its body is BodyIndex 2 plus its row.
struct Follower {
  std::string name;
  BodyIndex of = BodyIndex::reference;       ///< whose frame its coordinates use
  std::vector<BodyIndex> touches;            ///< bodies before it that it may touch
  bool touches_visual = false;               ///< also their drawn parts
  Body body;                                 ///< canonical, where its files are
  Eigen::Vector3d centre_mm{0.0, 0.0, 0.0};  ///< origin of its coordinates, canonical
  Eigen::Vector3d delta{-1.0, 0.0, 0.0};     ///< unit, canonical axes, fixed to it
  double push_n = 0.0;                       ///< along Delta
  model::Ligaments ligaments;                ///< canonical; each fibre has one end on it
  /// [n_fibres] As Uncertainty::reference_strain, where the scan found the objects.
  std::vector<double> reference_strain;
  std::vector<TendonDirection> directions;
  Pose X_of_scan = Pose::Identity();  ///< where slack lengths and directions are those of the scan,
  Pose X_reference_moving_scan = Pose::Identity();  ///< and the joint then
  bool has_reaction = false;                        ///< its fibres pull on the moving object
  int n_restarts = 2;                               ///< further starts at each flexion
};

/// The joint to solve. If scaling keeps the steps, lengths are at factor 1 and scaled_to_subject() gives the
/// subject's.
struct Case : CaseSettings {
  SolverFrame frame;  ///< side, rotation centre (canonical), Delta of the first flexion
  Body reference;     ///< canonical, own side
  Body moving;
  model::Ligaments ligaments;  ///< canonical, own side; empty if the job has none
  std::vector<Follower> followers;
  /// Set if a coordinate has a role that a grid cannot express. Of a sequence of frames, `grid` has the
  /// flexion of each frame (0 where free).
  std::optional<CoordinateRows> coordinates;
  std::vector<Push> push;  ///< [n_flexion]
  Push push_at_meshes;     ///< at the pose of the meshes
  bool is_push_fixed_in_reference = false;
  /// With the equilibrium, the flexions along which its spine continues: the grid's, with as many between
  /// them as keep steps of at most 1 degree. Otherwise the grid's.
  std::vector<double> path_flexion_deg;
  std::vector<Push> path_push;                              ///< [n_path]
  Eigen::Vector3d push_point_mm = Eigen::Vector3d::Zero();  ///< from the rotation centre, canonical axes
  std::vector<LoadPoint> loads;
  std::vector<LinePath> lines;
  std::string method;  ///< "stability-search" or "equilibrium"
  /// [n_triangles of moving.contact] compartment of each moving triangle; empty if the joint has none.
  std::vector<Compartment> compartment_of_triangle;

  std::optional<FoundFrames> found_frames;  ///< set if the job has "auto" in a frame

  std::optional<Uncertainty> uncertainty;  ///< set if the job has [uncertainty]

  std::optional<Scaling> scaling;  ///< set if the job has [scaling]
  double steps_scale = 1.0;        ///< ratio of the subject's size to the size of this case
  std::string rerun_reason;        ///< why scaling requires a new run; empty if it keeps the steps
  std::string steps_job_text;      ///< the part of `resolved_job` that determines the steps

  std::string job_text;      ///< bytes of the job file
  std::string resolved_job;  ///< canonical TOML with every key; equal jobs have equal text
  std::vector<LoadedInput> inputs;
  std::vector<ComponentSurvey> survey;
  std::vector<std::string> warnings;  ///< one sentence each
};

struct Job;  // job/job.hpp

struct LoadOptions {
  std::string data_directory;          ///< searched first for input files, if not empty
  std::vector<std::string> overrides;  ///< "key.path=value" in TOML syntax (`--set`)
};

/// A job file to load.
struct JobSource : LoadOptions {
  std::string job_file;
};

/// Loads and validates a job and its input files.
/// Throws InputError naming file, key, found and wanted. Cost: seconds for a million triangles.
Case load_case(const std::string& job_file, const LoadOptions& options = {});

/// Loads the input files of a parsed job.
Case load_case(const Job& job, const std::string& data_directory);

/// The case with one Delta and force for every row, for measured motions: those at the pose of the meshes if
/// they turn with the reference. Throws InputError, naming `job_file`, if the job has other directions over
/// flexion.
Case with_one_delta(Case loaded, const std::string& job_file);

/// The case at the subject's size: every length times `steps_scale`, including the lengths among the solver
/// settings, which applied at factor 1. The result has `steps_scale` 1.
Case scaled_to_subject(const Case& solved);

}  // namespace vrda::job
