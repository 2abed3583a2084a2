/// The job file (schemas/job.schema.json) as settings in internal units: mm, rad, N. The grid axes stay in
/// degrees, as written in the job.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/document.hpp"
#include "core/text.hpp"
#include "job/case.hpp"
#include "model/frames.hpp"
#include "model/step_record.hpp"

namespace vrda::job {

/// Direction of the triangle normals of an open sheet, by the winding in its file.
enum class Winding { outward, inward };

/// A generated part.
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
  std::string file;  ///< as written in the job; empty for a generated part
  std::optional<GenerateJob> generate;
  std::string material;
  bool has_contact = true;
  Winding winding = Winding::outward;
  double offset_mm = 0.0;         ///< radius by which the surface is rounded outward for gaps and contacts
  bool is_offset_fitted = false;  ///< offset_mm = "fit": unknown until `vrda fit` finds it
  double overlap_mm = 0.0;        ///< depth to which the other object may be inside, along the normal
  double inset_mm = 0.0;  ///< inward displacement of each vertex along its normal: reduces the thickness
  Eigen::Vector3d shift_mm{0.0, 0.0, 0.0};  ///< translation of the component, canonical axes
};

/// Map from mesh file coordinates to canonical axes (job/component_loader.hpp).
struct FrameJob {
  std::string key;  ///< "frame", "reference.frame" or "moving.frame"
  std::string unit;
  std::string anterior;
  std::string proximal;
  std::string right;
  Eigen::Vector3d origin_native{0.0, 0.0, 0.0};  ///< rotation centre, native unit
  Eigen::Vector3d align_rotation_rad{0.0, 0.0, 0.0};
  Eigen::Vector3d align_translation_mm{0.0, 0.0, 0.0};
  bool is_origin_auto = false;  ///< of a body: found by registration, 0 until then
  bool is_align_auto = false;   ///< the same
};

struct BodyJob {
  std::string name;
  std::optional<FrameJob> frame;  ///< absent: the job's
  std::vector<ComponentJob> components;
};

/// Scaling of the joint to the subject: a factor, or a landmark table for fitting one.
struct ScalingJob {
  Eigen::Vector3d factor{1.0, 1.0, 1.0};  ///< anterior, proximal, right; unused with landmarks
  std::string landmarks_file;             ///< empty if the factor is given
};

/// A setting over flexion: linear between rows, constant beyond the ends. A constant has one row. Or one
/// value per frame, from columns of the frames' table, which load_coordinates() reads.
struct FlexionTable {
  std::vector<double> flexion_rad;        ///< [n] increasing; empty with columns
  Eigen::MatrixXd value;                  ///< [n, components]; [n_frames, components] with columns
  std::vector<std::string> columns = {};  ///< [components]
  std::string key = {};                   ///< of the columns or table, for messages
  bool is_over_driving = false;           ///< `flexion_rad` has values of the driving coordinate, deg or mm
};

/// `n` components: constants, a table { flexion_deg, value } or { driving, value }, or { columns }
/// (job/command_jobs.cpp).
FlexionTable over_flexion_at(const core::Document& document, const std::string& key, std::size_t n);

/// from, from + step, ... up to `to`, which is included if a whole number of steps reaches it.
std::vector<double> range_at(const core::Document& document, const std::string& key);

/// The interpolated row of values at a flexion.
Eigen::VectorXd value_at_flexion(const FlexionTable& setting, double flexion_rad);

/// One [[push.load]].
struct LoadJob {
  LoadPoint at;
  FlexionTable force_n;     ///< [n, 3] anterior, proximal, right
  FlexionTable moment_nmm;  ///< [n, 3] about the same axes, right-handed
};

/// One [[push.line]].
struct LineJob {
  LinePath path;
  FlexionTable tension_n;  ///< [n, 1] at least 0
};

struct PushJob {
  bool is_fixed_in_reference = false;  ///< Delta and the forces turn with it instead of the moving object
  FlexionTable delta;                  ///< [n, 3] unit vectors, canonical
  FlexionTable force_n;                ///< [n, 1]
  FlexionTable lateral_force_n;        ///< [n, 2] across Delta: along X and Z rotated from +Y to Delta
  FlexionTable moment_nmm;             ///< [n, 1] about Delta
  FlexionTable varus_moment_nmm;       ///< [n, 1] on varus, adduction positive
  Eigen::Vector3d point_mm{0.0, 0.0, 0.0};
  std::vector<LoadJob> loads;
  std::vector<LineJob> lines;
};

/// One coordinate of [coordinates], in degrees or mm. Values over flexion are linear between rows.
struct CoordinateJob {
  CoordinateRole role = CoordinateRole::free;
  std::vector<double> driven;         ///< of a range
  std::optional<FlexionTable> given;  ///< [n, 1] a number or a table
  std::string column;                 ///< of `file`, or of the file of the frames
  std::string file;
  std::string over;  ///< column of the driving coordinate in `file`; empty: its name and unit
};

struct CoordinatesJob {
  std::array<CoordinateJob, n_joint_coordinates> coordinate;
  std::string frames_file;  ///< empty without [frames]
  std::string frames_key;   ///< column; empty: the first
};

enum class SolverMethod { stability_search, equilibrium };

/// One fibre, from the job or a table. Exactly one of slack length and reference strain is given.
struct FibreJob {
  std::string name;
  std::string bundle;  ///< empty: derived from the name
  /// Attachments in mm at the pose of the meshes, in the axes of the mesh files.
  Eigen::Vector3d reference_native_mm{0.0, 0.0, 0.0};
  Eigen::Vector3d moving_native_mm{0.0, 0.0, 0.0};
  double stiffness_n = 0.0;  ///< per unit strain, above 0
  std::optional<double> slack_length_mm;
  std::optional<double> reference_strain;  ///< at the pose of the meshes
  std::string wrap;
  std::string source;                                  ///< file, for messages
  std::string field;                                   ///< "ligaments.fibre.3" or "line 7"
  std::string from_body = {}, to_body = {};            ///< names; empty: the default of the table
  std::optional<double> tension_share = std::nullopt;  ///< constant tension instead of stiffness and length
};

/// Exactly one of `fibres_file`, `fibres` and `generate` is given.
struct LigamentsJob {
  std::string fibres_file;
  std::vector<FibreJob> fibres;
  std::optional<GenerateJob> generate;  ///< `part` is empty
  std::string wraps_file;
  double transition_strain = 0.06;
};

/// One [[follower]].
struct FollowerJob {
  std::string key;  ///< "follower.0"
  BodyJob body;
  std::string of;
  std::vector<std::string> touches;  ///< empty: the object of its coordinates
  std::optional<Eigen::Vector3d> centre_native_mm;
  Eigen::Vector3d delta{-1.0, 0.0, 0.0};
  double push_n = 0.0;
  std::string fibres_file, wraps_file;  ///< empty with `generate`
  std::optional<GenerateJob> generate;  ///< `part` is empty
  bool touches_visual = false;          ///< also the drawn parts of what it touches
  double transition_strain = 0.06, tension_n = 30.0;
  std::vector<TendonDirection> directions;
  std::array<double, n_joint_coordinates> scan_joint{}, scan_follower{};  ///< degrees and mm
  bool has_reaction = false;
  int n_restarts = 2;
};

/// Either a half-space bounded by the rotation centre or the names of moving components.
struct CompartmentJob {
  std::string half_space;  ///< "left", "right" or empty
  std::vector<std::string> components;
};

/// [laxity]: loads on the joint at some flexions. Loads of 0 are not applied.
struct LaxityJob {
  std::vector<double> flexion_deg;   ///< ascending
  double anterior_force_n = 0.0;     ///< forwards and backwards
  double internal_moment_nmm = 0.0;  ///< about Delta, both ways
  double varus_moment_nmm = 0.0;     ///< towards varus and valgus
  int load_steps = 5;                ///< equal ones from the unloaded pose
  /// Fibres that are removed together.
  struct Cut {
    std::string name;
    std::vector<std::string> bundles;
  };
  std::vector<Cut> cuts;
};

/// One [[fit.parameter]]: changes of an input, in strain, mm, N or N mm.
struct FitParameterJob {
  std::string follower;  ///< whose fibres or load; empty: the joint's
  InputQuantity quantity = InputQuantity::reference_strain;
  std::string fibre, bundle;  ///< empty: all fibres
  SharedBy shared_by = SharedBy::bundle;
  std::string body, axis, load;     ///< words of the schema; empty where they do not apply
  std::vector<double> flexion_deg;  ///< of a load: an unknown at each, linear between; empty: a constant
  double sd = 0.0;                  ///< of the prior, whose mean is no change
  double from = 0.0, to = 0.0;      ///< bounds of the change
};

/// [fit]: what `vrda fit --to` may change, and how well it is measured.
struct FitJob {
  std::vector<FitParameterJob> parameters;
  /// [n_joint_coordinates] rad or mm; infinite: not fitted, as the flexion.
  std::array<double, n_joint_coordinates> noise{};
  /// Of followers by name, rad or mm; infinite: not fitted.
  std::map<std::string, std::array<double, n_joint_coordinates>> follower_noise;
  double independent_deg = 5.0;  ///< frames closer in flexion than this count as one
};

struct Job : CaseSettings {
  std::string file;
  std::string text;           ///< the file's bytes
  std::string resolved_text;  ///< canonical TOML: every key with its value
  std::string steps_text;     ///< the same without [laxity] and [fit], which affect no step
  std::string unscaled_text;  ///< without [scaling] too
  core::Document document;    ///< for error messages
  bool has_campaign = false;  ///< the resolved job does not contain it

  Side side = Side::right;
  FrameJob frame;
  std::optional<ScalingJob> scaling;
  BodyJob reference;
  BodyJob moving;
  bool is_start_auto = false;  ///< its translation is found from the meshes
  PushJob push;
  std::optional<CoordinatesJob> coordinates;  ///< then the grid is empty
  SolverMethod method = SolverMethod::stability_search;
  std::optional<LigamentsJob> ligaments;
  std::vector<FollowerJob> followers;
  std::optional<OfCompartments<CompartmentJob>> compartments;
  std::optional<LaxityJob> laxity;
  std::optional<FitJob> fit;
};

/// The frame of a body's mesh files: its own or that of the job.
inline const FrameJob& frame_of(const Job& job, const BodyJob& body)
{
  return body.frame ? *body.frame : job.frame;
}

/// Whether a component is read from a file; generated parts are in canonical axes.
bool has_mesh_file(const Job& job);

/// Parses a job and applies `overrides` ("key.path=value"); `file` is its name in messages. Opens no file.
/// Throws InputError naming file, key, found and wanted.
Job parse_job(const std::string& file, std::string text, const std::vector<std::string>& overrides = {});

/// Reads a job file and parses it with parse_job(). Does not open meshes.
Job read_job(const std::string& file, const std::vector<std::string>& overrides = {});

/// The job with numbers in the place of every "auto" of its frames.
Job with_found_frames(const Job& job, const FoundFrames& found);

/// The Case of a job without loading meshes: ligaments, inputs and compartments are copied from `joint`,
/// which must be at factor 1; bodies, survey and warnings stay empty. The only file read is the landmark
/// table. Throws InputError for a combination that no method solves and for invalid scaling.
Case case_with_joint(const Job& job, const std::string& data_directory, const Case& joint);

// Validation of jobs and campaigns against their schemas (core/schema.hpp).

/// The job with defaults filled in, keys in the order of the schema and numbers typed by the schema.
/// [campaign] is checked and removed. Throws InputError for an unknown key (naming the nearest known one), a
/// missing key, a wrong type or value, and for a campaign without a joint.
core::DocumentValue checked_job(const core::Document& document);

/// Whether the document has a campaign and no joint, so it is a list of jobs.
bool is_campaign_only(const core::DocumentValue& root);

/// Checks the [campaign] of the document and the job keys that its levels set. Throws InputError like
/// checked_job(), and for any other key next to a campaign without a joint.
void check_campaign(const core::Document& document);

// Input files named in a job, whole files with a size limit, and SHA-256.

/// A file name in a job with its key and the expected kind of file.
struct FileReference {
  std::string key;   ///< "reference.component.0.file"
  std::string name;  ///< as written in the job
  std::string what;  ///< "a mesh file"
};

struct InputFile {
  std::string path;
  std::string bytes;
};

/// Searches the data folder (if not empty), then the folder of the job file.
/// Throws InputError naming job, key and file if the file is missing or unreadable.
InputFile input_file(const Job& job, const std::string& data_directory, const FileReference& named);

/// Size of all mesh files of the job in bytes; a missing file counts as none.
std::uintmax_t mesh_bytes(const Job& job, const std::string& data_directory);

/// The content of `file`. Throws InputError for a missing file, a folder, an unreadable file and one larger
/// than `largest_bytes`; `facts` supplies file, field and wanted of the message.
std::string file_bytes(const std::string& file, const InputError::Facts& facts, std::uintmax_t largest_bytes);

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string sha256_of(std::string_view bytes);

// Splits text files into words, fields, lines and numbers, for mesh formats and tables.

/// Blank, tab or line end.
bool is_space(char c);

/// The words of a line, separated by blanks and tabs; a final carriage return is ignored.
std::vector<std::string_view> split_words(std::string_view line);

/// Without white space (or other characters) at either end.
std::string_view trimmed(std::string_view text, std::string_view characters = " \t\r\n");

/// What separates the names of a table's columns: the first that they have of , ; tab and |; else a comma.
char separator_of(std::string_view names);
/// The fields between the separators of a line, trimmed; one more than the number of separators.
std::vector<std::string_view> split_fields(std::string_view line, char separator = ',');
/// What a field should be that is not a number: with a decimal point where it has a comma.
std::string wanted_number(std::string_view field);

inline constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  ///< of UTF-8

/// A line of a table, without blanks at its ends, and its line number, from 1.
struct TableLine {
  std::string_view text;
  std::size_t number = 0;
};

/// The lines that are neither empty nor comments (#). A byte order mark is skipped.
std::vector<TableLine> table_lines(std::string_view text);

/// The number if the whole word is one, with an optional sign; "nan" and "inf" are accepted.
std::optional<double> parse_real(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);

}  // namespace vrda::job
