/// The commands that work on a motion model or a trace. Each reads a file, prints to standard output and
/// returns the exit code; those that change a model replace the file atomically. Throw InputError for a file
/// that is refused.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/compare.hpp"
#include "core/console.hpp"
#include "store/trace.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct InfoOptions {
  std::string file;
  bool as_json = false;
};

/// Measures gaps and penetrations again from the file's meshes and poses at every attitude.
core::ExitCode info_command(const InfoOptions& options);

core::ExitCode validate_command(const InfoOptions& options);

/// `vrda audit`: measures gap and penetration of the motions in a motion model.
struct AuditOptions {
  std::string file;
  std::string set = "all";  ///< one of set_names of motion/poses.hpp, or "all"
  int refine = 1;           ///< subdivisions of each grid cell along each axis
  int n_threads = 0;        ///< 0: one per processor
  bool as_json = false;
};

/// Writes /audit/SET into the file and replaces an existing one.
core::ExitCode audit_command(const AuditOptions& options);

/// Contact of both compartments in a motion; null without compartments.
nlohmann::ordered_json two_sided_json(const store::TwoSidedFigures& figures);

/// One row per motion with compartments; prints nothing without any.
void print_two_sided(const std::vector<std::pair<std::string, store::TwoSidedFigures>>& motions);

/// One row per degree: lengths of the translation vector, angles per surface. Ends with a line feed.
std::string comparison_table(const analysis::Comparison& comparison);

/// Formats the recommendation as a sentence.
std::string recommendation_text(const analysis::Recommendation& recommendation);

/// All measures of each degree; a value that is not a number is null.
nlohmann::ordered_json json_of(const analysis::Comparison& comparison);

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

/// Prints one row per degree and the recommendation. Does not change the file.
core::ExitCode compare_command(const CompareCommandOptions& options);

/// `vrda reduce`: adds the flexion-only motion to a motion model and prints it.
struct ReduceOptions {
  std::string file;
  std::string set = "raw";  ///< source of the poses: one of set_names except zero_varus
  bool as_json = false;
};

/// Replaces an existing zero-varus motion, and drops its audit if the poses differ. Throws InputError, with
/// the file unchanged, for a joint without compartments and with given varus, for a set that is missing from
/// the file, and if no flexion can be reduced.
core::ExitCode reduce_command(const ReduceOptions& options);

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

/// Prints the set of add_smoothed().
core::ExitCode smooth_command(const SmoothCommandOptions& options);

/// `vrda trace`: summarises the searches of a trace.
struct TraceOptions {
  std::string file;
  store::AttitudeFilter filter;
  bool contact_only = false;  ///< omit moves that are not in contact
  bool as_csv = false;
  bool as_json = false;

  /// Declares the options of the command.
  void add_to(CLI::App& command);
};

core::ExitCode trace_command(const TraceOptions& options);

}  // namespace vrda::app
