/// [scaling] of a job: from a factor or a table of landmarks to a case of the subject's size.
/// schemas/scaling.md says what is scaled, and when the steps are kept.
#pragma once

#include "load/axis_map.hpp"

namespace vrda {

/// What the job asks for; no member where it has no [scaling] or no landmarks.
struct LoadedScaling {
  std::optional<Scaling> scaling;
  std::vector<LoadedInput> inputs;
  std::vector<std::string> warnings;  ///< how badly the landmarks fit
};

/// Reads the table of landmarks where the job names one (data folder first) and fits the factor.
/// Throws InputError naming the job's key or the table, also of a factor outside 0.1 to 10.
LoadedScaling load_scaling(const Job& job, const std::string& data_directory, const AxisMap& map);

/// Takes up `asked` in a case loaded at factor 1, with `steps_job`. Where an even factor keeps the contact,
/// `loaded` stays at factor 1 with `steps_scale` for what the steps find; everywhere else its lengths are
/// scaled and `solved_anew_because` says why. Throws InputError where an uneven factor meets a wrapping
/// surface, or a fibre whose attachments coincide.
void take_up_scaling(Case& loaded, const Job& job, const LoadedScaling& asked);

}  // namespace vrda
