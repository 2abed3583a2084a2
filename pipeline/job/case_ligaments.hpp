/// Loads the ligaments of a job: fibres and wraps in canonical axes.
#pragma once

#include "model/mesh.hpp"
#include "model/ligaments.hpp"
#include "job/axis_map.hpp"

namespace vrda::job {

struct LoadedLigaments {
  model::Ligaments ligaments;    ///< canonical, own side; empty if the job has none
  std::vector<FibreJob> jobs;       ///< [fibres] origin of each fibre
  std::vector<LoadedInput> inputs;  ///< files read, or the generator's name
};

/// Reads the files named in the job (data folder first), maps attachments and wraps like meshes, resolves
/// wrap names and computes slack lengths from reference strains. Throws InputError with file and line or key.
LoadedLigaments load_ligaments(const Job& job, const std::string& data_directory, const BodyMaps& maps);

/// "ligaments.fibre.3.stiffness_n" for a fibre in the job, "line 7, stiffness_n" for one in a table.
std::string fibre_key(const FibreJob& fibre, const std::string& key);

/// Throws InputError if all fibres are shorter than 1 mm (attachments in m), or if an attachment is outside
/// its object: outside the bounding box of all components (visual ones included), enlarged on each side by
/// half of its longest edge.
void check_attachments(const LoadedLigaments& loaded, const Body& reference, const Body& moving);

}  // namespace vrda::job
