/// Files of an identification (schemas/fit.md): the result, the ligaments and the job with it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/identification.hpp"
#include "core/framed_file.hpp"

namespace vrda::analysis {

struct FitDocument {
  std::string program, solver;           ///< that wrote it, and the solver's version
  std::string title, job;                ///< of the job; its resolved text
  std::vector<job::LoadedInput> inputs;  ///< of the job and the measurements: names and hashes
  std::vector<Unknown> unknowns;
  Identification found;
};

/// Text of the JSON document. Angles in degrees; every number reads back exactly.
std::string fit_json(const FitDocument& document);

/// The fibres of the joint, or of a follower by its row, as a table (schemas/ligaments.md) in the axes of the
/// mesh files, with the standard deviation of each slack length that is due to the unknowns.
std::string fitted_ligaments_csv(const job::Job& job, const job::Case& job_case,
                                 const std::vector<Unknown>& unknowns, const Identification& found,
                                 std::optional<std::size_t> follower = std::nullopt);

/// Names of tables in the place of the job's own: of the joint (no number) and of followers by row.
using FibreFiles = std::map<std::optional<std::size_t>, std::string>;

/// The resolved job with these tables and the changed loads. `job` has numbers for all frames.
std::string fitted_job_text(const job::Job& job, const job::Case& job_case, const FibreFiles& files,
                            const std::vector<Unknown>& unknowns, const Eigen::VectorXd& change);

// The append-only journal of an identification, from which an interrupted one continues: a frame of
// core/framed_file.hpp per evaluation.

/// SHA-256 of what determines the evaluations: job, inputs, solver, unknowns, measurements.
std::string identification_key(const FitData& data, const IdentifyPlan& plan,
                               const std::vector<std::string>& hashes_of_data);

/// Continues the journal at `path`, adding its evaluations, or starts one; with `is_fresh` always starts one.
/// Throws InputError if it has another key or is being written.
core::FrameWriter open_evaluations(const std::string& path, const std::string& key, bool is_fresh,
                                   std::vector<Evaluation>& known);

}  // namespace vrda::analysis
