/// Commands that check jobs and write files other than motion models.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/console.hpp"
#include "report/report.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct CheckOptions {
  std::string job_file;
  std::string data_directory;
  std::vector<std::string> overrides;
  std::string picture;  ///< PNG file of the joint as read; empty: none
  bool as_json = false;
};

/// What was understood, the plan, and warnings; writes the picture.
nlohmann::ordered_json check_json(const CheckOptions& options);

/// Prints check_json().
core::ExitCode check_command(const CheckOptions& options);

/// `vrda prepare`: a job from the meshes of two bones.
struct PrepareOptions {
  std::string femur, tibia;  ///< mesh files of the bones; may be empty where cartilage is given
  std::vector<std::string> femur_cartilage, tibia_cartilage, menisci;
  std::string fibula;
  std::string landmarks;           ///< TOML file of points (schemas/prepare.md); alone: no mesh is given
  std::string side;                ///< left or right; empty: found
  std::string unit;                ///< mm, cm or m; empty: found
  std::string cartilage = "auto";  ///< auto, none, or the thickness in mm on a bone without cartilage
  std::string template_job;        ///< empty: the generic knee
  std::string data_directory;      ///< of the template
  bool has_ligaments = true;
  bool keeps_specks = false;  ///< keep small separate pieces in the joint space
  std::string folder;
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  bool as_json = false;
};

/// Adds the options to a command.
void add_prepare_options(CLI::App& command, PrepareOptions& options);

/// Writes meshes in anatomical frames, job, ligaments, prepare.json and prepare.png, all at the end. Throws
/// InputError for objects that are not the bones of one knee: then refused.png is the only file written.
core::ExitCode prepare_command(const PrepareOptions& options);

/// `vrda shape`: writes a generated joint as STL files and its ligaments as a CSV table.
struct ShapeOptions {
  std::string shape;
  std::string folder;
  std::vector<std::string> parameters;  ///< "name=value"
  bool has_ligaments = false;           ///< write ligaments.csv too
};

core::ExitCode shape_command(const ShapeOptions& options);

/// Lists every shape with its parameters, for `--help`.
std::string shape_help();

/// `vrda convert`: converts the thesis's formats to VRDA's, and mesh files between formats.
struct ConvertObjectOptions {
  std::string prefix;  ///< PREFIX.coor, PREFIX.norm, PREFIX.elem
  std::string folder;
};

struct ConvertMeshOptions {
  std::string input;
  std::string output;
};

struct ConvertConfigOptions {
  std::string file;
  std::string output;
  std::string unit = "m";  ///< unit of the meshes and of all lengths in the file: m, cm or mm
};

/// Writes NAME.obj (Vertices-Faces) and NAME.normals per component; prints the table of thesis 5.2.
core::ExitCode convert_object_command(const ConvertObjectOptions& options);

core::ExitCode convert_mesh_command(const ConvertMeshOptions& options);

/// Searches for models in the folder `models` next to the configuration, then next to its folder.
core::ExitCode convert_config_command(const ConvertConfigOptions& options);

/// `vrda export`: writes a motion model in formats of other programs (schemas/exports.md).
struct ExportOptions {
  std::string file;     ///< motion model
  std::string format;   ///< sto, mot, osim, csv, gltf or vtk
  std::string output;   ///< with the format's extension: .sto, .mot, .osim, .csv, .glb or .pvd
  std::string set;      ///< empty: the player's default set
  std::string flexion;  ///< FROM:TO:STEP, degrees; empty: the model's
  std::string varus;    ///< degrees, "spine" or "zero"; empty: zero if the model is reduced, else spine
  std::vector<std::string> coordinates;          ///< COORDINATE=NAME of sto, mot and osim
  bool in_degrees = false;                       ///< angles of sto and mot in degrees
  bool only_joint = false;                       ///< osim: write the joint's element alone
  bool every_cell = false;                       ///< csv: write the whole grid
  double degrees_per_second = 30.0;              ///< flexion rate that sets time in sto, mot and gltf
  std::string translations = "rotation-centre";  ///< or "mesh-origin": point of tx, ty, tz in sto and mot
  bool as_json = false;
};

/// Writes the files; the result lists them (`files`) and, but for a whole grid, the attitudes that were
/// omitted. Omits attitudes without a pose and reports them. Throws InputError, with nothing written, for
/// options that do not apply to the format and if no attitude can be exported.
nlohmann::ordered_json write_export(const ExportOptions& options);

/// Prints the files of write_export().
core::ExitCode export_command(const ExportOptions& options);

/// Adds the options to a command.
void add_export_options(CLI::App& command, ExportOptions& options);

/// `vrda report`: writes motion models as one HTML page.
struct ReportOptions {
  std::vector<std::string> files;    ///< motion models
  std::string folder;                ///< output folder of index.html
  std::vector<std::string> against;  ///< CSV files of curves
  std::string player;                ///< path of vrda-player; empty: next to this program
  bool is_quick = false;             ///< skip the audit of each smoothing degree
  bool as_json = false;              ///< print the page's data instead of the page's path
};

/// Writes <folder>/index.html and prints its path. Writes nothing if a file is unreadable or has no solved
/// attitude.
core::ExitCode report_command(const ReportOptions& options);

/// Returns `player`, which must exist (InputError), or if empty the vrda-player next to the running program;
/// an empty text if none exists.
std::string find_player(const std::string& player);

/// Renders frames of the motion model `file` at several flexions from the front and side. A failure is
/// reported in the note, and the report has no pictures.
report::RenderedImages render_images(const std::string& player, const std::string& file,
                                     const store::MotionModel& model);

}  // namespace vrda::app
