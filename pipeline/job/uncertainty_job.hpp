/// Reads [uncertainty] of a job.
#pragma once

#include <optional>

#include "job/case.hpp"
#include "job/case_ligaments.hpp"
#include "job/job.hpp"

namespace vrda::job {

struct LoadedUncertainty {
  std::optional<Uncertainty> uncertainty;  ///< empty without [uncertainty]
  std::vector<LoadedInput> inputs;         ///< tables of values
};

/// `loaded` has bodies, fibres, loads and lines. Throws InputError naming the key: a fibre, bundle, component
/// or load that the job does not have, a distribution without its numbers, one that would make a stiffness
/// negative, or a method other than the equilibrium.
LoadedUncertainty load_uncertainty(const Job& job, const std::string& data_directory, const Case& loaded,
                                   const LoadedLigaments& ligaments);

}  // namespace vrda::job
