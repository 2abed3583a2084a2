/// The commands of `vrda`: a name here and a row in main.cpp for each, and what the Python module, other
/// commands and tests call. A command's options, what it does and what it prints are in its file. Functions
/// throw InputError for a file that is refused; those that change a model replace its file atomically.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/compare.hpp"
#include "app/command.hpp"
#include "run/submission.hpp"
#include "store/motion_model.hpp"

namespace vrda::app {

/// Declares the options of a command and what it does.
using Declare = void(Command&);
Declare declare_audit, declare_bands, declare_check, declare_compare, declare_convert, declare_convert_osim,
    declare_export, declare_fit, declare_import, declare_index, declare_info, declare_laxity, declare_merge,
    declare_plan, declare_prepare, declare_reduce, declare_repair, declare_report, declare_resume,
    declare_rom, declare_run, declare_score, declare_shape, declare_smooth, declare_status, declare_submit,
    declare_task, declare_trace, declare_validate;

struct CheckOptions : job::JobSource {
  std::string picture;  ///< PNG file of the joint as read; empty: none
  bool as_json = false;
};

/// What was understood, the plan, and warnings; writes the picture.
nlohmann::ordered_json check_json(const CheckOptions& options);

/// `vrda smooth`: adds a smoothed set to a motion model.
struct SmoothCommandOptions {
  std::string file;
  int degree = 6;
  bool is_robust = false;
  bool is_recontacted = false;  ///< also find the travel into contact at every attitude
  int n_threads = 0;            ///< 0: one per processor
  bool as_json = false;
};

/// Writes /smoothed/degree_N and replaces an existing one. Drops audits of a changed set; without a two-sided
/// motion decides on the default motion again. Empty when
/// interrupted while another process writes the file.
std::optional<store::SmoothedSet> add_smoothed(const SmoothCommandOptions& options);

/// Residuals, errors and travel of a set.
nlohmann::ordered_json json_of(const store::SmoothedSet& set);

/// `vrda compare`: compares smoothing degrees and recommends one.
struct CompareCommandOptions {
  std::string file;
  std::string degrees = "1..12";  ///< ranges and numbers: "1..12", "2,4,6", "1..4,8"
  int refine = 2;                 ///< subdivisions of an audited grid step; 1: grid only, 0: no audit
  int n_threads = 0;              ///< threads of the audit; 0: one per processor
  bool is_robust = false;
  bool is_recontacted = false;
  bool as_json = false;
  std::function<void()>
      before_measuring;  ///< called before each measurement; what it throws ends the command
};

/// Compares the degrees and logs those that are skipped.
analysis::Comparison compare_degrees(const CompareCommandOptions& options);

/// Parses degrees; returns them ascending and without duplicates. Throws InputError naming --degrees.
std::vector<int> parse_degrees(const std::string& text);

/// All measures of each degree; a value that is not a number is null.
nlohmann::ordered_json json_of(const analysis::Comparison& comparison);

/// One row per motion with compartments; prints nothing without any.
void print_two_sided(const std::vector<std::pair<std::string, store::TwoSidedFigures>>& motions);

/// `vrda export`: writes a motion model in formats of other programs (schemas/exports.md).
struct ExportOptions {
  std::string file;    ///< motion model
  std::string format;  ///< sto, mot, osim, csv, gltf, vtk, stl or mrk
  std::string
      output;       ///< with the format's extension: .sto, .mot, .osim, .csv, .glb, .pvd, .stl or .mrk.json
  std::string set;  ///< empty: the player's default set
  std::string flexion;  ///< FROM:TO:STEP, degrees; empty: the model's
  std::string pose;     ///< flexion=DEGREES of stl and mrk
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

/// `vrda index`: writes one table of the results of a submission.
struct IndexOptions {
  std::string folder;  ///< of a submission
  bool as_json = false;
  int n_processes = 0;  ///< processes that read models; 0: one per processor
};

/// Writes index.csv, index.h5 and index.times.csv into `options.folder`, which must be absolute, and prints
/// their paths. Unfinished cases get rows too. Throws InputError if the files cannot be written.
core::ExitCode write_submission_index(const IndexOptions& options, const run::Submission& submission);

}  // namespace vrda::app
