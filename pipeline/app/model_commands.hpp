/// The commands that work on a motion model or a trace.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compare/compare.hpp"
#include "store/trace.hpp"
#include "talk/talk.hpp"

namespace vrda {

struct InfoOptions {
  std::string file;
  bool as_json = false;
};

/// Gaps and penetrations are measured again from the file's meshes and poses at every attitude.
ExitCode info_command(const InfoOptions& options);

ExitCode validate_command(const InfoOptions& options);

/// `vrda audit`: gap and penetration of the motions in a motion model.
struct AuditOptions {
  std::string file;
  std::string set = "all";  ///< one of set_names of motion/poses.hpp, or all of them
  int refine = 1;           ///< parts each cell of the grid is cut into, along each axis
  int n_threads = 0;        ///< 0: as many as there are processors
  bool as_json = false;
};

/// Writes /audit/SET into the file, in place of the one of that name.
ExitCode audit_command(const AuditOptions& options);

/// A row a degree: lengths are of the translation as a vector, angles of each surface. Ends with a line feed.
std::string table_of(const Comparison& comparison);

/// The recommendation as a sentence.
std::string sentence_of(const Recommendation& recommendation);

/// Everything that is known of each degree; what is not a number is null.
nlohmann::ordered_json json_of(const Comparison& comparison);

/// `vrda compare`: smoothing degrees side by side, and which to take.
struct CompareCommandOptions {
  std::string file;
  std::string degrees = "1..12";  ///< ranges and numbers: "1..12", "2,4,6", "1..4,8"
  int refine = 2;                 ///< parts of a grid step that are audited; 1 the grid alone, 0 nothing
  int n_threads = 0;              ///< of the audit; 0: one a processor
  bool is_robust = false;
  bool is_recontacted = false;
  bool as_json = false;
};

/// The degrees that a text names, rising, each once. Throws InputError that names --degrees.
std::vector<int> degrees_of(const std::string& text);

/// Prints a row a degree and the recommendation. Changes nothing in the file.
ExitCode compare_command(const CompareCommandOptions& options);

/// `vrda reduce`: the flexion-only motion of a motion model, added to its file and printed.
struct ReduceOptions {
  std::string file;
  std::string set = "raw";  ///< whose poses: one of set_names, but zero_varus
  bool as_json = false;
};

/// Replaces a zero-varus motion that the file holds, and drops the audit of the old one where poses differ.
/// Throws InputError for a joint without compartments whose varus was given, for a set that the file does not
/// hold, and where no flexion can be reduced; the file is untouched then.
ExitCode reduce_command(const ReduceOptions& options);

/// `vrda smooth`: adds a smoothed set to a motion model.
struct SmoothCommandOptions {
  std::string file;
  int degree = 6;
  bool is_robust = false;
  bool is_recontacted = false;  ///< with travel into contact at every attitude
  int n_threads = 0;            ///< 0: as many as there are processors
  bool as_json = false;
};

/// Writes /smoothed/degree_N in place of the one of that degree. Audits of a set that changed are dropped.
ExitCode smooth_command(const SmoothCommandOptions& options);

/// `vrda trace`: what the searches of a trace did.
struct TraceOptions {
  std::string file;
  AttitudeFilter filter;
  bool contact_only = false;  ///< leave out the moves that are not in contact
  bool as_csv = false;
  bool as_json = false;
};

ExitCode trace_command(const TraceOptions& options);

}  // namespace vrda
