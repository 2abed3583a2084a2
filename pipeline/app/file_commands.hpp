/// The commands that check jobs and write files of other kinds.
#pragma once

#include <string>
#include <vector>

#include "report/report.hpp"
#include "talk/talk.hpp"

namespace vrda {

struct CheckOptions {
  std::string job_file;
  std::string data_directory;
  std::vector<std::string> overrides;
  std::string picture;  ///< PNG file to draw what was understood into; empty: none
  bool as_json = false;
};

ExitCode check_command(const CheckOptions& options);

/// `vrda shape`: writes a generated joint as STL files, and its ligaments as a table.
struct ShapeOptions {
  std::string shape;
  std::string folder;
  std::vector<std::string> parameters;  ///< "name=value"
  bool has_ligaments = false;           ///< write ligaments.csv too
};

ExitCode shape_command(const ShapeOptions& options);

/// Every shape with its parameters, for `--help`.
std::string shape_help();

/// `vrda convert`: the thesis's own formats to ours, and mesh files from one format to another.
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
  std::string unit = "m";  ///< of the meshes and of every length in the file: m, cm or mm
};

/// Writes NAME.obj (Vertices-Faces) and NAME.normals for each component; prints the table of thesis 5.2.
ExitCode convert_object_command(const ConvertObjectOptions& options);

ExitCode convert_mesh_command(const ConvertMeshOptions& options);

/// Models are looked for in `models` beside the configuration, or beside its folder.
ExitCode convert_config_command(const ConvertConfigOptions& options);

/// `vrda export`: a motion model in the formats of other programs (schemas/exports.md).
struct ExportOptions {
  std::string file;     ///< motion model
  std::string format;   ///< sto, mot, csv, gltf or vtk
  std::string output;   ///< with the format's extension: .sto, .mot, .csv, .glb or .pvd
  std::string set;      ///< empty: the set that the player shows
  std::string flexion;  ///< FROM:TO:STEP, degrees; empty: the model's
  std::string varus;    ///< degrees, "spine" or "zero"; empty: zero where reduced, else spine
  std::vector<std::string> coordinates;  ///< COORDINATE=NAME of sto and mot
  bool in_degrees = false;               ///< angles of sto and mot
  bool every_cell = false;               ///< csv: the whole grid
  double degrees_per_second = 30.0;      ///< what time is in sto, mot and gltf
  bool as_json = false;
};

/// Prints the files written. Attitudes without a pose are left out and said so. Throws InputError, with
/// nothing written, for options that the format has no use for and where nothing is left to export.
ExitCode export_command(const ExportOptions& options);

/// `vrda report`: motion models as one HTML page.
struct ReportOptions {
  std::vector<std::string> files;    ///< motion models
  std::string folder;                ///< gets index.html
  std::vector<std::string> against;  ///< CSV files of curves
  std::string player;                ///< vrda-player; empty: the one beside this program
  bool is_quick = false;             ///< do not measure what each smoothing degree does to the meshes
  bool as_json = false;              ///< print the page's data instead of the page's path
};

/// Writes <folder>/index.html and prints its path. Nothing is written when any of the files cannot be read or
/// has no solved attitude.
ExitCode report_command(const ReportOptions& options);

/// `player` as given, which must then be there (InputError), or the vrda-player beside the running program;
/// empty when there is none.
std::string player_program(const std::string& player);

/// Stills of the motion model `file` at several flexions from its front and side. What goes wrong is told in
/// the note; the report goes on without pictures.
Stills player_stills(const std::string& player, const std::string& file, const MotionModel& model);

}  // namespace vrda
