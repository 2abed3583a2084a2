/// Files of an identification (schemas/fit.md): the result, the ligaments and the job with it.
#pragma once

#include <string>
#include <vector>

#include "analysis/identification.hpp"

namespace vrda::analysis {

struct FitDocument {
  std::string program, solver;            ///< that wrote it, and the solver's version
  std::string title, job;                 ///< of the job; its resolved text
  std::vector<job::LoadedInput> inputs;  ///< of the job and the measurements: names and hashes
  std::vector<Unknown> unknowns;
  Identification found;
};

/// Text of the JSON document. Angles in degrees; every number reads back exactly.
std::string fit_json(const FitDocument& document);

/// The fibres as a table of [ligaments] (schemas/ligaments.md) in the axes of the mesh files, with the
/// standard deviation of each slack length that is due to the unknowns.
std::string fitted_ligaments_csv(const job::Job& job, const job::Case& job_case,
                                 const std::vector<Unknown>& unknowns, const Identification& found);

/// The resolved job with the table `ligaments_file` (if not empty) and the changed loads. `job` has numbers
/// for all frames.
std::string fitted_job_text(const job::Job& job, const std::string& ligaments_file,
                            const std::vector<Unknown>& unknowns, const Eigen::VectorXd& change);

}  // namespace vrda::analysis
